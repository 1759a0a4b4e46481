//! Status of runs, steps and increments.

use serde::{Deserialize, Serialize};

/// Status at the end of a run, a step or an increment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Status {
    /// The certificate found forces and moments in equilibrium.
    Converged,
    /// No further progress is possible in double precision; the residual is above the tolerance.
    Stalled,
    /// The iteration limit was reached.
    IterationLimit,
    /// No step lowers the energy, or numbers are not finite.
    Failed,
    /// Interrupted by a request from outside.
    Interrupted,
}

impl Status {
    /// All values.
    pub const ALL: [Status; 5] =
        [Status::Converged, Status::Stalled, Status::IterationLimit, Status::Failed, Status::Interrupted];

    /// Whether it is that of an equilibrium: its values count in tables and requirements, and the run goes on from it.
    pub fn is_balanced(self) -> bool {
        matches!(self, Status::Converged | Status::Stalled)
    }

    /// Word used in results.
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
