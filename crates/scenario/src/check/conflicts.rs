//! Refuses constraints that do not fit where they attach, or that contradict one another.

use super::timeline::stages;
use crate::attachment::At;
use crate::fault::Fault;
use crate::scenario::{Facing, Scenario};
use std::collections::{BTreeMap, BTreeSet};
use wireloom_core::constraint::Hold;
use wireloom_core::load::{Axes, LoadAction};
use wireloom_core::network::Load;
use wireloom_core::rotation::columns;
use wireloom_core::steps::{Bodies, Move, Turn};
use wireloom_core::{Action, Matrix, Network, Pose, Rotation, RotationHold, Vector};

/// Constraints and loads that need a frame, or freedoms, that their place does not have.
pub(crate) fn refuse_misplaced(scenario: &Scenario, network: &Network) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (own, constraint) in scenario.constraints.iter().zip(&network.constraints) {
        if constraint.model.needs_frame()
            && let Some(site) = constraint.stations.iter().find(|site| site.frame.is_none())
        {
            faults.push(Fault {
                span: own.spans.of(Some("at")),
                message: format!(
                    "constraint \"{}\" holds more than the position at joint {}, which has no frame",
                    own.name,
                    joint_name(network, site.point),
                ),
                help: "write hold = [\"position\"], attach it further along a branch, or use a joint model with a body"
                    .to_owned(),
            });
        } else if constraint.site.local.position != Vector::zeros() && holds_a_part(constraint.model.action()) {
            faults.push(Fault {
                span: own.spans.of(Some("at")),
                message: format!(
                    "constraint \"{}\" holds some freedoms of an arm that leaves joint {} with an offset",
                    own.name,
                    joint_name(network, constraint.site.point),
                ),
                help: "let it hold position, tangent and twist, attach it to the joint, or one segment away".to_owned(),
            });
        }
    }
    faults.extend(refuse_bad_slides(scenario, network));
    faults.extend(refuse_bad_shapes(scenario, network));
    for (own, load) in scenario.loads.iter().zip(&network.loads) {
        let mut refuse = |key: &str, message: String, help: &str| {
            faults.push(Fault { span: own.spans.of(Some(key)), message, help: help.to_owned() });
        };
        match &load.action {
            LoadAction::At { place, load } if place.site.frame.is_none() => {
                let (joint, help) = (
                    joint_name(network, place.site.point),
                    "attach it further along a branch, or use a joint model with a body",
                );
                if load.axes() == Axes::Frame {
                    refuse("follows", format!("load \"{}\" follows joint {joint}, which has no frame", own.name), help);
                } else if load.without_potential().is_some() {
                    let message = format!("load \"{}\" has a moment at joint {joint}, which has no frame", own.name);
                    refuse("moment", message, help);
                }
            }
            LoadAction::At { .. } => {}
            LoadAction::Along { spans, .. } => {
                if let Some(span) = spans.iter().find(|span| network.branches[span.branch].mesh_moves) {
                    let message = format!(
                        "load \"{}\" acts along branch \"{}\", whose mesh moves along the cable",
                        own.name, network.branches[span.branch].name
                    );
                    let help = "leave out the constraints that slide on that branch or close at its nearest place";
                    refuse("span", message, help);
                }
            }
        }
    }
    faults
}

/// Refuses sliding at places where something else attaches to the material.
fn refuse_bad_slides(scenario: &Scenario, network: &Network) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (index, (own, constraint)) in scenario.constraints.iter().zip(&network.constraints).enumerate() {
        if constraint.slide.is_none() {
            continue;
        }
        let others = network.constraints.iter().enumerate();
        let other = others.filter(|(k, _)| *k != index).find(|(_, other)| other.places.contains(&constraint.place));
        let acts_here =
            |load: &&Load| matches!(&load.action, LoadAction::At { place, .. } if place.point == constraint.site.point);
        let load = network.loads.iter().find(acts_here);
        let message = match (other, load) {
            (Some((_, other)), _) => {
                format!(
                    "the cable cannot slide through constraint \"{}\": \"{}\" attaches at the same place",
                    own.name, other.name
                )
            }
            (_, Some(load)) => {
                format!(
                    "the cable cannot slide through constraint \"{}\": load \"{}\" acts at the same place",
                    own.name, load.name
                )
            }
            (None, None) => continue,
        };
        faults.push(Fault {
            span: own.spans.of(Some("at")),
            message,
            help: "attach a sliding constraint within a branch, at an arc length of its own".to_owned(),
        });
    }
    faults
}

/// Refuses constraints that prescribe more than one station, equations without a valid scale, and spans on a branch
/// whose mesh moves along the cable.
fn refuse_bad_shapes(scenario: &Scenario, network: &Network) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (own, constraint) in scenario.constraints.iter().zip(&network.constraints) {
        let mut refuse = |key: &str, message: String, help: &str| {
            faults.push(Fault { span: own.spans.of(Some(key)), message, help: help.to_owned() });
        };
        let name = &own.name;
        if matches!(constraint.model.action(), Action::Prescribed(_))
            && (constraint.stations.len() != 1 || constraint.span.is_some())
        {
            let message = format!("constraint \"{name}\" prescribes freedoms, but does not attach to one place alone");
            refuse(
                "at",
                message,
                "give one place in `at` and no `span`: a constraint prescribes one station's freedoms",
            );
        }
        if let Some(invalid) =
            constraint.residuals.iter().find(|residual| !(residual.scale > 0.0 && residual.scale.is_finite()))
        {
            let message = format!("constraint \"{name}\" has an equation with the scale {}", invalid.scale);
            refuse("kind", message, "this is a fault of its kind: a scale is a positive number");
        }
        if let Some(span) = constraint.span.as_ref().filter(|span| network.branches[span.branch].mesh_moves) {
            let branch = &network.branches[span.branch].name;
            let message =
                format!("constraint \"{name}\" acts along branch \"{branch}\", which slides through another one");
            refuse("span", message, "use no sliding constraint on that branch, or divide it by a joint");
        }
    }
    faults
}

fn joint_name(network: &Network, point: usize) -> String {
    network
        .joints
        .iter()
        .find(|joint| joint.point == point)
        .map(|joint| format!("\"{}\"", joint.name))
        .unwrap_or_default()
}

/// Whether some freedoms are prescribed, and others are not.
fn holds_a_part(action: Action<'_>) -> bool {
    match action {
        Action::Prescribed(Hold { position: true, rails, rotation: RotationHold::All }) => !rails.is_empty(),
        Action::Prescribed(_) => true,
        _ => false,
    }
}

/// Source of a held value: given by the file, or found as the pose of the cable when a constraint (by index) begins.
#[derive(Clone, Copy, PartialEq)]
enum Held<T> {
    Given(T),
    Found(usize),
}

/// A given direction or frame.
#[derive(Clone, Copy, PartialEq)]
enum Faced {
    Tangent(Vector),
    Frame(Rotation),
}

/// The values that a constraint prescribes while it acts; of one that is mounted on a body, in the axes of that.
struct Target<'n> {
    hold: &'n Hold,
    position: Held<Vector>,
    facing: Held<Faced>,
}

/// Pairs of constraints that hold the same freedom of the same place at the same time in different ways.
pub(crate) fn refuse_contradictions(scenario: &Scenario, network: &Network) -> Vec<Fault> {
    let mut faults = Vec::new();
    let mut reported = BTreeSet::new();
    let mut targets: Vec<Option<Target<'_>>> = network.constraints.iter().map(|_| None).collect();
    let mut bodies = Bodies::drawn(&network.mechanisms);
    for stage in stages(scenario) {
        // Constraints with given values come first: those that begin at the same place without values take these
        // over. A constraint of a step begins at the pose of the cable and moves from there to its given values.
        let mut begins = stage.begins.clone();
        begins.sort_by_key(|constraint| scenario.constraints[*constraint].position.is_none());
        let mut at_point: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for constraint in &stage.active {
            at_point.entry(network.constraints[*constraint].site.point).or_default().push(*constraint);
        }
        let beside = |constraint: usize| {
            let here = at_point.get(&network.constraints[constraint].site.point);
            here.into_iter().flatten().copied().filter(move |other| *other != constraint)
        };
        for constraint in &begins {
            let given = if stage.step.is_none() { given(scenario, *constraint) } else { (None, None) };
            targets[*constraint] = begin((network, &bodies), &targets, beside(*constraint), *constraint, given);
        }
        // Only constraints that begin or move can newly contradict others.
        let mut check = |bodies: &Bodies<'_>, targets: &[Option<Target<'_>>], changed: &[usize]| {
            for one in changed {
                for other in beside(*one) {
                    let (a, b) = (other.min(*one), other.max(*one));
                    let Some(what) = contradiction((network, bodies), targets, a, b) else { continue };
                    if reported.insert((a, b)) {
                        faults.push(fault(scenario, a, b, what, &stage.label));
                    }
                }
            }
        };
        check(&bodies, &targets, &begins);
        for &constraint in &begins {
            let Some(target) = &mut targets[constraint] else { continue };
            let (position, facing) = given(scenario, constraint);
            target.position = position.unwrap_or(target.position);
            target.facing = facing.unwrap_or(target.facing);
        }
        for motion in stage.step.into_iter().flat_map(|step| &step.moves) {
            moved(motion, &mut targets);
            begins.extend(motion.carried.iter().map(|carried| carried.constraint));
        }
        bodies.drive(stage.step.map_or(&[], |step| &step.drives));
        begins.extend(stage.active.iter().filter(|f| bodies.moves(network.constraints[**f].mount)));
        check(&bodies, &targets, &begins);
    }
    faults
}

/// Sets the targets after a motion: the end of its track, except for constraints that follow the first one as a body.
fn moved(motion: &Move, targets: &mut [Option<Target<'_>>]) {
    let leads = motion.origin == (None, None);
    let track = &motion.track;
    for (k, carried) in motion.carried.iter().enumerate() {
        let constraint = carried.constraint;
        let Some(target) = &mut targets[constraint] else { continue };
        if !(k == 0 && leads) {
            (target.position, target.facing) = (Held::Found(constraint), Held::Found(constraint));
            continue;
        }
        if let Some((_, position)) = track.positions.last() {
            target.position = Held::Given(*position);
        }
        match track.turns.last() {
            None if track.spin != 0.0 => target.facing = Held::Found(constraint),
            None | Some((_, Turn::Keep)) => {}
            Some((_, Turn::Tangent(tangent))) => target.facing = Held::Given(Faced::Tangent(*tangent)),
            Some((_, Turn::Orientation(frame))) => target.facing = Held::Given(Faced::Frame(*frame)),
        }
    }
}

fn fault(scenario: &Scenario, a: usize, b: usize, what: &str, when: &str) -> Fault {
    let (first, second) = (&scenario.constraints[a], &scenario.constraints[b]);
    let place = match second.place() {
        At::Joint(joint) => format!("joint \"{}\"", scenario.joints[joint].name),
        At::Branch { branch, s } => format!("s = {s} m of branch \"{}\"", scenario.branches[branch].name),
    };
    Fault {
        span: second.spans.of(None),
        message: format!(
            "constraints \"{}\" and \"{}\" hold {what} at {place} differently {when}",
            first.name, second.name
        ),
        help: "release one before the other begins, or let them hold different freedoms with `hold`".to_owned(),
    }
}

/// Whether two constraints attach to the same point and frame with the same local pose.
fn same_place(network: &Network, a: usize, b: usize) -> bool {
    network.constraints[a].site == network.constraints[b].site
}

/// Position and facing that the file gives a constraint.
type Given = (Option<Held<Vector>>, Option<Held<Faced>>);

fn given(scenario: &Scenario, constraint: usize) -> Given {
    let own = &scenario.constraints[constraint];
    let facing = match own.facing {
        Facing::Left => None,
        Facing::Tangent(tangent) => Some(Held::Given(Faced::Tangent(tangent))),
        Facing::Orientation(frame) => Some(Held::Given(Faced::Frame(frame))),
    };
    (own.position.map(Held::Given), facing)
}

/// The target of a constraint when it begins: its given values, or those that others already hold there, or the pose
/// of the cable; `None` if it prescribes nothing.
fn begin<'n>(
    (network, bodies): (&'n Network, &Bodies<'_>),
    targets: &[Option<Target<'n>>],
    at_point: impl Iterator<Item = usize> + Clone,
    constraint: usize,
    (position, facing): Given,
) -> Option<Target<'n>> {
    let Action::Prescribed(hold) = network.constraints[constraint].model.action() else { return None };
    let beside = || {
        let others = at_point.clone().filter(|other| same_place(network, constraint, *other));
        others.filter_map(|other| {
            targets[other].as_ref().map(|target| (bodies.under(network.constraints[other].mount), target))
        })
    };
    let own = bodies.under(network.constraints[constraint].mount).inverse();
    let point = || beside().find(|(_, other)| other.hold.position && other.hold.rails.is_empty());
    let point = || point().map(|(body, other)| moved_with(&own, moved_with(&body, other.position)));
    let frame = || beside().find(|(_, other)| other.hold.rotation != RotationHold::Free);
    let frame = || frame().map(|(body, other)| turned_with(&own, turned_with(&body, other.facing)));
    let (found, found_facing) = (Held::Found(constraint), Held::Found(constraint));
    Some(Target {
        hold,
        position: position.or_else(point).unwrap_or(found),
        facing: facing.or_else(frame).unwrap_or(found_facing),
    })
}

/// A position, moved as a body is.
fn moved_with(body: &Pose, position: Held<Vector>) -> Held<Vector> {
    match position {
        Held::Given(x) => Held::Given(body.world(&x)),
        Held::Found(f) => Held::Found(f),
    }
}

/// A direction or frame, turned as a body is.
fn turned_with(body: &Pose, facing: Held<Faced>) -> Held<Faced> {
    match facing {
        Held::Given(Faced::Tangent(d)) => Held::Given(Faced::Tangent(body.orientation * d)),
        Held::Given(Faced::Frame(frame)) => Held::Given(Faced::Frame(body.orientation * frame)),
        Held::Found(f) => Held::Found(f),
    }
}

/// The freedom that two constraints hold differently, if any.
fn contradiction(
    (network, bodies): (&Network, &Bodies<'_>),
    targets: &[Option<Target<'_>>],
    a: usize,
    b: usize,
) -> Option<&'static str> {
    if network.constraints[a].site.point != network.constraints[b].site.point {
        return None;
    }
    let (first, second) = (targets[a].as_ref()?, targets[b].as_ref()?);
    let mounts = [a, b].map(|f| network.constraints[f].mount);
    let [one, other] = mounts.map(|mount| bodies.under(mount));
    let [p, q] = [moved_with(&one, first.position), moved_with(&other, second.position)];
    let faced = [turned_with(&one, first.facing), turned_with(&other, second.facing)];
    // One of them moves away from the other on its body.
    let part = mounts[0] != mounts[1] && mounts.iter().any(|mount| bodies.moves(*mount));
    let same = same_place(network, a, b) && !part;
    let shared = shared_directions(&first.hold.held_directions(), &second.hold.held_directions());
    let differ = |d: &Vector| match (p, q) {
        (Held::Given(p), Held::Given(q)) => d.dot(&(p - q)).abs() > 1e-9 * (1.0 + p.norm()),
        (p, q) => p != q,
    };
    if shared.iter().any(|d| !same || differ(d)) {
        return Some("the position");
    }
    match (first.hold.rotation, second.hold.rotation) {
        (RotationHold::Free, _) | (_, RotationHold::Free) => None,
        (RotationHold::Tangent, RotationHold::Twist) | (RotationHold::Twist, RotationHold::Tangent) => None,
        (RotationHold::Tangent, _) | (_, RotationHold::Tangent) => {
            let differ = match faced.map(tangent) {
                [Some(p), Some(q)] => (p - q).norm() > 1e-9,
                _ => faced[0] != faced[1],
            };
            (!same || differ).then_some("the tangent")
        }
        _ => {
            let differ = match faced {
                [Held::Given(Faced::Frame(p)), Held::Given(Faced::Frame(q))] => p.angle_to(&q) > 1e-7,
                [p, q] => p != q,
            };
            (!same || differ).then_some("the orientation")
        }
    }
}

fn tangent(facing: Held<Faced>) -> Option<Vector> {
    match facing {
        Held::Given(Faced::Tangent(tangent)) => Some(tangent),
        Held::Given(Faced::Frame(frame)) => Some(columns(&frame)[2]),
        Held::Found(_) => None,
    }
}

/// Orthonormal basis of the directions common to two subspaces with orthonormal bases: the eigenvectors of
/// `P_A P_B P_A` to the eigenvalue 1.
fn shared_directions(a: &[Vector], b: &[Vector]) -> Vec<Vector> {
    let projector = |basis: &[Vector]| basis.iter().map(|d| d * d.transpose()).sum::<Matrix>();
    let (pa, pb) = (projector(a), projector(b));
    let eigen = (pa * pb * pa).symmetric_eigen();
    (0..3).filter(|k| eigen.eigenvalues[*k] > 1.0 - 1e-9).map(|k| eigen.eigenvectors.column(k).into_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_common_to_two_planes() {
        let shared = shared_directions(&[Vector::x(), Vector::y()], &[Vector::y(), Vector::z()]);
        assert_eq!(shared.len(), 1);
        assert!((shared[0].y.abs() - 1.0).abs() < 1e-12);
        assert!(shared_directions(&[Vector::x()], &[Vector::y()]).is_empty());
        assert!(shared_directions(&[], &[Vector::y()]).is_empty());
    }
}
