//! Requirements and markers.

use super::constraints::{AT, NAME};
use crate::format::form::{Form, Keys, may, must};
use crate::format::limits::NON_NEGATIVE;
use wireloom_core::Quantity;

/// Words of the measures that a requirement may limit.
const MEASURES: &[&str] = &[
    "bend_radius",
    "tension",
    "compression",
    "strain",
    "torsion",
    "turns",
    "force",
    "moment",
    "insertion_force",
    "contact_force",
    "clearance",
    "slack",
    "deviation",
    "reach",
];

/// What a requirement is about; one of them.
pub(crate) const PART: Keys = Keys {
    what: "part",
    keys: &[
        may("branch", Form::Name, "a branch"),
        may("from", Form::Number(Quantity::Length, NON_NEGATIVE), "with branch: arc length where it begins to count"),
        may("to", Form::Number(Quantity::Length, NON_NEGATIVE), "with branch: arc length where it ceases to count"),
        may("branches", Form::Name, "all branches of names like this: `*` stands for any characters, `?` for one"),
        may("constraint", Form::Name, "a constraint"),
        may("constraints", Form::Name, "all constraints of names like this"),
        may("obstacle", Form::Name, "an obstacle"),
        may("obstacles", Form::Name, "all obstacles of names like this"),
    ],
};

/// A requirement.
pub(crate) const REQUIREMENT: Keys = Keys {
    what: "requirement",
    keys: &[
        NAME,
        must("quantity", Form::Choice(MEASURES), "what it limits"),
        may("of", Form::Table(&PART), "what it is about; default every part that has this quantity"),
        may("between", Form::Tables(&PART), "instead of `of`, for a clearance or a contact force: the two parts"),
        may("min", Form::Quantity, "least value; this or `max`, or both"),
        may("max", Form::Quantity, "greatest value"),
        may("steps", Form::Names, "names of the steps in which it counts; default all"),
        may(
            "motion",
            Form::Choice(&["any", "moving", "rest"]),
            "for branches: whether it counts only while they move, or only at rest; default any",
        ),
        may(
            "severity",
            Form::Choice(&["must", "should"]),
            "\"should\": it is reported, and decides nothing; default must",
        ),
        may("because", Form::Name, "its reason, such as a standard"),
    ],
};

/// A marker.
pub(crate) const MARKER: Keys =
    Keys { what: "marker", keys: &[NAME, must("at", Form::Table(&AT), "its place on the harness")] };
