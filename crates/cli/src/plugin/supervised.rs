//! The side of a process that another one supervises ([`crate::plugin::supervise`]): what it tells the other.
//!
//! | in the folder that both know | content |
//! | --- | --- |
//! | `calls` | calls of plugins, in memory that both share |
//! | `place` | folder, step and increment of a run, written as each increment begins |
//! | `end` | made by the process as it comes to its end |

use crate::interrupt;
use serde::{Deserialize, Serialize};
use std::io::{self, BufRead};
use std::path::{Path, PathBuf};
use std::thread;

/// Environment variable of a supervised process: the folder that both know.
pub const FOLDER: &str = "WIRELOOM_SUPERVISED";
pub const CALLS: &str = "calls";
pub const PLACE: &str = "place";
pub const END: &str = "end";
/// Line on the standard input of a supervised process after Ctrl-C.
pub const STOP: &str = "stop";
/// Exit code after Ctrl-C where there is nothing to resume.
pub const ENDED_BY_INTERRUPT: u8 = 130;

/// Where a run is.
#[derive(Serialize, Deserialize)]
pub struct Place {
    pub folder: PathBuf,
    pub step: String,
    pub increment: usize,
}

/// The folder that this process shares with its supervisor, if it has one.
pub fn shared() -> Option<PathBuf> {
    std::env::var_os(FOLDER).map(PathBuf::from)
}

/// Begins the work of a process with a supervisor: it ends with the supervisor, and stops when told to.
pub fn begin() {
    let Some(folder) = shared() else { return };
    // Without the record the supervisor does not know which plugin ended the process.
    #[cfg(unix)]
    let _ = wireloom::plugins::record_calls(&folder.join(CALLS));
    let listen = || {
        for line in io::stdin().lock().lines().map_while(Result::ok) {
            if line == STOP {
                interrupt::stop();
            }
        }
        interrupt::leave(i32::from(ENDED_BY_INTERRUPT));
    };
    let _ = thread::Builder::new().name("supervisor".to_owned()).spawn(listen);
}

/// An increment of a run begins, for the supervisor, if there is one.
pub fn at(folder: &Path, step: &str, increment: usize) {
    let Some(shared) = shared() else { return };
    let place = Place { folder: folder.to_owned(), step: step.to_owned(), increment };
    // Without it the supervisor says less.
    let _ = serde_json::to_vec(&place).map(|bytes| std::fs::write(shared.join(PLACE), bytes));
}

/// The process comes to its end by itself.
pub fn end() {
    if let Some(folder) = shared() {
        // Without it the supervisor reports a plugin that ended the process.
        let _ = std::fs::write(folder.join(END), "");
    }
}
