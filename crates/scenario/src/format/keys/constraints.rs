//! Constraints and loads, and where they attach.

pub(crate) use super::identities::NAME;
use super::identities::{COLOUR, DESCRIPTION, KBL, PART, SUPPLIER};
use crate::format::form::{Family, Form, Key, Keys, may, must, unless, with};
use crate::format::limits::{ANY, DRAG_COEFFICIENT, FRICTION_COEFFICIENT, LOAD_FACTOR, POSITIVE};
use wireloom_core::Quantity;

/// A place that something attaches to.
pub(crate) const AT: Keys = Keys {
    what: "at",
    keys: &[
        may("end", Form::Name, "a free end, by vertex"),
        may("joint", Form::Name, "a joint, by vertex"),
        may("branch", Form::Name, "a branch, with s"),
        may("s", Form::Number(Quantity::Length, ANY), "unstressed arc length along the branch"),
    ],
};

pub(crate) const TANGENT: Key =
    may("tangent", Form::Direction, "direction of d3: along the branch, from `from` to `to`");
pub(crate) const UP: Key =
    may("up", Form::Direction, "direction of d1; with tangent it gives the twist; projected if not orthogonal");
pub(crate) const ORIENTATION: Key = may("orientation", Form::Orientation, "instead of tangent and up: the whole frame");

pub(crate) const PLACE: Key = must("at", Form::Table(&AT), "where it attaches");
pub(crate) const MOUNT: Key = may(
    "mount",
    Form::Name,
    "body of a mechanism that carries it: \"BODY\", or \"MECHANISM/BODY\" where several have its name; its pose and \
     its moves are then as the mechanism is drawn",
);
pub(crate) const HOLD: Key =
    may("hold", Form::Words(&["position", "tangent", "twist"]), "freedoms that it holds, instead of those of its kind");
pub(crate) const FREE_AXIS: Key =
    may("free_axis", Form::Direction, "the only world axis about which it may turn: a hinge");
pub(crate) const RAIL: Key =
    may("rail", Form::Directions, "one or two world directions along which the held point may move freely");
pub(crate) const SLIDE: Key = may(
    "slide",
    Form::Flag,
    "whether the cable may slide through: a ring or, with the tangent held, a sleeve; default false",
);
pub(crate) const FRICTION: Key = may(
    "friction",
    Form::Number(Quantity::Dimensionless, FRICTION_COEFFICIENT),
    "friction of the sliding cable: axial force per force across at which the cable slips; default 0",
);
pub(crate) const PULL_OUT_FORCE: Key = may(
    "pull_out_force",
    Form::Number(Quantity::Force, POSITIVE),
    "largest force before it is pulled out; larger ones are reported",
);
pub(crate) const MAX_MOMENT: Key =
    may("max_moment", Form::Number(Quantity::Moment, POSITIVE), "largest moment; larger ones are reported");
pub(crate) const INSERTION_FORCE: Key =
    may("insertion_force", Form::Number(Quantity::Force, POSITIVE), "force needed to push it in");

/// A part of a branch.
pub(crate) const SPAN: Keys = Keys {
    what: "span",
    keys: &[
        must("branch", Form::Name, "the branch"),
        may("from", Form::Number(Quantity::Length, ANY), "arc length where it begins; default 0"),
        may("to", Form::Number(Quantity::Length, ANY), "arc length where it ends; default the end of the branch"),
    ],
};

/// A constraint.
pub(crate) const CONSTRAINT: Keys = Keys {
    what: "constraint",
    keys: &[
        NAME,
        must("kind", Form::Kind(Family::Constraint, None), "its kind, such as \"connector\" or \"edge-clip\""),
        unless(
            &["span"],
            "at",
            Form::OneOrMoreTables(&AT),
            "where it attaches; a list for kinds that attach to several places",
        ),
        may("span", Form::Table(&SPAN), "the part of a branch along which it acts, for kinds that act along one"),
        may("position", Form::Vector(Quantity::Length), "position that it holds; left out: that of the cable"),
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

/// A flow.
pub(crate) const FLOW: Keys = Keys {
    what: "flow",
    keys: &[
        must("velocity", Form::Vector(Quantity::Velocity), "velocity of the fluid in world axes"),
        may("density", Form::Number(Quantity::Density, POSITIVE), "density of the fluid; default 1.2 (air)"),
        may(
            "drag_coefficient",
            Form::Number(Quantity::Dimensionless, DRAG_COEFFICIENT),
            "drag coefficient across the cable, by its outer diameter; default 1.2 (smooth cylinder)",
        ),
    ],
};

/// A load.
pub(crate) const LOAD: Keys = Keys {
    what: "load",
    keys: &[
        must("name", Form::Name, "its name"),
        unless(&["span"], "at", Form::Table(&AT), "where force and moment act"),
        may("force", Form::Vector(Quantity::Force), "force in world axes; default 0"),
        may("moment", Form::Vector(Quantity::Moment), "moment in world axes; default 0"),
        may(
            "span",
            Form::OneOrMoreTables(&SPAN),
            "the part of a branch along which a force per length or a flow acts; a list for several",
        ),
        with(
            "span",
            "force_per_length",
            Form::Vector(Quantity::ForcePerLength),
            "force per unstressed length in world axes",
        ),
        with("span", "flow", Form::Table(&FLOW), "flow of air or water, whose drag across the cable acts"),
        may(
            "follows",
            Form::Flag,
            "true: it turns with the cable, and its axes are d1, d2, d3 in place of those of the world; default false",
        ),
        may("factor", Form::Number(Quantity::Dimensionless, LOAD_FACTOR), "factor at the beginning; default 1"),
    ],
};
