//! The process that takes over when a plugin crashes this one, or does not return.

use crate::plugin::supervised;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;
use wireloom::plugins::install_crash_handler;
use wireloom::session::Progress;

/// Prepares the report of a crash where there is nothing to save yet.
pub fn prepare(time_limit: f64) {
    prepare_successor(&[], time_limit);
}

/// Prepares the report of a crash in a process that computes points of a sweep.
pub fn prepare_for_sweep(time_limit: f64) {
    prepare_successor(&["--sweep".into()], time_limit);
}

fn prepare_successor(arguments: &[OsString], time_limit: f64) {
    let Ok(program) = std::env::current_exe() else { return };
    let arguments = [&["plugin-fault".into()], arguments, &["--".into()]].concat();
    install_crash_handler(&program, &arguments, Duration::try_from_secs_f64(time_limit).unwrap_or(Duration::MAX));
}

/// Report of a crash during a run, with the increment; it saves all that is computed.
pub struct CrashReport {
    folder: PathBuf,
    steps: Vec<String>,
    time_limit: f64,
}

impl CrashReport {
    /// For a run with these steps and results in `folder`, which begins now.
    pub fn new(folder: &Path, steps: Vec<String>, time_limit: f64) -> Self {
        let report = Self { folder: folder.to_owned(), steps, time_limit };
        report.increment(0, 1);
        report
    }

    /// An increment has ended.
    pub fn after(&self, progress: &Progress) {
        if progress.increment < progress.increments {
            self.increment(progress.step_index, progress.increment + 1);
        } else if progress.step_index + 1 < progress.steps {
            self.increment(progress.step_index + 1, 1);
        }
    }

    fn increment(&self, step: usize, increment: usize) {
        let name = self.steps.get(step).map_or(ALONE, String::as_str);
        supervised::at(&self.folder, name, increment);
        let increment = increment.to_string();
        let folder = self.folder.as_os_str().to_owned();
        prepare_successor(
            &["--folder".into(), folder, "--step".into(), name.into(), "--increment".into(), increment.into()],
            self.time_limit,
        );
    }
}

/// The step of a scenario that has none.
const ALONE: &str = "equilibrium";
