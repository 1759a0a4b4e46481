//! Prolongation of an equilibrium to a similar harness: from a coarse mesh to a fine one, or between points of a sweep.
//!
//! Nested iteration: far from the equilibrium the number of iterations hardly depends on the mesh, so they are cheap on
//! a coarse mesh; a few remain on the fine one (Brandt 1977).

use std::ops::Range;
use wireloom_core::{Network, State};

/// Whether harnesses have the same branches and joints, with any lengths and meshes, and no history in their states: no
/// meshes that move along their cables, and no obstacles, which cables can pass on either side.
pub fn alike(one: &Network, other: &Network) -> bool {
    same_graph(one, other)
        && [one, other].iter().all(|network| network.branches.iter().all(|branch| !branch.mesh_moves))
        && one.obstacles.is_empty()
        && other.obstacles.is_empty()
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

/// State of a harness on the mesh of another one with the same branches and joints: points and frames of branches are
/// interpolated at equal fractions of length, those of joints are copied.
///
/// # Panics
/// If the networks do not have the same branches and joints.
pub fn prolonged(from: &Network, state: &State, network: &Network) -> State {
    let mut prolonged = State::origin(network);
    for (b, (old, new)) in from.branches.iter().zip(&network.branches).enumerate() {
        let s = state.arc_lengths(from, b);
        let places = old.rod.mesh().frame_places(&s);
        let (points, frames) = (&state.points[old.points.clone()], &state.frames[old.frames.clone()]);
        let mesh = new.rod.mesh();
        let stretch = s[s.len() - 1] / mesh.length();
        let at: Vec<f64> = mesh.arc_lengths().into_iter().map(|s| s * stretch).collect();
        for (i, &at) in new.points.clone().zip(&at) {
            let (k, t) = between(&s, at);
            prolonged.points[i] = points[k].lerp(&points[k + 1], t);
        }
        for (c, at) in new.frames.clone().zip(mesh.frame_places(&at)) {
            // A branch of one segment without stations has one frame.
            prolonged.frames[c] = if frames.len() < 2 {
                frames[0]
            } else {
                let (k, t) = between(&places, at);
                frames[k] * (frames[k].inverse() * frames[k + 1]).powf(t)
            };
        }
    }
    for (old, new) in from.joints.iter().zip(&network.joints) {
        prolonged.points[new.point] = state.points[old.point];
        if let (Some(old), Some(new)) = (old.frame, new.frame) {
            prolonged.frames[new] = state.frames[old];
        }
    }
    network.follow_ties(&mut prolonged);
    prolonged
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
