//! What requirements read of a part of a branch: its nodes, both sides of those at which something attaches, and its
//! ends where they lie between nodes.

use super::result;
use wireloom_core::equilibrium::{BranchResult, NodeSides};
use wireloom_core::{Rotation, Vector};

/// Distance along a branch, as a fraction of its length, within which an end of a part is at a node.
const SAME: f64 = 1e-9;
/// Curvature, as a fraction of its change between two nodes, that is round-off.
const NO_BEND: f64 = 1e-9;
/// Nodes on either side of a part that tell how values change within it.
const AROUND: usize = 3;

/// Both sides of a node, where something attaches.
fn sides(branch: &BranchResult, node: usize) -> Option<&NodeSides> {
    branch.sides.binary_search_by_key(&node, |sides| sides.node).ok().map(|k| &branch.sides[k])
}

/// Results at one place.
pub struct Local {
    /// The node, or the one before the place.
    pub node: usize,
    /// The segment on whose side of the node it is.
    pub segment: usize,
    /// Fraction of the way to the next node; 0 at a node.
    pub fraction: f64,
    /// Arc length, m.
    pub s: f64,
    pub position: Vector,
    pub frame: Rotation,
    /// Internal force, N.
    pub force: Vector,
    /// Internal moment, N m.
    pub moment: Vector,
    /// m; infinite where straight.
    pub bend_radius: f64,
}

impl Local {
    /// At a node; beside something that attaches there on one side, 0 before and 1 after.
    fn at_node(branch: &BranchResult, node: usize, side: usize) -> Self {
        let sides = sides(branch, node);
        let before = (sides.is_some() && side == 0) || node + 1 == branch.s.len();
        Self {
            node,
            segment: if before { node.saturating_sub(1) } else { node },
            fraction: 0.0,
            s: branch.s[node],
            position: branch.position[node],
            frame: branch.frame[node],
            force: sides.map_or(branch.force[node], |sides| sides.force[side]),
            moment: sides.map_or(branch.moment[node], |sides| sides.moment[side]),
            bend_radius: sides.map_or(branch.bend_radius[node], |sides| sides.bend_radius[side]),
        }
    }

    /// Between a node and the next one: linear, forces and moments in the axes of the frame, the bend by its curvature,
    /// the position along the centre line.
    fn between(branch: &BranchResult, node: usize, s: f64) -> Self {
        let (a, b) = (Self::at_node(branch, node, 1), Self::at_node(branch, node + 1, 0));
        let t = (s - a.s) / (b.s - a.s);
        let frame = a.frame.try_slerp(&b.frame, t, 1e-12).unwrap_or(a.frame);
        let mix = |of_a: &Vector, of_b: &Vector| {
            frame * (a.frame.inverse() * of_a * (1.0 - t) + b.frame.inverse() * of_b * t)
        };
        let bend = (1.0 - t) / a.bend_radius + t / b.bend_radius;
        Self {
            node,
            segment: node,
            fraction: t,
            s,
            position: result::position_at(branch, s),
            frame,
            force: mix(&a.force, &b.force),
            moment: mix(&a.moment, &b.moment),
            bend_radius: if bend > 0.0 { 1.0 / bend } else { f64::INFINITY },
        }
    }

    /// Component of the force along the cable, N.
    pub fn tension(&self) -> f64 {
        self.force.dot(&(self.frame * Vector::z()))
    }

    /// An error (one for each node) at the place: the larger one of both nodes around it.
    pub fn error(&self, of_nodes: impl Fn(usize) -> f64) -> f64 {
        let own = of_nodes(self.node);
        if self.fraction > 0.0 { own.max(of_nodes(self.node + 1)) } else { own }
    }
}

/// Internal force before and after a node, N.
pub fn forces_around(branch: &BranchResult, node: usize) -> [Vector; 2] {
    [0, 1].map(|side| Local::at_node(branch, node, side).force)
}

/// Where a part of a branch is straightest as it bends over to the other side between two of its nodes: the node
/// before, the arc length (m) and the curvature (1/m). The vector of the curvature is linear between nodes: in a plane
/// it vanishes there.
pub fn straightest(branch: &BranchResult, from: f64, to: f64) -> Option<(usize, f64, f64)> {
    let (s, x) = (&branch.s, &branch.position);
    let edges: Vec<Vector> = x.windows(2).map(|pair| (pair[1] - pair[0]).normalize()).collect();
    let is_inner = |i: usize| i > 0 && i < edges.len() && sides(branch, i).is_none();
    // Of nodes at which nothing attaches: the side to which the cable bends there.
    let at_inner = |i: usize| {
        let side = (edges[i] - edges[i - 1]).try_normalize(0.0).unwrap_or_default();
        side / branch.bend_radius[i]
    };
    // Where something attaches, the side is that of the nodes beyond.
    let curvature = |i: usize, side: usize, inward: [Option<usize>; 2]| {
        if is_inner(i) {
            return Some(at_inner(i));
        }
        let [near, far] = inward.map(|k| k.filter(|&k| is_inner(k)).map(at_inner));
        let beyond = far.map_or(near, |far| near.map(|near| near * 2.0 - far))?;
        let radius = sides(branch, i).map_or(branch.bend_radius[i], |sides| sides.bend_radius[side]);
        Some(beyond.try_normalize(0.0).unwrap_or_default() / radius)
    };
    let between = |i: usize| {
        let a = curvature(i, 1, [Some(i + 1), Some(i + 2)])?;
        let b = curvature(i + 1, 0, [Some(i), i.checked_sub(1)])?;
        let change = b - a;
        let place = -a.dot(&change) / change.norm_squared();
        let at = s[i] + (s[i + 1] - s[i]) * place;
        let bend = (a + change * place).norm();
        let bend = if bend > NO_BEND * change.norm() { bend } else { 0.0 };
        let turns_over = a.dot(&b) < 0.0 && place > 0.0 && place < 1.0;
        (turns_over && from <= at && at <= to).then_some((i, at, bend))
    };
    (0..edges.len()).filter_map(between).min_by(|a, b| a.2.total_cmp(&b.2))
}

/// Places of a part of a branch, in order, with some nodes around it.
pub struct PartOfBranch {
    /// Each place, and whether it is in the part.
    places: Vec<(Local, bool)>,
}

impl PartOfBranch {
    /// Between two unstressed arc lengths (m), which may lie beyond the ends of the branch.
    pub fn new(branch: &BranchResult, from: f64, to: f64) -> Self {
        let s = &branch.s;
        let (start, end) = (s[0], s[s.len() - 1]);
        let near = SAME * (end - start);
        let (from, to) = (from.clamp(start, end), to.clamp(start, end));
        let (first, last) = (s.partition_point(|s| *s < from - near), s.partition_point(|s| *s <= to + near));
        let mut places = Vec::with_capacity(last - first + 2 * AROUND + 2);
        for node in first.saturating_sub(AROUND)..(last + AROUND).min(s.len()) {
            let inside = (first..last).contains(&node);
            // The ends of the part, where they are not at nodes.
            let mut end_before = |place: f64, at: usize| {
                if node == at && at > 0 && (s[at - 1] + near..s[at] - near).contains(&place) {
                    places.push((Local::between(branch, at - 1, place), true));
                }
            };
            end_before(from, first);
            end_before(to, last);
            if sides(branch, node).is_some() {
                // A side belongs to the part that is on it.
                let (before, after) = (s[node] > from + near, s[node] < to - near);
                places.push((Local::at_node(branch, node, 0), inside && (before || !after)));
                places.push((Local::at_node(branch, node, 1), inside && (after || !before)));
            } else {
                places.push((Local::at_node(branch, node, 0), inside));
            }
        }
        Self { places }
    }

    /// All values in the part, each with its place and by how much those around it, between nodes, may be beyond it: an
    /// eighth of the largest second difference of the nodes near it, those across what attaches left out.
    pub fn values(&self, value: impl Fn(&Local) -> f64) -> impl Iterator<Item = (&Local, f64, f64)> {
        let values: Vec<f64> = self.places.iter().map(|(place, _)| value(place)).collect();
        let mut differences = vec![0.0_f64; values.len()];
        let nodes: Vec<usize> = (0..values.len()).filter(|k| self.places[*k].0.fraction == 0.0).collect();
        for three in nodes.windows(3) {
            let [before, here, after] = [three[0], three[1], three[2]].map(|k| self.places[k].0.node);
            if after == here + 1 && here == before + 1 {
                differences[three[1]] = (values[three[0]] - 2.0 * values[three[1]] + values[three[2]]).abs();
            }
        }
        let around = move |k: usize| {
            differences[k.saturating_sub(2)..(k + 3).min(differences.len())].iter().copied().fold(0.0, f64::max) / 8.0
        };
        let inside = self.places.iter().zip(values).enumerate().filter(|(_, ((_, inside), _))| *inside);
        inside.map(move |(k, ((place, _), value))| (place, value, around(k)))
    }
}
