//! Pages that play a run, and their scene.

use crate::failure::Failure;
use crate::files::folder;
use crate::files::own::Own;
use crate::program::PROGRAM;
use std::io::Write;
use std::path::Path;
use wireloom::scenario::Built;
use wireloom_studio::protocol::Scene;
use wireloom_studio::replay::Replay;
use wireloom_studio::{PAGE, scene};

/// Scene of a page: harness and obstacles; in the program's own folder beside the result.
pub const SCENE: &str = "scene";

/// Keeps the scene beside the result, for `wireloom studio DIR`.
pub fn keep_scene(own: &Own, built: &Built) -> Result<Scene, Failure> {
    let schedule = &built.schedule;
    let scene = scene::of(schedule, PROGRAM, &built.network);
    let bytes = serde_json::to_vec(&scene).map_err(|error| Failure::io("write", &own.path(SCENE))(error.into()))?;
    own.keep(SCENE, &bytes, false)?;
    Ok(scene)
}

/// Writes a page that plays a run.
pub fn write_page(path: &Path, replay: &Replay) -> Result<(), Failure> {
    let page = replay.page(PAGE);
    folder::write(path, |out| out.write_all(page.as_bytes()))
}
