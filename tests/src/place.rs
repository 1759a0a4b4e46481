//! A folder in which the program is run as a user would run it. What goes wrong in it ends the test.
#![allow(clippy::missing_panics_doc, reason = "all of this panics where the machine does not do as it should")]

use crate::program;
use std::fs;
use std::io::Read;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Longer than anything in tests takes on a slow machine that has other work to do; what takes longer hangs.
pub const PATIENCE: Duration = Duration::from_secs(300);

/// A folder in which the program is run.
pub struct Place(TempDir);

/// End of a program.
#[derive(Debug)]
pub struct Ended {
    /// Exit code; none where a signal ended it.
    pub code: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Place {
    /// With a scenario `s.toml`.
    pub fn new(scenario: &str) -> Self {
        let place = Self(tempfile::tempdir().expect("a folder"));
        place.file("s.toml", scenario);
        place
    }

    /// A path in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A file, with the folders on the way to it.
    pub fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(&path, content).expect("room on the disk");
        path
    }

    /// The text of a file.
    pub fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// A link to what is at `target`, seen from here.
    #[cfg(unix)]
    pub fn link(&self, name: &str, target: &str) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::os::unix::fs::symlink(self.path(target), path).expect("a link");
    }

    /// The program, to be started in it.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(program());
        command.args(arguments).current_dir(self.0.path());
        // Nothing of the user's is touched or seen.
        command
            .env("HOME", self.path("nobody"))
            .env("XDG_STATE_HOME", self.path("state"))
            .env_remove("WIRELOOM_PLUGINS");
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs the program.
    pub fn run(&self, arguments: &[&str]) -> Ended {
        ended(self.command(arguments).spawn().expect("the program runs"))
    }

    /// `result.json` without times.
    pub fn result(&self, folder: &str) -> serde_json::Value {
        let mut result: serde_json::Value =
            serde_json::from_str(&self.text(&format!("{folder}/result.json"))).expect("JSON");
        for step in result["steps"].as_array_mut().expect("steps") {
            step["minimiser"]["seconds"] = serde_json::Value::Null;
        }
        result
    }

    /// Starts a run or a sweep and waits until `file` is there.
    pub fn begun(&self, arguments: &[&str], file: &str) -> Child {
        let mut child = self.command(arguments).spawn().expect("the program runs");
        let began = Instant::now();
        while !self.path(file).exists() {
            assert!(child.try_wait().expect("a state").is_none(), "it was over before {file} was there");
            assert!(began.elapsed() < PATIENCE, "no {file}");
            std::thread::sleep(Duration::from_millis(1));
        }
        child
    }
}

/// Waits for the end of a process; one that does not end is killed.
///
/// # Panics
/// If it does not end.
pub fn ended(mut child: Child) -> Ended {
    let began = Instant::now();
    // It waits where it prints more than a pipe holds, so that is read meanwhile.
    let [out, err] = [child.stdout.take().map(all_of), child.stderr.take().map(all_of)];
    let text = |read: Option<JoinHandle<Vec<u8>>>| {
        let bytes = read.map(|read| read.join().expect("read")).unwrap_or_default();
        String::from_utf8_lossy(&bytes).into_owned()
    };
    let status = loop {
        if let Some(status) = child.try_wait().expect("a state") {
            break status;
        }
        if began.elapsed() > PATIENCE {
            child.kill().expect("killed");
            panic!("it does not end: {} {}", text(out), text(err));
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    Ended { code: status.code(), out: text(out), err: text(err) }
}

/// Reads a pipe to its end, in a thread of its own.
fn all_of(mut pipe: impl Read + Send + 'static) -> JoinHandle<Vec<u8>> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        pipe.read_to_end(&mut bytes).expect("read");
        bytes
    })
}

/// Kills a process.
///
/// # Panics
/// If that cannot be done.
pub fn kill(mut child: Child) {
    child.kill().expect("killed");
    child.wait().expect("ended");
}

impl Ended {
    /// Ended with this code, and said this on standard error; no panic.
    #[track_caller]
    pub fn says(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, Some(code), "{self:#?}");
        assert!(!self.err.contains("panicked"), "{self:#?}");
        for word in words {
            assert!(self.err.contains(word), "no `{word}` in {self:#?}");
        }
    }
}
