//! The process that takes over when a plugin crashes this one, or does not return.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;
use wireloom::host::install_crash_handler;
use wireloom::solve::Progress;

/// What becomes of this process where a plugin ends it before there is anything to save: it says so.
pub fn prepare(time_limit: f64) {
    become_heir(&[], time_limit);
}

fn become_heir(arguments: &[OsString], time_limit: f64) {
    let Ok(program) = std::env::current_exe() else { return };
    let arguments = [&["plugin-fault".into()], arguments, &["--".into()]].concat();
    install_crash_handler(&program, &arguments, Duration::try_from_secs_f64(time_limit).unwrap_or(Duration::MAX));
}

/// What becomes of this process where a plugin ends it during a run: it says so, with the increment at hand, and saves what there is.
pub struct Worst {
    folder: PathBuf,
    steps: Vec<String>,
    time_limit: f64,
}

impl Worst {
    /// Of a run with these steps whose results go to `folder`; it begins now.
    pub fn new(folder: &Path, steps: Vec<String>, time_limit: f64) -> Self {
        let worst = Self { folder: folder.to_owned(), steps, time_limit };
        worst.increment(0, 1);
        worst
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
        let increment = increment.to_string();
        let folder = self.folder.as_os_str().to_owned();
        become_heir(
            &["--folder".into(), folder, "--step".into(), name.into(), "--increment".into(), increment.into()],
            self.time_limit,
        );
    }
}

/// The step of a scenario that has none.
const ALONE: &str = "equilibrium";
