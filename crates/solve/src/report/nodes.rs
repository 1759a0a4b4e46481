//! Frames, moments and curvatures at the nodes between stations, to fourth order in the segment length.
//!
//! A node i of a span that is fine enough ([`wireloom_core::rod::Mesh::pairs`]) is at `x_i + o_i` of the centre line,
//! `o = (ℓ²/24) x″`. With the force n at the middle of each segment and the load w per length:
//!
//! - The rotation half-way between the frames of both segments is short of that at the node by `(ℓ₀ ℓ₁/8) κ′`.
//! - A coupling has the moment about x_i, in balance with the lumped loads: from node to node it changes by `−e × n_j`
//!   with the force n_j of the segment. The moment in the rod changes by `−∫ x′ × n ds = −(e + Δo) × n + (ℓ²/12) Δx′ ×
//!   w`, and where w is not even, so that the force is curved within the segment, by `(ℓ³/24) x′ × w′` besides. The sum
//!   of the differences from the station before is what the coupling's moment lacks. At the end at a joint that the rod
//!   does not run through, that is `−o × n`.
//! - The curvature is that under this moment.

use wireloom_core::equilibrium::BranchResult;
use wireloom_core::network::Branch;
use wireloom_core::rod::Mesh;
use wireloom_core::rotation::columns;
use wireloom_core::{BranchShape, Rotation, Vector};

/// Segments of a branch.
pub struct Segments<'a> {
    /// Shape of the branch.
    pub shape: &'a BranchShape<'a>,
    /// Force at the middle of each, N.
    pub forces: &'a [Vector],
    /// The same less the force of the segment, N.
    pub shifts: &'a [Vector],
}

/// Refines the frames and moments of `result` at nodes without a station, and passes each such node with its moment
/// (N m, body axes) to `bend`. `through` says whether the rod runs on through a joint at its start and end, where the
/// frame is refined already; `weight` is the load per length of a segment, N/m.
pub fn refine(
    branch: &Branch,
    segments: &Segments<'_>,
    through: [bool; 2],
    weight: impl Fn(usize) -> Vector,
    result: &mut BranchResult,
    mut bend: impl FnMut(usize, Vector),
) {
    let mesh = branch.rod.mesh();
    let Segments { shape, forces, shifts } = segments;
    let (n, l) = (mesh.segments(), shape.rest_lengths);
    let places = mesh.frame_places(&result.s);
    let pairs = shape.frames.windows(2).zip(shape.coupling_lengths);
    let curvature: Vec<Vector> =
        pairs.map(|(frames, lambda)| (frames[0].inverse() * frames[1]).scaled_axis() / *lambda).collect();
    let middle = |c: usize| 0.5 * (places[c] + places[c + 1]);
    for (c, &node) in mesh.coupling_nodes.iter().enumerate() {
        if node == 0 || node == n || mesh.station_frame(node).is_some() || !mesh.is_fine(node - 1) {
            continue;
        }
        // At an end without a station the first coupling has no neighbour on one side.
        let inner = c.clamp(1, mesh.coupling_nodes.len() - 2);
        let around = [inner - 1, inner, inner + 1];
        let rate = slope(around.map(middle), around.map(|c| curvature[c]), middle(c));
        result.frame[node] *= Rotation::from_scaled_axis(rate * (l[node - 1] * l[node] / -8.0));
    }
    let tangent = |node: usize| columns(&result.frame[node])[2];
    let offset = |node: usize| result.position[node] - (shape.points[node] + shape.compensation[node]);
    let mut lag = Vector::zeros();
    for node in 0..=n {
        if mesh.station_frame(node).is_some() {
            lag = Vector::zeros();
            continue;
        }
        let j = node.saturating_sub(1);
        if !mesh.is_fine(j) {
            continue;
        }
        if node == 0 || node == n && !through[1] {
            lag = -offset(node).cross(&result.force[node]);
            if !through[usize::from(node == n)] {
                result.moment[node] += lag;
                continue;
            }
            // As within a span far from its ends.
            lag += tangent(0).cross(&weight(0)) * (l[0] * l[0] / 24.0);
        } else {
            lag -= (offset(node) - offset(j)).cross(&forces[j]) + shape.edge(j).cross(&shifts[j]);
            lag += (tangent(node) - tangent(j)).cross(&weight(j)) * (l[j] * l[j] / 12.0);
            lag += (tangent(node) + tangent(j)).cross(&growth(mesh, j, &weight)) * (l[j] * l[j] / 48.0);
        }
        result.moment[node] += lag;
        bend(node, result.frame[node].inverse() * result.moment[node]);
    }
}

/// By how much a load per length (N/m, of a segment) grows along a segment. At a station it may end.
pub fn growth(mesh: &Mesh, j: usize, load: impl Fn(usize) -> Vector) -> Vector {
    let is_inner = |node: usize| node > 0 && node < mesh.segments() && mesh.station_frame(node).is_none();
    let [before, after] = [j - usize::from(is_inner(j)), j + usize::from(is_inner(j + 1))];
    (load(after) - load(before)) / (after - before).max(1) as f64
}

/// x′ at the middle of each segment: its edge over its length, beside a station of a fine span and `(ℓ/24) x″` at the
/// station ([`wireloom_core::rod::Beside::next`]: by three tangents, else by two).
pub fn middle_tangents(branch: &Branch, shape: &BranchShape<'_>) -> Vec<Vector> {
    let mesh = branch.rod.mesh();
    let mut tangents: Vec<Vector> = (0..mesh.segments()).map(|j| shape.edge(j) / shape.rest_lengths[j]).collect();
    let fine = mesh.beside.iter().filter(|beside| branch.rod.couples_pairs() && mesh.is_fine(beside.segment));
    for beside in fine {
        let j = beside.segment;
        let along = |c: usize| columns(&shape.frames[c])[2];
        let own = along(mesh.segment_frames[j]);
        for c in beside.stations.into_iter().flatten() {
            let bend = match beside.next {
                Some(next) => own * 3.0 - along(c) * (8.0 / 3.0) - along(next) / 3.0,
                None => (own - along(c)) * 2.0,
            };
            let stretch = tangents[j].norm();
            tangents[j] += bend * (stretch / 24.0);
        }
    }
    tangents
}

/// Slope at a place of the parabola through three others.
pub fn slope([a, b, c]: [f64; 3], [fa, fb, fc]: [Vector; 3], at: f64) -> Vector {
    let (first, second) = ((fb - fa) / (b - a), (fc - fb) / (c - b));
    first + (second - first) * ((2.0 * at - a - b) / (c - a))
}

/// Curvature at each node, 1/m.
pub fn curvatures(branch: &BranchResult) -> Vec<f64> {
    branch.bend_radius.iter().map(|radius| 1.0 / radius).collect()
}

/// Twist per length of the frames from node to node, 1/m.
pub fn twists(branch: &BranchResult) -> Vec<f64> {
    let turned = branch.frame.windows(2).zip(branch.s.windows(2));
    turned.map(|(q, s)| (q[0].inverse() * q[1]).scaled_axis().z / (s[1] - s[0])).collect()
}
