//! The function to be minimised.

use crate::{Network, Pose, Vector};

/// What acts on the harness at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditions {
    /// Gravity, m/s².
    pub gravity: Vector,
    /// Factor of each load.
    pub load_factors: Vec<f64>,
    /// Which fixings act.
    pub active: Vec<bool>,
    /// Where each fixing holds (or pulls) its station.
    pub targets: Vec<Pose>,
}

/// A network under conditions.
pub struct Problem<'n> {
    /// The harness.
    pub network: &'n Network,
    conditions: Conditions,
}
