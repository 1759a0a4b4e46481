//! The files of a run.
//!
//! | file | what | when |
//! | --- | --- | --- |
//! | `result.json` | the whole run | always |
//! | `picture.svg` | the last equilibrium | `picture` |
//! | `report.html` | the whole run on one page | `report` |
//! | `csv/STEP/BRANCH.csv` | the branches at the end of every step | `csv` |
//! | `vtk/NNNN.vtp`, `harness.pvd` | every increment, and all of them as a series in time | `vtk` |

use crate::failure::Failure;
use crate::folder::{Folder, file_name};
use wireloom::core::{Run, StepResult};
use wireloom::export::json::Provenance;
use wireloom::export::vtk::SeriesFile;
use wireloom::export::{csv, json, picture, report, vtk};
use wireloom::scenario::Output;
use wireloom::solve::Progress;

/// Where the whole run is.
pub const RESULT: &str = "result.json";

/// Name and version of this program.
pub const PROGRAM: &str = concat!("wireloom ", env!("CARGO_PKG_VERSION"));

/// Writes what a scenario's `[output]` asks for.
pub struct Results {
    folder: Folder,
    output: Output,
    texts: Vec<(String, String)>,
    provenance: Provenance,
    series: Vec<SeriesFile>,
}

impl Results {
    /// Into this folder; `texts`: those of the scenario; `series`: what was written before a run was interrupted.
    pub fn new(
        folder: Folder,
        output: Output,
        texts: Vec<(String, String)>,
        provenance: Provenance,
        series: Vec<SeriesFile>,
    ) -> Self {
        Self { folder, output, texts, provenance, series }
    }

    /// The VTK files so far.
    pub fn series(&self) -> &[SeriesFile] {
        &self.series
    }

    /// What is written as soon as an increment has ended, so that it is there whatever comes.
    pub fn increment(&mut self, progress: &Progress, end: &StepResult) -> Result<(), Failure> {
        if !self.output.vtk {
            return Ok(());
        }
        let file = format!("vtk/{:04}.vtp", self.series.len() + 1);
        self.folder.write(&file, |out| vtk::write(end, out))?;
        let time = progress.step_index as f64 + progress.increment as f64 / progress.increments as f64;
        self.series.push(SeriesFile { file, time });
        Ok(())
    }

    /// What is written when all is done.
    pub fn finish(&mut self, run: &Run) -> Result<(), Failure> {
        let provenance = &self.provenance;
        self.folder.write(RESULT, |out| json::write(run, provenance, out))?;
        if self.output.vtk {
            self.folder.write("harness.pvd", |out| vtk::write_series(&self.series, out))?;
        }
        if self.output.csv {
            self.tables(run)?;
        }
        if let Some(end) = run.steps.last().filter(|_| self.output.picture) {
            let title = format!("{}: {}", run.scenario, end.name);
            self.folder.write("picture.svg", |out| picture::write(end, &title, out))?;
        }
        if self.output.report {
            let report = report::Report {
                run,
                texts: &self.texts,
                program: PROGRAM,
                machine: &crate::bench::machine(),
                written: &humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string(),
            };
            self.folder.write("report.html", |out| report::write(&report, out))?;
        }
        Ok(())
    }

    fn tables(&mut self, run: &Run) -> Result<(), Failure> {
        let mut steps = vec![];
        for (k, end) in run.steps.iter().enumerate() {
            if run.steps.get(k + 1).is_some_and(|next| next.name == end.name && next.increment > end.increment) {
                continue;
            }
            let step = file_name(&format!("{}-{}", steps.len() + 1, end.name), &mut steps);
            let mut branches = vec![];
            for branch in &end.branches {
                let name = file_name(&branch.name, &mut branches);
                self.folder.write(&format!("csv/{step}/{name}.csv"), |out| csv::write(branch, out))?;
            }
        }
        Ok(())
    }

    /// `out/first: result.json, picture.svg`, with no more than a few names.
    pub fn words(&self) -> String {
        let (below, top): (Vec<&String>, Vec<&String>) =
            self.folder.written.iter().partition(|name| name.contains('/'));
        let mut names: Vec<&str> = top.into_iter().map(String::as_str).collect();
        let more = match below.len() {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        names.sort_unstable();
        format!("{}: {}{more}", self.folder.path().display(), names.join(", "))
    }
}
