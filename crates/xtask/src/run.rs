//! Runs other programs in the repository.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Root of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("crates/xtask lies in the repository")
}

/// Target directory of cargo.
pub fn target() -> PathBuf {
    root().join(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

/// A program with its arguments, to be run at the root of the repository.
pub fn command(program: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.args(arguments).current_dir(root());
    command
}

/// Runs a step; prints its purpose and its duration.
pub fn step(why: &str, command: &mut Command) -> Result<(), String> {
    println!("\n== {why}\n   {}", words(command));
    let clock = Instant::now();
    let status = command.status().map_err(|error| format!("{} cannot be run: {error}", words(command)))?;
    if !status.success() {
        return Err(format!("\nfailed: {why}\n   {} ({status})", words(command)));
    }
    println!("   {:.0} s", clock.elapsed().as_secs_f64());
    Ok(())
}

/// Whether a program succeeds; its output is discarded.
pub fn works(command: &mut Command) -> bool {
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|s| s.success())
}

fn words(command: &Command) -> String {
    let program = std::iter::once(command.get_program()).chain(command.get_args());
    program.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}
