//! The scenario's file: it is written, and read anew.

use super::Session;
use crate::protocol::Notice;
use wireloom::session::Refusal;

/// Reads and writes the file of a session's scenario.
pub trait Storage: Send {
    /// Whether there is no file yet: the first text is stored under a name.
    fn is_new(&self) -> bool {
        false
    }

    /// Writes a text into the scenario's file, or into another one of its folder, which then is its file. `replace`:
    /// whether to replace what another program has written there. Returns the file's name.
    ///
    /// # Errors
    /// Why the text was not written.
    fn store(&mut self, text: &str, name: Option<&str>, replace: bool) -> Result<String, StoreError>;

    /// The text of the file, which the session may refuse.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn read(&self) -> Result<String, Refusal>;

    /// The session has taken this text of the file: it may be replaced unasked.
    fn taken(&mut self, text: &str);
}

/// Why a text was not written into a file.
#[derive(Clone, Debug, PartialEq)]
pub enum StoreError {
    /// Another program has changed the scenario's file since it was read or written.
    Changed {
        /// Name of the file.
        name: String,
    },
    /// There is another file of the name that is wanted.
    Exists {
        /// Name of the file.
        name: String,
    },
    /// The name is no name of a file, or the system refuses.
    Refused(Refusal),
}

impl Session {
    /// Reads the file anew, and the files that it names.
    pub(super) fn reload(&mut self, tab: u32) -> Result<(), Refusal> {
        self.end_drag();
        let text = self.storage.as_ref().ok_or_else(no_file)?.read()?;
        let label = format!("load {} anew", self.name);
        let files = self.now.files.anew();
        self.become_text(label, &text, &files).map_err(|faults| self.refuse_text(tab, &text, &faults))?;
        self.storage.as_mut().ok_or_else(no_file)?.taken(&text);
        (self.unsaved, self.changes.edited) = (false, true);
        Ok(())
    }

    /// Writes the text into its file.
    pub(super) fn store(&mut self, tab: u32, name: Option<&str>, replace: bool) -> Result<(), Refusal> {
        let text = self.text()?;
        let storage = self.storage.as_mut().ok_or_else(no_file)?;
        let was_new = storage.is_new();
        let notice = match storage.store(&text, name, replace) {
            Ok(name) => {
                (self.unsaved, self.changes.edited) = (false, true);
                if was_new || self.name != name {
                    self.name.clone_from(&name);
                    self.changes.document = Some(self.document());
                }
                Notice::Stored { name }
            }
            Err(StoreError::Changed { name }) => Notice::Conflict { name, own: true },
            Err(StoreError::Exists { name }) => Notice::Conflict { name, own: false },
            Err(StoreError::Refused(refusal)) => return Err(refusal),
        };
        self.changes.said.push((Some(tab), notice));
        Ok(())
    }
}

fn no_file() -> Refusal {
    Refusal::new("this session has no file", "download a copy of the scenario instead")
}
