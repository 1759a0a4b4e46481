//! Error of a part that cannot be built.

/// Why a factory could not build what the scenario asks for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct BuildError {
    /// What is wrong, naming the value.
    pub message: String,
    /// What would be right.
    pub help: String,
    /// Key of the scenario at fault, where it is one.
    pub key: Option<String>,
}

impl BuildError {
    /// A fault of the whole entry.
    pub fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { message: message.into(), help: help.into(), key: None }
    }
    /// The same, pointing at a key.
    pub fn at(mut self, key: &str) -> Self {
        self.key = Some(key.to_owned());
        self
    }
}
