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
