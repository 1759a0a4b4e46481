//! Error of a part that cannot be built.

/// Error of a factory that cannot build the part that the scenario asks for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct BuildError {
    /// Description of the error, with the offending value.
    pub message: String,
    /// Suggested correction.
    pub help: String,
    /// Offending key of the scenario; `None` if the whole entry is wrong.
    pub key: Option<String>,
}

impl BuildError {
    /// Error that concerns the whole entry.
    pub fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { message: message.into(), help: help.into(), key: None }
    }
    /// Sets the offending key.
    pub fn at(mut self, key: &str) -> Self {
        self.key = Some(key.to_owned());
        self
    }
}
