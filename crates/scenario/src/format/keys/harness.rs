//! Branches and joints.

use super::identities::{COLOUR, DESCRIPTION, KBL, PART, SUPPLIER};
use crate::format::form::{Family, Form, Keys, may, must};
use crate::format::limits::{ANY, FRACTION, MAX_COUNT, NON_NEGATIVE, POSITIVE, SPAN_LENGTH};
use wireloom_core::Quantity;

/// A branch.
pub(crate) const BRANCH: Keys = Keys {
    what: "branch",
    keys: &[
        must("name", Form::Name, "its name"),
        must("from", Form::Name, "vertex where it begins"),
        must("to", Form::Name, "vertex where it ends"),
        must("section", Form::Name, "name of its section"),
        may("sections", Form::Tables(&SECTION_PART), "parts of it with another section, such as under a tube"),
        must("length", Form::Number(Quantity::Length, SPAN_LENGTH), "unstressed length"),
        may("segments", Form::Count(1, MAX_COUNT), "number of segments; this or max_segment, or [mesh] accuracy"),
        may(
            "max_segment",
            Form::Number(Quantity::Length, POSITIVE),
            "longest segment, also of a mesh by [mesh] accuracy",
        ),
        may("rod", Form::Kind(Family::Rod, Some("cosserat")), "kind of rod; default \"cosserat\""),
        may(
            "curvature",
            Form::Vector(Quantity::Curvature),
            "rest curvature about d1 and d2 and rest twist about d3; default straight",
        ),
        may(
            "path",
            Form::Points(2),
            "centre line along which it is laid at the start, from `from` to `to`, world coordinates; only the initial \
             shape depends on it",
        ),
        may(
            "drawn",
            Form::Points(2),
            "drawn centre line, with which results are compared, where that is not `path`: as where the harness starts \
             on a board and is drawn in the vehicle",
        ),
        PART,
        DESCRIPTION,
        SUPPLIER,
        COLOUR,
        KBL,
    ],
};

/// A part of a branch with another section.
const SECTION_PART: Keys = Keys {
    what: "part",
    keys: &[
        must("section", Form::Name, "name of its section"),
        may("from", Form::Number(Quantity::Length, ANY), "arc length where it begins; default 0"),
        may("to", Form::Number(Quantity::Length, ANY), "arc length where it ends; default the end of the branch"),
    ],
};

/// A joint.
pub(crate) const JOINT: Keys = Keys {
    what: "joint",
    keys: &[
        must("name", Form::Name, "its vertex"),
        may("model", Form::Kind(Family::Joint, Some("cosserat")), "joint model; default \"cosserat\""),
        must("arms", Form::Tables(&ARM), "one entry for every branch that ends here"),
        may("wires", Form::Tables(&WIRES), "wires that run through; default: by stiffness"),
        may("mass", Form::Number(Quantity::Mass, NON_NEGATIVE), "mass; default 0"),
        may(
            "bending_stiffness",
            Form::OneOrTwo(Quantity::MomentPerAngle, POSITIVE),
            "of the springs that hold the arms to a hub, about d1 and d2 of the arm; only models with such springs \
             (`compliant-hub`) look at it, so that one file serves all models",
        ),
        may(
            "torsion_stiffness",
            Form::Number(Quantity::MomentPerAngle, POSITIVE),
            "of the springs that hold the arms to a hub, about d3 of the arm; for the same models",
        ),
        may(
            "friction",
            Form::Table(&ARM_FRICTION),
            "what slips beside these springs, so that a bent arm keeps a set: tape about a break-out; for \
             `compliant-hub` only",
        ),
        PART,
        DESCRIPTION,
        SUPPLIER,
        COLOUR,
    ],
};

/// An arm of a joint.
pub(crate) const ARM: Keys = Keys {
    what: "arm",
    keys: &[
        must("branch", Form::Name, "name of its branch"),
        may("direction", Form::Direction, "direction out of the joint along the arm, in the joint's frame"),
        may("up", Form::Direction, "d1 of the branch in the joint's frame; projected if not orthogonal"),
        may(
            "orientation",
            Form::Orientation,
            "instead of direction and up: frame of the branch (d3 `from → to`) in the joint's frame",
        ),
        may(
            "offset",
            Form::Vector(Quantity::Length),
            "point where the arm leaves the joint, in the joint's frame; for models with a body",
        ),
        may(
            "bending_stiffness",
            Form::OneOrTwo(Quantity::MomentPerAngle, POSITIVE),
            "of the spring that holds this arm to its hub, about d1 and d2 of the arm; default: that of the joint",
        ),
        may(
            "torsion_stiffness",
            Form::Number(Quantity::MomentPerAngle, POSITIVE),
            "of the spring that holds this arm to its hub, about d3 of the arm; default: that of the joint",
        ),
        may("friction", Form::Table(&ARM_FRICTION), "what slips beside the spring of this arm; default: as the joint"),
    ],
};

/// Friction between an arm and its hub.
pub(crate) const ARM_FRICTION: Keys = Keys {
    what: "friction",
    keys: &[
        may(
            "bending",
            Form::Tables(&ARM_FRICTION_ELEMENT),
            "elements in bending, in parallel to bending_stiffness and to each other; alike about d1 and d2",
        ),
        may(
            "torsion",
            Form::Tables(&ARM_FRICTION_ELEMENT),
            "elements in torsion, in parallel to torsion_stiffness and to each other",
        ),
    ],
};

/// Element of friction between an arm and its hub: a spring in series with a slider.
pub(crate) const ARM_FRICTION_ELEMENT: Keys = Keys {
    what: "element",
    keys: &[
        must("stiffness", Form::Number(Quantity::MomentPerAngle, POSITIVE), "stiffness that it adds while it sticks"),
        must("moment", Form::Number(Quantity::Moment, POSITIVE), "moment at which it slips, and which it then keeps"),
    ],
};

/// An entry of a joint's anatomy.
pub(crate) const WIRES: Keys = Keys {
    what: "wires",
    keys: &[
        must("between", Form::Names, "two arms, by branch"),
        must(
            "share",
            Form::Number(Quantity::Dimensionless, FRACTION),
            "fraction of the first arm's wires that passes to the second",
        ),
    ],
};
