//! Bodies that are driven into what constraints hold, or constraints that carry their cable into bodies: no shape of
//! the cable gives way there. Open meshes have no inside: nothing is driven into them.

use wireloom_core::conditions::Conditions;
use wireloom_core::constraint::Action;
use wireloom_core::network::AttachedConstraint;
use wireloom_core::obstacle::Obstacle;
use wireloom_core::{Network, Pose, Vector};

/// Change of the distance of a held centre line from an obstacle that is round-off, in radii of the cable.
const SAME_DEPTH: f64 = 1e-6;
/// Smallest distance between looks at a body on its way, in radii of the cable.
const CLOSEST_LOOKS: f64 = 0.05;
/// Largest number of looks from one of the [`Places`] to the next.
const MOST_LOOKS: f64 = 1e3;

/// Where constraints and obstacles are at one moment.
pub(crate) struct Places {
    targets: Vec<Pose>,
    obstacles: Vec<Pose>,
}

impl Places {
    /// Under these conditions.
    pub fn of(conditions: &Conditions) -> Self {
        Self { targets: conditions.targets.clone(), obstacles: conditions.contact.poses.clone() }
    }

    /// A constraint in the axes of an obstacle, m.
    fn held(&self, constraint: usize, obstacle: usize) -> Vector {
        self.obstacles[obstacle].local(&self.targets[constraint].position)
    }
}

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

/// Whether a constraint holds a place of the cable where it is led.
pub(crate) fn holds_a_place(constraint: &AttachedConstraint) -> bool {
    matches!(constraint.model.action(), Action::Prescribed(hold) if hold.position && hold.rails.is_empty())
}

/// All of them on a way: stretches without a corner, each with its places at equal parts of the step, from its
/// beginning to its end. `acts` tells which constraints act on all of it.
pub(crate) fn driven(network: &Network, acts: impl Fn(usize) -> bool, way: &[Vec<Places>]) -> Vec<Driven> {
    let mut found = Vec::new();
    let held = network.constraints.iter().enumerate().filter(|(f, constraint)| acts(*f) && holds_a_place(constraint));
    for (f, constraint) in held {
        let radius = 0.5 * network.diameter_at(constraint.place);
        for (o, obstacle) in network.obstacles.iter().enumerate() {
            let Some(first) = way.first().and_then(|stretch| stretch.first()) else { continue };
            let was = obstacle.shape.distance(&first.held(f, o), radius).min(0.0);
            let stretches = way.iter().map(|stretch| {
                let places: Vec<Vector> = stretch.iter().map(|places| places.held(f, o)).collect();
                least_distance(obstacle, &places, radius)
            });
            let least = stretches.fold(f64::INFINITY, f64::min);
            if least < was - SAME_DEPTH * radius {
                let stands = way.iter().flatten().all(|places| places.obstacles[o] == first.obstacles[o]);
                let allowed = if stands { radius.max(-was) } else { -was };
                found.push(Driven { constraint: f, obstacle: o, depth: -least, allowed });
            }
        }
    }
    found
}

/// Least distance of a point from an obstacle on its way through these places, in the axes of the obstacle, m; anything
/// above 0 if they do not meet. Between two places the way is taken as straight: what it may bend there, an eighth of
/// the second difference of the places, is taken off a depth.
fn least_distance(obstacle: &Obstacle, places: &[Vector], radius: f64) -> f64 {
    let at_places = places.iter().map(|x| obstacle.shape.distance(x, radius)).fold(f64::INFINITY, f64::min);
    let bend = |k: usize| match (k.checked_sub(1).map(|before| places[before]), places.get(k + 1)) {
        (Some(before), Some(after)) => 0.125 * (before + after - places[k] * 2.0).norm(),
        _ => 0.0,
    };
    let between = places
        .array_windows()
        .enumerate()
        .map(|(k, [from, to])| between_places(obstacle, [from, to], radius) + bend(k).max(bend(k + 1)));
    between.fold(at_places, f64::min)
}

/// The same on a straight line. The distance changes by at most the way, so that looks may be as far apart as it takes
/// to a smaller one.
fn between_places(obstacle: &Obstacle, [from, to]: [&Vector; 2], radius: f64) -> f64 {
    let way = (to - from).norm();
    let closest = (CLOSEST_LOOKS * radius).max(way / MOST_LOOKS);
    let (mut least, mut t) = (f64::INFINITY, 0.0);
    while t < 1.0 && way > 0.0 {
        let here = obstacle.shape.distance(&from.lerp(to, t), way * (1.0 - t) + radius);
        least = least.min(here);
        t += (here - least.min(0.0)).max(closest) / way;
    }
    least
}
