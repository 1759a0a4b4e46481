//! `cargo xtask peer`: the drag step of `wireloom bench` beside Exudyn, another program for flexible multibody systems.

use crate::run::{command, step, target};
use crate::tools;

/// Installs Exudyn into the target folder, builds the program, and measures both in one run.
pub fn peer() -> Result<(), String> {
    let python = tools::exudyn()?;
    let build = ["build", "--quiet", "--release", "--package", "wireloom-cli"];
    step("release build of the program", &mut command("cargo", &build))?;
    let program = target().join("release/wireloom").with_extension(std::env::consts::EXE_EXTENSION);
    step("the same drag in both programs", &mut command(&python, &["tests/peer/drag.py", &program.to_string_lossy()]))
}
