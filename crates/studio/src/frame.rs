//! A shape as it goes over the wire, and into pages that replay a run: little-endian,
//!
//! | bytes | what |
//! | --- | --- |
//! | 4 | length n of the header, a multiple of 4 |
//! | n | [`Header`] as JSON, padded with spaces |
//! | 4·[`FLOATS`] a node | what is known of every node, branch after branch: f32 |
//!
//! Of a node: position x, y, z (m, world); d1 x, y, z; arc length (m); curvature (1/m); tension (N); bending moment (N m); torque (N m);
//! clearance (m; NaN where it is not known).

use serde::{Deserialize, Serialize};
#[cfg(test)]
use ts_rs::TS;

/// Numbers a node.
pub const FLOATS: usize = 12;

/// What is known of an increment's end beside its nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Header {
    /// Number of the frame.
    pub frame: u32,
    /// Name of the step.
    pub step: String,
    /// Which increment of it, from 1; 0: the start.
    pub increment: u32,
    /// As results call it: `converged`, `stalled`, `iteration-limit`...
    pub status: String,
    /// Whether the equilibrium is stable, where that is known.
    pub stable: Option<bool>,
    /// Iterations of this increment.
    pub iterations: u32,
    /// What it took to compute, s.
    pub seconds: f64,
    /// Relative residual of forces and moments.
    pub residual: f64,
    /// Joints, in the order of the scene.
    pub joints: Vec<Placed>,
    /// Fixings that act.
    pub fixings: Vec<FixingFrame>,
    /// Bodies, in the order of the scene.
    pub obstacles: Vec<ObstacleFrame>,
    /// The bend nearest to its limit, or of least radius.
    pub tightest: Option<Tightest>,
    /// Energy by effect, J: total, stretch, shear, bend, twist, gravity, load, joint, constraint.
    pub energy: Vec<(String, f64)>,
}

/// Where something is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Placed {
    /// Position, m.
    pub position: [f64; 3],
    /// Orientation `[w, x, y, z]`.
    pub orientation: [f64; 4],
}

/// A fixing that acts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct FixingFrame {
    /// Name.
    pub name: String,
    /// Where the cable is held.
    pub at: Placed,
    /// Force on the harness, N, world axes.
    pub force: [f64; 3],
    /// Moment on the harness, N m, world axes.
    pub moment: [f64; 3],
    /// Arc length at it now (m), where the cable slides through.
    pub slid_to: Option<f64>,
}

/// A body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct ObstacleFrame {
    /// Where it stands.
    pub at: Placed,
    /// Force on the harness, N.
    pub force: [f64; 3],
    /// Number of places where it touches.
    pub contacts: u32,
}

/// A bend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Tightest {
    /// Branch.
    pub branch: String,
    /// Arc length, m.
    pub s: f64,
    /// Bend radius, m.
    pub radius: f64,
    /// Least allowed, m.
    pub limit: Option<f64>,
}
