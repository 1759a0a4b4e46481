//! Bodies that are driven into what constraints hold, or constraints that carry their cable into bodies: no shape of
//! the cable gives way there.

use wireloom_core::conditions::Conditions;
use wireloom_core::constraint::Action;
use wireloom_core::obstacle::Obstacle;
use wireloom_core::problem::Problem;
use wireloom_core::{Pose, Rotation, Vector};

/// Change of the distance of a held centre line from an obstacle that is round-off, in radii of the cable.
const SAME_DEPTH: f64 = 1e-6;
/// Smallest distance between looks at a body on its way, in radii of the cable.
const CLOSEST_LOOKS: f64 = 0.05;
/// Largest number of looks on a way.
const MOST_LOOKS: f64 = 1e4;

/// A constraint that holds its cable in an obstacle, deeper than at the beginning of the increment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Driven {
    /// Index of the constraint.
    pub constraint: usize,
    /// Index of the obstacle.
    pub obstacle: usize,
    /// Largest depth of the centre line below the surface on the way through the increment, m.
    pub depth: f64,
    /// Depth that is no fault, m: that at the beginning, and in a body that stands the radius of the cable, as in the
    /// check of a scenario.
    pub allowed: f64,
}

/// All of them on the way from the conditions `before` to the present ones, along which everything moves and turns
/// uniformly.
pub(crate) fn driven(problem: &Problem<'_>, before: &Conditions) -> Vec<Driven> {
    let (network, now) = (problem.network, problem.conditions());
    let mut found = Vec::new();
    let acting = network.constraints.iter().enumerate().filter(|(f, _)| now.active[*f] && before.active[*f]);
    for (f, constraint) in acting {
        let Action::Prescribed(hold) = constraint.model.action() else { continue };
        if !hold.position || !hold.rails.is_empty() {
            continue;
        }
        let radius = 0.5 * network.diameter_at(constraint.place);
        let held = [before, now].map(|at| at.targets[f].position);
        for (o, obstacle) in network.obstacles.iter().enumerate() {
            let poses = [before, now].map(|at| at.contact.poses[o]);
            let was = obstacle.shape.distance(&poses[0].local(&held[0]), radius).min(0.0);
            let least = least_distance(obstacle, poses, held, radius);
            if least < was - SAME_DEPTH * radius {
                let allowed = if poses[0] == poses[1] { radius.max(-was) } else { -was };
                found.push(Driven { constraint: f, obstacle: o, depth: -least, allowed });
            }
        }
    }
    found
}

/// Least distance of a point from an obstacle while both go from the first to the second of these places, m; anything
/// above 0 if they do not meet. The distance changes by at most the way of the one relative to the other, so that looks
/// may be as far apart as they are from each other.
fn least_distance(obstacle: &Obstacle, [from, to]: [Pose; 2], [x, y]: [Vector; 2], radius: f64) -> f64 {
    let turn = from.orientation.rotation_to(&to.orientation).scaled_axis();
    let arm = (x - from.position).norm().max((y - to.position).norm());
    let way = (y - x).norm() + (to.position - from.position).norm() + turn.norm() * arm;
    let distance = |t: f64, reach: f64| {
        let orientation = Rotation::new(turn * t) * from.orientation;
        let pose = Pose { position: from.position.lerp(&to.position, t), orientation };
        obstacle.shape.distance(&pose.local(&x.lerp(&y, t)), reach)
    };
    let closest = (CLOSEST_LOOKS * radius).max(way / MOST_LOOKS);
    let mut least = obstacle.shape.distance(&to.local(&y), radius);
    let mut t = 0.0;
    while t < 1.0 && way > 0.0 {
        let left = way * (1.0 - t);
        let here = distance(t, left + radius);
        least = least.min(here);
        t += here.abs().max(closest) / way;
    }
    least
}
