//! Tools of the tests beyond cargo: two components of Rust, a Vulkan device, CMake, pkg-config, Node and two browsers
//! for the studio's page, FreeCAD, cargo-deny, a Python with packages, and one with Exudyn; the last three are
//! installed into the target folder.

use crate::run::{command, step, target, works};
use std::path::PathBuf;

const DENY: &str = "0.20.2";
const DUCKDB: &str = "2.0.0";
const OPEN_CASCADE: &str = "8.0.1.1.0";
const EXUDYN: &str = "1.13.6";
/// What the Python package needs to be packed and tested.
const PACKING: [&str; 13] = [
    "anywidget>=0.9",
    "cosseratbench==0.3.0",
    "distributed>=2026.8",
    "jax>=0.4",
    "jupyterlab>=4.2",
    "maturin==1.16.0",
    "matplotlib>=3.8",
    "mypy==2.4.1",
    "numpy>=2,<3",
    "playwright>=1.48",
    "pytest==9.2.0",
    "usd-core==26.11",
    "wheel>=0.45",
];

/// Makes sure that `cargo fmt` and `cargo clippy` are installed.
pub fn components() -> Result<(), String> {
    for (subcommand, component) in [("fmt", "rustfmt"), ("clippy", "clippy")] {
        if works(&mut command("cargo", &[subcommand, "--version"])) {
            continue;
        }
        let why = format!("install {component}, which this Rust came without");
        step(&why, &mut command("rustup", &["component", "add", component]))
            .map_err(|error| format!("{error}\ninstall {component} by hand: this Rust was not installed by rustup"))?;
    }
    Ok(())
}

/// Makes sure that there is a Vulkan device for the GPU tests; installs Mesa's software device if the system has no
/// driver. Returns whether there is one; without one these tests are shown as ignored.
pub fn vulkan() -> bool {
    const PACKAGES: [&str; 2] = ["mesa-vulkan-drivers", "libvulkan1"];
    if has_vulkan() {
        return true;
    }
    let by_hand = format!("install {} (or what your system calls them) to run them", PACKAGES.join(" and "));
    let done = install("install a software Vulkan device", &PACKAGES);
    if let Err(error) = &done {
        println!("{error}\nno Vulkan driver: the tests that need a device are ignored; {by_hand}");
    }
    done.is_ok() && has_vulkan()
}

/// Installs CMake and pkg-config, with which programs find the C library; without them its tests are ignored.
pub fn finders() {
    let missing = |program: &&str| !works(&mut command(program, &["--version"]));
    let missing: Vec<&str> = ["cmake", "pkg-config"].into_iter().filter(missing).collect();
    if missing.is_empty() {
        return;
    }
    if let Err(error) = install("install what finds the C library", &missing) {
        println!("{error}\nno {}: the tests of the C library that need it are ignored", missing.join(" and no "));
    }
}

/// The Python that has FreeCAD's modules and pytest, beside a display without a screen for the user interface; installs
/// them if they are missing. Without them the tests of the workbench are left out.
pub fn freecad() -> Option<&'static str> {
    const PACKAGES: [&str; 6] =
        ["freecad-python3", "libgl1-mesa-dri", "python3-numpy", "python3-pytest", "xauth", "xvfb"];
    // Debian's: FreeCAD is compiled for the Python of the system, whatever others there are.
    const PYTHON: &str = "/usr/bin/python3";
    let there = || {
        let known =
            "import sys; sys.path.append('/usr/lib/freecad-python3/lib'); import FreeCAD, numpy, pytest, tomllib";
        works(&mut command(PYTHON, &["-c", known]))
            && works(&mut command("sh", &["-c", "command -v xvfb-run && command -v xauth"]))
    };
    if there() || install("install FreeCAD", &PACKAGES).is_ok_and(|()| there()) {
        return Some(PYTHON);
    }
    println!("   FreeCAD of Debian 12 or later is missing: the tests of its workbench are left out");
    None
}

/// Installs packages on Debian and its derivatives, as root or with passwordless sudo.
fn install(why: &str, packages: &[&str]) -> Result<(), String> {
    let root: &[&str] = if works(&mut command("sh", &["-c", "test \"$(id -u)\" = 0"])) { &[] } else { &["sudo", "-n"] };
    let apt = |arguments: &[&str]| {
        let all = [root, &["env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-q"], arguments].concat();
        command(all[0], &all[1..])
    };
    if !cfg!(target_os = "linux") || !works(&mut apt(&["--version"])) {
        return Err(format!("\nfailed: {why}: this needs Debian and root"));
    }
    let install = [&["install", "--yes", "--no-install-recommends"][..], packages].concat();
    step("update the package lists", &mut apt(&["update"]))?;
    step(why, &mut apt(&install))
}

/// A runtime folder for systems that define none.
pub fn runtime() -> Result<PathBuf, String> {
    let folder = target().join("tools/runtime");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{} cannot be made: {error}", folder.display()))?;
    Ok(folder)
}

/// Whether the system has the Vulkan loader and a driver.
fn has_vulkan() -> bool {
    let loader = command("ldconfig", &["-p"]).output();
    let loader = loader.or_else(|_| command("/sbin/ldconfig", &["-p"]).output());
    let found = loader.is_ok_and(|out| String::from_utf8_lossy(&out.stdout).contains("libvulkan.so.1"));
    let drivers = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"].map(std::fs::read_dir);
    found && drivers.into_iter().flatten().any(|mut files| files.next().is_some())
}

/// Folder of the page's sources.
pub const PAGE: &str = "crates/studio/web";

/// Path of cargo-deny; installs it if it is missing: unoptimised, in half the time, for a check of a few seconds.
pub fn deny() -> Result<String, String> {
    let root = target().join("tools");
    let program = root.join("bin/cargo-deny").with_extension(std::env::consts::EXE_EXTENSION);
    let path = program.to_string_lossy().into_owned();
    let version = command(&path, &["--version"]).output().map(|out| String::from_utf8_lossy(&out.stdout).into_owned());
    if !version.is_ok_and(|version| version.trim().ends_with(DENY)) {
        let root = root.to_string_lossy();
        let arguments = ["install", "cargo-deny", "--quiet", "--debug", "--locked", "--version", DENY, "--root", &root];
        step("install cargo-deny into the target folder (a minute or two, once)", &mut command("cargo", &arguments))?;
    }
    Ok(path)
}

/// Installs what the Python package needs to be packed and tested; `python`: the one of [`python`].
pub fn packing(python: &str) -> Result<(), String> {
    let known = "import anywidget, cosseratbench, distributed, jax, jupyterlab, maturin, matplotlib, mypy, numpy, \
                 playwright, pytest, wheel, pxr.Usd";
    if works(&mut command(python, &["-c", known])) {
        return Ok(());
    }
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    step("install the tools of the Python package", &mut command(python, &[&pip, &PACKING[..]].concat()))
}

/// Path of a Python with DuckDB; `None` if it cannot be installed, and the tests that need it are then ignored.
pub fn python() -> Option<String> {
    let found = python_with("python", "duckdb", DUCKDB, "an independent reader of sweep tables");
    found.inspect_err(|error| println!("{error}\n   so the tests with DuckDB are ignored")).ok()
}

/// Installs Open CASCADE beside DuckDB; without it the tests that read STEP files are ignored.
pub fn open_cascade(python: &str) {
    if works(&mut command(python, &["-c", "import OCP.STEPCAFControl"])) {
        return;
    }
    let wanted = format!("cadquery-ocp-novtk=={OPEN_CASCADE}");
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", &wanted];
    if let Err(error) = step("install Open CASCADE, which reads STEP files", &mut command(python, &pip)) {
        println!("{error}\n   so the tests that read STEP files are ignored");
    }
}

/// Path of a Python with Exudyn.
pub fn exudyn() -> Result<String, String> {
    python_with("peer", "exudyn", EXUDYN, "another program that finds equilibria of cables")
}

/// Path of a Python with a package, in a folder of its own; installs it if it is missing.
fn python_with(folder: &str, package: &str, version: &str, what: &str) -> Result<String, String> {
    let root = target().join("tools").join(folder);
    let path =
        root.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" }).to_string_lossy().into_owned();
    let known = format!("import {package}; assert {package}.__version__ == '{version}'");
    if works(&mut command(&path, &["-c", &known])) {
        return Ok(path);
    }
    virtual_environment(&root.to_string_lossy())?;
    let wanted = format!("{package}=={version}");
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", &wanted];
    step(&format!("install {package}, {what}"), &mut command(&path, &pip))?;
    Ok(path)
}

/// Creates a virtual environment of Python; on Debian its module may be missing, which needs root.
fn virtual_environment(root: &str) -> Result<(), String> {
    let mut make = command("python3", &["-m", "venv", "--clear", root]);
    let why = "make a virtual environment of Python in the target folder";
    if works(&mut make) {
        return Ok(());
    }
    install("install Python's module venv", &["python3-venv"])
        .map_err(|error| format!("{error}\n   {why}: install python3 with its module venv by hand"))?;
    step(why, &mut make)
}

/// Whether the page of the studio can be built here: npm and the page's dependencies are installed, or could be.
pub fn node() -> bool {
    let there = || works(&mut command("npm", &["--version"]));
    if !there() && !install("install Node, which builds the studio's page", &["nodejs", "npm"]).is_ok_and(|()| there())
    {
        println!("   npm is missing: the studio's page in the repository is used as it is and not tested in a browser");
        return false;
    }
    let install = ["ci", "--prefix", PAGE, "--ignore-scripts", "--no-audit", "--no-fund", "--silent"];
    step("install the dependencies of the studio's page", &mut command("npm", &install))
        .inspect_err(|error| println!("{error}\n   so the page in the repository is used as it is"))
        .is_ok()
}

/// Whether there is Chromium for the tests of the page; on Debian it is installed if possible.
pub fn chromium() -> bool {
    browser("Chromium", &["chromium"], || works(&mut command("chromium", &["--version"])))
}

/// Whether there is Firefox for the tests of the page, and a display on which it has WebGL; likewise.
pub fn firefox() -> bool {
    const PACKAGES: [&str; 7] = ["firefox-esr", "libegl1", "libgl1", "libgl1-mesa-dri", "libpci3", "xauth", "xvfb"];
    browser("Firefox", &PACKAGES, || {
        works(&mut command("firefox-esr", &["--version"]))
            && works(&mut command("sh", &["-c", "command -v xvfb-run && command -v xauth"]))
    })
}

/// Whether a browser is there, after its packages are installed if it was not.
fn browser(name: &str, packages: &[&str], there: impl Fn() -> bool) -> bool {
    // The browser driver needs this version.
    if !works(&mut command("node", &["-e", "process.exit(parseInt(process.versions.node) < 20 ? 1 : 0)"])) {
        println!("   Node is older than 20, so the page is not tested in {name}");
        return false;
    }
    if there() || install(&format!("install {name} for the page"), packages).is_ok_and(|()| there()) {
        return true;
    }
    println!("   {name} is missing, so the page is not tested in it");
    false
}
