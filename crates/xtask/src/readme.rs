//! `cargo xtask readme`: updates the README with the current output of the program; `cargo xtask reality`: the page
//! where cables are held against measurements.

use crate::run::{command, root, step};

/// Runs the main command, keeps its picture, and runs the README's test in write mode.
pub fn readme() -> Result<(), String> {
    let main = ["run", "--quiet", "--release", "--", "run", "scenarios/first.toml"];
    step("the main command", &mut command("cargo", &main))?;
    std::fs::copy(root().join("out/first/picture.svg"), root().join("scenarios/first.svg"))
        .map_err(|error| format!("scenarios/first.svg cannot be written: {error}"))?;
    let write = ["test", "--quiet", "--package", "wireloom-tests", "--test", "readme"];
    step("its output into README.md", command("cargo", &write).env("WIRELOOM_README", "write"))
}

/// Runs the test that holds cables against measurements, in write mode.
pub fn reality() -> Result<(), String> {
    let write = ["test", "--quiet", "--package", "wireloom-tests", "--test", "measured"];
    step("scenarios/measured/reality.md", command("cargo", &write).env("WIRELOOM_REALITY", "write"))
}
