//! `grasp`: a hand takes hold of the cable where it is.

use super::{Begins, StepOperation};
use crate::format::form::{Family, Form, Keys, may};
use crate::format::keys::constraints::{FREE_AXIS, HOLD, MAX_MOMENT, NAME, PLACE, PULL_OUT_FORCE, RAIL};
use wireloom_core::steps::Operation;

/// Hands that take hold.
pub(crate) const GRASP: StepOperation = StepOperation {
    key: may("grasp", Form::Tables(&KEYS), "hands that take hold of the cable where it is when this step begins"),
    begins: |_| Begins::AtPlace,
    read: |_, begun, _| begun.map(|constraint| Operation::Grasp { constraint }),
};

/// A hand that takes hold.
const KEYS: Keys = Keys {
    what: "grasp",
    keys: &[
        NAME,
        may("kind", Form::Kind(Family::Constraint, Some("handle")), "what takes hold; default \"handle\""),
        PLACE,
        HOLD,
        FREE_AXIS,
        RAIL,
        PULL_OUT_FORCE,
        MAX_MOMENT,
    ],
};
