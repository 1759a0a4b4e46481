//! The state that the operations of a step read and change.

use crate::read::entry::Entry;
use crate::read::names::{Names, lookup};
use crate::scenario::Constraint;
use crate::span::Span;
use std::collections::{BTreeMap, BTreeSet};
use wireloom_core::mechanism::closure::Driven;
use wireloom_core::steps::{Move, ObstacleMove};

/// The constraints that act, from step to step.
pub(crate) struct Acting {
    pub active: BTreeSet<usize>,
    /// Released constraints, with their step.
    pub released: BTreeMap<usize, usize>,
    /// Connectors that are in their seats.
    pub mated: BTreeSet<usize>,
}

/// A joint of a mechanism that is driven.
pub(crate) struct DrivenJoint {
    pub mechanism: usize,
    pub driven: Vec<Driven>,
    /// Place of its values.
    pub span: Span,
    /// Number of values with a result of their own; 0 for the last alone.
    pub stops: usize,
}

/// A step while it is read. A constraint or an obstacle takes part in one motion at most.
pub(crate) struct Context<'s, 'a> {
    /// The step.
    pub entry: &'s Entry<'a>,
    pub names: &'s Names<'a>,
    pub acting: &'s mut Acting,
    pub constraints: &'s mut [Constraint],
    /// Constraints that begin with the step.
    pub begun: &'s [usize],
    pub drives: Vec<DrivenJoint>,
    pub moves: Vec<Move>,
    pub obstacle_moves: Vec<ObstacleMove>,
    /// Loads, by index, and the factors reached.
    pub loads: Vec<(usize, f64)>,
    /// Branches, by index, and the temperatures reached, K.
    pub temperatures: Vec<(usize, f64)>,
}

impl Context<'_, '_> {
    /// The constraint of this name, if it may be moved.
    pub fn claim(&self, entry: &Entry<'_>, name: &str, span: Span) -> Option<usize> {
        let index = *lookup(entry, "constraint", &self.names.constraints, name, span.clone())?;
        let step = &self.entry.label;
        let (message, help) = if self.acting.released.contains_key(&index) {
            (format!("{step} moves \"{name}\", which is released"), "move it before it is released")
        } else if !self.acting.active.contains(&index) {
            (format!("{step} moves \"{name}\", which has not begun"), "add it in this step or before")
        } else if self.moves.iter().any(|other| other.carried.iter().any(|carried| carried.constraint == index)) {
            let help = "give one move for every constraint, with `via` points where it needs them";
            (format!("{step} moves \"{name}\" twice"), help)
        } else {
            return Some(index);
        };
        entry.reader.fault(span, message, help);
        None
    }

    /// The obstacle of this name, if no other motion moves it.
    pub fn claim_obstacle(&self, entry: &Entry<'_>, name: &str) -> Option<usize> {
        let span = entry.span_of("obstacle");
        let index = *lookup(entry, "obstacle", &self.names.obstacles, name, span.clone())?;
        if self.names.mounted_obstacles.contains(&index) {
            let message = format!("{} moves the obstacle \"{name}\", which is mounted on a body", self.entry.label);
            entry.reader.fault(span, message, "a mechanism carries it: use `drive`, or leave out its `mount`");
            return None;
        }
        if self.obstacle_moves.iter().any(|other| other.obstacle == index) {
            let message = format!("{} moves the obstacle \"{name}\" twice", self.entry.label);
            let help = "give one move for every obstacle, with `via` points where it needs them";
            entry.reader.fault(span, message, help);
            return None;
        }
        Some(index)
    }
}
