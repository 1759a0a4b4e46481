//! `carry`: constraints that move together, as one rigid body.

use super::context::Context;
use super::{Begins, StepOperation};
use crate::fault::did_you_mean;
use crate::format::form::{Form, Keys, may, must, unless};
use crate::format::keys::constraints::{ORIENTATION, TANGENT, UP};
use crate::format::limits::{Bound, FRACTION};
use crate::read::entry::Entry;
use crate::read::places::facing;
use crate::read::poses;
use crate::scenario::Facing;
use wireloom_core::steps::{Carried, Move, Operation, Track, Turn};
use wireloom_core::{Quantity, Rotation, Vector};

/// Constraints that move together.
pub(crate) const CARRY: StepOperation = StepOperation {
    key: may("carry", Form::Tables(&KEYS), "motions of constraints that are carried together"),
    begins: |_| Begins::Nothing,
    read,
};

/// Constraints that move together.
const KEYS: Keys = Keys {
    what: "carry",
    keys: &[
        must("what", Form::Names, "constraints that move together, as one rigid body; the motion is that of the first"),
        may(
            "about",
            Form::Table(&ABOUT),
            "the motion is that of a point and frame of the body instead of the first: their pose when the step begins",
        ),
        unless(&["path"], "keyframes", Form::Tables(&KEYFRAME), "poses that are passed"),
        may(
            "path",
            Form::Name,
            "instead of keyframes: a CSV file of poses, from the folder of the scenario; columns t, x, y, z and, all \
             or none, qw, qx, qy, qz; lengths in m or as in x [mm]; t from the step's beginning to its end",
        ),
        may("timing", Form::Tables(&TIMING), "constraints that begin to move later, or end sooner, than the step"),
    ],
};

/// Pose of a body when it begins to move.
const ABOUT: Keys = Keys {
    what: "about",
    keys: &[
        must("position", Form::Vector(Quantity::Length), "a point of the body"),
        may("tangent", Form::Direction, "with up: its frame, d3; default the world's axes"),
        may("up", Form::Direction, "with tangent: its frame, d1"),
        ORIENTATION,
    ],
};

/// A pose that is passed.
const KEYFRAME: Keys = Keys {
    what: "keyframe",
    keys: &[
        must(
            "at",
            Form::Number(Quantity::Dimensionless, FRACTION),
            "fraction of the step at which it is passed; a keyframe at 0 gives the first pose of the body",
        ),
        may("position", Form::Vector(Quantity::Length), "position; left out, it is interpolated"),
        TANGENT,
        UP,
        ORIENTATION,
    ],
};

/// Part of the step in which a constraint moves.
const TIMING: Keys = Keys {
    what: "timing",
    keys: &[
        must("what", Form::Name, "name of the constraint"),
        may(
            "delay",
            Form::Number(Quantity::Dimensionless, FRACTION),
            "fraction of the step after which it begins to move; default 0",
        ),
        may(
            "share",
            Form::Number(Quantity::Dimensionless, Bound { exclusive: true, ..FRACTION }),
            "fraction of the step over which it moves; default the rest of it",
        ),
    ],
};

/// A pose that is passed.
struct Keyframe {
    at: f64,
    position: Option<Vector>,
    turn: Turn,
}

/// Moves constraints together, as one rigid body.
fn read(entry: &Entry<'_>, _: Option<usize>, step: &mut Context<'_, '_>) -> Option<Operation> {
    let carried = carried(entry, step);
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
    // A body that turns holds the whole frame; a single tangent leaves the twist free.
    let tangents = track.turns.iter().all(|(_, turn)| matches!(turn, Turn::Tangent(_)));
    for Carried { constraint, .. } in &carried {
        step.constraints[*constraint].tangent_given |= !track.turns.is_empty();
        step.constraints[*constraint].up_given |= !(track.turns.is_empty() || tangents && carried.len() == 1);
    }
    let constraints: Vec<usize> = carried.iter().map(|carried| carried.constraint).collect();
    if constraints.is_empty() {
        return None;
    }
    step.moves.push(Move { carried, origin: origin.unwrap_or_default(), track });
    Some(Operation::Carry { constraints })
}

/// The constraints that move, and when.
fn carried(entry: &Entry<'_>, step: &Context<'_, '_>) -> Vec<Carried> {
    let mut all: Vec<(&str, Carried)> = Vec::new();
    let given = entry.names("what");
    for (name, span) in &given {
        if all.iter().any(|(other, _)| other == name) {
            let message = format!("{} names \"{name}\" twice", entry.label);
            entry.reader.fault(span.clone(), message, "name each constraint once");
        } else if let Some(constraint) = step.claim(entry, name, span.clone()) {
            // Alone it moves against its body; together with others, it is not clear against which.
            if step.constraints[constraint].mount.is_some() && (given.len() > 1 || entry.has("about")) {
                let message = format!("{} carries \"{name}\", which is mounted on a body", entry.label);
                let help = "a mechanism carries it: use `drive`, or carry it alone, against its body";
                entry.reader.fault(span.clone(), message, help);
            }
            all.push((name, Carried { constraint, delay: 0.0, fraction: 1.0 }));
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
            timing.fault_here(message, "their sum must be at most 1, and `share` above 0");
        }
        if let Some((_, carried)) = all.iter_mut().find(|(other, _)| *other == name) {
            (carried.delay, carried.fraction) = (delay, share);
        } else if !given.iter().any(|(other, _)| *other == name) {
            let help = did_you_mean(name, given.iter().map(|(other, _)| *other));
            timing.fault_at("what", format!("{} does not carry \"{name}\"", entry.label), help);
        }
    }
    all.into_iter().map(|(_, carried)| carried).collect()
}

/// The motion: keyframes, or the poses of a file.
fn way(entry: &Entry<'_>) -> Vec<Keyframe> {
    if !entry.has("path") {
        return keyframes(entry);
    }
    for other in ["keyframes", "about"].into_iter().filter(|key| entry.has(key)) {
        let message = format!("{} has `{other}` beside `path`", entry.label);
        let help = "leave it out: the first pose of the file is that of the body when the step begins";
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
            given.fault_at("at", message, "give keyframes in the order in which they are passed");
        }
        if at == 0.0 && entry.has("about") {
            let message = format!("{} has `about` and a keyframe at 0: both give the first pose", entry.label);
            given.fault_at("at", message, "leave one of them out");
        }
        if at == 0.0 && matches!(facing, Facing::Tangent(_)) {
            let message = format!("the keyframe at 0 of {} has a tangent alone", entry.label);
            given.fault_at("tangent", message, "add `up`, or leave both out for the frame of the first constraint");
        }
        frames.push(Keyframe { at, position, turn: facing.turn() });
    }
    if entry.has("keyframes") && !frames.iter().any(|frame| frame.at > 0.0) {
        let message = format!("{} goes nowhere", entry.label);
        entry.fault_at(
            "keyframes",
            message,
            "give at least one keyframe after 0, such as { at = 1, position = [0, 0, 1] }",
        );
    }
    frames
}

/// The frame of a body: the world's axes if none is given.
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
