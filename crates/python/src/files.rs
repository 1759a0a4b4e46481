//! The files of a run that its scenario's `[output]` asks for, written when they are asked for. What a file needs of
//! every increment is kept during the run.

use std::sync::Arc;
use wireloom::export::catalogue::FORMATS;
use wireloom::export::format::{Ended, Format, Increment, Surroundings};
use wireloom::export::json::Provenance;
use wireloom::geometry::Vector;
use wireloom::harness::{Obstacle, Surface};
use wireloom::result::Identities;
use wireloom::scenario::{Built, Output, Scenario};
use wireloom::session::{Checkpoint, Monitor, Progress};
use wireloom::shapes::swept::Envelope;
use wireloom::{Run, StepResult};

/// Name and version of the program, as the command line writes it into results.
pub const PROGRAM: &str = concat!("wireloom ", env!("CARGO_PKG_VERSION"));

/// What the files need of the scenario.
pub struct Recipe {
    output: Output,
    texts: Vec<(String, String)>,
    provenance: Provenance,
    surroundings: Surroundings,
    identities: Arc<Identities>,
    /// For each branch, its points in a state and the radius of each segment, m.
    branches: Vec<(std::ops::Range<usize>, Vec<f64>)>,
}

/// What they need of the increments.
#[derive(Default)]
pub struct Made {
    /// Files of single increments, by name.
    pub files: Vec<(String, Result<Vec<u8>, String>)>,
    times: Vec<f64>,
    /// Nodes of the branches at the start and after every increment, where the swept space is asked for.
    lines: Vec<Vec<Vec<Vector>>>,
    swept: Option<Surface>,
    /// What is to be said of them.
    pub remark: Option<String>,
}

impl Recipe {
    /// Of a scenario; `texts`: its own and those of the files it names; `hashed`: other files.
    pub fn of(scenario: &Scenario, built: &Built, texts: Vec<(String, String)>, hashed: &[(String, String)]) -> Self {
        let branches = built.network.branches.iter();
        Self {
            output: scenario.output,
            provenance: wireloom::export::provenance(PROGRAM, scenario, &texts, hashed, &[]),
            texts,
            surroundings: Surroundings::of_run(built.network.obstacles.clone(), &built.schedule),
            identities: built.schedule.identities.clone(),
            branches: branches.map(|branch| (branch.points.clone(), branch.radii())).collect(),
        }
    }

    /// The formats that are asked for, and those that are always written.
    pub fn asked(&self) -> impl Iterator<Item = &'static dyn Format> {
        FORMATS.iter().copied().filter(|format| format.key().is_none_or(|key| self.output.asks_for(key)))
    }

    /// The obstacles.
    pub fn obstacles(&self) -> &[Obstacle] {
        self.surroundings.obstacles()
    }

    /// What formats write of.
    pub fn ended<'a>(&'a self, run: &'a Run, made: &'a Made, machine: &'a str, written: &'a str) -> Ended<'a> {
        Ended {
            run,
            provenance: &self.provenance,
            texts: &self.texts,
            surroundings: &self.surroundings,
            times: &made.times,
            swept: made.swept.as_ref(),
            fields_apart: self.output.asks_for("fields"),
            program: PROGRAM,
            machine,
            written,
        }
    }
}

impl Made {
    /// Keeps what files need of the start.
    pub fn begin(&mut self, recipe: &Recipe, checkpoint: &Checkpoint) {
        if recipe.output.swept.is_some() && self.times.is_empty() && self.lines.is_empty() {
            let points = checkpoint.points();
            self.lines.push(recipe.branches.iter().map(|(range, _)| points[range.clone()].to_vec()).collect());
        }
    }

    /// Keeps what files need of an increment.
    pub fn see(&mut self, recipe: &Recipe, progress: &Progress, end: &StepResult) {
        let Recipe { surroundings, identities, .. } = recipe;
        let ended = Increment { number: self.times.len() + 1, end, surroundings, identities };
        for file in recipe.asked().flat_map(|format| format.at_increment(&ended)) {
            let (name, mut bytes) = (file.name.clone(), vec![]);
            let written = file.write(&mut bytes).map(|()| bytes).map_err(|error| error.to_string());
            self.files.push((name, written));
        }
        if recipe.output.swept.is_some() {
            self.lines.push(end.branches.iter().map(|branch| branch.position.clone()).collect());
        }
        self.times.push(progress.step_index as f64 + progress.increment as f64 / progress.increments as f64);
    }

    /// Computes the swept space, unless the run is to stop. Its cells are doubled until they fit into memory, as on the
    /// command line.
    pub fn finish(&mut self, recipe: &Recipe, monitor: &Monitor) {
        let Some(asked) = recipe.output.swept else { return };
        let mut cell = asked;
        let radii: Vec<Vec<f64>> = recipe.branches.iter().map(|(_, radii)| radii.clone()).collect();
        let lines = std::mem::take(&mut self.lines);
        'coarser: loop {
            let mut envelope = Envelope::new(cell, &radii);
            for state in &lines {
                if monitor.is_stopped() {
                    return;
                }
                if envelope.sweep(state).is_err() {
                    cell *= 2.0;
                    continue 'coarser;
                }
            }
            self.swept = Some(envelope.surface());
            if cell > asked {
                let (taken, asked) = (1e3 * cell, 1e3 * asked);
                self.remark = Some(format!(
                    "swept.glb has cells of {taken} mm: with {asked} mm it would have taken too much memory"
                ));
            }
            return;
        }
    }
}
