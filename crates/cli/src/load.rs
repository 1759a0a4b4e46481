//! From a file's name to a checked scenario.

use crate::failure::{Failure, Refusal};
use crate::plugins::{self, Trust};
use crate::results::PROGRAM;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use wireloom::core::Registry;
use wireloom::export::json::Provenance;
use wireloom::host::Plugin;
use wireloom::scenario::settings::{self, Setting};
use wireloom::scenario::{Built, Fault, Files, Scenario};

/// Reads a text file. What is no UTF-8 is refused, not an I/O fault.
pub fn text(path: &Path) -> Result<String, Failure> {
    let bytes = std::fs::read(path).map_err(Failure::io("read", path))?;
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count() + 1;
        Failure::Input(format!("{}:{line}: not UTF-8 text (byte {at})", path.display()))
    })
}

/// The files that a scenario names, relative to its folder; what was read is remembered.
pub struct Beside {
    folder: PathBuf,
    read: Mutex<Vec<(String, String)>>,
    /// Names and SHA-256 of files that are no texts.
    hashed: Mutex<BTreeMap<String, String>>,
}

impl Beside {
    /// Those of the scenario at `path`.
    pub fn of(path: &Path) -> Self {
        Self {
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            read: Mutex::default(),
            hashed: Mutex::default(),
        }
    }

    fn known(&self) -> MutexGuard<'_, Vec<(String, String)>> {
        // Nothing that holds it can panic half way.
        self.read.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Files for Beside {
    fn read(&self, path: &str) -> Result<String, String> {
        if let Some((_, text)) = self.known().iter().find(|(known, _)| known == path) {
            return Ok(text.clone());
        }
        let text = text(&self.folder.join(path)).map_err(|failure| match failure {
            Failure::Io { source, .. } => source.to_string(),
            other => other.to_string(),
        })?;
        self.known().push((path.to_owned(), text.clone()));
        Ok(text)
    }

    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        let bytes = std::fs::read(self.folder.join(path)).map_err(|error| error.to_string())?;
        let mut hashed = self.hashed.lock().unwrap_or_else(PoisonError::into_inner);
        hashed.insert(path.to_owned(), wireloom::sha256(&bytes));
        Ok(bytes)
    }
}

/// A scenario ready to be carried out.
pub struct Loaded {
    /// As it is written.
    pub scenario: Scenario,
    /// As it is carried out.
    pub built: Built,
    /// Names and texts: of the scenario, then of all files it names.
    pub texts: Vec<(String, String)>,
    /// Names and SHA-256 of the files it names that are no texts.
    pub hashed: Vec<(String, String)>,
    /// The plugins it uses.
    pub plugins: Vec<Plugin>,
    /// All kinds that it may name.
    pub registry: Registry,
    /// What was set beside it.
    pub settings: Vec<Setting>,
}

impl Loaded {
    /// What results of it say of their making.
    pub fn provenance(&self) -> Provenance {
        wireloom::provenance(PROGRAM, &self.scenario, &self.texts, &self.hashed, &self.settings)
    }
}

/// Reads, checks and builds a scenario, with the plugins it wants and the user trusts; `settings` take the place of what it says.
pub fn scenario(path: &Path, settings: &[Setting], trust: &Trust) -> Result<Loaded, Failure> {
    scenario_of(path, text(path)?, settings, trust)
}

/// The same of a text that takes the place of the one in the file.
pub fn scenario_of(path: &Path, text: String, settings: &[Setting], trust: &Trust) -> Result<Loaded, Failure> {
    let mut registry = trust.registry();
    let plugins = plugins::load(path, &text, trust, &mut registry)?;
    let files = Beside::of(path);
    match wireloom::load_with_settings(&text, settings, &files, &registry) {
        Ok((scenario, built)) => {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let mut texts = vec![(name, text)];
            texts.append(&mut files.known());
            let hashed = files.hashed.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().collect();
            Ok(Loaded { scenario, built, texts, hashed, plugins, registry, settings: settings.to_vec() })
        }
        Err(faults) => {
            let (own, set) = settings::apart(&text, faults);
            let mut refusals = vec![];
            if !own.is_empty() {
                refusals.push(refusal(path, text, own));
            }
            if !set.is_empty() {
                refusals.push(refusal(Path::new(COMMAND_LINE), settings::lines(settings), set));
            }
            Err(Failure::Refused(refusals))
        }
    }
}

/// What faults of settings name instead of a file.
const COMMAND_LINE: &str = "command line";

/// A refusal of the scenario in `path`.
pub fn refusal(path: &Path, text: String, faults: Vec<Fault>) -> Refusal {
    Refusal { file: path.display().to_string(), text, faults }
}
