//! Nested iteration: a start found on a coarse mesh, carried over to a fine one.
//!
//! From far away the number of iterations hardly depends on the mesh, so they are cheap where segments are few; on the fine mesh
//! a handful is left (Brandt 1977).

use std::ops::Range;
use wireloom_core::{Network, State};

/// The state of a harness on a coarse mesh, on a finer mesh of the same harness: points and frames between those of the coarse one
/// by their arc lengths, those of stations and joints as they are.
///
/// # Panics
/// If the networks are not of the same branches and joints.
pub fn refined(coarse: &Network, state: &State, network: &Network) -> State {
    let mut fine = State::origin(network);
    for (b, (from, to)) in coarse.branches.iter().zip(&network.branches).enumerate() {
        let s = state.arc_lengths(coarse, b);
        let places = from.rod.mesh().frame_places(&s);
        let (points, frames) = (&state.points[from.points.clone()], &state.frames[from.frames.clone()]);
        let mesh = to.rod.mesh();
        let fine_s = mesh.arc_lengths();
        for (i, &at) in to.points.clone().zip(&fine_s) {
            let (k, t) = between(&s, at);
            fine.points[i] = points[k].lerp(&points[k + 1], t);
        }
        for (c, at) in to.frames.clone().zip(mesh.frame_places(&fine_s)) {
            // A branch of one segment between two points has one frame.
            fine.frames[c] = if frames.len() < 2 {
                frames[0]
            } else {
                let (k, t) = between(&places, at);
                frames[k] * (frames[k].inverse() * frames[k + 1]).powf(t)
            };
        }
    }
    for (from, to) in coarse.joints.iter().zip(&network.joints) {
        fine.points[to.point] = state.points[from.point];
        if let (Some(from), Some(to)) = (from.frame, to.frame) {
            fine.frames[to] = state.frames[from];
        }
    }
    network.follow_ties(&mut fine);
    fine
}

/// Which two of increasing places `at` is between (or next to, at the ends): the first of them, and how far on the way to the second.
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
