//! `grasp`: a hand grasps the cable where it is.

use super::{Begins, StepOperation};
use crate::format::form::{Family, Form, Keys, may};
use crate::format::keys::constraints::{FREE_AXIS, HOLD, MAX_MOMENT, MOUNT, NAME, PLACE, PULL_OUT_FORCE, RAIL};
use wireloom_core::steps::Operation;

/// Hands that grasp the cable.
pub(crate) const GRASP: StepOperation = StepOperation {
    key: may("grasp", Form::Tables(&KEYS), "hands that grasp the cable where it is when this step begins"),
    begins: |_| Begins::AtPlace,
    read: |_, begun, _| begun.map(|constraint| Operation::Grasp { constraint }),
};

/// A hand that grasps the cable.
const KEYS: Keys = Keys {
    what: "grasp",
    keys: &[
        NAME,
        may("kind", Form::Kind(Family::Constraint, Some("handle")), "its kind; default \"handle\""),
        PLACE,
        MOUNT,
        HOLD,
        FREE_AXIS,
        RAIL,
        PULL_OUT_FORCE,
        MAX_MOMENT,
    ],
};
