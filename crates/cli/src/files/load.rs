//! From the path of a file to a checked scenario.

use crate::failure::{Failure, Refusal};
use crate::interrupt;
use crate::plugin::load::load as load_plugins;
use crate::plugin::trust::Trust;
use crate::print::progress::Bar;
use crate::program::PROGRAM;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use wireloom::Registry;
use wireloom::export::json::Provenance;
use wireloom::plugins::{Plugin, open_regular_file};
use wireloom::scenario::settings::Setting;
use wireloom::scenario::{Built, Fault, Files, Scenario, settings};

/// Largest text that is read, bytes: thirty times the harness of a whole car as KBL.
const TEXT: u64 = 64 << 20;
/// Largest file of another kind that is read as a whole, bytes: a mesh of ten million triangles has half of it.
const LARGEST: u64 = 1 << 30;

/// Reads a text file. Text that is not UTF-8 is refused input, not an I/O fault.
pub fn text(path: &Path) -> Result<String, Failure> {
    utf8(read(path, TEXT).map_err(refused(path))?, path)
}

/// Reads a file of bytes.
pub fn bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    read(path, LARGEST).map_err(refused(path))
}

/// Opens a plain file of any size, to read it piece by piece.
pub fn open(path: &Path) -> Result<File, Failure> {
    open_regular_file(path, u64::MAX).map_err(refused(path))
}

fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = vec![];
    // It may grow while it is read.
    open_regular_file(path, most)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn utf8(bytes: Vec<u8>, path: &Path) -> Result<String, Failure> {
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count() + 1;
        Failure::Input(format!("{}:{line}: not UTF-8 text (byte {at})", path.display()))
    })
}

/// A file of an unsuitable kind or size is refused input; the rest are I/O faults.
fn refused(path: &Path) -> impl FnOnce(io::Error) -> Failure {
    move |error| match error.kind() {
        io::ErrorKind::InvalidInput => Failure::Input(format!("cannot read {}: {error}", path.display())),
        _ => Failure::io("read", path)(error),
    }
}

/// The files that a scenario names, relative to its folder; files that were read are kept.
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
        // Nothing panics while it holds this.
        self.read.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Files for Beside {
    fn read(&self, path: &str) -> Result<String, String> {
        if let Some((_, text)) = self.known().iter().find(|(known, _)| known == path) {
            return Ok(text.clone());
        }
        let file = self.folder.join(path);
        let bytes = read(&file, TEXT).map_err(|error| error.to_string())?;
        let text = utf8(bytes, &file).map_err(|failure| failure.to_string())?;
        self.known().push((path.to_owned(), text.clone()));
        Ok(text)
    }

    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        let bytes = read(&self.folder.join(path), LARGEST).map_err(|error| error.to_string())?;
        let mut hashed = self.hashed.lock().unwrap_or_else(PoisonError::into_inner);
        hashed.insert(path.to_owned(), wireloom::export::sha256(&bytes));
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
    /// Settings on the command line.
    pub settings: Vec<Setting>,
}

impl Loaded {
    /// With the mesh that its accuracy asks for, which trial runs find, as `bar` says; see [`wireloom::mesh`]. A signal
    /// to stop ends them, and then the run that follows, at its beginning.
    pub fn with_mesh(self, bar: &Bar) -> Result<Self, Failure> {
        interrupt::listen();
        let Self { scenario, built, registry, .. } = self;
        if scenario.accuracy.is_some() {
            bar.say("finding the mesh");
        }
        let meshed = wireloom::mesh::by_accuracy(scenario, built, &registry, interrupt::monitor());
        let (scenario, built) = meshed.map_err(|faults| {
            let (name, text) = self.texts[0].clone();
            Failure::Refused(vec![refusal(Path::new(&name), text, faults)])
        })?;
        Ok(Self { scenario, built, registry, ..self })
    }

    /// Provenance of its results.
    pub fn provenance(&self) -> Provenance {
        wireloom::export::provenance(PROGRAM, &self.scenario, &self.texts, &self.hashed, &self.settings)
    }
}

/// Reads, checks and builds a scenario, with the plugins that it names and the user trusts; `settings` replace values
/// of the file.
pub fn scenario(path: &Path, settings: &[Setting], trust: &Trust) -> Result<Loaded, Failure> {
    scenario_of(path, text(path)?, settings, trust)
}

/// The same for a text in place of the file's.
pub fn scenario_of(path: &Path, text: String, settings: &[Setting], trust: &Trust) -> Result<Loaded, Failure> {
    let mut registry = trust.registry();
    let plugins = load_plugins(path, &text, trust, &mut registry)?;
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

/// File name in faults of settings.
const COMMAND_LINE: &str = "command line";

/// A refusal of the scenario in `path`.
pub fn refusal(path: &Path, text: String, faults: Vec<Fault>) -> Refusal {
    Refusal { file: path.display().to_string(), text, faults }
}
