//! `cargo xtask hunt`: the standing hunt for wrong answers. It lives with the whole-program tests (`tests/src/hunt`), for it sees what they see.

use crate::run::{command, step, target};

/// Builds the hunt as the tests are built, and goes hunting.
pub fn hunt(options: &[&str]) -> Result<(), String> {
    let build = ["build", "--quiet", "--workspace", "--bin", "hunt"];
    step("the hunt is built with what the tests are built with", &mut command("cargo", &build))?;
    let program = target().join("debug/hunt");
    step("hunting", &mut command(&program.to_string_lossy(), options))
}
