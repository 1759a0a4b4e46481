//! The files of a run.
//!
//! | file | what | when |
//! | --- | --- | --- |
//! | `result.json` | the whole run | always |
//! | `picture.svg` | the last equilibrium | `picture` |
//! | `report.html` | the whole run on one page | `report` |
//! | `harness.glb` | harness and obstacles at the end of every step | `gltf` |
//! | `swept.glb` | the space that the harness goes through | `swept` |
//! | `csv/STEP/BRANCH.csv` | the branches at the end of every step | `csv` |
//! | `vtk/NNNN.vtp`, `harness.pvd` | every increment, and all of them as a series in time | `vtk` |
//! | `vtk/obstacles.vtp`, `vtk/obstacles-NNNN.vtp` | obstacles that stand still, and those that move, at every increment | `vtk` |

use crate::failure::Failure;
use crate::folder::Folder;
use wireloom::core::obstacle::{Obstacle, Surface};
use wireloom::core::{Run, StepResult};
use wireloom::export::json::Provenance;
use wireloom::export::names::file_name;
use wireloom::export::vtk::SeriesFile;
use wireloom::export::{csv, gltf, json, picture, report, vtk};
use wireloom::scenario::{Built, Output};
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
    surroundings: Surroundings,
    series: Vec<SeriesFile>,
}

/// The bodies about a harness.
pub struct Surroundings {
    obstacles: Vec<Obstacle>,
    /// Whether a step moves it, for each.
    moves: Vec<bool>,
}

impl Surroundings {
    /// Those of a scenario.
    pub fn of(built: &Built) -> Self {
        let obstacles = built.network.obstacles.clone();
        let moved = |k: usize| {
            built.schedule.steps.iter().flat_map(|step| &step.obstacle_moves).any(|motion| motion.obstacle == k)
        };
        Self { moves: (0..obstacles.len()).map(moved).collect(), obstacles }
    }

    /// Surfaces of those that move, or of the others, where they are in `end`; each with its index.
    fn surfaces(&self, end: &StepResult, moving: bool) -> Vec<(usize, Surface)> {
        let chosen = (0..self.obstacles.len()).filter(|k| self.moves[*k] == moving);
        let placed = |k: usize| {
            let pose = end.obstacles[k].pose;
            let mut surface = self.obstacles[k].shape.surface(DRAWN);
            surface.corners.iter_mut().for_each(|x| *x = pose.position + pose.orientation * *x);
            (k, surface)
        };
        chosen.map(placed).collect()
    }
}

/// How far a body without end is drawn, m.
const DRAWN: f64 = 10.0;
/// Obstacles that stand still.
const STANDING: &str = "vtk/obstacles.vtp";

impl Results {
    /// Into this folder; `texts`: those of the scenario; `series`: what was written before a run was interrupted.
    pub fn new(
        folder: Folder,
        output: Output,
        texts: Vec<(String, String)>,
        provenance: Provenance,
        surroundings: Surroundings,
        series: Vec<SeriesFile>,
    ) -> Self {
        Self { folder, output, texts, provenance, surroundings, series }
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
        let number = self.series.len() + 1;
        let file = format!("vtk/{number:04}.vtp");
        self.folder.write(&file, |out| vtk::write(end, out))?;
        let moving = self.surroundings.surfaces(end, true);
        if !moving.is_empty() {
            self.folder.write(&moving_file(number), |out| vtk::write_surfaces(&moving, out))?;
        }
        if number == 1 {
            let standing = self.surroundings.surfaces(end, false);
            if !standing.is_empty() {
                self.folder.write(STANDING, |out| vtk::write_surfaces(&standing, out))?;
            }
        }
        let time = progress.step_index as f64 + progress.increment as f64 / progress.increments as f64;
        self.series.push(SeriesFile { file, time });
        Ok(())
    }

    /// What is written when all is done.
    pub fn finish(&mut self, run: &Run) -> Result<(), Failure> {
        let provenance = &self.provenance;
        self.folder.write(RESULT, |out| json::write(run, provenance, out))?;
        if self.output.vtk {
            let series = self.with_obstacles();
            self.folder.write("harness.pvd", |out| vtk::write_series(&series, out))?;
        }
        if self.output.csv {
            self.tables(run)?;
        }
        if self.output.gltf && !run.steps.is_empty() {
            let (ends, obstacles) = (ends(run), &self.surroundings.obstacles);
            self.folder.write("harness.glb", |out| gltf::write(&ends, obstacles, out))?;
        }
        if let Some(end) = run.steps.last().filter(|_| self.output.picture) {
            let title = format!("{}: {}", run.scenario, end.name);
            self.folder.write("picture.svg", |out| picture::write(end, &self.surroundings.obstacles, &title, out))?;
        }
        if self.output.report {
            let report = report::Report {
                run,
                obstacles: &self.surroundings.obstacles,
                texts: &self.texts,
                program: PROGRAM,
                machine: &crate::bench::machine(),
                written: &humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string(),
            };
            self.folder.write("report.html", |out| report::write(&report, out))?;
        }
        Ok(())
    }

    /// The space that the harness went through; nothing where it never was anywhere.
    pub fn swept(&mut self, surface: &Surface) -> Result<(), Failure> {
        if surface.triangles.is_empty() {
            return Ok(());
        }
        self.folder.write("swept.glb", |out| gltf::write_surface("swept", surface, out))
    }

    /// The series with the obstacles at every time.
    fn with_obstacles(&self) -> Vec<SeriesFile> {
        let Surroundings { moves, .. } = &self.surroundings;
        let mut all = vec![];
        for (k, own) in self.series.iter().enumerate() {
            all.push(own.clone());
            let beside = |file: String| SeriesFile { file, time: own.time };
            all.extend(moves.contains(&false).then(|| beside(STANDING.to_owned())));
            all.extend(moves.contains(&true).then(|| beside(moving_file(k + 1))));
        }
        all
    }

    fn tables(&mut self, run: &Run) -> Result<(), Failure> {
        let mut steps = vec![];
        for end in ends(run) {
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
        let (below, names): (Vec<&str>, Vec<&str>) = self.folder.names().partition(|name| name.contains('/'));
        let more = match below.len() {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        format!("{}: {}{more}", self.folder.path().display(), names.join(", "))
    }
}

/// Makes sure that the files of a series still are what was written, before more are added to it.
pub fn check(folder: &Folder, series: &[SeriesFile]) -> Result<(), Failure> {
    for (k, own) in series.iter().enumerate() {
        folder.check(&own.file)?;
        let moving = moving_file(k + 1);
        if folder.names().any(|name| name == moving) {
            folder.check(&moving)?;
        }
    }
    if folder.names().any(|name| name == STANDING) { folder.check(STANDING) } else { Ok(()) }
}

/// The last increment of every step.
fn ends(run: &Run) -> Vec<&StepResult> {
    let goes_on = |k: usize, end: &StepResult| {
        run.steps.get(k + 1).is_some_and(|next| next.name == end.name && next.increment > end.increment)
    };
    run.steps.iter().enumerate().filter(|(k, end)| !goes_on(*k, end)).map(|(_, end)| end).collect()
}

/// Obstacles that move, at an increment.
fn moving_file(number: usize) -> String {
    format!("vtk/obstacles-{number:04}.vtp")
}
