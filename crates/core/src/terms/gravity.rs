//! Weight, lumped at nodes: `E = −Σ m g·x`; in axes that rotate also `−½ Σ m |ω × r|²`.

use crate::conditions::System;
use crate::network::{Branch, Tie};
use crate::variable::{Block, Variable};
use crate::{Matrix, State, Tangent, Vector};
use std::collections::BTreeMap;
use std::ops::{Mul, Neg};

/// Fraction of the weight of a segment beside a station that is lumped at its other node instead: this removes the
/// boundary term `−(ℓ²/24) [ρ g·t]` of each span from the error of the staggered scheme.
pub const STATION_SHIFT: f64 = 1.0 / 24.0;

/// Fractions of what is spread over a segment that are lumped at its two nodes, which may be stations.
pub(super) fn shares(stations: [bool; 2]) -> [f64; 2] {
    let [first, second] = stations.map(|station| if station { STATION_SHIFT } else { 0.0 });
    [0.5 - first + second, 0.5 - second + first]
}

/// Passes what segments of these rest lengths (m) have by this density (per metre), lumped at nodes, to `add`, by
/// point: half of each segment's part at either of its nodes, corrected by [`STATION_SHIFT`].
fn lumped<T: Copy + Mul<f64, Output = T> + Neg<Output = T>>(
    branch: &Branch,
    rest_lengths: &[f64],
    density: T,
    mut add: impl FnMut(usize, T),
) {
    let start = branch.points.start;
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

/// Passes the weight of segments of these rest lengths (m), lumped at nodes, to `add`, by point, N.
pub fn weights(system: System<'_>, branch: usize, rest_lengths: &[f64], add: impl FnMut(usize, Vector)) {
    let branch = &system.network.branches[branch];
    lumped(branch, rest_lengths, system.conditions.gravity * branch.section.linear_density, add);
}

/// Passes their mass to `add`, by point, kg.
pub fn masses(system: System<'_>, branch: usize, rest_lengths: &[f64], add: impl FnMut(usize, f64)) {
    let branch = &system.network.branches[branch];
    lumped(branch, rest_lengths, branch.section.linear_density, add);
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

/// Passes every mass, lumped at `state`, to `add`, by point, kg, if the axes rotate.
fn rotating_masses(system: System<'_>, state: &State, mut add: impl FnMut(usize, f64)) {
    if system.conditions.rotation.is_moving() {
        for b in 0..system.network.branches.len() {
            masses(system, b, state.branch(system.network, b).rest_lengths, &mut add);
        }
        system.network.joints.iter().for_each(|joint| add(joint.point, joint.mass));
    }
}

/// Energy of the rotation of the axes, J.
pub fn centrifugal_energy(system: System<'_>, state: &State) -> f64 {
    let mut energy = 0.0;
    rotating_masses(system, state, |i, mass| energy += mass * system.conditions.rotation.potential(&state.points[i]));
    energy
}

/// Adds its first derivatives to the gradient, with tied entries, its energy to `energy` (J), and the sum of its
/// absolute values to `magnitude` (J).
pub fn centrifugal_gradient(
    system: System<'_>,
    state: &State,
    gradient: &mut Tangent,
    energy: &mut f64,
    magnitude: &mut f64,
) {
    rotating_masses(system, state, |i, mass| {
        let own = mass * system.conditions.rotation.potential(&state.points[i]);
        gradient.points[i] -= system.conditions.rotation.pull(&state.points[i]) * mass;
        *energy += own;
        *magnitude += own.abs();
    });
}

/// Adds its second derivatives in the independent variables, both triangles, without those of the levers of tied
/// points. A tied point moves by `δx = δX − R [o]ₓ θ` with the point X and the frame R of its hub.
pub fn centrifugal_blocks(system: System<'_>, state: &State, blocks: &mut Vec<Block>) {
    if !system.conditions.rotation.is_moving() {
        return;
    }
    let hessian = system.conditions.rotation.hessian();
    let ties: BTreeMap<usize, &Tie> = system.network.ties.iter().map(|tie| (tie.point, tie)).collect();
    rotating_masses(system, state, |i, mass| {
        let tie = ties.get(&i);
        let mut add = |row, column, matrix: Matrix| blocks.push(Block { row, column, matrix });
        let own = hessian * mass;
        let point = Variable::Point(tie.map_or(i, |tie| tie.hub_point));
        add(point, point, own);
        if let Some((hub, offset)) = tie.and_then(|tie| Some((tie.hub_frame?, tie.offset)))
            && offset != Vector::zeros()
        {
            let lever = -(state.frames[hub].to_rotation_matrix().matrix() * crate::rotation::skew(&offset));
            let frame = Variable::Frame(hub);
            add(point, frame, own * lever);
            add(frame, point, lever.transpose() * own);
            add(frame, frame, lever.transpose() * own * lever);
        }
    });
}
