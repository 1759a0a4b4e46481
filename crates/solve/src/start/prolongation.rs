//! Prolongation of an equilibrium to a similar harness: from a coarse mesh to a fine one, or between points of a sweep.
//!
//! Nested iteration: far from the equilibrium the number of iterations hardly depends on the mesh, so they are cheap on
//! a coarse mesh; a few remain on the fine one (Brandt 1977).

use std::ops::Range;
use wireloom_core::network::Branch;
use wireloom_core::{Network, State};

/// Whether harnesses have the same branches and joints, with any lengths and meshes, and no history in their states.
pub fn alike(one: &Network, other: &Network) -> bool {
    same_graph(one, other) && !has_history(one) && !has_history(other)
}

/// Whether states of a harness have a history: in a mesh that moves along its cable, or with obstacles, which cables
/// can pass on either side.
pub fn has_history(network: &Network) -> bool {
    !network.obstacles.is_empty() || network.branches.iter().any(|branch| branch.mesh_moves)
}

/// Whether harnesses have the same branches and joints, with any lengths and meshes.
pub fn same_graph(one: &Network, other: &Network) -> bool {
    let branches =
        |network: &Network| network.branches.iter().map(|b| (b.name.clone(), b.start, b.end)).collect::<Vec<_>>();
    let joints = |network: &Network| -> Vec<_> {
        network.joints.iter().map(|j| (j.name.clone(), j.branches.clone(), j.frame.is_some())).collect()
    };
    branches(one) == branches(other) && joints(one) == joints(other)
}

/// State of a harness on the mesh of another one with the same branches and joints; see [`Places::prolonged`].
///
/// # Panics
/// If the networks do not have the same branches and joints.
pub fn prolonged(from: &Network, state: &State, network: &Network) -> State {
    Places::of(from, state).prolonged(state, network)
}

/// Where the nodes and the frames of a harness lie along its branches.
#[derive(Clone, Debug)]
pub struct Places {
    branches: Vec<BranchPlaces>,
    /// Point and frame of each joint.
    joints: Vec<(usize, Option<usize>)>,
}

#[derive(Clone, Debug)]
struct BranchPlaces {
    points: Range<usize>,
    frames: Range<usize>,
    /// Arc lengths of the points, m.
    nodes: Vec<f64>,
    /// Arc lengths of the frames, m.
    middles: Vec<f64>,
}

impl Places {
    /// The places in a state; on meshes that do not move, those in every state.
    pub fn of(network: &Network, state: &State) -> Self {
        let of_branch = |(b, branch): (usize, &Branch)| {
            let nodes = state.arc_lengths(network, b);
            let middles = branch.rod.mesh().frame_places(&nodes);
            BranchPlaces { points: branch.points.clone(), frames: branch.frames.clone(), nodes, middles }
        };
        let branches = network.branches.iter().enumerate().map(of_branch).collect();
        Self { branches, joints: network.joints.iter().map(|joint| (joint.point, joint.frame)).collect() }
    }

    /// A state of the harness on another mesh: points and frames of branches are interpolated at equal fractions of
    /// length, those of joints are copied.
    ///
    /// # Panics
    /// If `network` does not have the same branches and joints.
    pub fn prolonged(&self, state: &State, network: &Network) -> State {
        let mut prolonged = State::origin(network);
        for (old, new) in self.branches.iter().zip(&network.branches) {
            let (s, places) = (&old.nodes, &old.middles);
            let (points, frames) = (&state.points[old.points.clone()], &state.frames[old.frames.clone()]);
            let mesh = new.rod.mesh();
            let stretch = s[s.len() - 1] / mesh.length();
            let at: Vec<f64> = mesh.arc_lengths().into_iter().map(|s| s * stretch).collect();
            for (i, &at) in new.points.clone().zip(&at) {
                let (k, t) = between(s, at);
                prolonged.points[i] = points[k].lerp(&points[k + 1], t);
            }
            for (c, at) in new.frames.clone().zip(mesh.frame_places(&at)) {
                // A branch of one segment without stations has one frame.
                prolonged.frames[c] = if frames.len() < 2 {
                    frames[0]
                } else {
                    let (k, t) = between(places, at);
                    frames[k] * (frames[k].inverse() * frames[k + 1]).powf(t)
                };
            }
        }
        for (&(point, frame), new) in self.joints.iter().zip(&network.joints) {
            prolonged.points[new.point] = state.points[point];
            if let (Some(old), Some(new)) = (frame, new.frame) {
                prolonged.frames[new] = state.frames[old];
            }
        }
        network.follow_ties(&mut prolonged);
        prolonged
    }
}

/// Interval of increasing places that contains `at` (the nearest one outside): index of its start, and the fraction of
/// `at` in it.
fn between(places: &[f64], at: f64) -> (usize, f64) {
    let inner: Range<usize> = 1..places.len() - 1;
    let k = places[inner].partition_point(|place| *place <= at);
    (k, (at - places[k]) / (places[k + 1] - places[k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lie_between_their_neighbours() {
        let places = [0.0, 1.0, 3.0];
        assert_eq!(between(&places, 0.0), (0, 0.0));
        assert_eq!(between(&places, 1.0), (1, 0.0));
        assert_eq!(between(&places, 2.0), (1, 0.5));
        assert_eq!(between(&places, 3.0), (1, 1.0));
        assert_eq!(between(&places, -0.5), (0, -0.5));
        assert_eq!(between(&places[..2], 0.25), (0, 0.25));
    }
}
