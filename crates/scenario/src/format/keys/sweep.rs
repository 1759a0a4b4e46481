//! Sweeps: a scenario run over many values.

use crate::format::form::{Form, Keys, may, must};
use crate::format::limits::{ANY, MAX_COUNT, POSITIVE, SECONDS};
use crate::sweep::MAX_POINTS;
use wireloom_core::Quantity;

/// Methods to choose points.
const METHODS: &[&str] = &["grid", "zip", "random", "latin-hypercube", "sobol"];

/// Quantities that an output of a sweep measures.
const QUANTITIES: &[&str] = &[
    "position",
    "orientation",
    "angle",
    "force",
    "moment",
    "tension",
    "bend_radius",
    "slack",
    "turns",
    "clearance",
    "contact_force",
    "output",
];

/// A sweep.
pub(crate) const SWEEP: Keys = Keys {
    what: "sweep",
    keys: &[
        may(
            "method",
            Form::Choice(METHODS),
            "method to choose points: every combination (grid), the first values of all keys, then the second ones \
             (zip), at random, or spread evenly by Latin hypercube or Sobol's sequence (scrambled again after every \
             65,536 points); default \"grid\"",
        ),
        may("samples", Form::Count(1, MAX_POINTS), "number of points; for random, latin-hypercube and sobol"),
        may("seed", Form::Count(0, u32::MAX as usize), "seed of the random numbers; default 0"),
        must(
            "vary",
            Form::Named(&VARIED),
            "keys that vary, each by its path in quotes, such as \"branches.left.length\" = { from = 0.4, to = 0.5 }; \
             `*` stands for every entry of a list",
        ),
        may(
            "cross",
            Form::Named(&VARIED),
            "keys with lists of values, such as \"joints.J.model\" = { values = [\"cosserat\", \"rigid-body\"] }: the \
             points of `vary` are computed with every combination of them",
        ),
        may(
            "time_limit",
            Form::Number(Quantity::Dimensionless, SECONDS),
            "time limit of a point, in seconds: one that takes longer is ended, and is a row with that reason; \
             default none",
        ),
        may(
            "swept",
            Form::Number(Quantity::Length, POSITIVE),
            "size of the cells of a grid, on which the space that the harness sweeps at all points and in all steps \
             is written as one closed mesh, and as tubes around each branch that hold it in 50, 90, 95 and 100 % of \
             the points",
        ),
        may(
            "outputs",
            Form::Named(&OUTPUT),
            "further columns of the table, by name, such as tip = { quantity = \"position\", of = { end = \"B\" } }",
        ),
    ],
};

/// A quantity that is measured at every point.
pub(crate) const OUTPUT: Keys = Keys {
    what: "output",
    keys: &[
        must(
            "quantity",
            Form::Choice(QUANTITIES),
            "measured quantity: position (m) and orientation (quaternion) of a place, a constraint or an obstacle; \
             internal force (N) and moment (N m) at a place, or those that a constraint or an obstacle exerts on the \
             harness; tension at a place (N, the force along the branch); smallest bend_radius (m) and slack (m, \
             unstressed length beyond the distance of the ends) of a part of a branch; turns of twist of a branch; \
             angle (rad) between the directions of two branches at two places; clearance (m) between two branches, or \
             between a branch and an obstacle; contact_force (N, the sum of the sizes of the forces) of an obstacle; \
             output of a plugin's constraint (SI)",
        ),
        may("of", Form::Table(&MEASURED), "what is measured: a place, a part of a branch, a constraint or an obstacle"),
        may("between", Form::Tables(&MEASURED), "instead of `of`, for an angle and a clearance: both of them"),
        may(
            "at",
            Form::Name,
            "when: \"end\" (of the run), \"min\" or \"max\" (the least or greatest value over all increments), or the \
             name of a step, at its end; default \"end\"",
        ),
    ],
};

/// What an output measures; one of: a place, a part of a branch, a constraint, an obstacle.
pub(crate) const MEASURED: Keys = Keys {
    what: "of",
    keys: &[
        may("end", Form::Name, "a free end, by vertex"),
        may("joint", Form::Name, "a joint, by vertex"),
        may("branch", Form::Name, "a branch: a place on it with `s`, otherwise the part between `from` and `to`"),
        may("s", Form::Number(Quantity::Length, ANY), "unstressed arc length along the branch"),
        may("from", Form::Number(Quantity::Length, ANY), "arc length where the part begins; default 0"),
        may("to", Form::Number(Quantity::Length, ANY), "arc length where the part ends; default the end of the branch"),
        may("constraint", Form::Name, "a constraint"),
        may("output", Form::Name, "with `constraint`: an output of its kind; `wireloom plugin check` lists them"),
        may("obstacle", Form::Name, "an obstacle"),
    ],
};

/// A key that varies.
pub(crate) const VARIED: Keys = Keys {
    what: "varied key",
    keys: &[
        may("values", Form::Values, "list of values, written as in the file"),
        may("from", Form::Quantity, "least value of a range"),
        may("to", Form::Quantity, "greatest value of a range"),
        may("count", Form::Count(2, MAX_COUNT), "number of values of the range, ends included; for grid and zip"),
        may("mean", Form::Quantity, "mean of a normal distribution"),
        may("deviation", Form::Quantity, "standard deviation of a normal distribution"),
        may(
            "when",
            Form::Conditions,
            "it varies only where other keys of the sweep have these values, such as { \"joints.J.model\" = \
             \"cosserat\" } or { \"joints.J.model\" = [\"cosserat\", \"fused\"] }; elsewhere the file's value holds",
        ),
    ],
};
