//! Weight, lumped at nodes: `E = −Σ m g·x`.

use crate::conditions::System;
use crate::{State, Vector};

/// Fraction of the weight of a segment beside a station that is lumped at its other node instead: this removes the
/// boundary term `−(ℓ²/24) [ρ g·t]` of each span from the error of the staggered scheme.
pub const STATION_SHIFT: f64 = 1.0 / 24.0;

/// Passes the weight of segments of these rest lengths (m), lumped at nodes, to `add`, by point, N: half of each
/// segment's weight at either of its nodes, corrected by [`STATION_SHIFT`].
pub fn weights(system: System<'_>, branch: usize, rest_lengths: &[f64], mut add: impl FnMut(usize, Vector)) {
    let branch = &system.network.branches[branch];
    let start = branch.points.start;
    let density = system.conditions.gravity * branch.section.linear_density;
    for (j, l) in rest_lengths.iter().enumerate().filter(|(_, l)| **l != 0.0) {
        add(start + j, density * (0.5 * l));
        add(start + j + 1, density * (0.5 * l));
    }
    for beside in &branch.rod.mesh().beside {
        let j = beside.segment;
        let shifted = density * (rest_lengths[j] * STATION_SHIFT);
        for (from, station) in [j, j + 1].into_iter().zip(beside.stations) {
            if station.is_some() {
                add(start + from, -shifted);
                add(start + 2 * j + 1 - from, shifted);
            }
        }
    }
}

/// Passes the weight of the branches with a fixed mesh to `add`, by point, N.
pub fn fixed_weights(system: System<'_>, mut add: impl FnMut(usize, Vector)) {
    for (b, branch) in system.network.branches.iter().enumerate().filter(|(_, branch)| !branch.mesh_moves) {
        weights(system, b, &branch.rod.mesh().rest_lengths, &mut add);
    }
}

/// Passes the weight of the branches whose mesh may move along the cable, lumped at `state`, to `add`, by point, N.
pub fn moving_weights(system: System<'_>, state: &State, mut add: impl FnMut(usize, Vector)) {
    for (b, _) in system.network.branches.iter().enumerate().filter(|(_, branch)| branch.mesh_moves) {
        weights(system, b, state.branch(system.network, b).rest_lengths, &mut add);
    }
}
