//! The files that a scenario names: those that the host gave, and those in a folder.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use wireloom::plugins::open_regular_file;
use wireloom::scenario;

/// Largest text that is read, bytes, as on the command line.
const TEXT: u64 = 64 << 20;
/// Largest file of another kind, bytes.
const LARGEST: u64 = 1 << 30;

/// Files of a scenario.
#[derive(Clone)]
pub struct Files {
    folder: Option<PathBuf>,
    held: BTreeMap<String, Arc<[u8]>>,
    /// Names of those among them that are surfaces of bodies.
    bodies: BTreeSet<String>,
}

/// The text of a scenario's file.
pub fn read_text(path: &Path) -> io::Result<Vec<u8>> {
    whole(path, TEXT)
}

fn whole(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // It may grow while it is read.
    open_regular_file(path, most)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

impl Files {
    /// Those in a folder, whose path is absolute: the host may go to another one.
    pub fn new(folder: Option<PathBuf>) -> Self {
        Self { folder, held: BTreeMap::new(), bodies: BTreeSet::new() }
    }

    /// Keeps a file.
    pub fn hold(&mut self, name: String, bytes: Vec<u8>) {
        self.held.insert(name, bytes.into());
    }

    /// Keeps the surface of a body.
    pub fn hold_body(&mut self, name: String, bytes: Vec<u8>) {
        self.bodies.insert(name.clone());
        self.hold(name, bytes);
    }

    /// Whether a file is the surface of a body.
    pub fn is_body(&self, name: &str) -> bool {
        self.bodies.contains(name)
    }

    /// A file that it keeps.
    pub fn held(&self, name: &str) -> Option<&[u8]> {
        self.held.get(name).map(|bytes| &**bytes)
    }

    /// Names of the files that it keeps.
    pub fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.held.keys().map(String::as_str)
    }

    fn found(&self, path: &str, most: u64) -> Result<Vec<u8>, String> {
        if let Some(held) = self.held.get(path) {
            return Ok(held.to_vec());
        }
        let none = "the scenario was made without a folder, and the host did not add this file";
        let path = self.folder.as_ref().ok_or(none)?.join(path);
        whole(&path, most).map_err(|error| error.to_string())
    }
}

impl scenario::Files for Files {
    fn read(&self, path: &str) -> Result<String, String> {
        let bytes = self.found(path, TEXT)?;
        String::from_utf8(bytes).map_err(|error| format!("not UTF-8 text (byte {})", error.utf8_error().valid_up_to()))
    }

    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.found(path, LARGEST)
    }
}
