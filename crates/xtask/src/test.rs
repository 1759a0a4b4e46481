//! `cargo xtask test`: all checks. Fast checks come first.

use crate::freecad;
use crate::package;
use crate::run::{command, root, step, target, tests};
use crate::tools;

/// Installs missing tools, then checks format, lints, docs, tests and licences.
pub fn test() -> Result<(), String> {
    tools::components()?;
    step("format of all sources", &mut command("cargo", &["fmt", "--all", "--check"]))?;
    let lints = ["clippy", "--quiet", "--workspace", "--all-targets", "--", "-D", "warnings"];
    step("lints", &mut command("cargo", &lints))?;
    features()?;
    let docs = ["doc", "--quiet", "--workspace", "--no-deps"];
    step("docs: no broken links", command("cargo", &docs).env("RUSTDOCFLAGS", "-D warnings"))?;
    let all = ["test", "--quiet", "--workspace", "--no-fail-fast"];
    let mut all = command("cargo", &all);
    all.env("WIRELOOM_GPU_TESTS", if tools::vulkan() { "require" } else { "auto" });
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // GPU drivers expect this variable and print a warning at every start without it.
        all.env("XDG_RUNTIME_DIR", tools::runtime()?);
    }
    tools::finders();
    let python = tools::python();
    if let Some(python) = &python {
        tools::open_cascade(python);
        all.env("WIRELOOM_PYTHON", python);
    }
    tests("tests and doc tests", &mut all)?;
    if let Some(python) = &python {
        package::test(python)?;
        freecad::test(python)?;
    }
    page()?;
    let deny = tools::deny()?;
    let licences = ["--log-level", "error", "check", "licenses", "bans", "sources"];
    step("licences and sources of all dependencies", &mut command(&deny, &licences))?;
    println!("\nall checks passed");
    Ok(())
}

/// Lints of the façade with none of its features, and with each of them alone.
fn features() -> Result<(), String> {
    let manifest = root().join("crates/wireloom/Cargo.toml");
    let manifest = std::fs::read_to_string(manifest).map_err(|error| format!("the façade's manifest: {error}"))?;
    let lines =
        manifest.lines().skip_while(|line| *line != "[features]").skip(1).take_while(|line| !line.starts_with('['));
    let names = lines
        .filter_map(|line| Some(line.split_once(" = ")?.0))
        .filter(|name| !name.starts_with('#') && *name != "full");
    for name in names {
        let lints = format!("clippy --quiet -p wireloom --no-default-features --features {name} -- -D warnings");
        let lints: Vec<&str> = lints.split(' ').collect();
        step(&format!("lints: the library with the feature `{name}` alone"), &mut command("cargo", &lints))?;
    }
    Ok(())
}

/// Checks the page of the studio, if its tools are available: types, whether the bundle matches its sources, and the
/// page in browsers.
fn page() -> Result<(), String> {
    if !tools::node() {
        return Ok(());
    }
    let npm = |arguments: &[&str]| command("npm", &[&["--silent", "--prefix", tools::PAGE], arguments].concat());
    step("types of the studio's page", &mut npm(&["run", "check"]))?;
    step("the page in the repository matches its sources", &mut npm(&["run", "build", "--", "--check"]))?;
    let program = target().join("debug/wireloom");
    if tools::chromium() {
        step("the page in Chromium", npm(&["test"]).env("WIRELOOM", &program))?;
    }
    if tools::firefox() {
        step("the page in Firefox", npm(&["run", "test:firefox"]).env("WIRELOOM", &program))?;
    }
    Ok(())
}
