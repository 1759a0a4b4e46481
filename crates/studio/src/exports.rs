//! Exported files of a session, in the formats of `run`.
//!
//! | name | what |
//! | --- | --- |
//! | `result.json` | the run so far |
//! | `report.html`
//! the report, on one page |
//! | `picture.svg`
//! picture of the current shape |
//! | `harness.vtp`, `obstacles.vtp`
//! harness and obstacles for ParaView |
//! | `csv/BRANCH.csv`
//! table of each branch |

use crate::protocol::Scene;
use wireloom::core::equilibrium::{ObstacleResult, Run, StepResult};
use wireloom::core::obstacle::{Obstacle, Surface};
use wireloom::export::json::Provenance;
use wireloom::export::names::file_name;
use wireloom::export::report::Report;
use wireloom::export::{csv, json, picture, report, vtk};

/// Names of all files for a scene.
pub fn names(scene: &Scene) -> Vec<String> {
    let mut names =
        vec!["result.json".to_owned(), "report.html".to_owned(), "picture.svg".to_owned(), "harness.vtp".to_owned()];
    names.extend((!scene.obstacles.is_empty()).then(|| "obstacles.vtp".to_owned()));
    names.extend(tables(scene.branches.iter().map(|branch| branch.name.as_str())));
    names
}

/// Names of the tables of branches.
fn tables<'a>(branches: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut taken = vec![];
    branches.map(|branch| format!("csv/{}.csv", file_name(branch, &mut taken))).collect()
}

/// Information that files state about their origin.
pub struct ExportInfo<'a> {
    /// Origin of the data.
    pub provenance: &'a Provenance,
    /// Names and texts of the scenario and of the files it names.
    pub texts: &'a [(String, String)],
    /// Program and version.
    pub program: &'a str,
    /// Name of the machine.
    pub machine: &'a str,
    /// Date and time.
    pub written: &'a str,
}

/// The file of this name; `None` if it does not exist, or if there is no result yet.
pub fn make(run: &Run, obstacles: &[Obstacle], name: &str, info: &ExportInfo<'_>) -> Option<Vec<u8>> {
    let end = run.steps.last()?;
    let mut bytes = Vec::new();
    let written = match name {
        "result.json" => json::write(run, info.provenance, &mut bytes),
        "report.html" => {
            let ExportInfo { texts, program, machine, written, .. } = *info;
            report::write(&Report { run, obstacles, texts, program, machine, written }, &mut bytes)
        }
        "picture.svg" => picture::write(end, obstacles, &format!("{}: {}", run.scenario, end.name), &mut bytes),
        "harness.vtp" => vtk::write(end, &mut bytes),
        "obstacles.vtp" => vtk::write_surfaces(&surfaces(obstacles, end), &mut bytes),
        table => {
            let names = tables(end.branches.iter().map(|branch| branch.name.as_str()));
            let branch = names.iter().position(|name| name == table)?;
            csv::write(&end.branches[branch], &mut bytes)
        }
    };
    written.ok().map(|()| bytes)
}

/// Surfaces of the obstacles at their current poses.
fn surfaces(obstacles: &[Obstacle], end: &StepResult) -> Vec<(usize, Surface)> {
    let placed = |(k, (body, result)): (usize, (&Obstacle, &ObstacleResult))| {
        let mut surface = body.shape.surface(crate::scene::DRAWN);
        surface.corners.iter_mut().for_each(|x| *x = result.pose.position + result.pose.orientation * *x);
        (k, surface)
    };
    obstacles.iter().zip(&end.obstacles).enumerate().map(placed).collect()
}
