//! Requests that cannot be fulfilled: message and help.

use wireloom::scenario::Fault;

/// Why a request cannot be fulfilled, and what to do instead.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Refusal {
    pub message: String,
    pub help: String,
}

impl Refusal {
    pub fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { message: message.into(), help: help.into() }
    }
}

impl From<Fault> for Refusal {
    fn from(fault: Fault) -> Self {
        Self { message: fault.message, help: fault.help }
    }
}

impl From<Vec<Fault>> for Refusal {
    fn from(faults: Vec<Fault>) -> Self {
        let first = faults.into_iter().next().map(Self::from);
        first.unwrap_or_else(|| Self::new("the scenario is invalid", "undo the last change"))
    }
}

/// The refusal while there is no initial equilibrium.
pub(super) fn no_start() -> Refusal {
    Refusal::new("no initial equilibrium was found", "change a setting, or undo the last change")
}
