//! A scenario's text and the files that it names; checks and edits of the text.

use crate::failure::{Failure, diagnostics};
use crate::parts::{self, Part};
use crate::worker::guarded;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wireloom::Registry;
use wireloom::plugins::open_regular_file;
use wireloom::scenario::{Built, Fault, Files, Scenario, record};
use wireloom::session::Monitor;

/// Largest text that is read, bytes, as on the command line.
const TEXT: u64 = 64 << 20;
/// Largest file of another kind, bytes.
const LARGEST: u64 = 1 << 30;

/// The bytes of a plain file.
fn bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // It may grow while it is read.
    open_regular_file(path, most)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a file.
fn utf8(bytes: Vec<u8>) -> Result<String, String> {
    String::from_utf8(bytes).map_err(|error| format!("not UTF-8 text (byte {})", error.utf8_error().valid_up_to()))
}

/// The files beside a scenario; those that were read are kept.
#[derive(Default)]
pub struct Beside {
    folder: Option<PathBuf>,
    /// Files that came with the scenario from another machine; where there are any, no others are read.
    held: Option<Held>,
    texts: Mutex<Vec<(String, String)>>,
    /// Names and SHA-256 of files that are no texts.
    hashed: Mutex<BTreeMap<String, String>>,
}

/// Files by name.
pub type Held = BTreeMap<String, Vec<u8>>;

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Nothing panics while it holds one of these.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Beside {
    fn path(&self, path: &str) -> Result<PathBuf, String> {
        let none = "the scenario is a text without a folder: give loads(text, folder=...)";
        Ok(self.folder.as_ref().ok_or(none)?.join(path))
    }

    fn found(&self, path: &str, most: u64) -> Result<Vec<u8>, String> {
        match &self.held {
            Some(held) => held.get(path).cloned().ok_or_else(|| "it did not come with the scenario".to_owned()),
            None => bytes(&self.path(path)?, most).map_err(|error| error.to_string()),
        }
    }

    /// All files that were read.
    pub fn all(&self) -> Result<Held, String> {
        let texts = locked(&self.texts).clone().into_iter().map(|(name, text)| Ok((name, text.into_bytes())));
        let names: Vec<String> = locked(&self.hashed).keys().cloned().collect();
        texts.chain(names.into_iter().map(|name| Ok((name.clone(), self.found(&name, LARGEST)?)))).collect()
    }
}

impl Files for Beside {
    fn read(&self, path: &str) -> Result<String, String> {
        if let Some((_, text)) = locked(&self.texts).iter().find(|(known, _)| known == path) {
            return Ok(text.clone());
        }
        let text = utf8(self.found(path, TEXT)?)?;
        locked(&self.texts).push((path.to_owned(), text.clone()));
        Ok(text)
    }

    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        let bytes = self.found(path, LARGEST)?;
        locked(&self.hashed).insert(path.to_owned(), wireloom::export::sha256(&bytes));
        Ok(bytes)
    }
}

/// A scenario as Python has it: a tuple.
#[derive(Clone, FromPyObject)]
pub struct Source {
    /// Its text.
    #[pyo3(item(0))]
    pub text: String,
    /// Its name in diagnostics.
    #[pyo3(item(1))]
    pub name: String,
    /// The folder of the files that it names.
    #[pyo3(item(2))]
    pub folder: Option<PathBuf>,
    /// Constraints and joint models written in Python.
    #[pyo3(item(3), from_py_with = parts::shared)]
    pub parts: Vec<Arc<Part>>,
}

/// A scenario that is ready to be carried out.
pub struct Loaded {
    pub scenario: Scenario,
    pub built: Built,
    pub registry: Registry,
    /// Names and texts: of the scenario, then of the files it names.
    pub texts: Vec<(String, String)>,
    /// Names and SHA-256 of other files.
    pub hashed: Vec<(String, String)>,
    /// The files that it names.
    pub files: Beside,
}

impl Source {
    /// A refusal of it.
    pub fn refused(&self, faults: Vec<Fault>) -> Failure {
        Failure::Refused { name: self.name.clone(), text: self.text.clone(), faults }
    }

    /// The files beside it.
    pub fn files(&self) -> Beside {
        Beside { folder: self.folder.clone(), ..Beside::default() }
    }

    /// Refuses a text that loads plugins.
    pub fn refuse_plugins(&self) -> Result<(), Failure> {
        let Some((name, span)) = wireloom::scenario::plugins(&self.text).load.into_iter().next() else {
            return Ok(());
        };
        let message = format!("the Python package does not load plugins yet, so \"{name}\" is not loaded");
        let help = "carry the scenario out with the command line: wireloom run".to_owned();
        Err(self.refused(vec![Fault { span, message, help }]))
    }

    /// Reads, checks and builds it.
    pub fn load(&self) -> Result<Loaded, Failure> {
        self.load_on(parts::registry(&self.parts)?, None)
    }

    /// The same with these kinds, and with the files that came with it.
    pub fn load_on(&self, registry: Registry, held: Option<Held>) -> Result<Loaded, Failure> {
        self.refuse_plugins()?;
        let files = Beside { held, ..self.files() };
        let (scenario, built) =
            wireloom::load_with_files(&self.text, &files, &registry).map_err(|faults| self.refused(faults))?;
        let name = Path::new(&self.name).file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut texts = vec![(name, self.text.clone())];
        texts.extend(locked(&files.texts).iter().cloned());
        let hashed = locked(&files.hashed).clone().into_iter().collect();
        Ok(Loaded { scenario, built, registry, texts, hashed, files })
    }

    /// The same, with the mesh that its accuracy asks for.
    pub fn load_with_mesh(&self, monitor: &Monitor) -> Result<Loaded, Failure> {
        let Loaded { scenario, built, registry, texts, hashed, files } = self.load()?;
        let (scenario, built) =
            wireloom::mesh::by_accuracy(scenario, built, &registry, monitor).map_err(|faults| self.refused(faults))?;
        Ok(Loaded { scenario, built, registry, texts, hashed, files })
    }
}

/// The text of a scenario's file.
#[pyfunction]
pub fn read(py: Python<'_>, path: PathBuf) -> PyResult<String> {
    guarded(py, || {
        let bytes = bytes(&path, TEXT).map_err(Failure::io("read", &path))?;
        String::from_utf8(bytes).map_err(|error| {
            let at = error.utf8_error().valid_up_to();
            let line = error.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count() + 1;
            let words = format!("{}:{line}: not UTF-8 text (byte {at})", path.display());
            Failure::Io(io::Error::new(io::ErrorKind::InvalidInput, words))
        })
    })
}

/// The faults of a scenario as a list of `Diagnostic`.
#[pyfunction]
pub fn check(py: Python<'_>, source: Source) -> PyResult<Vec<Bound<'_, PyAny>>> {
    let faults = guarded(py, || match source.load() {
        Ok(_) => Ok(Vec::new()),
        Err(Failure::Refused { faults, .. }) => Ok(faults),
        Err(failure) => Err(failure),
    })?;
    diagnostics(py, &source.name, &source.text, &faults)
}

/// The faults of a text that is not TOML, which has no keys.
fn of_key(source: &Source, fault: Fault) -> Failure {
    if fault.message.starts_with("this is not TOML") { source.refused(vec![fault]) } else { Failure::Key(fault) }
}

/// The value of a key, as JSON.
#[pyfunction]
pub fn value_at(py: Python<'_>, source: Source, key: &str) -> PyResult<String> {
    guarded(py, || {
        let value = record::value_at(&source.text, key).map_err(|fault| of_key(&source, fault))?;
        Ok(value.to_string())
    })
}

/// The text with another value of a key, which is JSON.
#[pyfunction]
pub fn with_value(py: Python<'_>, source: Source, key: &str, json: &str) -> PyResult<String> {
    let value = serde_json::from_str(json).map_err(|error| PyValueError::new_err(format!("not JSON: {error}")))?;
    guarded(py, || {
        let registry = parts::registry(&source.parts)?;
        record::with_json(&source.text, key, &value, &registry).map_err(|fault| of_key(&source, fault))
    })
}
