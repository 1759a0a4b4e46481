//! `clip`: a clip closes around the cable and moves it to its seat.

use super::{Begins, StepOperation};
use crate::format::form::{Family, Form, Keys, may, must};
use crate::format::keys::constraints::{
    AT, FREE_AXIS, FRICTION, HOLD, INSERTION_FORCE, MAX_MOMENT, MOUNT, NAME, ORIENTATION, PULL_OUT_FORCE, RAIL, SLIDE,
    TANGENT, UP,
};
use crate::format::keys::identities::{COLOUR, DESCRIPTION, KBL, PART, SUPPLIER};
use wireloom_core::Quantity;
use wireloom_core::steps::Operation;

/// Clips that close.
pub(super) const CLIP: StepOperation = StepOperation {
    key: may("clip", Form::Tables(&KEYS), "clips that close around the cable and move it to their seats"),
    begins: |_| Begins::AtPlaceOrNearest,
    read: |_, begun, _| begun.map(|constraint| Operation::Clip { constraint }),
};

/// A clip that closes.
const KEYS: Keys = Keys {
    what: "clip",
    keys: &[
        NAME,
        may("kind", Form::Kind(Family::Constraint, Some("collar")), "its kind; default \"collar\""),
        must(
            "at",
            Form::Table(&AT),
            "where it closes: branch and s, or branch alone for the place nearest to its seat when the step begins",
        ),
        must("position", Form::Vector(Quantity::Length), "its seat"),
        TANGENT,
        UP,
        ORIENTATION,
        MOUNT,
        HOLD,
        FREE_AXIS,
        RAIL,
        SLIDE,
        FRICTION,
        PULL_OUT_FORCE,
        MAX_MOMENT,
        INSERTION_FORCE,
        PART,
        DESCRIPTION,
        SUPPLIER,
        COLOUR,
        KBL,
    ],
};
