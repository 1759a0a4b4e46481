//! The FreeCAD workbench: its tests in FreeCAD, its types.

use crate::run::{command, root, step, target};
use crate::{package, tools};

/// Folder of the workbench.
const WORKBENCH: &str = "crates/freecad";

/// Packs the Python package, and tests the workbench alone.
pub fn freecad() -> Result<(), String> {
    let python = tools::python().ok_or("no Python to pack the package with")?;
    package::test(&python)?;
    test(&python)
}

/// Tests the workbench with the Python package that was packed last, in FreeCAD if that can be installed; `python`: the
/// one of [`tools::python`], in which the package is installed.
pub fn test(python: &str) -> Result<(), String> {
    let config = format!("{WORKBENCH}/pyproject.toml");
    let sources = format!("{WORKBENCH}/wireloom_freecad");
    step("types of the FreeCAD workbench", &mut command(python, &["-m", "mypy", "--config-file", &config, &sources]))?;
    let Some(system) = tools::freecad() else { return Ok(()) };
    let mut tests = command(system, &["-m", "pytest", "-q", "-ra", "-p", "no:cacheprovider", "tests"]);
    let program = target().join("debug/wireloom").with_extension(std::env::consts::EXE_EXTENSION);
    tests.current_dir(root().join(WORKBENCH)).env("WIRELOOM", program);
    tests.env("PYTHONPATH", package::stage()).env("PYTHONDONTWRITEBYTECODE", "1");
    step("tests of the FreeCAD workbench", &mut tests)
}
