//! Events of an increment: exceeded limits, jumps, instability, slip, and missing convergence.

use super::log::{EventLog, Occurrence};
use crate::report::clearance::{Cables, clearances, keep_least};
use crate::report::driven::Driven;
use crate::report::spans::{self, Spans};
use crate::report::twist_loss::RESOLVED_TURN;
use crate::steps::certificate::FEASIBLE;
use std::collections::BTreeMap;
use wireloom_core::conditions::Partner;
use wireloom_core::equilibrium::{
    BranchResult, Clearance, ClearanceFrom, ConstraintResult, OperationResult, SlideMotion, StepResult,
};
use wireloom_core::minimiser::Stop;
use wireloom_core::problem::Problem;
use wireloom_core::sections::Bend;
use wireloom_core::status::Status;
use wireloom_core::terms::contact::{ContactViolation, HeldOverlap, Lack};
use wireloom_core::{EventKind, EventPlace, Network, Pose, State};

/// Factor on the previous move above which a move may be a jump.
const OUT_OF_PROPORTION: f64 = 2.0;
/// The same where nothing moved before: on the prescribed move, and on the prescribed turn times the length of the
/// longest branch. A taut cable moves several times as far as its end.
const BEYOND_PRESCRIBED: [f64; 2] = [8.0, 2.0];
/// Least move of a jump, as a fraction of the branch that moves farthest.
pub const FAR: f64 = 0.01;

/// Largest prescribed motion from some targets to others: the largest move (m) and turn (rad) of the targets of the
/// active constraints.
pub fn prescribed(active: &[bool], from: &[Pose], to: &[Pose]) -> [f64; 2] {
    let mut most = [0.0_f64; 2];
    for ((from, to), _) in from.iter().zip(to).zip(active).filter(|(_, active)| **active) {
        most[0] = most[0].max((to.position - from.position).norm());
        most[1] = most[1].max(to.orientation.angle_to(&from.orientation));
    }
    most
}

/// Whether a harness that `moved` by this distance (m) in an increment moved out of proportion to the previous
/// increment (`previous`, m) or, where nothing moved in that, to the prescribed motion (m, rad). `longest` is the
/// length of the longest branch, m.
pub fn is_out_of_proportion(moved: f64, previous: f64, prescribed: [f64; 2], longest: f64) -> bool {
    let expected = if previous > 0.0 {
        OUT_OF_PROPORTION * previous
    } else {
        BEYOND_PRESCRIBED[0] * prescribed[0] + BEYOND_PRESCRIBED[1] * longest * prescribed[1]
    };
    moved > expected
}

/// Jump event of an increment in which the harness `moved` by this distance (m), and no equilibrium was found within
/// the allowed iterations.
pub fn jump_unseen(moved: f64) -> Occurrence {
    Occurrence {
        kind: EventKind::Jump,
        place: EventPlace::default(),
        value: Some(moved),
        limit: None,
        message: format!(
            "moved by {:.1} mm in one increment, and was found with more iterations than are allowed, after smaller \
             increments did not help",
            1e3 * moved
        ),
    }
}

/// Logs the events at the end of an increment: of one that is no equilibrium only what may be the reason. With `all`,
/// all clearances are kept, not only the required ones.
pub(crate) fn log_increment(
    log: &mut EventLog,
    problem: &mut Problem<'_>,
    state: &State,
    end: &StepResult,
    (cables, spans): (&Cables<'_>, &Spans),
    (stop, all): (&Stop, bool),
) {
    overlaps(log, problem);
    passed_through(log, problem.network, cables);
    if end.status.is_balanced() {
        bends(log, &end.branches);
        short_clearances(log, problem, cables, all);
        constraints(log, problem, &end.constraints);
        slides(log, end);
        insertions(log, end);
    }
    coarse_meshes(log, problem, state);
    for span in spans::overstretched(problem.network, spans) {
        log.raise(span);
    }
    if end.stable == Some(false) {
        log.raise(Occurrence {
            kind: EventKind::Unstable,
            place: EventPlace::default(),
            value: None,
            limit: None,
            message: "the equilibrium is not stable: the least disturbance makes the harness leave it".into(),
        });
    }
    if end.status != Status::Converged {
        let allowed = FEASIBLE * stop.force_tolerance;
        let residual = end.minimiser.constraint_residual.filter(|residual| *residual > allowed || residual.is_nan());
        let equations = residual.map_or_else(String::new, |residual| {
            format!("; equations of constraints are off by {residual:.1e}, allowed {allowed:.1e}")
        });
        let shape = end.minimiser.shape_error.map_or_else(String::new, |error| {
            format!("; the next Newton step would move it by {:.1e} mm", 1e3 * error)
        });
        let (place, contact) = problem.worst_contact(state).map_or_else(Default::default, |worst| {
            let (place, what) = contact_violation(problem.network, state, &worst);
            (place, format!("; contact is not met: {what}"))
        });
        log.raise(Occurrence {
            kind: EventKind::NotConverged,
            place,
            value: Some(end.minimiser.force_residual),
            limit: Some(stop.force_tolerance),
            message: format!(
                "not in balance: {}, residual {:.1e}, allowed {:.1e}{equations}{shape}{contact}",
                end.status.word(),
                end.minimiser.force_residual,
                stop.force_tolerance
            ),
        });
    }
}

/// A body that would pass through a cable in this part of a step.
pub(crate) fn passes_through(part: f64) -> Occurrence {
    let parts = 1.0 / part;
    Occurrence {
        kind: EventKind::CutBack,
        place: EventPlace::default(),
        value: Some(parts),
        limit: None,
        message: format!(
            "an obstacle moves so fast that it would pass through a cable in 1/{parts:.0} of the step; let it move less"
        ),
    }
}

/// A body that is driven into what a constraint holds, or a plug into a body.
pub(crate) fn driven_into_body(network: &Network, driven: &Driven) -> Occurrence {
    let (constraint, obstacle) =
        (&network.constraints[driven.constraint].name, &network.obstacles[driven.obstacle].name);
    Occurrence {
        kind: EventKind::Overlap,
        place: EventPlace { obstacle: Some(obstacle.clone()), ..EventPlace::constraint(constraint) },
        value: Some(-driven.depth),
        limit: Some(-driven.allowed),
        message: format!(
            "obstacle `{obstacle}` and the cable that `{constraint}` holds are driven into each other: its centre line \
             is {:.1} mm below the surface",
            1e3 * driven.depth
        ),
    }
}

/// Place and description of a contact violation.
fn contact_violation(network: &Network, state: &State, worst: &ContactViolation) -> (EventPlace, String) {
    let place = EventPlace::branch(&network.branches[worst.branch].name, worst.s);
    let (place, other) = match worst.partner {
        Partner::Obstacle { obstacle, .. } => {
            let name = &network.obstacles[obstacle as usize].name;
            (EventPlace { obstacle: Some(name.clone()), ..place }, format!("obstacle `{name}`"))
        }
        Partner::Cable { branch, segment } => {
            let s = state.arc_lengths(network, branch as usize)[segment as usize];
            (place, format!("branch `{}` near s = {s:.4} m", network.branches[branch as usize].name))
        }
    };
    let message = match worst.lack {
        Lack::Depth(depth) if depth >= 0.0 => format!("the cable lies {:.3} mm deep in {other}", 1e3 * depth),
        Lack::Depth(depth) => format!("the cable pushes {:.3} mm before it touches {other}", -1e3 * depth),
        Lack::Friction(off) => format!("friction on {other} goes by a normal force that is {off:.2e} N off"),
    };
    (place, message)
}

/// Logs constraints that hold their cable inside the cable of another constraint, each with the nearest one.
fn overlaps(log: &mut EventLog, problem: &Problem<'_>) {
    let network = problem.network;
    let constraint = |f: usize| &network.constraints[f].name;
    let mut worst: BTreeMap<usize, HeldOverlap> = BTreeMap::new();
    for overlap in problem.held_overlaps() {
        let known = worst.entry(overlap.constraints[0]).or_insert(*overlap);
        if overlap.distance - overlap.both < known.distance - known.both {
            *known = *overlap;
        }
    }
    for HeldOverlap { constraints: [f, g], distance, both, .. } in worst.into_values() {
        log.raise(Occurrence {
            kind: EventKind::Overlap,
            place: EventPlace::constraint(constraint(f)),
            value: Some(distance),
            limit: Some(both),
            message: format!(
                "holds its cable {:.2} mm from that of `{}`; both together are {:.2} mm thick, so they overlap here",
                1e3 * distance,
                constraint(g),
                1e3 * both
            ),
        });
    }
}

/// Logs cables that lie in each other, or in themselves, deeper than soft cables may.
fn passed_through(log: &mut EventLog, network: &Network, cables: &Cables<'_>) {
    for overlap in cables.overlaps().iter().filter(|overlap| overlap.depth > overlap.allowed) {
        let [branch, other] = overlap.branches.map(|b| &network.branches[b].name);
        let in_what = if branch == other { "itself".to_owned() } else { format!("`{other}`") };
        let advice = if network.contact.cables { "" } else { "; with contact.cables they are kept apart" };
        log.raise(Occurrence {
            kind: EventKind::PassedThrough,
            place: EventPlace {
                other_branch: Some(other.clone()),
                other_s: Some(overlap.s[1]),
                ..EventPlace::branch(branch, overlap.s[0])
            },
            value: Some(overlap.depth),
            limit: Some(overlap.allowed),
            message: format!(
                "lies {:.1} mm deep in {in_what} at s = {:.4} m; soft cables may press into each other by {:.1} \
                 mm{advice}",
                1e3 * overlap.depth,
                overlap.s[1],
                1e3 * overlap.allowed
            ),
        });
    }
}

/// Logs branches whose neighbouring frames turn too far against each other to resolve the cable: a common cause of
/// missing convergence.
fn coarse_meshes(log: &mut EventLog, problem: &Problem<'_>, state: &State) {
    let network = problem.network;
    for (b, branch) in network.branches.iter().enumerate() {
        let mesh = branch.rod.mesh();
        let turns = state.frames[branch.frames.clone()].windows(2).map(|pair| pair[0].angle_to(&pair[1]));
        let worst = turns.enumerate().max_by(|p, q| p.1.total_cmp(&q.1));
        let Some((c, turn)) = worst else { continue };
        if turn <= RESOLVED_TURN {
            continue;
        }
        let s = state.arc_lengths(network, b)[mesh.coupling_nodes[c]];
        let segments = mesh.segments();
        let few = if segments == 1 { "1 segment is".to_owned() } else { format!("{segments} segments are") };
        log.raise(Occurrence {
            kind: EventKind::CoarseMesh,
            place: EventPlace::branch(&branch.name, s),
            value: Some(turn),
            limit: Some(RESOLVED_TURN),
            message: format!(
                "neighbouring segments are turned by {:.0}° against each other, and follow the cable up to {:.0}°: \
                 {few} too few for how it bends or twists there, {:.0} may do",
                turn.to_degrees(),
                RESOLVED_TURN.to_degrees(),
                (segments as f64 * turn / RESOLVED_TURN).ceil()
            ),
        });
    }
}

/// Logs cables closer to an obstacle than required, and updates the least clearances: of all pairs, or of those with a
/// required one.
pub(crate) fn short_clearances(log: &mut EventLog, problem: &Problem<'_>, cables: &Cables<'_>, all: bool) {
    let now = clearances(cables, &problem.conditions().contact.poses, log.now(), all);
    for clearance in now.iter().filter(|clearance| clearance.is_short()) {
        let Clearance { branch, from, distance, s, required, .. } = clearance;
        if let (ClearanceFrom::Obstacle(obstacle), Some(required)) = (from, required) {
            log.raise(Occurrence {
                kind: EventKind::Clearance,
                place: EventPlace { obstacle: Some(obstacle.clone()), ..EventPlace::branch(branch, *s) },
                value: Some(*distance),
                limit: Some(*required),
                message: format!(
                    "{:.1} mm from `{obstacle}`, at least {:.1} mm required",
                    1e3 * distance,
                    1e3 * required
                ),
            });
        }
    }
    keep_least(&mut log.clearances, now);
}

/// Logs branches bent more tightly than their sections allow.
pub(crate) fn bends(log: &mut EventLog, branches: &[BranchResult]) {
    for branch in branches {
        let worst = branch.bends().min_by(Bend::compare);
        if let Some(Bend { s, radius, limit: Some(limit) }) = worst.filter(|bend| bend.use_of_limit() > 1.0) {
            log.raise(Occurrence {
                kind: EventKind::BendRadius,
                place: EventPlace::branch(&branch.name, s),
                value: Some(radius),
                limit: Some(limit),
                message: format!("bend radius {:.1} mm, allowed {:.1} mm", 1e3 * radius, 1e3 * limit),
            });
        }
    }
}

/// Logs constraints loaded beyond their limits.
pub(crate) fn constraints(log: &mut EventLog, problem: &Problem<'_>, results: &[ConstraintResult]) {
    for result in results {
        // A released constraint may have the same name.
        let mut acting =
            problem.network.constraints.iter().zip(&problem.conditions().active).filter(|(_, acts)| **acts);
        let Some((constraint, _)) = acting.find(|(constraint, _)| constraint.name == result.name) else { continue };
        let loads = [
            (EventKind::ConstraintForce, "force", result.largest_force(), constraint.limits.pull_out_force),
            (EventKind::ConstraintMoment, "moment", result.largest_moment(), constraint.limits.max_moment),
        ];
        for (kind, what, value, limit) in loads {
            if let Some(limit) = limit.filter(|limit| value > *limit) {
                let unit = kind.unit();
                log.raise(Occurrence {
                    kind,
                    place: EventPlace::constraint(&constraint.name),
                    value: Some(value),
                    limit: Some(limit),
                    message: format!("takes a {what} of {value:.4} {unit}, bears {limit} {unit}"),
                });
            }
        }
        for declared in constraint.outputs.iter().filter(|output| output.event) {
            let Some((name, value)) = result.outputs.iter().find(|(name, _)| *name == declared.name) else { continue };
            log.raise(Occurrence {
                kind: EventKind::Reported,
                place: EventPlace::constraint(&constraint.name),
                value: Some(*value),
                limit: None,
                message: format!("{name}: {}, {value:.4} {}", declared.doc, declared.quantity.unit())
                    .trim_end()
                    .to_owned(),
            });
        }
    }
}

/// Logs connectors that need a larger insertion force than allowed.
fn insertions(log: &mut EventLog, end: &StepResult) {
    for operation in &end.operations {
        if let OperationResult::Mate { constraint, insertion_force: Some(force), limit: Some(limit), .. } = operation
            && force > limit
        {
            log.raise(Occurrence {
                kind: EventKind::InsertionForce,
                place: EventPlace::constraint(constraint),
                value: Some(*force),
                limit: Some(*limit),
                message: format!("takes {force:.3} N to push home, allowed {limit} N"),
            });
        }
    }
}

/// Logs sliding constraints that slip, stick again or are at a stop.
fn slides(log: &mut EventLog, end: &StepResult) {
    for result in &end.constraints {
        let Some(slide) = &result.slide else { continue };
        let place =
            EventPlace { constraint: Some(result.name.clone()), ..EventPlace::branch(&slide.branch, slide.arc_length) };
        let force = slide.axial_force.abs();
        let (kind, message) = match slide.motion {
            SlideMotion::Slip => (EventKind::Slip, format!("the cable slips against {force:.3} N of friction")),
            SlideMotion::Stopped => {
                (EventKind::SlideStop, format!("the cable cannot run on: its stop takes {force:.3} N"))
            }
            SlideMotion::Stick if log.was_present(EventKind::Slip, &place) => {
                (EventKind::Stick, format!("friction holds the cable again, with {force:.3} N"))
            }
            SlideMotion::Stick | SlideMotion::Free => continue,
        };
        log.raise(Occurrence { kind, place, value: Some(force), limit: None, message });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom_core::Moment;

    fn moment(step: usize, increment: usize) -> Moment {
        Moment { step: format!("step {step}"), step_index: step, increment }
    }

    fn bend(s: f64, radius: f64) -> Occurrence {
        Occurrence {
            kind: EventKind::BendRadius,
            place: EventPlace::branch("trunk", s),
            value: Some(radius),
            limit: Some(0.05),
            message: format!("{radius}"),
        }
    }

    #[test]
    fn a_continued_occurrence_is_one_event_and_a_repeated_one_another() {
        let mut log = EventLog::default();
        let radii = [None, Some((0.1, 0.04)), Some((0.2, 0.02)), Some((0.3, 0.03)), None, Some((0.1, 0.01))];
        for (k, radius) in radii.into_iter().enumerate() {
            log.begin(moment(k / 3, k % 3 + 1));
            if let Some((s, radius)) = radius {
                log.raise(bend(s, radius));
                // A second one in the same increment counts once.
                log.raise(bend(s, radius));
            }
        }
        let events = log.events();
        let [long, again] = events else { panic!("{events:?}") };
        assert_eq!((&long.first, &long.worst, &long.last), (&moment(0, 2), &moment(0, 3), &moment(1, 1)));
        assert_eq!((long.increments, long.value, long.place.s), (3, Some(0.02), Some(0.2)));
        assert_eq!(long.message, "0.02");
        assert_eq!((&again.first, again.increments, again.value), (&moment(1, 3), 1, Some(0.01)));
    }

    #[test]
    fn sticking_after_slip_is_detected_once() {
        let mut log = EventLog::default();
        let place = EventPlace { constraint: Some("ring".into()), ..EventPlace::branch("trunk", 0.1) };
        let moved = EventPlace { s: Some(0.2), ..place.clone() };
        log.begin(moment(0, 1));
        log.raise(Occurrence { kind: EventKind::Slip, place, ..bend(0.1, 1.0) });
        assert!(!log.was_present(EventKind::Slip, &moved));
        log.begin(moment(0, 2));
        assert!(log.was_present(EventKind::Slip, &moved) && !log.was_present(EventKind::Stick, &moved));
        log.begin(moment(0, 3));
        assert!(!log.was_present(EventKind::Slip, &moved));
    }

    #[test]
    fn events_of_different_parts_or_kinds_are_separate() {
        let mut log = EventLog::default();
        log.begin(moment(0, 1));
        log.raise(bend(0.1, 0.04));
        log.raise(Occurrence { place: EventPlace::branch("arm", 0.1), ..bend(0.1, 0.03) });
        log.raise(Occurrence { kind: EventKind::Overstretched, ..bend(0.1, 0.03) });
        assert_eq!(log.events().len(), 3);
    }
}
