//! `mate`: a connector is moved to the place before its seat and pushed in.

use super::context::Context;
use super::{Begins, StepOperation};
use crate::attachment::At;
use crate::format::form::{Family, Form, Keys, may, must};
use crate::format::keys::constraints::{
    AT, HOLD, INSERTION_FORCE, MAX_MOMENT, MOUNT, ORIENTATION, PULL_OUT_FORCE, TANGENT, UP,
};
use crate::format::keys::identities::{COLOUR, DESCRIPTION, PART, SUPPLIER};
use crate::format::limits::POSITIVE;
use crate::read::entry::Entry;
use crate::read::kinds;
use crate::read::places::facing;
use crate::scenario::Facing;
use wireloom_core::Quantity;
use wireloom_core::rotation::columns;
use wireloom_core::steps::{Move, Operation, Track, Turn};

/// Connectors that are pushed in.
pub(super) const MATE: StepOperation = StepOperation {
    key: may("mate", Form::Tables(&KEYS), "connectors that are moved to the place before their seats and pushed in"),
    begins: |entry| if entry.has("name") { Begins::AtPlace } else { Begins::Nothing },
    read,
};

/// A connector that is pushed in.
const KEYS: Keys = Keys {
    what: "mate",
    keys: &[
        may("constraint", Form::Name, "name of a constraint that acts already; either this, or name and at"),
        may("name", Form::Name, "name of a constraint that begins with this step, at the pose of the cable"),
        may("kind", Form::Kind(Family::Constraint, Some("connector")), "its kind; default \"connector\""),
        may("at", Form::Table(&AT), "where it attaches"),
        must("position", Form::Vector(Quantity::Length), "its seat"),
        TANGENT,
        UP,
        ORIENTATION,
        may("direction", Form::Direction, "direction of the push; default out of the end of the branch along tangent"),
        may(
            "approach",
            Form::Number(Quantity::Length, POSITIVE),
            "distance from the seat at which the push begins; default 30 mm",
        ),
        may(
            "max_insertion_force",
            Form::Number(Quantity::Force, POSITIVE),
            "largest force of the push; larger ones are reported",
        ),
        MOUNT,
        HOLD,
        PULL_OUT_FORCE,
        MAX_MOMENT,
        INSERTION_FORCE,
        PART,
        DESCRIPTION,
        SUPPLIER,
        COLOUR,
    ],
};

/// Default distance from the seat at which the push of a connector begins, m: two lengths of a small plug.
const APPROACH: f64 = 0.03;
/// Fraction of the step at which a connector has reached the place before its seat.
const APPROACHED: f64 = 0.7;
/// Fraction of the step at which it has also been turned about its tangent to its final frame; the rest is the push.
const TURNED: f64 = 0.8;

/// Moves a connector to the place before its seat, turns it about its tangent by the shortest turn, and pushes it
/// straight in.
fn read(entry: &Entry<'_>, begun: Option<usize>, step: &mut Context<'_, '_>) -> Option<Operation> {
    let seat = entry.vector("position");
    let facing = facing(entry);
    let direction = entry.direction("direction").map(|direction| *direction);
    let approach = entry.number("approach").unwrap_or(APPROACH);
    let limit = entry.number("max_insertion_force");
    if !["tangent", "up", "orientation"].iter().any(|key| entry.has(key)) {
        let message = format!("{} gives no direction of the connector", entry.label);
        entry.fault_here(message, "add `tangent`: direction of d3 in its seat, along the branch, and `up`");
    }
    let tangent = match facing {
        Facing::Left => None,
        Facing::Tangent(tangent) => Some(tangent),
        Facing::Orientation(frame) => Some(columns(&frame)[2]),
    };
    let index = which(entry, begun, step)?;
    let direction = match (direction, tangent) {
        (Some(direction), _) => direction,
        (None, Some(tangent)) => tangent * outward(entry, step.constraints[index].place(), step)?,
        (None, None) => return None,
    };
    let (seat, tangent) = (seat?, tangent?);
    let constraint = &mut step.constraints[index];
    constraint.tangent_given = true;
    let before = seat - direction * approach;
    let mut track = Track {
        positions: vec![(APPROACHED, before), (1.0, seat)],
        turns: vec![(APPROACHED, Turn::Tangent(tangent))],
        spin: 0.0,
    };
    let mut push_from = APPROACHED;
    if let Facing::Orientation(frame) = facing {
        constraint.up_given = true;
        track.positions.insert(1, (TURNED, before));
        track.turns.push((TURNED, Turn::Orientation(frame)));
        push_from = TURNED;
    }
    step.moves.push(Move::of(index, track));
    step.acting.mated.insert(index);
    Some(Operation::Mate { constraint: index, direction, push_from, limit })
}

/// The connector that is pushed in: one that acts, or one that begins with the step.
fn which(entry: &Entry<'_>, begun: Option<usize>, step: &Context<'_, '_>) -> Option<usize> {
    match (entry.has("constraint"), entry.has("name")) {
        (false, true) => {
            if !entry.has("at") {
                entry.missing("at", "where the connector attaches, such as { end = \"B\" }");
            }
            begun
        }
        (true, false) => {
            kinds::read(entry);
            let of_its_own = ["kind", "at", "mount", "hold", "pull_out_force", "max_moment", "insertion_force"];
            let identity = ["part", "description", "supplier", "colour"];
            if let Some(key) = of_its_own.into_iter().chain(identity).find(|key| entry.has(key)) {
                let message = format!("{} has `{key}` beside `constraint`", entry.label);
                entry.fault_at(key, message, "give it where the constraint begins");
            }
            let name = entry.word("constraint")?;
            let span = entry.span_of("constraint");
            let constraint = step.claim(entry, name, span.clone())?;
            if step.acting.mated.contains(&constraint) {
                let message = format!("{} mates \"{name}\", which is in its seat already", step.entry.label);
                entry.reader.fault(span, message, "release it first, or move it together with others by `carry`");
            }
            Some(constraint)
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
fn outward(entry: &Entry<'_>, at: At, step: &Context<'_, '_>) -> Option<f64> {
    if let At::Branch { branch, s } = at {
        if s == 0.0 {
            return Some(-1.0);
        }
        if step.names.lengths.get(branch) == Some(&Some(s)) {
            return Some(1.0);
        }
    }
    let message = format!("{} is not at an end and gives no direction of the push", entry.label);
    entry.fault_here(message, "add `direction`");
    None
}
