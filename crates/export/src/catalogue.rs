//! All output formats of a run. A new format is a file with its writer and a [`Format`], an entry here, and its key
//! in the table `OUTPUT` of `wireloom-scenario`; a test of the command line holds both lists equal.
//!
//! | key in `[output]` | files | content |
//! | --- | --- | --- |
//! | (always) | `result.json` | the whole run |
//! | `fields` | `fields.arrow` | fields of all nodes, which `result.json` is then without |
//! | `report` | `report.html` | the whole run on one page |
//! | `picture` | `picture.svg` | the last equilibrium |
//! | `vtk` | `vtk/NNNN.vtp`, `harness.pvd` | every increment, and all of them as a series in time |
//! | `vtk` | `vtk/obstacles.vtp` | obstacles that stand still |
//! | `vtk` | `vtk/obstacles-NNNN.vtp` | obstacles that move, at every increment |
//! | `csv` | `csv/STEP/BRANCH.csv` | the branches at the end of every step |
//! | `csv` | `csv/STEP-joints.csv` | the arms that slip on their hub, at the end of every step |
//! | `csv` | `requirements.csv` | the sheet of requirements |
//! | `csv` | `parts.csv`, `connections.csv` | part numbers and connections, where the scenario has any |
//! | `gltf` | `harness.glb` | harness and obstacles at the end of every step |
//! | `swept` | `swept.glb` | the space that the harness goes through |
//!
//! A session of the studio offers the equilibrium at hand in some of them: `result.json`, `report.html`,
//! `picture.svg`, `harness.vtp`, `obstacles.vtp` and `csv/BRANCH.csv`.

use crate::format::{Ended, File, Format};
use crate::{csv, gltf, json, picture, report, vtk};

/// All formats, in the order in which they are written.
pub const FORMATS: &[&dyn Format] = &[
    #[cfg(feature = "arrow")]
    &crate::fields::Fields,
    &json::Json,
    &report::Html,
    &picture::Picture,
    &vtk::Vtk,
    &csv::Csv,
    &gltf::Gltf,
    &gltf::Swept,
];

/// Media type of files of an unknown format.
const BYTES: &str = "application/octet-stream";

/// Media type of a file, by the end of its name.
pub fn media_type(name: &str) -> &'static str {
    let extension = |name: &str| name.rsplit_once('.').map(|(_, extension)| extension.to_owned());
    let is_one = |format: &&&dyn Format| format.files().iter().any(|file| extension(file) == extension(name));
    FORMATS.iter().find(is_one).map_or(BYTES, |format| format.media_type())
}

/// Folders below that of the results that formats write to.
pub fn folders() -> Vec<&'static str> {
    let files = FORMATS.iter().flat_map(|format| format.files());
    let mut folders: Vec<&str> = files.filter_map(|file| file.split_once('/')).map(|(folder, _)| folder).collect();
    folders.sort_unstable();
    folders.dedup();
    folders
}

/// Names of the files that a session offers of a harness with these branches; `obstacles`: whether there are any.
pub fn offered(branches: &[&str], obstacles: bool) -> Vec<String> {
    FORMATS.iter().flat_map(|format| format.offered(branches, obstacles)).collect()
}

/// A file that a session offers; `None` where there is none of this name, or no equilibrium yet.
pub fn at_hand<'a>(ended: &'a Ended<'a>, name: &str) -> Option<File<'a>> {
    ended.run.steps.last()?;
    FORMATS.iter().flat_map(|format| format.at_hand(ended)).find(|file| file.name == name)
}
