//! Assembly operations, resolved: names are indices into the network.

use crate::{Rotation, Vector};

/// How the orientation of a target moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Turn {
    /// It stays.
    Keep,
    /// d3 turns to this direction by the shortest way.
    Tangent(Vector),
    /// To this orientation by the shortest turn.
    Orientation(Rotation),
}

/// Motion of one fixing's target over a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// Index of the fixing.
    pub fixing: usize,
    /// Points the target passes through, at equal shares of the step; the last is the end. Empty: it stays.
    pub path: Vec<Vector>,
    /// Orientation.
    pub turn: Turn,
    /// Then turned about its tangent by this many turns, spread over the increments.
    pub turns: f64,
}

/// One assembly operation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Step {
    /// Name.
    pub name: String,
    /// Increments; every one ends in an equilibrium.
    pub increments: usize,
    /// Gravity reached at the end of the step, m/s².
    pub gravity: Option<Vector>,
    /// Fixings that begin with this step.
    pub add: Vec<usize>,
    /// Fixings that end with this step.
    pub release: Vec<usize>,
    /// Motions.
    pub moves: Vec<Move>,
    /// Load index and the factor reached at the end of the step.
    pub loads: Vec<(usize, f64)>,
}

/// Where the rest shape is laid at the beginning: the start of this branch at this pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Initial {
    /// Index of the branch.
    pub branch: usize,
    /// Pose of its start.
    pub pose: crate::Pose,
}

/// Everything that happens to a harness, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// Name of the scenario.
    pub scenario: String,
    /// Gravity at the beginning, m/s².
    pub gravity: Vector,
    /// Where the rest shape is laid; `None`: a start is found from the drawn paths or the constraints.
    pub initial: Option<Initial>,
    /// The steps; empty: one equilibrium.
    pub steps: Vec<Step>,
    /// Keep every increment in the result, not only the last of each step.
    pub increments: bool,
}
