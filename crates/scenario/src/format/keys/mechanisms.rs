//! Mechanisms: bodies that joints connect.

use super::constraints::{NAME, ORIENTATION, TANGENT, UP};
use crate::format::form::{Form, Keys, may, must, unless, with};
use crate::format::limits::ANY;
use wireloom_core::Quantity;

/// Kinds of joints of mechanisms.
pub(crate) const JOINT_KINDS: [&str; 7] =
    ["fixed", "revolute", "prismatic", "cylindrical", "screw", "universal", "spherical"];

/// A mechanism.
pub(crate) const MECHANISM: Keys = Keys {
    what: "mechanism",
    keys: &[
        NAME,
        unless(
            &["urdf"],
            "joints",
            Form::Tables(&MECHANISM_JOINT),
            "its joints; the bodies come into being by being named",
        ),
        may("urdf", Form::Name, "instead of joints: a URDF file with them, from the folder of the scenario"),
        with(
            "urdf",
            "position",
            Form::Vector(Quantity::Length),
            "position of the root of the file; default the origin",
        ),
        TANGENT,
        UP,
        ORIENTATION,
    ],
};

/// A joint of a mechanism.
const MECHANISM_JOINT: Keys = Keys {
    what: "joint of a mechanism",
    keys: &[
        NAME,
        must("kind", Form::Choice(&JOINT_KINDS), "its kind"),
        must(
            "between",
            Form::Names,
            "the two bodies that it connects: its value is a motion of the second against the first; \"ground\" is the \
             body that does not move",
        ),
        may(
            "origin",
            Form::Vector(Quantity::Length),
            "a point of its axis, or its centre, as drawn; default the origin",
        ),
        may("axis", Form::Direction, "direction of its axis, as drawn"),
        may("second_axis", Form::Direction, "second axis of a universal joint, as drawn: it turns with the first"),
        may("pitch", Form::Number(Quantity::Length, ANY), "way of a screw along its axis in one turn"),
        may(
            "limits",
            Form::Values,
            "smallest and largest value of a joint with one freedom, such as [\"0 deg\", \"80 deg\"]; 0 as drawn",
        ),
    ],
};
