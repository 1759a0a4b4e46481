//! Sweeps: a scenario run over many values.

use super::constraints::{AT, SPAN};
use crate::format::form::{Form, Keys, may, must};
use crate::format::limits::MAX_COUNT;

/// Methods to choose points.
const METHODS: &[&str] = &["grid", "zip", "random", "latin-hypercube", "sobol"];

/// Quantities that an output of a sweep measures.
const QUANTITIES: &[&str] = &["position", "force", "moment", "tension", "bend-radius", "slack"];

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
        may("samples", Form::Count(1, MAX_COUNT), "number of points; for random, latin-hypercube and sobol"),
        may("seed", Form::Count(0, u32::MAX as usize), "seed of the random numbers; default 0"),
        must(
            "vary",
            Form::Named(&VARIED),
            "keys that vary, each by its path in quotes, such as \"branches.left.length\" = { from = 0.4, to = 0.5 }; \
             `*` stands for every entry of a list",
        ),
        may(
            "outputs",
            Form::Named(&OUTPUT),
            "further columns of the table, by name, such as tip = { quantity = \"position\", at = { end = \"B\" } }",
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
            "measured quantity: position (m), internal force (N), internal moment (N m) and tension (N, the force \
             along the branch) at a place; smallest bend-radius (m) and slack (m, unstressed length beyond the \
             distance of the ends) of a span",
        ),
        may("at", Form::Table(&AT), "place of a position, force, moment or tension"),
        may("span", Form::Table(&SPAN), "part of a branch whose bend-radius or slack is measured"),
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
    ],
};
