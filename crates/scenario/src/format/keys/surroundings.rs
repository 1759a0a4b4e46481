//! Obstacles and contact.

use super::constraints::{MOUNT, NAME};
use super::identities::{COLOUR, DESCRIPTION, PART, SUPPLIER};
use crate::format::form::{Family, Form, Keys, may, with};
use crate::format::limits::{FRICTION_COEFFICIENT, NON_NEGATIVE, POSITIVE};
use wireloom_core::Quantity;

/// A body that the harness may touch.
pub(crate) const OBSTACLE: Keys = Keys {
    what: "obstacle",
    keys: &[
        NAME,
        may("shape", Form::Kind(Family::Shape, Some("mesh")), "its shape; default \"mesh\""),
        may(
            "mesh",
            Form::Name,
            "a file with its surface, from the folder of the scenario: STL, OBJ, PLY, glTF, GLB or STEP",
        ),
        with(
            "mesh",
            "scale",
            Form::Number(Quantity::Dimensionless, POSITIVE),
            "length of a unit of the file in m: 0.001 for a file in millimetres; default 1",
        ),
        may("position", Form::Vector(Quantity::Length), "position of its origin; default the world's"),
        may(
            "tangent",
            Form::Direction,
            "direction of its third axis, such as that of a cylinder; default the world's z",
        ),
        may("up", Form::Direction, "with tangent: direction of its first axis; projected if not orthogonal"),
        may("orientation", Form::Orientation, "instead of tangent and up: its axes; default the world's"),
        MOUNT,
        may(
            "friction",
            Form::Number(Quantity::Dimensionless, FRICTION_COEFFICIENT),
            "coefficient of Coulomb friction: force along its surface per force across, at slip; default 0",
        ),
        may(
            "min_clearance",
            Form::Number(Quantity::Length, NON_NEGATIVE),
            "least distance from the surface of a cable to its own; smaller ones are reported",
        ),
        may(
            "max_contact_force",
            Form::Number(Quantity::Force, POSITIVE),
            "largest sum of the sizes of its contact forces on the cables",
        ),
        PART,
        DESCRIPTION,
        SUPPLIER,
        COLOUR,
    ],
};

/// Contact.
pub(crate) const CONTACT: Keys = Keys {
    what: "contact",
    keys: &[
        may("cables", Form::Flag, "whether cables touch each other, and themselves; default false"),
        with(
            "cables",
            "friction",
            Form::Number(Quantity::Dimensionless, FRICTION_COEFFICIENT),
            "coefficient of Coulomb friction of cables on each other and on themselves; default 0",
        ),
        may(
            "resolve",
            Form::Flag,
            "true: a harness that begins inside an obstacle is pushed out first; default false: it is refused",
        ),
    ],
};
