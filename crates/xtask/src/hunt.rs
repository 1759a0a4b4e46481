//! `cargo xtask hunt`: random search for wrong answers. It is in `tests/src/hunt`, with the whole-program tests,
//! because it uses what they use.

use crate::run::{command, step, target};

/// Builds the search as the tests are built, and runs it.
pub fn hunt(options: &[&str]) -> Result<(), String> {
    let build = ["build", "--quiet", "--workspace", "--bin", "hunt"];
    step("build the random search as the tests are built", &mut command("cargo", &build))?;
    let program = target().join("debug/hunt");
    step("random search", &mut command(&program.to_string_lossy(), options))
}
