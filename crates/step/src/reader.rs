//! Reads STEP files, each once.

use crate::assembly::Assembly;
use crate::cache::{self, Cache};
use crate::error::StepError;
use crate::message::{Message, decode};
use crate::process::{Process, SCRIPT};
use crate::text;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use wireloom_core::Monitor;

/// Environment variable with the interpreter of Python.
pub const PYTHON: &str = "WIRELOOM_PYTHON";
/// Its default.
const PYTHON_3: &str = "python3";
/// Default of the time limit, s.
const SECONDS: u64 = 600;

/// A reader of STEP files.
pub struct Reader {
    python: String,
    seconds: u64,
    monitor: Monitor,
    cache: Option<Cache>,
    known: Mutex<Known>,
}

/// What this process has asked before: a sweep builds its scenario thousands of times.
#[derive(Default)]
struct Known {
    version: Option<String>,
    read: HashMap<String, Arc<Assembly>>,
}

impl Reader {
    /// The interpreter that `WIRELOOM_PYTHON` names, or `python3`; the cache that `WIRELOOM_CACHE` names, or
    /// `~/.wireloom/cache`. The monitor ends the other process.
    pub fn from_environment(monitor: Monitor) -> Self {
        let python = std::env::var(PYTHON).ok().filter(|python| !python.is_empty());
        let python = python.unwrap_or_else(|| PYTHON_3.to_owned());
        Self { python, seconds: SECONDS, monitor, cache: Cache::from_environment(), known: Mutex::default() }
    }

    /// With another time limit, s.
    pub fn with_time_limit(self, seconds: u64) -> Self {
        Self { seconds, ..self }
    }

    /// With another folder for the cache.
    pub fn with_cache(self, folder: PathBuf) -> Self {
        Self { cache: Some(Cache(folder)), ..self }
    }

    /// The folder of the cache; `None`: there is no home to keep it in.
    pub fn cache(&self) -> Option<&Path> {
        self.cache.as_ref().map(Cache::folder)
    }

    /// Reads a STEP file; `deflection`: largest distance of the triangles from the surfaces, m.
    ///
    /// # Errors
    /// If it is not a whole STEP file with units, if Python or Open CASCADE is missing, fails or takes too long, or if
    /// the cache cannot be used.
    pub fn read(&self, bytes: &[u8], deflection: f64) -> Result<Arc<Assembly>, StepError> {
        if !(deflection > 0.0 && deflection.is_finite()) {
            return Err(StepError::Deflection { value: deflection * 1e3 });
        }
        text::check(bytes)?;
        let process = Process { python: &self.python, seconds: self.seconds, monitor: &self.monitor };
        // One process at a time. Nothing panics while it holds this.
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let version = match &known.version {
            Some(version) => version.clone(),
            None => known.version.insert(process.version()?).clone(),
        };
        let key = cache::key(&[SCRIPT, &version], deflection, bytes);
        if let Some(assembly) = known.read.get(&key) {
            return Ok(assembly.clone());
        }
        let kept = self.cache.as_ref().map(|cache| cache.get(&key)).transpose()?.flatten();
        let message = match kept.as_deref().and_then(decode) {
            Some(message) => message,
            None => {
                let written = process.read(bytes, deflection)?;
                let broken = || StepError::Crashed { how: "what it wrote is damaged".into(), said: String::new() };
                let message = decode(&written).ok_or_else(broken)?;
                if let Some(cache) = &self.cache {
                    cache.put(&key, &written)?;
                }
                message
            }
        };
        let assembly = match message {
            Message::Read(assembly) => assembly,
            Message::Refused(why) if why == "syntax" => {
                return Err(StepError::Faulty { line: None, said: "Open CASCADE cannot read it".into() });
            }
            Message::Refused(_) => return Err(StepError::NoSolids),
        };
        if assembly.units.is_empty() || assembly.units.iter().any(String::is_empty) {
            return Err(StepError::NoUnit { line: text::line_of_units(bytes) });
        }
        let assembly = Arc::new(assembly);
        known.read.insert(key, assembly.clone());
        Ok(assembly)
    }
}
