//! Faults of constraints that hold a cable inside a body: no shape of the cable satisfies them.

use std::collections::HashSet;
use wireloom_core::constraint::Action;
use wireloom_core::steps::{Bodies, Move, Step};
use wireloom_core::{Network, Pose, Rotation, Vector};
use wireloom_scenario::{Built, Fault, Scenario};

/// Tolerance of the depth beyond the cable's radius, m: round-off of what is meant to touch.
const ROUND_OFF: f64 = 1e-9;

/// One fault for each constraint and step in which the held point is deeper inside an obstacle than the radius of the
/// cable, at the deepest place. A body that moves in a step is ignored in it: it may make room.
pub(crate) fn refuse_inside(scenario: &Scenario, built: &Built) -> Vec<Fault> {
    let network = &built.network;
    let mut bodies: Vec<Pose> = network.obstacles.iter().map(|obstacle| obstacle.pose).collect();
    if bodies.is_empty() {
        return Vec::new();
    }
    let mut faults = Vec::new();
    let standing = |bodies: &[Pose], moving: &HashSet<usize>| -> Vec<(usize, Pose)> {
        bodies.iter().copied().enumerate().filter(|(o, _)| !moving.contains(o)).collect()
    };
    // Position of each constraint, and its orientation if known; of those on a body, as the mechanism is drawn.
    let given =
        |f: usize| network.constraints[f].position.map(|position| (position, network.constraints[f].orientation));
    let mut held: Vec<Option<(Vector, Option<Rotation>)>> =
        (0..network.constraints.len()).map(|f| given(f).filter(|_| network.constraints[f].from_start)).collect();
    let mut carriers = Bodies::drawn(&network.mechanisms);
    let mount = |f: usize| network.constraints[f].mount;
    let all = standing(&bodies, &HashSet::new());
    let of_constraint = |f: usize| scenario.constraints[f].spans.of(Some("position"));
    for (f, at) in held.iter().enumerate() {
        let deepest = at.and_then(|(x, _)| deepest(network, f, &[x], &all));
        faults.extend(deepest.map(|deep| deep.fault(scenario, of_constraint(f), "holds the cable")));
    }
    for (step, span) in scenario.steps.iter().zip(&scenario.step_spans) {
        carriers.drive(&step.drives);
        let carried = (0..bodies.len()).filter(|o| carriers.moves(network.obstacles[*o].mount));
        let moving: HashSet<usize> = step.obstacle_moves.iter().map(|m| m.obstacle).chain(carried).collect();
        // A way against a body that moves is left out.
        let in_world = |f: usize, x: &Vector| carriers.under(mount(f)).world(x);
        let all = standing(&bodies, &moving);
        for &f in step.release.iter().chain(&step.add) {
            held[f] = None;
        }
        let begin = held.clone();
        for (f, ways) in step.moves.iter().flat_map(|m| ways(m, &begin, step)) {
            let passed = if carriers.moves(mount(f)) { &[][..] } else { &ways.passed };
            let passed: Vec<Vector> = passed.iter().map(|x| in_world(f, x)).collect();
            let deepest = deepest(network, f, &passed, &all);
            let what = format!("in step \"{}\" takes the cable", step.name);
            faults.extend(deepest.map(|deep| deep.fault(scenario, span.clone(), &what)));
            held[f] = ways.end;
        }
        for &f in step.add.iter().filter(|f| !step.moves.iter().flat_map(|m| &m.carried).any(|c| c.constraint == **f)) {
            held[f] = given(f);
            let deepest = held[f].and_then(|(x, _)| deepest(network, f, &[in_world(f, &x)], &all));
            faults.extend(deepest.map(|deep| deep.fault(scenario, of_constraint(f), "holds the cable")));
        }
        for (body, own) in bodies.iter_mut().zip(&network.obstacles).filter(|(_, own)| carriers.moves(own.mount)) {
            *body = carriers.under(own.mount).compose(&own.pose);
        }
        for motion in &step.obstacle_moves {
            bodies[motion.obstacle] = motion.track.from(&bodies[motion.obstacle]).at(1.0);
        }
    }
    faults
}

/// Positions of a constraint in a step, as far as they are known.
struct Ways {
    passed: Vec<Vector>,
    end: Option<(Vector, Option<Rotation>)>,
}

/// Positions of all constraints that take part in a motion.
fn ways(motion: &Move, held: &[Option<(Vector, Option<Rotation>)>], step: &Step) -> Vec<(usize, Ways)> {
    // A start at an unknown place leaves everything open but the points of the path itself.
    let stand_in = |f: usize| {
        let (position, orientation) = held[f].unwrap_or((Vector::zeros(), None));
        Pose { position, orientation: orientation.unwrap_or_else(Rotation::identity) }
    };
    let first = motion.carried.first().map(|carried| carried.constraint);
    let turned_known = |f: usize| held[f].is_some_and(|(_, orientation)| orientation.is_some());
    let origin_known = motion.origin.0.is_some() || first.is_some_and(|f| held[f].is_some());
    let turns = !motion.track.turns.is_empty() || motion.track.spin != 0.0;
    let turn_known = !turns || motion.origin.1.is_some() || first.is_some_and(turned_known);
    let alone = motion.carried.len() == 1 && motion.origin == (None, None);
    let fractions: Vec<f64> = (1..=step.increments).map(|k| k as f64 / step.increments as f64).collect();
    let way = |(k, journey): (usize, wireloom_core::steps::Journey)| {
        let f = journey.constraint();
        let carried = motion.carried[k];
        let known = held[f].is_some() && origin_known && (turn_known || alone);
        let passed = if known {
            fractions.iter().copied().chain(motion.corners()).map(|t| journey.at(t).position).collect()
        } else if alone {
            motion.track.positions.iter().map(|(_, x)| *x).collect()
        } else {
            Vec::new()
        };
        let ends_at = journey.at(carried.delay + carried.fraction);
        let placed = known || alone && motion.track.positions.last().is_some_and(|(t, _)| *t == 1.0);
        let orientation = (turn_known && turned_known(f)).then_some(ends_at.orientation);
        (f, Ways { passed, end: placed.then_some((ends_at.position, orientation)) })
    };
    motion.journeys(stand_in).into_iter().enumerate().map(way).collect()
}

/// Constraint that holds its cable inside a body.
struct Deep {
    constraint: usize,
    obstacle: usize,
    depth: f64,
    radius: f64,
    at: Vector,
}

/// What a reader of the scenario would refuse of a motion of a constraint to `position` among obstacles at these poses:
/// the obstacle and the depth (m) to which it would hold the cable there.
pub(crate) fn too_deep<'n>(
    network: &'n Network,
    f: usize,
    position: &Vector,
    poses: &[Pose],
) -> Option<(&'n str, f64)> {
    let bodies: Vec<(usize, Pose)> = poses.iter().copied().enumerate().collect();
    let deep = deepest(network, f, &[*position], &bodies)?;
    Some((network.obstacles[deep.obstacle].name.as_str(), deep.depth))
}

/// Deepest of some positions of a constraint that prescribes them, if it is deeper than the cable's radius.
fn deepest(network: &Network, f: usize, places: &[Vector], bodies: &[(usize, Pose)]) -> Option<Deep> {
    let constraint = &network.constraints[f];
    let Action::Prescribed(hold) = constraint.model.action() else { return None };
    if !hold.position || !hold.rails.is_empty() {
        return None;
    }
    let radius = 0.5 * network.diameter_at(constraint.place);
    let mut deepest: Option<Deep> = None;
    for &(obstacle, pose) in bodies {
        for at in places {
            let own = pose.local(at);
            let depth = -network.obstacles[obstacle].shape.distance(&own, radius);
            if depth > deepest.as_ref().map_or(radius + ROUND_OFF, |deep| deep.depth) {
                deepest = Some(Deep { constraint: f, obstacle, depth, radius, at: *at });
            }
        }
    }
    deepest
}

impl Deep {
    fn fault(&self, scenario: &Scenario, span: std::ops::Range<usize>, what: &str) -> Fault {
        let Self { constraint, obstacle, depth, radius, at } = self;
        Fault {
            span,
            message: format!(
                "constraint \"{}\" {what} {:.1} mm inside obstacle \"{}\", at [{:.4}, {:.4}, {:.4}]",
                scenario.constraints[*constraint].name,
                1e3 * depth,
                scenario.obstacles[*obstacle].obstacle.name,
                at.x,
                at.y,
                at.z
            ),
            help: format!(
                "hold its centre line outside; what is fastened to a body may lie as deep as the cable's radius, {:.1} \
                 mm",
                1e3 * radius
            ),
        }
    }
}
