//! Weight, lumped at nodes: `E = −Σ m g·x`; in axes that rotate also `−½ Σ m |ω × r|²`.

use crate::conditions::System;
use crate::network::{Branch, Tie};
use crate::rod::{Beside, Mesh};
use crate::variable::{Block, Variable};
use crate::{Matrix, State, Tangent, Vector};
use std::collections::BTreeMap;
use std::ops::{Mul, Neg};

/// Part of a segment's load that is lumped at the other node of a segment beside a station instead of the station, on
/// meshes that are too coarse for [`WIDE_SHIFTS`].
const STATION_SHIFT: f64 = 1.0 / 24.0;

/// What is lumped at a station and at the next three nodes, as fractions of a segment's load, beside the half that each
/// segment lumps at either node. Nodes between segments stand for `x − (ℓ²/24) x″ + (7/5760) ℓ⁴ x⁗` of the centre line
/// ([`crate::rod`]; the edge between two of them is ℓ times the tangent at its middle). So by the halves alone the
/// potential of a load per length, w, differs from that of the rod by `w (−(ℓ²/24) x′ + (ℓ³/48) x″ + (7/1920) ℓ⁴ x‴)`
/// at the start of a span. These fractions take all of it out ([`STATION_SHIFT`] the first term).
const WIDE_SHIFTS: [f64; 4] = [-223.0 / 2080.0, 10039.0 / 49920.0, -1017.0 / 8320.0, 283.0 / 9984.0];

/// Fractions of [`WIDE_SHIFTS`] for a segment with one station or two, at the nodes that they belong to.
fn shifts(beside: &Beside) -> impl Iterator<Item = (usize, f64)> {
    let fractions = if beside.next.is_some() { WIDE_SHIFTS } else { [-STATION_SHIFT, STATION_SHIFT, 0.0, 0.0] };
    let j = beside.segment;
    let at = move |k: usize, side: usize| if side == 0 { j + k } else { (j + 1).wrapping_sub(k) };
    let sides = [0, 1].into_iter().filter(|side| beside.stations[*side].is_some());
    sides
        .flat_map(move |side| fractions.into_iter().enumerate().map(move |(k, fraction)| (at(k, side), fraction)))
        .filter(|(_, fraction)| *fraction != 0.0)
}

/// Nodes at which what is spread over segment j is lumped, with the fractions.
pub(super) fn lumps(mesh: &Mesh, j: usize) -> impl Iterator<Item = (usize, f64)> {
    let beside = mesh.beside.binary_search_by_key(&j, |beside| beside.segment).ok();
    let shifts = beside.into_iter().flat_map(|k| shifts(&mesh.beside[k]));
    [(j, 0.5), (j + 1, 0.5)].into_iter().chain(shifts)
}

/// Length of cable (m) whose load is lumped before the middle of each segment beyond the halves: by that load, the
/// force of the segment differs from the one at its middle.
pub fn middle_shifts(mesh: &Mesh, rest_lengths: &[f64]) -> Vec<f64> {
    let mut lengths = vec![0.0; mesh.nodes()];
    for beside in &mesh.beside {
        shifts(beside).for_each(|(node, fraction)| lengths[node] += rest_lengths[beside.segment] * fraction);
    }
    let mut before = 0.0;
    lengths.pop();
    lengths.iter_mut().for_each(|own| {
        before += *own;
        *own = before;
    });
    lengths
}

/// Passes what segments of these rest lengths (m) have by their density (kg/m) and a factor, lumped at nodes, to `add`,
/// by point: half of each segment's part at either of its nodes, corrected beside stations.
fn lumped<T: Copy + Mul<f64, Output = T> + Neg<Output = T>>(
    branch: &Branch,
    rest_lengths: &[f64],
    factor: T,
    mut add: impl FnMut(usize, T),
) {
    let start = branch.points.start;
    for (j, l) in rest_lengths.iter().enumerate().filter(|(_, l)| **l != 0.0) {
        let density = factor * branch.sections.of(j).linear_density;
        add(start + j, density * (0.5 * l));
        add(start + j + 1, density * (0.5 * l));
    }
    for beside in &branch.rod.mesh().beside {
        let density = factor * branch.sections.of(beside.segment).linear_density;
        let weight = density * rest_lengths[beside.segment];
        shifts(beside).for_each(|(node, fraction)| add(start + node, weight * fraction));
    }
}

/// Passes the weight of segments of these rest lengths (m), lumped at nodes, to `add`, by point, N.
pub fn weights(system: System<'_>, branch: usize, rest_lengths: &[f64], add: impl FnMut(usize, Vector)) {
    let branch = &system.network.branches[branch];
    lumped(branch, rest_lengths, system.conditions.gravity, add);
}

/// Passes their mass to `add`, by point, kg.
pub fn masses(system: System<'_>, branch: usize, rest_lengths: &[f64], add: impl FnMut(usize, f64)) {
    let branch = &system.network.branches[branch];
    lumped(branch, rest_lengths, 1.0, add);
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
