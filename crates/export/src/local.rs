//! Internal force and moment at a node, split along and across the tangent.

use std::io;
use wireloom_core::Vector;
use wireloom_core::equilibrium::BranchResult;
use wireloom_core::rotation::columns;

/// Internal force and moment of a cross-section at one node. With `n`, `m` the internal force and moment and `d3` the
/// tangent: `N = n·d3`, `V = |n − N d3|`, `T = m·d3`, `M = |m − T d3|`, `κ = 1/R`.
pub struct Local {
    /// Director d1.
    pub d1: Vector,
    /// Tangent d3.
    pub d3: Vector,
    /// `N`, N; positive in tension.
    pub tension: f64,
    /// `V`, N.
    pub shear: f64,
    /// `M`, N m.
    pub bending_moment: f64,
    /// `T`, N m.
    pub torque: f64,
    /// `κ`, 1/m.
    pub curvature: f64,
}

impl Local {
    /// At node `i` of a branch that [`node_count`] accepted.
    pub fn at(branch: &BranchResult, i: usize) -> Self {
        let [d1, _, d3] = columns(&branch.frame[i]);
        let (n, m) = (branch.force[i], branch.moment[i]);
        let (tension, torque) = (n.dot(&d3), m.dot(&d3));
        Self {
            d1,
            d3,
            tension,
            shear: (n - d3 * tension).norm(),
            bending_moment: (m - d3 * torque).norm(),
            torque,
            curvature: 1.0 / branch.bend_radius[i],
        }
    }
}

/// Number of nodes of a branch.
///
/// # Errors
/// `InvalidInput` where its vectors differ in length.
pub fn node_count(branch: &BranchResult) -> io::Result<usize> {
    let lengths = [
        branch.s.len(),
        branch.position.len(),
        branch.frame.len(),
        branch.force.len(),
        branch.moment.len(),
        branch.bend_radius.len(),
        branch.friction.as_ref().map_or(branch.s.len(), |friction| friction.set.len()),
    ];
    if lengths.iter().all(|&n| n == lengths[0]) {
        return Ok(lengths[0]);
    }
    let [s, position, frame, force, moment, bend_radius, set] = lengths;
    let set = if branch.friction.is_some() { format!(", set {set}") } else { String::new() };
    Err(io::Error::new(
        io::ErrorKind::InvalidInput,
        format!(
            "branch {:?}: vectors differ in length: s {s}, position {position}, frame {frame}, force {force}, \
             moment {moment}, bend_radius {bend_radius}{set}",
            branch.name
        ),
    ))
}
