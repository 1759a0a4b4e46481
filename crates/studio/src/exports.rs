//! Exported files of a session, in the formats of `run`.

use crate::protocol::Scene;
use wireloom::Run;
use wireloom::export::catalogue;
use wireloom::export::format::{Ended, Surroundings};
use wireloom::export::json::Provenance;
use wireloom::harness::Obstacle;

/// Names of the files for a scene.
pub fn names(scene: &Scene) -> Vec<String> {
    let branches: Vec<&str> = scene.branches.iter().map(|branch| branch.name.as_str()).collect();
    catalogue::offered(&branches, !scene.obstacles.is_empty())
}

/// Origin of a result, as its files state it.
pub struct ExportInfo<'a> {
    /// Origin of the run.
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

/// The file of this name; `None` where there is none, or no equilibrium yet.
pub fn make(run: &Run, obstacles: &[Obstacle], name: &str, made: &ExportInfo<'_>) -> Option<Vec<u8>> {
    let ExportInfo { provenance, texts, program, machine, written } = *made;
    let surroundings = Surroundings::new(obstacles.to_vec(), |_| false);
    let ended = Ended {
        run,
        provenance,
        texts,
        surroundings: &surroundings,
        times: &[],
        swept: None,
        fields_apart: false,
        program,
        machine,
        written,
    };
    let mut bytes = Vec::new();
    let file = catalogue::at_hand(&ended, name)?;
    file.write(&mut bytes).ok().map(|()| bytes)
}
