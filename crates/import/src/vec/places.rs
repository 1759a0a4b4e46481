//! Where a file draws and places things.

use crate::curve::{Polygon, Vector};
use crate::document::{ListedPlace, Location};
use crate::xml::Xml;
use nalgebra::Matrix3;
use std::collections::HashMap;

/// Where things are drawn, in the vehicle, by XML ids of the topology and of occurrences.
#[derive(Default)]
pub(super) struct Geometry<'a, 'i> {
    /// m.
    pub nodes: HashMap<&'a str, Vector>,
    /// Curves of each segment.
    pub curves: HashMap<&'a str, Vec<Polygon>>,
    /// Items of each occurrence, with the places of their building blocks.
    pub items: HashMap<&'a str, (Xml<'a, 'i>, Frame)>,
}

/// A place with its axes as columns, which may be scaled.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub axes: Matrix3<f64>,
    /// m.
    pub origin: Vector,
}

impl Frame {
    pub fn of_vehicle() -> Self {
        Self { axes: Matrix3::identity(), origin: Vector::zeros() }
    }

    pub fn point(&self, x: Vector) -> Vector {
        self.axes * x + self.origin
    }
}

/// What is placed where, by the XML ids of the topology, in the order of the file.
#[derive(Default)]
pub(super) struct Placed<'a, 'i> {
    pub at_nodes: HashMap<&'a str, Vec<Along<'a, 'i>>>,
    pub along: HashMap<&'a str, Vec<Along<'a, 'i>>>,
    pub over: HashMap<&'a str, Vec<Over<'a, 'i>>>,
    /// Places of each occurrence.
    pub listed: HashMap<&'a str, Vec<Place<'a>>>,
}

/// A part at a node or a place of a segment.
#[derive(Clone, Copy)]
pub(super) struct Along<'a, 'i> {
    pub placement: Xml<'a, 'i>,
    pub occurrence: Xml<'a, 'i>,
    /// On its segment.
    pub at: Location,
}

/// A part over a piece of a segment.
pub(super) struct Over<'a, 'i> {
    pub placement: Xml<'a, 'i>,
    pub occurrence: Xml<'a, 'i>,
    pub from: Location,
    pub to: Location,
}

/// A place of an occurrence.
pub(super) enum Place<'a> {
    Node(&'a str),
    Segment { id: &'a str, from: Location, to: Location },
}

impl Place<'_> {
    pub fn listed(&self) -> ListedPlace {
        match *self {
            Self::Node(id) => ListedPlace::Node(id.to_owned()),
            Self::Segment { id, from, to } => {
                ListedPlace::Segment { id: id.to_owned(), from: Some(from), to: Some(to) }
            }
        }
    }
}
