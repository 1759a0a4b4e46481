//! What is known of a computed harness.

use crate::curve::Vector;
use nalgebra::UnitQuaternion;

/// Largest distance, m, of the ends of branches that end at one point.
pub const JOINED: f64 = 1e-5;

/// The computed harness.
pub struct Computed<'a> {
    /// Its branches.
    pub branches: Vec<Branch<'a>>,
    /// Its constraints that come from assignments of fixings.
    pub fixings: Vec<Held>,
}

/// A computed branch.
pub struct Branch<'a> {
    /// Its name.
    pub name: String,
    /// Id of the segment that it comes from.
    pub segment: Option<String>,
    /// Arc lengths of its nodes, of the unstressed cable, m.
    pub s: &'a [f64],
    /// Its points over the fraction of its arc length, 0 to 1, m.
    pub at: Box<dyn Fn(f64) -> Vector + 'a>,
    /// Frames at its start and its end; d3 is the tangent.
    pub frames: [UnitQuaternion<f64>; 2],
    /// Its least bend radius, m; infinite where it is straight.
    pub bend_radius: f64,
}

/// A constraint that holds a fixing.
pub struct Held {
    /// Its name.
    pub name: String,
    /// Id of the assignment.
    pub assignment: String,
    /// Held point of the cable, m.
    pub position: Vector,
    /// Unit tangent of the cable there.
    pub tangent: Vector,
    /// Name of the branch and arc length (m) where the cable slides through it.
    pub slides: Option<(String, f64)>,
}
