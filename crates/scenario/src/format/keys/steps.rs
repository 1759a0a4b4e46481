//! Steps: their own keys, and those of the step operations.

use crate::format::form::{Form, Key, Keys, may};
use crate::format::limits::{ANY, MAX_INCREMENTS, NON_NEGATIVE};
use crate::operations::OPERATIONS;
use wireloom_core::Quantity;

/// A step.
pub(crate) const STEP: Keys = Keys { what: "step", keys: &KEYS };

/// Keys of a step itself.
const OWN: [Key; 8] = [
    may("name", Form::Name, "its name; default \"step N\""),
    may("increments", Form::Count(1, MAX_INCREMENTS), "number of increments; default 1"),
    may(
        "duration",
        Form::Number(Quantity::Time, NON_NEGATIVE),
        "time that it takes, in which sections with `creep` relax, such as \"2 h\"; default 0",
    ),
    may("gravity", Form::Vector(Quantity::Acceleration), "gravity reached at its end"),
    may("acceleration", Form::Vector(Quantity::Acceleration), "acceleration of the car reached at its end"),
    may(
        "rotation_speed",
        Form::Number(Quantity::AngularSpeed, ANY),
        "speed of the `rotation` reached at its end, such as \"3000 rpm\"",
    ),
    may("release", Form::Names, "constraints that are released when this step begins"),
    may("wait", Form::Flag, "true: the step does nothing but find the equilibrium; default false"),
];

/// Keys of a step, followed by those of the step operations.
const KEYS: [Key; OWN.len() + OPERATIONS.len()] = {
    let mut keys = [OWN[0]; OWN.len() + OPERATIONS.len()];
    let mut k = 0;
    while k < keys.len() {
        keys[k] = if k < OWN.len() { OWN[k] } else { OPERATIONS[k - OWN.len()].key };
        k += 1;
    }
    keys
};
