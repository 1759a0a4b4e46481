//! Clearance between cables and obstacles at every node.

use wireloom::StepResult;
use wireloom::geometry::Vector;
use wireloom::harness::Obstacle;

/// Distance (m) of the cable's surface from the nearest obstacle, for every node of all branches; empty without
/// obstacles.
pub(super) fn of_nodes(obstacles: &[Obstacle], end: &StepResult) -> Vec<f64> {
    if obstacles.is_empty() {
        return Vec::new();
    }
    let mut all = Vec::new();
    for branch in &end.branches {
        // Between neighbouring nodes the distance changes by at most the length between them.
        let (mut before, mut reach): (Option<&Vector>, f64) = (None, f64::INFINITY);
        for x in &branch.position {
            reach += before.map_or(0.0, |before| (x - before).norm());
            let mut least = reach;
            for (obstacle, result) in obstacles.iter().zip(&end.obstacles) {
                let into = result.pose.inverse();
                let distance = obstacle.shape.distance(&(into.position + into.orientation * x), least);
                least = least.min(distance);
            }
            all.push(least - 0.5 * branch.diameter);
            (before, reach) = (Some(x), least);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::tests::{STEPS, Y, last, session};
    use super::*;

    #[test]
    fn a_sphere_is_as_far_as_its_centre_less_both_radii() {
        let ball =
            "[[obstacles]]\nname = \"ball\"\nshape = \"sphere\"\nradius = \"30 mm\"\nposition = [0.3, 0.3, 0.1]\n";
        let session = session(&format!("{Y}{STEPS}\n{ball}"));
        let end = last(&session);
        let found = of_nodes(&session.now.harness.network.obstacles, &end);
        let nodes = end.branches.iter().flat_map(|branch| branch.position.iter().map(|x| (x, branch.diameter)));
        assert_eq!(found.len(), nodes.clone().count());
        for ((x, diameter), distance) in nodes.zip(&found) {
            let expected = (x - Vector::new(0.3, 0.3, 0.1)).norm() - 0.03 - 0.5 * diameter;
            assert!((distance - expected).abs() < 1e-12, "{distance} not {expected}");
        }
        let frames = session.frames_from(session.now.frames() - 1);
        let (_, nodes) = crate::frame::decode(frames[0].as_ref().expect("there")).expect("a frame");
        assert!(nodes.iter().zip(&found).all(|(node, distance)| node[crate::frame::FLOATS - 1] == *distance as f32));
    }
}
