//! Optimisation: numbers and words of the scenario that are chosen so that its requirements are kept.

use crate::format::form::{Form, Keys, may, must};
use crate::format::limits::{ACCURACY, ANY, FRACTION, MAX_COUNT};
use wireloom_core::Quantity;

/// Most starts of an optimisation.
const MAX_STARTS: usize = 1000;

/// An optimisation.
pub(crate) const OPTIMISE: Keys = Keys {
    what: "optimise",
    keys: &[
        must(
            "vary",
            Form::Named(&VARIABLE),
            "keys that are chosen, each by its path in quotes, such as \"branches.left.length\" = { from = 0.4, to = \
             0.5 } or \"branches.left.section\" = { values = [\"thin\", \"thick\"] }; the file's own values are the \
             first start",
        ),
        must(
            "minimise",
            Form::NamesOrTables(&TERM),
            "what is made as small as possible, one or a weighted sum: \"length\" (of all branches, m), \"mass\" (of \
             all branches, kg), the worst value of a requirement over all increments, by its name (in its unit; of one \
             with a least value it is made as large as possible), or \"worst margin\" (the smallest relative margin of \
             all requirements, which is made as large as possible). All requirements that must be kept are constraints",
        ),
        may(
            "starts",
            Form::Count(1, MAX_STARTS),
            "number of starts for each combination of choices: the file's own values, then points that fill the ranges \
             evenly; default 1",
        ),
        may("runs", Form::Count(1, MAX_COUNT), "largest number of runs of the scenario; default 200"),
        may(
            "margin",
            Form::Number(Quantity::Dimensionless, FRACTION),
            "margin to keep from every limit, relative to it, beyond the estimated discretisation error; default 0.001",
        ),
        may(
            "accuracy",
            Form::Number(Quantity::Dimensionless, ACCURACY),
            "change of the objective, relative to it, below which it counts as smallest; default 0.0001",
        ),
    ],
};

/// A key that is chosen.
pub(crate) const VARIABLE: Keys = Keys {
    what: "variable",
    keys: &[
        may("from", Form::Quantity, "least value"),
        may("to", Form::Quantity, "greatest value"),
        may("values", Form::Values, "instead: list of values to choose from, written as in the file"),
    ],
};

/// A part of the objective.
pub(crate) const TERM: Keys = Keys {
    what: "minimise",
    keys: &[
        must("name", Form::Name, "\"length\", \"mass\", \"worst margin\", or the name of a requirement"),
        may("weight", Form::Number(Quantity::Dimensionless, ANY), "factor in the sum; default 1"),
    ],
};
