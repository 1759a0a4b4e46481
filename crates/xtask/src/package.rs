//! The Python package: its wheel, its tests, its types.

use crate::run::{as_tested, command, root, step, target};
use crate::tools;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::fs;
use std::path::{Path, PathBuf};

/// Folder of the package's sources.
const PACKAGE: &str = "crates/python";

/// Packs and tests the package alone.
pub fn package() -> Result<(), String> {
    let python = tools::python().ok_or("no Python to install the package into")?;
    test(&python)
}

/// Packs the package, installs it into the virtual environment of `python`, and runs its tests.
pub fn test(python: &str) -> Result<(), String> {
    tools::packing(python)?;
    // `maturin build` sees the package alone and would compile most crates again.
    as_tested("the compiled part of the Python package, and the program whose results its tests compare")?;
    let stage = stage();
    let wheels = target().join("tools/wheel");
    collect(&stage).map_err(|error| format!("the files of the Python package: {error}"))?;
    let (stage, wheels) = (stage.to_string_lossy().into_owned(), wheels.to_string_lossy().into_owned());
    let manifest = format!("{PACKAGE}/Cargo.toml");
    let info = ["-m", "maturin", "pep517", "write-dist-info", "--metadata-directory", &stage, "-m", &manifest];
    step("metadata of its wheel", &mut command(python, &[&info[..], &["--interpreter", python]].concat()))?;
    step("its wheel", &mut command(python, &["-m", "wheel", "pack", &stage, "--dest-dir", &wheels]))?;
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    let wheel = ["--no-deps", "--no-index", "--force-reinstall", "--find-links", &wheels, "wireloom"];
    step("install it", &mut command(python, &[&pip[..], &wheel[..]].concat()))?;
    let mut tests = command(python, &["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests"]);
    let program = target().join("debug/wireloom").with_extension(std::env::consts::EXE_EXTENSION);
    tests.current_dir(root().join(PACKAGE)).env("WIRELOOM", program);
    step("tests of the Python package", &mut tests)?;
    let config = format!("{PACKAGE}/pyproject.toml");
    let sources = format!("{PACKAGE}/python/wireloom");
    step("types of the Python package", &mut command(python, &["-m", "mypy", "--config-file", &config, &sources]))?;
    let allowed = format!("{PACKAGE}/stubtest.txt");
    let stubs = ["-m", "mypy.stubtest", "wireloom", "--mypy-config-file", &config, "--allowlist", &allowed];
    step("its stubs match the compiled part", &mut command(python, &stubs))
}

/// Folder in which the package lies as it is in its wheel.
pub fn stage() -> PathBuf {
    target().join("tools/wheel/wireloom")
}

/// Puts the sources of the package and its compiled part into one new folder.
fn collect(stage: &Path) -> std::io::Result<()> {
    if let Some(wheels) = stage.parent().filter(|wheels| wheels.exists()) {
        fs::remove_dir_all(wheels)?;
    }
    let package = stage.join("wireloom");
    fs::create_dir_all(&package)?;
    for entry in fs::read_dir(root().join(PACKAGE).join("python/wireloom"))? {
        let path = entry?.path();
        let wanted =
            path.extension().is_some_and(|extension| ["js", "py", "pyi", "typed"].iter().any(|own| extension == *own));
        if let Some(name) = path.file_name().filter(|_| wanted) {
            fs::copy(&path, package.join(name))?;
        }
    }
    let compiled = target().join("debug").join(format!("{DLL_PREFIX}_wireloom{DLL_SUFFIX}"));
    let name = if cfg!(windows) { "_wireloom.pyd" } else { "_wireloom.abi3.so" };
    fs::copy(compiled, package.join(name))?;
    Ok(())
}
