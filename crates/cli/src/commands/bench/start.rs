//! Times from the start of this program to its end, as a user waits for it: for nothing, and for a small scenario.

use crate::failure::Failure;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

/// The scenario of the README.
const FIRST: &str = include_str!("../../../../../scenarios/first.toml");
/// Number of starts of each case.
const RUNS: usize = 21;

/// One command, started again and again.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// `start` for `wireloom --version`, `run-first` for `wireloom run scenarios/first.toml`.
    pub case: &'static str,
    /// Number of starts.
    pub runs: usize,
    /// Median time from the start of the process to its end, s.
    pub seconds: f64,
    /// Shortest such time, s.
    pub fastest: f64,
    /// Number of starts that did not end with exit code 0.
    pub failures: usize,
}

/// Measures both cases.
///
/// # Errors
/// If this program cannot be started, or there is no folder for temporary files.
pub fn measure() -> Result<Vec<Start>, Failure> {
    let program = std::env::current_exe().map_err(Failure::system("find this program"))?;
    let folder = tempfile::tempdir().map_err(Failure::system("make a temporary folder"))?;
    std::fs::write(folder.path().join("first.toml"), FIRST).map_err(Failure::io("write", folder.path()))?;
    let cases: [(&'static str, &[&str]); 2] = [("start", &["--version"]), ("run-first", &["run", "first.toml"])];
    cases.iter().map(|(case, arguments)| started(case, &program, arguments, folder.path())).collect()
}

fn started(case: &'static str, program: &Path, arguments: &[&str], folder: &Path) -> Result<Start, Failure> {
    let (mut times, mut failures) = (Vec::with_capacity(RUNS), 0);
    for _ in 0..RUNS {
        let mut command = Command::new(program);
        command.args(arguments).current_dir(folder).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let clock = Instant::now();
        let status = command.status().map_err(Failure::io("run", program))?;
        times.push(clock.elapsed().as_secs_f64());
        failures += usize::from(!status.success());
    }
    times.sort_by(f64::total_cmp);
    Ok(Start { case, runs: RUNS, seconds: times[RUNS / 2], fastest: times[0], failures })
}
