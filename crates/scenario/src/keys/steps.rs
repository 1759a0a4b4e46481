//! Steps, and what is done in them.

use super::*;

/// An assembly operation.
pub(crate) const STEP: Keys = Keys {
    what: "step",
    keys: &[
        may("name", Form::Name, "its name; default \"step N\""),
        may("increments", Form::Count(1, INCREMENTS), "in how many parts it is carried out; default 1"),
        may("gravity", Form::Vector(Quantity::Acceleration), "gravity reached at its end"),
        may("release", Form::Names, "constraints that let go when this step begins"),
        may("grasp", Form::Tables(&GRASP), "hands that take hold of the cable where it is when this step begins"),
        may("add", Form::Tables(&CONSTRAINT), "constraints that begin with this step"),
        may("move", Form::Tables(&MOVE), "motions of constraints and obstacles, one by one"),
        may("carry", Form::Tables(&CARRY), "motions of hands or connectors that are carried together"),
        may("mate", Form::Tables(&MATE), "connectors that are brought before their seats and pushed home"),
        may("clip", Form::Tables(&CLIP), "clips that close around the cable and bring it to their seats"),
        may("load", Form::Tables(&FACTOR), "load factors reached at its end"),
        may("wait", Form::Flag, "true: nothing is done but to let the harness come to rest; default false"),
    ],
};

/// A hand that takes hold.
pub(crate) const GRASP: Keys = Keys {
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

/// Things that are carried together.
pub(crate) const CARRY: Keys = Keys {
    what: "carry",
    keys: &[
        must("what", Form::Names, "constraints that move together, as one rigid body; the way is that of the first"),
        may(
            "about",
            Form::Table(&ABOUT),
            "the way is that of a point and frame of the body, here when the step begins, instead of the first",
        ),
        unless("path", "keyframes", Form::Tables(&KEYFRAME), "the way"),
        may(
            "path",
            Form::Name,
            "instead of keyframes: a CSV file of poses, from the folder of the scenario; columns t, x, y, z and, all or none, qw, qx, qy, qz; lengths in m or as in x [mm]; t from the step's beginning to its end",
        ),
        may("timing", Form::Tables(&TIMING), "those that begin later, or are done sooner, than the step"),
    ],
};

/// Where a body is when it begins to be carried.
pub(crate) const ABOUT: Keys = Keys {
    what: "about",
    keys: &[
        must("position", Form::Vector(Quantity::Length), "a point of the body"),
        may("tangent", Form::Direction, "with up: its frame, d3; default the world's axes"),
        may("up", Form::Direction, "with tangent: its frame, d1"),
        ORIENTATION,
    ],
};

/// A place on the way.
pub(crate) const KEYFRAME: Keys = Keys {
    what: "keyframe",
    keys: &[
        must(
            "at",
            Form::Number(Quantity::Dimensionless, SHARE),
            "share of the step at which it is passed; one at 0 says where the body counts as being as the step begins",
        ),
        may("position", Form::Vector(Quantity::Length), "position; left out, it is on the way between those beside it"),
        TANGENT,
        UP,
        ORIENTATION,
    ],
};

/// When something that is carried moves.
pub(crate) const TIMING: Keys = Keys {
    what: "timing",
    keys: &[
        must("what", Form::Name, "name of the constraint"),
        may(
            "delay",
            Form::Number(Quantity::Dimensionless, SHARE),
            "share of the step after which it begins to move; default 0",
        ),
        may(
            "share",
            Form::Number(Quantity::Dimensionless, Bound { exclusive: true, ..SHARE }),
            "share of the step over which it moves; default what is left of it",
        ),
    ],
};

/// A connector that is pushed home.
pub(crate) const MATE: Keys = Keys {
    what: "mate",
    keys: &[
        may("constraint", Form::Name, "name of the constraint, where it acts already; either this, or name and at"),
        may("name", Form::Name, "name of a constraint that begins with this step, where the cable is"),
        may("kind", Form::Kind(Family::Constraint, Some("connector")), "its kind; default \"connector\""),
        may("at", Form::Table(&AT), "where it attaches"),
        must("position", Form::Vector(Quantity::Length), "its seat"),
        TANGENT,
        UP,
        ORIENTATION,
        may("direction", Form::Direction, "where it is pushed; default out of the end of the branch along tangent"),
        may(
            "approach",
            Form::Number(Quantity::Length, POSITIVE),
            "how far before its seat the push begins; default 30 mm",
        ),
        may(
            "max_insertion_force",
            Form::Number(Quantity::Force, POSITIVE),
            "largest force that a hand may push with; reported against",
        ),
        HOLD,
        PULL_OUT_FORCE,
        MAX_MOMENT,
        INSERTION_FORCE,
    ],
};

/// A clip that closes.
pub(crate) const CLIP: Keys = Keys {
    what: "clip",
    keys: &[
        NAME,
        may("kind", Form::Kind(Family::Constraint, Some("collar")), "what it is; default \"collar\""),
        must(
            "at",
            Form::Table(&AT),
            "where it closes: branch and s, or branch alone for the place that is nearest to it when the step begins",
        ),
        must("position", Form::Vector(Quantity::Length), "its seat"),
        TANGENT,
        UP,
        ORIENTATION,
        HOLD,
        FREE_AXIS,
        RAIL,
        SLIDE,
        FRICTION,
        PULL_OUT_FORCE,
        MAX_MOMENT,
        INSERTION_FORCE,
    ],
};

/// Motion of a constraint or an obstacle.
pub(crate) const MOVE: Keys = Keys {
    what: "move",
    keys: &[
        unless("obstacle", "constraint", Form::Name, "name of the constraint"),
        may("obstacle", Form::Name, "instead of a constraint: name of the obstacle"),
        may("position", Form::Vector(Quantity::Length), "position reached at the end"),
        may("via", Form::Points(1), "points passed on the way, at equal shares of the step"),
        TANGENT,
        UP,
        ORIENTATION,
        may(
            "turns",
            Form::Number(Quantity::Dimensionless, TURNS),
            "then turned about the tangent by so many turns, spread over the increments",
        ),
    ],
};

/// A load factor reached by a step.
pub(crate) const FACTOR: Keys = Keys {
    what: "load",
    keys: &[
        must("load", Form::Name, "name of the load"),
        must("factor", Form::Number(Quantity::Dimensionless, LOAD_FACTOR), "factor reached at the end of the step"),
    ],
};
