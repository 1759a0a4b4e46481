//! Files that a scenario names: this crate opens none, whoever calls it does.

/// Reads the files that a scenario names.
pub trait Files {
    /// The text of the file at `path`, written as the scenario writes it. Relative paths count from the folder of the
    /// scenario.
    ///
    /// # Errors
    /// Why it cannot be read, in words that may follow a colon.
    fn read(&self, path: &str) -> Result<String, String>;

    /// The bytes of the file at `path`, which need be no text.
    ///
    /// # Errors
    /// As [`Self::read`].
    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.read(path).map(String::into_bytes)
    }
}

/// For a text that lies in no folder: whatever it names cannot be read.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Files for NoFiles {
    fn read(&self, _: &str) -> Result<String, String> {
        Err("the scenario is a text without a folder".to_owned())
    }
}
