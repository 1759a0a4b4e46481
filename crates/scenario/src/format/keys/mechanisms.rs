//! Mechanisms: bodies that joints connect.

use super::constraints::{NAME, ORIENTATION, TANGENT, UP};
use crate::format::form::{Form, Keys, may, must, unless, with};
use crate::format::limits::ANY;
use wireloom_core::Quantity;

/// Kinds of joints of mechanisms.
pub(crate) const JOINT_KINDS: [&str; 9] =
    ["fixed", "revolute", "prismatic", "cylindrical", "screw", "universal", "spherical", "planar", "floating"];

/// Shapes of the links of a URDF file.
pub(crate) const LINK_SHAPES: [&str; 2] = ["collision", "visual"];

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
        with(
            "urdf",
            "drawn",
            Form::Tables(&DRAWN),
            "values of joints with which the file stands as everything is given; default 0",
        ),
        with(
            "urdf",
            "obstacles",
            Form::Choice(&LINK_SHAPES),
            "which shapes of its links are obstacles, mounted on them and named MECHANISM/LINK; default none",
        ),
        with(
            "obstacles",
            "without",
            Form::Names,
            "links whose shapes are left out, such as a gripper that holds a cable; `*` stands for any text",
        ),
        with("obstacles", "open", Form::Flag, "true: their meshes are sheets, and may have borders; default false"),
    ],
};

/// The value of a joint of a URDF file as drawn.
const DRAWN: Keys = Keys {
    what: "value of a joint as drawn",
    keys: &[
        must("joint", Form::Name, "a joint of the file"),
        must("value", Form::QuantityOrList, "its value, or one for each of its freedoms"),
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
        may(
            "second_axis",
            Form::Direction,
            "second axis of a universal joint, as drawn: it turns with the first; of a planar joint, whose `axis` is \
             the normal of its plane, the direction of its first translation",
        ),
        may("pitch", Form::Number(Quantity::Length, ANY), "way of a screw along its axis in one turn"),
        may("drawn", Form::QuantityOrList, "its value as drawn, or one for each of its freedoms; default 0"),
        may(
            "limits",
            Form::Values,
            "its smallest and largest value, such as [\"0 deg\", \"80 deg\"]; for a joint with several freedoms a \
             list of such pairs, where [] is none",
        ),
    ],
};
