//! Why a session could not do something.

use std::fmt;
use wireloom_core::equilibrium::PartFault;
use wireloom_scenario::Fault;
use wireloom_scenario::fault::did_you_mean;
use wireloom_solve::steps::Interruption;

/// What is wrong with a request, and what to do instead.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// What is wrong.
    pub message: String,
    /// What would be right.
    pub help: String,
}

impl Refusal {
    /// A refusal with these words.
    pub fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { message: message.into(), help: help.into() }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { message, help } = self;
        if help.is_empty() { write!(f, "{message}") } else { write!(f, "{message}; {help}") }
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

/// Why a session could not do something.
#[derive(Clone, Debug, thiserror::Error)]
pub enum SessionError {
    /// The scenario has faults, or would have them.
    #[error("{}", Refusal::from(faults.clone()))]
    Refused {
        /// Its text.
        text: String,
        /// All its faults.
        faults: Vec<Fault>,
    },
    /// A key that does not exist, or a value that TOML does not have.
    #[error("{}", Refusal::from(fault.clone()))]
    Key {
        /// The scenario without what was done by hand.
        text: String,
        /// What is wrong.
        fault: Fault,
    },
    /// A name that does not exist.
    #[error("{0}")]
    Unknown(Refusal),
    /// A value that is none, such as a quaternion of length zero.
    #[error("{0}")]
    Value(Refusal),
    /// What cannot be done now, such as a motion to a place at which there is no equilibrium.
    #[error("{0}")]
    Request(Refusal),
    /// It was stopped ([`Monitor::stop`](super::Monitor::stop)).
    #[error("it was stopped; repeat it")]
    Stopped,
    /// A part of the harness failed.
    #[error("{0}")]
    Part(PartFault),
}

impl SessionError {
    pub(super) fn unknown<'n>(message: String, name: &str, known: impl IntoIterator<Item = &'n str> + Clone) -> Self {
        Self::Unknown(Refusal::new(message, did_you_mean(name, known)))
    }

    pub(super) fn value(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Value(Refusal::new(message, help))
    }

    pub(super) fn request(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::Request(Refusal::new(message, help))
    }
}

impl From<Interruption> for SessionError {
    fn from(interruption: Interruption) -> Self {
        match interruption {
            Interruption::Stopped => Self::Stopped,
            Interruption::Fault(fault) => Self::Part(fault),
        }
    }
}

impl From<SessionError> for Refusal {
    fn from(error: SessionError) -> Self {
        match error {
            SessionError::Refused { faults, .. } => faults.into(),
            SessionError::Key { fault, .. } => fault.into(),
            SessionError::Unknown(refusal) | SessionError::Value(refusal) | SessionError::Request(refusal) => refusal,
            SessionError::Stopped => Self::new("it was stopped", "repeat it"),
            SessionError::Part(fault) => Self::new(fault.to_string(), ""),
        }
    }
}
