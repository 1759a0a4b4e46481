//! Reads the operations of a step in the words of the trade, and makes motions of them: grasp, carry, mate, clip.

use crate::document::Names;
use crate::fixings::facing;
use crate::reader::Entry;
use crate::scenario::{At, Branch, Constraint, Facing, Load};
use crate::sequence::{Begins, Motions, turn};
use crate::{kinds, poses};
use wireloom_core::rotation::columns;
use wireloom_core::steps::{Carried, Move, Operation, Track, Turn};
use wireloom_core::{Rotation, Vector};

/// How far before its seat the push of a connector begins where the file does not say, m: two lengths of a small plug.
const APPROACH: f64 = 0.03;
/// Share of the step in which a connector is brought before its seat.
const BROUGHT: f64 = 0.7;
/// Share of the step in which it has been turned home about its tangent; the rest is the push.
const TURNED: f64 = 0.8;
/// Attachments closer than this share of the branch have no room for another one between them and it.
const CROWDED: f64 = 0.02;

/// The operations of a step; their motions are put behind its plain ones.
pub(crate) fn read(
    step: &Entry<'_>,
    begins: &Begins<'_>,
    motions: &mut Motions<'_, '_>,
    constraints: &mut [Constraint],
    names: &Names<'_>,
) -> Vec<Operation> {
    let mut all: Vec<Operation> = begins.grasps.iter().map(|&fixing| Operation::Grasp { fixing }).collect();
    all.extend(step.entries("carry").iter().filter_map(|entry| carry(entry, motions, constraints, names)));
    let mates = step.entries("mate");
    all.extend(
        mates.iter().zip(&begins.mates).filter_map(|(entry, begun)| mate(entry, *begun, motions, constraints, names)),
    );
    all.extend(begins.clips.iter().map(|&fixing| Operation::Clip { fixing }));
    all
}

// ---- carry ------------------------------------------------------------------------------------------------------

/// A place on the way of what is carried.
struct Keyframe {
    at: f64,
    position: Option<Vector>,
    turn: Turn,
}

/// Moves constraints together, as one rigid body.
fn carry(
    entry: &Entry<'_>,
    motions: &mut Motions<'_, '_>,
    constraints: &mut [Constraint],
    names: &Names<'_>,
) -> Option<Operation> {
    let carried = carried(entry, motions, names);
    let mut frames = way(entry);
    let about = entry.entry("about").map(|about| (about.vector("position"), frame(&about)));
    let origin = about.or_else(|| {
        let first = frames.first().filter(|first| first.at == 0.0)?;
        let frame = if let Turn::Orientation(frame) = first.turn { Some(frame) } else { None };
        Some((first.position, frame))
    });
    frames.retain(|frame| frame.at > 0.0);
    let track = Track {
        positions: frames.iter().filter_map(|frame| Some((frame.at, frame.position?))).collect(),
        turns: frames.iter().filter(|frame| frame.turn != Turn::Keep).map(|frame| (frame.at, frame.turn)).collect(),
        spin: 0.0,
    };
    // What turns a body holds all of its frame; a single tangent leaves the twist to the cable.
    let tangents = track.turns.iter().all(|(_, turn)| matches!(turn, Turn::Tangent(_)));
    for Carried { fixing, .. } in &carried {
        constraints[*fixing].tangent_given |= !track.turns.is_empty();
        constraints[*fixing].up_given |= !(track.turns.is_empty() || tangents && carried.len() == 1);
    }
    let fixings: Vec<usize> = carried.iter().map(|carried| carried.fixing).collect();
    if fixings.is_empty() {
        return None;
    }
    motions.moves.push(Move { carried, origin: origin.unwrap_or_default(), track });
    Some(Operation::Carry { fixings })
}

/// What is carried, and when.
fn carried(entry: &Entry<'_>, motions: &Motions<'_, '_>, names: &Names<'_>) -> Vec<Carried> {
    let mut all: Vec<(&str, Carried)> = Vec::new();
    let given = entry.names("what");
    for (name, span) in &given {
        if all.iter().any(|(other, _)| other == name) {
            let message = format!("{} names \"{name}\" twice", entry.label);
            entry.reader.fault(span.clone(), message, "name everything once");
        } else if let Some(fixing) = motions.claim(entry, name, span.clone(), names) {
            all.push((name, Carried { fixing, delay: 0.0, share: 1.0 }));
        }
    }
    if entry.has("what") && given.is_empty() {
        entry.fault_at("what", format!("{} carries nothing", entry.label), "name one constraint at least");
    }
    for timing in entry.entries("timing") {
        let delay = timing.number("delay").unwrap_or(0.0);
        let share = timing.number("share").unwrap_or(1.0 - delay);
        let Some(name) = timing.word("what") else { continue };
        if delay + share > 1.0 + 1e-12 || share <= 0.0 {
            let message = format!("\"{name}\" would not arrive within the step: `delay` + `share` = {}", delay + share);
            timing.fault_here(message, "they add up to at most 1, and some share is left to move in");
        }
        if let Some((_, carried)) = all.iter_mut().find(|(other, _)| *other == name) {
            (carried.delay, carried.share) = (delay, share);
        } else if !given.iter().any(|(other, _)| *other == name) {
            let help = crate::fault::did_you_mean(name, given.iter().map(|(other, _)| *other));
            timing.fault_at("what", format!("{} does not carry \"{name}\"", entry.label), help);
        }
    }
    all.into_iter().map(|(_, carried)| carried).collect()
}

/// The way of what is carried: keyframes, or the poses of a file.
fn way(entry: &Entry<'_>) -> Vec<Keyframe> {
    if !entry.has("path") {
        return keyframes(entry);
    }
    for other in ["keyframes", "about"].into_iter().filter(|key| entry.has(key)) {
        let message = format!("{} has `{other}` beside `path`", entry.label);
        let help = "leave it out: the first pose of the file says where the body begins, the others where it goes";
        entry.fault_at(other, message, help);
    }
    let turn = |frame: Option<Rotation>| frame.map_or(Turn::Keep, Turn::Orientation);
    let poses = poses::read(entry, "path").unwrap_or_default();
    let frame =
        |pose: poses::TimedPose| Keyframe { at: pose.at, position: Some(pose.position), turn: turn(pose.orientation) };
    poses.into_iter().map(frame).collect()
}

fn keyframes(entry: &Entry<'_>) -> Vec<Keyframe> {
    let mut frames: Vec<Keyframe> = Vec::new();
    for given in entry.entries("keyframes") {
        let position = given.vector("position");
        let facing = facing(&given);
        if !["position", "tangent", "up", "orientation"].iter().any(|key| given.has(key)) {
            let message = format!("{} says nothing", given.label);
            given.fault_here(message, "give `position`, `tangent` and `up`, or `orientation`");
        }
        let Some(at) = given.number("at") else { continue };
        if let Some(last) = frames.last().filter(|last| at <= last.at) {
            let message = format!("`at` = {at} of {} does not come after {}", given.label, last.at);
            given.fault_at("at", message, "keyframes come in the order in which they are passed");
        }
        if at == 0.0 && entry.has("about") {
            let message = format!("{} has `about` and a keyframe at 0: both say where the body begins", entry.label);
            given.fault_at("at", message, "leave one of them out");
        }
        if at == 0.0 && matches!(facing, Facing::Tangent(_)) {
            let message = format!("the keyframe at 0 of {} has a tangent alone", entry.label);
            given.fault_at(
                "tangent",
                message,
                "add `up`: the body begins with a whole frame, or with that of the first",
            );
        }
        frames.push(Keyframe { at, position, turn: turn(facing) });
    }
    if entry.has("keyframes") && !frames.iter().any(|frame| frame.at > 0.0) {
        let message = format!("{} goes nowhere", entry.label);
        entry.fault_at(
            "keyframes",
            message,
            "give one keyframe at least behind 0, such as { at = 1, position = [0, 0, 1] }",
        );
    }
    frames
}

/// The frame of a body: the world's axes where none is given.
fn frame(about: &Entry<'_>) -> Option<Rotation> {
    match facing(about) {
        Facing::Left => Some(Rotation::identity()),
        Facing::Orientation(frame) => Some(frame),
        Facing::Tangent(_) => {
            let message = format!("{} has a tangent alone", about.label);
            about.fault_at("tangent", message, "add `up`, or leave both out for the world's axes");
            None
        }
    }
}

// ---- mate -------------------------------------------------------------------------------------------------------

/// Brings a connector before its seat, turns it home about its tangent by the shortest turn, and pushes it straight in.
fn mate(
    entry: &Entry<'_>,
    begun: Option<usize>,
    motions: &mut Motions<'_, '_>,
    constraints: &mut [Constraint],
    names: &Names<'_>,
) -> Option<Operation> {
    let seat = entry.vector("position");
    let facing = facing(entry);
    let direction = entry.direction("direction").map(|direction| *direction);
    let approach = entry.number("approach").unwrap_or(APPROACH);
    let limit = entry.number("max_insertion_force");
    if !["tangent", "up", "orientation"].iter().any(|key| entry.has(key)) {
        let message = format!("{} does not say which way the connector faces", entry.label);
        entry.fault_here(message, "add `tangent`: direction of d3 in its seat, along the branch, and `up`");
    }
    let tangent = match facing {
        Facing::Left => None,
        Facing::Tangent(tangent) => Some(tangent),
        Facing::Orientation(frame) => Some(columns(&frame)[2]),
    };
    let fixing = which(entry, begun, motions, names)?;
    let direction = match (direction, tangent) {
        (Some(direction), _) => direction,
        (None, Some(tangent)) => tangent * outward(entry, constraints[fixing].place(), names)?,
        (None, None) => return None,
    };
    let (seat, tangent) = (seat?, tangent?);
    let constraint = &mut constraints[fixing];
    constraint.tangent_given = true;
    let before = seat - direction * approach;
    let mut track = Track {
        positions: vec![(BROUGHT, before), (1.0, seat)],
        turns: vec![(BROUGHT, Turn::Tangent(tangent))],
        spin: 0.0,
    };
    let mut push_from = BROUGHT;
    if let Facing::Orientation(frame) = facing {
        constraint.up_given = true;
        track.positions.insert(1, (TURNED, before));
        track.turns.push((TURNED, Turn::Orientation(frame)));
        push_from = TURNED;
    }
    motions.moves.push(Move::of(fixing, track));
    motions.acting.mated.insert(fixing);
    Some(Operation::Mate { fixing, direction, push_from, limit })
}

/// The connector that is pushed home: one that acts, or one that begins with the step.
fn which(entry: &Entry<'_>, begun: Option<usize>, motions: &Motions<'_, '_>, names: &Names<'_>) -> Option<usize> {
    match (entry.has("constraint"), entry.has("name")) {
        (false, true) => {
            if !entry.has("at") {
                entry.missing("at", "where the connector attaches, such as { end = \"B\" }");
            }
            begun
        }
        (true, false) => {
            kinds::read(entry);
            let of_its_own = ["kind", "at", "hold", "pull_out_force", "max_moment", "insertion_force"];
            if let Some(key) = of_its_own.into_iter().find(|key| entry.has(key)) {
                let message = format!("{} has `{key}` beside `constraint`", entry.label);
                entry.fault_at(key, message, "give it where the constraint begins");
            }
            let name = entry.word("constraint")?;
            let span = entry.span_of("constraint");
            let fixing = motions.claim(entry, name, span.clone(), names)?;
            if motions.acting.mated.contains(&fixing) {
                let message = format!("{} mates \"{name}\", which is in its seat already", motions.step.label);
                entry.reader.fault(span, message, "release it first, or move it with its counterpart by `carry`");
            }
            Some(fixing)
        }
        (both, _) => {
            kinds::read(entry);
            let what = if both { "`constraint` and `name`" } else { "neither `constraint` nor `name`" };
            let help = "give `constraint` for a connector that acts already, `name` and `at` for one that begins now";
            entry.fault_here(format!("{} has {what}", entry.label), help);
            None
        }
    }
}

/// 1 where d3 leaves the cable at an end, −1 where it enters.
fn outward(entry: &Entry<'_>, at: At, names: &Names<'_>) -> Option<f64> {
    if let At::Branch { branch, s } = at {
        if s == 0.0 {
            return Some(-1.0);
        }
        if names.lengths.get(branch) == Some(&Some(s)) {
            return Some(1.0);
        }
    }
    let message = format!("{} is not at an end, and does not say where to push", entry.label);
    entry.fault_here(message, "add `direction`");
    None
}

// ---- clip -------------------------------------------------------------------------------------------------------

/// Gives clips that close at the nearest place a provisional one, apart from everything else on the branch: where the drawn path, or what
/// is known of the branch, puts their seat, or else in the middle of the longest free span. Their order along the branch remains.
pub(crate) fn settle_nearest(constraints: &mut [Constraint], loads: &[Load], branches: &[Branch]) {
    let on = |at: At| if let At::Branch { branch, s } = at { Some((branch, s)) } else { None };
    let settled =
        constraints.iter().filter(|c| !c.nearest).flat_map(|c| c.places()).chain(loads.iter().map(|load| load.at));
    let mut taken: Vec<(usize, f64)> = settled.filter_map(on).collect();
    let seats = constraints.iter().filter(|c| !c.nearest);
    let seats: Vec<((usize, f64), Vector)> = seats.filter_map(|c| Some((on(c.place())?, c.position?))).collect();
    for constraint in constraints.iter_mut().filter(|c| c.nearest) {
        let At::Branch { branch, .. } = constraint.place() else { continue };
        let Some(own) = branches.get(branch) else { continue };
        let mut places: Vec<f64> = taken.iter().filter(|(b, _)| *b == branch).map(|(_, s)| *s).collect();
        places.extend([0.0, own.length]);
        places.sort_by(f64::total_cmp);
        let mut known = drawn(own);
        if known.is_empty() {
            known.extend(seats.iter().filter(|((b, _), _)| *b == branch).map(|((_, s), seat)| (*s, *seat)));
            known.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let guess = constraint.position.and_then(|seat| nearest_on(&known, &seat, own.length));
        let free = |s: &f64| places.iter().all(|place| (place - s).abs() > CROWDED * own.length);
        let s = guess.filter(free).or_else(|| {
            let longest = places.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
            Some(0.5 * (longest[0] + longest[1]))
        });
        let s = s.unwrap_or(0.5 * own.length);
        constraint.at = vec![At::Branch { branch, s }];
        taken.push((branch, s));
    }
}

/// Arc lengths (m) and points of a branch's drawn path, as much longer as the branch is.
fn drawn(branch: &Branch) -> Vec<(f64, Vector)> {
    let mut along = 0.0;
    let mut points: Vec<(f64, Vector)> = Vec::new();
    for point in &branch.path {
        along += points.last().map_or(0.0, |(_, last)| (point - last).norm());
        points.push((along, *point));
    }
    points.iter().map(|(s, point)| (s * branch.length / along, *point)).collect()
}

/// Arc length (m) at which a branch is nearest to `seat`, by the straight lines between what is `known` of it (arc lengths and points);
/// beyond the first and the last, as far away as they are from the seat. `None` where that leaves two places, or none.
fn nearest_on(known: &[(f64, Vector)], seat: &Vector, length: f64) -> Option<f64> {
    let inner = known.windows(2).map(|pair| {
        let ((from, a), (to, b)) = (pair[0], pair[1]);
        let edge = b - a;
        let share = (edge.dot(&(seat - a)) / edge.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (from + (to - from) * share, (a + edge * share - seat).norm())
    });
    let best = inner.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(s, _)| s);
    let (first, last) = (known.first()?, known.last()?);
    let beyond = |(s, point): &(f64, Vector), sign: f64| s + sign * (point - seat).norm();
    let (before, after) = (beyond(first, -1.0), beyond(last, 1.0));
    match best {
        Some(s) if s > first.0 && s < last.0 => Some(s),
        Some(s) if s <= first.0 => Some(if before > 0.0 { before } else { s }),
        Some(s) => Some(if after < length { after } else { s }),
        None => match (before > 0.0, after < length) {
            (true, false) => Some(before),
            (false, true) => Some(after),
            _ => None,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seat_is_on_the_line_between_what_is_known_or_as_far_beyond() {
        let at = |x: f64| Vector::new(x, 0.1, 0.0);
        let known = [(0.0, Vector::zeros()), (0.8, Vector::new(0.5, 0.0, 0.0))];
        let near = |known: &[(f64, Vector)], seat| nearest_on(known, &seat, 1.0);
        assert!((near(&known, at(0.25)).unwrap() - 0.4).abs() < 1e-12);
        let beyond = 0.8 + 0.02_f64.sqrt();
        assert!((near(&known, at(0.6)).unwrap() - beyond).abs() < 1e-12);
        assert_eq!(near(&known[..1], Vector::new(0.3, 0.0, 0.0)), Some(0.3));
        assert_eq!(near(&[(0.5, Vector::zeros())], Vector::new(0.3, 0.0, 0.0)), None);
        assert_eq!(near(&[], at(0.0)), None);
    }
}
