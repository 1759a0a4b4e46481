//! `move`: motions of constraints and obstacles, one by one.

use super::context::Context;
use super::{Begins, StepOperation};
use crate::format::form::{Form, Keys, may, unless};
use crate::format::keys::constraints::{ORIENTATION, TANGENT, UP};
use crate::format::limits::TURNS;
use crate::read::entry::Entry;
use crate::read::places::facing;
use wireloom_core::steps::{Move, ObstacleMove, Operation, Track, Turn};
use wireloom_core::{Quantity, Vector};

/// Motions of constraints and obstacles.
pub(crate) const MOVE: StepOperation = StepOperation {
    key: may("move", Form::Tables(&KEYS), "motions of constraints and obstacles, one by one"),
    begins: |_| Begins::Nothing,
    read,
};

/// Motion of a constraint or an obstacle.
const KEYS: Keys = Keys {
    what: "move",
    keys: &[
        unless(&["obstacle"], "constraint", Form::Name, "name of the constraint"),
        may("obstacle", Form::Name, "instead of a constraint: name of the obstacle"),
        may("position", Form::Vector(Quantity::Length), "position reached at the end"),
        may("via", Form::Points(1), "points that are passed, at equal fractions of the step"),
        TANGENT,
        UP,
        ORIENTATION,
        may(
            "turns",
            Form::Number(Quantity::Dimensionless, TURNS),
            "number of turns about the tangent, in addition, spread over the increments",
        ),
    ],
};

fn read(entry: &Entry<'_>, _: Option<usize>, step: &mut Context<'_, '_>) -> Option<Operation> {
    let mut path = path(entry);
    let facing = facing(entry);
    let turns = entry.number("turns").unwrap_or(0.0);
    let moves_something = ["position", "via", "tangent", "up", "orientation", "turns"];
    if !moves_something.iter().any(|key| entry.has(key)) {
        let message = format!("{} moves nothing", entry.label);
        entry.fault_here(message, "give `position`, `tangent` and `up`, `orientation` or `turns`");
    }
    if entry.has("constraint") && entry.has("obstacle") {
        let message = format!("{} has both `constraint` and `obstacle`", entry.label);
        entry.fault_at("obstacle", message, "give each of them a move of its own");
        return None;
    }
    if let Some(name) = entry.word("obstacle") {
        let obstacle = step.claim_obstacle(entry, name);
        let track = track(path, facing.turn(), turns);
        step.obstacle_moves.extend(obstacle.map(|obstacle| ObstacleMove { obstacle, track }));
        return None;
    }
    let name = entry.word("constraint")?;
    let index = step.claim(entry, name, entry.span_of("constraint"))?;
    let constraint = &mut step.constraints[index];
    let mut turn = facing.turn();
    constraint.tangent_given |= turn != Turn::Keep;
    constraint.up_given |= matches!(turn, Turn::Orientation(_));
    if step.begun.contains(&index) {
        // It begins where the cable is. The motion passes the position and ends in the frame that the constraint gives,
        // unless it gives its own frame.
        path.splice(0..0, constraint.position);
        turn = if turn == Turn::Keep { constraint.facing.turn() } else { turn };
    }
    step.moves.push(Move::of(index, track(path, turn, turns)));
    None
}

/// The track through these points, at equal fractions of the step.
fn track(path: Vec<Vector>, turn: Turn, spin: f64) -> Track {
    let legs = path.len() as f64;
    Track {
        positions: path.into_iter().enumerate().map(|(k, point)| ((k + 1) as f64 / legs, point)).collect(),
        turns: if turn == Turn::Keep { vec![] } else { vec![(1.0, turn)] },
        spin,
    }
}

fn path(motion: &Entry<'_>) -> Vec<Vector> {
    let mut path = motion.points("via").unwrap_or_default();
    if motion.has("via") && !motion.has("position") {
        let message = format!("{} has `via` but no `position`", motion.label);
        motion.fault_at("via", message, "add `position`: where the motion ends");
    }
    path.extend(motion.vector("position"));
    path
}
