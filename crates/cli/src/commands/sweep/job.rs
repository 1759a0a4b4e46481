//! A sweep before it begins: its scenario, and everything that its points depend on.

use crate::arguments::Allowed;
use crate::failure::Failure;
use crate::files::load::{self, Beside, Loaded};
use crate::plugin::load::record;
use crate::plugin::trust::Trust;
use crate::program::PROGRAM;
use crate::size;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use wireloom::result::{Library, Measure};
use wireloom::scenario::Setting;
use wireloom::sweep::tubes::Stations;
use wireloom::sweep::{Points, Sweep, header};
use wireloom_dataset::{Dataset, Manifest};

/// Version of the files of an interrupted sweep; changes with their meaning.
const FORMAT: u32 = 10;

/// Origin of a sweep.
#[derive(PartialEq, Serialize, Deserialize)]
pub struct Origin {
    format: u32,
    program: String,
    minimiser: Option<String>,
    texts: Vec<(String, String)>,
    /// Names and SHA-256 of files that are no texts.
    hashed: Vec<(String, String)>,
    /// The plugins that take part.
    pub plugins: Vec<Library>,
}

impl Origin {
    /// SHA-256 of all of it.
    pub fn hash(&self) -> String {
        // Texts and numbers are always valid JSON.
        wireloom::export::sha256(&serde_json::to_vec(self).unwrap_or_default())
    }
}

/// A sweep that is ready to begin.
pub struct Job {
    /// File of the scenario.
    pub file: PathBuf,
    pub loaded: Loaded,
    pub origin: Origin,
    trust: Trust,
    beside: Beside,
}

impl Job {
    /// Reads the scenario.
    pub fn read(file: &Path, minimiser: Option<&str>, allowed: &Allowed) -> Result<Self, Failure> {
        let trust = Trust::to_run(allowed).for_batches();
        let settings: Vec<Setting> = minimiser.map(Setting::minimiser).into_iter().collect();
        let loaded = load::scenario(file, &settings, &trust)?;
        size::estimate(&loaded.built.network, 1)?;
        if loaded.scenario.sweep.is_none() {
            let help = "add one, such as\n[sweep.vary]\n\
                        \"branches.NAME.length\" = { from = \"400 mm\", to = \"500 mm\", count = 11 }";
            return Err(Failure::Input(format!("{} has no [sweep]: {help}", file.display())));
        }
        let origin = Origin {
            format: FORMAT,
            program: PROGRAM.to_owned(),
            minimiser: minimiser.map(str::to_owned),
            texts: loaded.texts.clone(),
            hashed: loaded.hashed.clone(),
            plugins: loaded.plugins.iter().map(record).collect(),
        };
        Ok(Self { file: file.to_owned(), loaded, origin, trust, beside: Beside::of(file) })
    }

    /// The sweep.
    pub fn sweep(&self) -> &Sweep {
        self.loaded.scenario.sweep.as_ref().expect("a scenario without one is refused")
    }

    /// Its points.
    pub fn points(&self) -> Points<'_> {
        Points {
            text: &self.loaded.texts[0].1,
            files: &self.beside,
            minimiser: self.origin.minimiser.as_deref(),
            registry: &self.loaded.registry,
            batch: (self.loaded.scenario.minimiser.kind == "gpu").then(|| self.trust.batch()),
            sweep: self.sweep(),
            header: header(self.sweep(), &self.loaded.built.network),
            stations: Stations::of(&self.loaded.built.network, &self.loaded.built.schedule),
        }
    }

    /// Whether native code of plugins takes part: its points are computed in other processes.
    pub fn has_plugins(&self) -> bool {
        !self.loaded.plugins.is_empty()
    }

    /// Metadata of the table of its points, which have these requirements.
    pub fn notes(&self, points: &Points<'_>, requirements: &[(String, Measure)]) -> Vec<(String, String)> {
        let file = self.file.file_name().unwrap_or_default().to_string_lossy();
        let mut notes = points.notes(PROGRAM, &self.loaded.scenario.name, &file, requirements);
        let plugins: Vec<String> = self.origin.plugins.iter().map(ToString::to_string).collect();
        for (key, lines) in [("wireloom.plugins", plugins), ("wireloom.notes", wireloom::plugins::notes())] {
            if !lines.is_empty() {
                notes.push((key.to_owned(), lines.join("\n")));
            }
        }
        notes
    }

    /// Its dataset at a place, with some columns or all.
    pub fn dataset(&self, points: &Points<'_>, place: &str, columns: Option<&[String]>) -> Result<Dataset, Failure> {
        let Origin { program, minimiser, texts, hashed, plugins, .. } = &self.origin;
        let notes = self.notes(points, &[]);
        let minimiser = minimiser.as_deref();
        let origin = wireloom_dataset::Origin { program, minimiser, texts, hashed, plugins, notes };
        let (scenario, network) = (&self.loaded.scenario.name, &self.loaded.built.network);
        let manifest = Manifest::of(origin, scenario, points, network, columns).map_err(Failure::Dataset)?;
        Dataset::begin(place, manifest).map_err(Failure::Dataset)
    }
}
