//! What the tests need beyond cargo: two components of Rust, and cargo-deny, which goes into the target folder.

use crate::run::{command, step, target, works};

const DENY: &str = "0.20.2";

/// Makes sure that `cargo fmt` and `cargo clippy` are there.
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

/// Path of cargo-deny, installed (about three minutes on two cores) where it is missing.
pub fn deny() -> Result<String, String> {
    let root = target().join("tools");
    let program = root.join("bin/cargo-deny").with_extension(std::env::consts::EXE_EXTENSION);
    let path = program.to_string_lossy().into_owned();
    let version = command(&path, &["--version"]).output().map(|out| String::from_utf8_lossy(&out.stdout).into_owned());
    if !version.is_ok_and(|version| version.trim().ends_with(DENY)) {
        let root = root.to_string_lossy();
        let arguments = ["install", "cargo-deny", "--quiet", "--locked", "--version", DENY, "--root", &root];
        step("install cargo-deny into the target folder (minutes, once)", &mut command("cargo", &arguments))?;
    }
    Ok(path)
}
