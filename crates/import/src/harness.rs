//! The harness of a scenario: data only.

use super::curve::Vector;
use super::section::{Makeup, Types};
use nalgebra::UnitQuaternion;
use wireloom_core::identity::{Identities, Identity};

/// The harness of a scenario. SI throughout.
pub(super) struct Harness {
    pub name: String,
    pub vertices: Vec<Vertex>,
    pub types: Types,
    pub sections: Vec<Section>,
    pub branches: Vec<Branch>,
    pub joints: Vec<Joint>,
    pub constraints: Vec<Constraint>,
    /// Identity of each constraint.
    pub identities: Vec<Identity>,
    /// Components and wires.
    pub listed: Identities,
}

/// An end of branches: a node of the file.
pub(super) struct Vertex {
    pub name: String,
    /// Drawn position in the vehicle, m.
    pub position: Vector,
}

pub(super) struct Section {
    pub name: String,
    pub makeup: Makeup,
    pub remark: String,
}

pub(super) struct Branch {
    pub name: String,
    /// XML id of its segment, if results are written back into the file.
    pub segment: Option<String>,
    /// Indices of its first and last vertex.
    pub ends: [usize; 2],
    /// Index of the section that most of it has.
    pub section: usize,
    /// Its parts that have another one, in the order of arc length.
    pub parts: Vec<SectionPart>,
    /// m.
    pub length: f64,
    /// Deviations of the length that are allowed, m: the least and the greatest.
    pub tolerance: Option<[f64; 2]>,
    /// kg/m.
    pub linear_density: f64,
    /// m.
    pub diameter: f64,
    /// m.
    pub min_bend_radius: f64,
    /// Centre line from the first end to the second, m; empty if both ends are drawn at one point.
    pub path: Vec<Vector>,
    pub remark: String,
}

/// Part of a branch with a section of its own.
pub(super) struct SectionPart {
    /// Index of the section.
    pub section: usize,
    /// Where it begins and ends, m.
    pub range: [f64; 2],
}

pub(super) struct Joint {
    /// Index of its vertex.
    pub vertex: usize,
    pub arms: Vec<Arm>,
    pub wires: Vec<CommonWires>,
}

pub(super) struct Arm {
    /// Index of the branch.
    pub branch: usize,
    /// Frame of the branch (columns d1, d2, d3; d3 `from → to`) in world axes.
    pub orientation: UnitQuaternion<f64>,
}

/// Wires that two arms of a joint have in common.
pub(super) struct CommonWires {
    /// Index of the arm of whose stiffness `fraction` is that of the common wires.
    pub first: usize,
    pub second: usize,
    pub fraction: f64,
    pub wires: usize,
}

/// A place that something attaches to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// At a free end, by index of the vertex.
    End(usize),
    /// Along a branch, by index, at an arc length, m.
    Along { branch: usize, s: f64 },
    /// At a joint, by index of the vertex.
    Joint(usize),
}

/// Roles of constraints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Holds an end: position, tangent and twist.
    Connector,
    /// Closes around the cable: position and tangent.
    Clip,
    /// Like a clip, but lets the cable slide along itself.
    Guide,
}

pub(super) struct Constraint {
    pub name: String,
    pub at: Place,
    pub role: Role,
    pub position: Vector,
    /// d3 along the branch, `from → to`.
    pub frame: UnitQuaternion<f64>,
    /// kg, of the connector.
    pub mass: f64,
    /// XML id of the connector or fixing; `None` where the file has none there.
    pub of: Option<String>,
    /// XML id of the assignment of a fixing, if results are written back into the file.
    pub assignment: Option<String>,
    pub remark: String,
}
