//! Files that a scenario names. This crate opens none; its caller does.

/// Reads the files that a scenario names.
pub trait Files {
    /// The text of the file at `path`, as the scenario writes it. Relative paths count from the folder of the
    /// scenario.
    ///
    /// # Errors
    /// The reason why it cannot be read, in words that may follow a colon.
    fn read(&self, path: &str) -> Result<String, String>;

    /// The bytes of the file at `path`, which need not be text.
    ///
    /// # Errors
    /// See [`Self::read`].
    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.read(path).map(String::into_bytes)
    }
}

/// No files: for a text without a folder.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Files for NoFiles {
    fn read(&self, _: &str) -> Result<String, String> {
        Err("the scenario is a text without a folder".to_owned())
    }
}
