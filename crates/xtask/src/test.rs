//! `cargo xtask test`: all that must hold. What is quick to fail comes first.

use crate::run::{command, root, step, target};
use crate::tools;

/// Installs what is missing, then checks form, lints, docs, tests and licences.
pub fn test() -> Result<(), String> {
    tools::components()?;
    step("one form for all sources", &mut command("cargo", &["fmt", "--all", "--check"]))?;
    let lints = ["clippy", "--quiet", "--workspace", "--all-targets", "--", "-D", "warnings"];
    step("lints: what is known to go wrong", &mut command("cargo", &lints))?;
    features()?;
    let docs = ["doc", "--quiet", "--workspace", "--no-deps"];
    step("docs: every link leads somewhere", command("cargo", &docs).env("RUSTDOCFLAGS", "-D warnings"))?;
    let tests = ["test", "--quiet", "--workspace", "--no-fail-fast"];
    let mut tests = command("cargo", &tests);
    tests.env("WIRELOOM_GPU_TESTS", if tools::vulkan() { "require" } else { "auto" });
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // Drivers of GPUs look for one and complain at every start where there is none.
        tests.env("XDG_RUNTIME_DIR", tools::runtime()?);
    }
    if let Some(python) = tools::python() {
        tests.env("WIRELOOM_PYTHON", python);
    }
    step("tests, and the examples in the docs", &mut tests)?;
    page()?;
    let deny = tools::deny()?;
    let licences = ["--log-level", "error", "check", "licenses", "bans", "sources"];
    step("licences and sources of everything that is built in", &mut command(&deny, &licences))?;
    println!("\nall holds");
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

/// The page of the studio, where its tools can be had: types, whether the bundle is what its sources make, and the page in a browser.
fn page() -> Result<(), String> {
    if !tools::node() {
        return Ok(());
    }
    let npm = |arguments: &[&str]| command("npm", &[&["--silent", "--prefix", tools::PAGE], arguments].concat());
    step("types of the studio's page", &mut npm(&["run", "check"]))?;
    step("the page in the repository is what its sources make", &mut npm(&["run", "build", "--", "--check"]))?;
    if tools::browser() {
        let program = target().join("debug/wireloom");
        step("the page in a browser", npm(&["test"]).env("WIRELOOM", program))?;
    }
    Ok(())
}
