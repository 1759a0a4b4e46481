//! Status of runs, steps and increments.

use serde::{Deserialize, Serialize};

/// How a run, a step or an increment ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Status {
    /// The certificate found forces and moments in balance.
    Converged,
    /// No further progress is possible in double precision; the residual is above the tolerance.
    Stalled,
    /// The iterations allowed were used up.
    IterationLimit,
    /// No step lowers the energy any more, or numbers ceased to be finite.
    Failed,
    /// Stopped from outside.
    Interrupted,
}

impl Status {
    /// All there are.
    pub const ALL: [Status; 5] =
        [Status::Converged, Status::Stalled, Status::IterationLimit, Status::Failed, Status::Interrupted];

    /// The word used in results.
    pub fn word(self) -> &'static str {
        match self {
            Status::Converged => "converged",
            Status::Stalled => "stalled at round-off",
            Status::IterationLimit => "iteration limit",
            Status::Failed => "failed",
            Status::Interrupted => "interrupted",
        }
    }
}
