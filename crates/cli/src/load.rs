//! From a file's name to a checked scenario.

use crate::failure::{Failure, Refusal};
use std::cell::RefCell;
use std::path::Path;
use wireloom::core::Registry;
use wireloom::core::registry::Parameters;
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
struct Beside<'a> {
    folder: &'a Path,
    read: RefCell<Vec<(String, String)>>,
}

impl Files for Beside<'_> {
    fn read(&self, path: &str) -> Result<String, String> {
        let text = text(&self.folder.join(path)).map_err(|failure| match failure {
            Failure::Io { source, .. } => source.to_string(),
            other => other.to_string(),
        })?;
        self.read.borrow_mut().push((path.to_owned(), text.clone()));
        Ok(text)
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
}

/// Reads, checks and builds a scenario; `minimiser` replaces its own.
pub fn scenario(path: &Path, minimiser: Option<&str>, registry: &Registry) -> Result<Loaded, Failure> {
    let text = text(path)?;
    let files = Beside { folder: path.parent().unwrap_or(Path::new("")), read: RefCell::default() };
    let loaded = match minimiser {
        None => wireloom::load_with_files(&text, &files, registry),
        Some(kind) => {
            let parameters = parameters(kind, registry)?;
            wireloom::scenario::parse_with_files(&text, &files, registry)
                .and_then(|scenario| replace(scenario, kind, parameters, registry))
        }
    };
    match loaded {
        Ok((scenario, built)) => {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let mut texts = vec![(name, text)];
            texts.append(&mut files.read.into_inner());
            Ok(Loaded { scenario, built, texts })
        }
        Err(faults) => Err(Failure::Refused(vec![refusal(path, text, faults)])),
    }
}

/// A refusal of the scenario in `path`.
pub fn refusal(path: &Path, text: String, faults: Vec<Fault>) -> Refusal {
    Refusal { file: path.display().to_string(), text, faults }
}

fn replace(
    mut scenario: Scenario,
    kind: &str,
    parameters: Parameters,
    registry: &Registry,
) -> Result<(Scenario, Built), Vec<Fault>> {
    if scenario.minimiser.kind != kind {
        scenario.minimiser.kind = kind.to_owned();
        scenario.minimiser.parameters = parameters;
    }
    let built = scenario.build(registry)?;
    Ok((scenario, built))
}

/// The parameters of a minimiser about which the scenario says nothing.
fn parameters(kind: &str, registry: &Registry) -> Result<Parameters, Failure> {
    let Some(found) = registry.minimiser(kind) else {
        let known: Vec<&str> = registry.minimisers().map(|kind| kind.name.as_str()).collect();
        return Err(Failure::Input(format!("unknown minimiser `{kind}`; known: {}", known.join(", "))));
    };
    if let Some(missing) = found.parameters.iter().find(|parameter| parameter.required) {
        let name = &missing.name;
        return Err(Failure::Input(format!("minimiser `{kind}` needs `{name}`: choose it in the scenario instead")));
    }
    let defaults = found.parameters.iter().filter_map(|p| Some((p.name.clone(), p.default.clone()?)));
    Ok(Parameters(defaults.collect()))
}
