//! Files that a stranger supplies, folders that runs share, disks that fail: with real processes.

#![cfg(unix)]

mod inputs;
mod kept;
mod links;
mod trouble;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use wireloom_tests::program;

/// Longer than anything here takes on a slow machine that has other work to do; what takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(120);

/// A cable between two plugs, one of which is moved in so many increments.
fn cable(increments: usize, more: &str) -> String {
    format!(
        r#"
schema = 1
name = "cable"
[sections.cable]
diameter = "6 mm"
linear_density = "50 g/m"
axial_stiffness = 1e4
bending_stiffness = 0.01
torsion_stiffness = 0.008
[[branches]]
name = "cable"
from = "A"
to = "B"
section = "cable"
length = "1 m"
segments = 20
[[constraints]]
name = "plug-A"
kind = "connector"
at = {{ end = "A" }}
position = [0, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
[[constraints]]
name = "plug-B"
kind = "connector"
at = {{ end = "B" }}
position = [0.6, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
[[steps]]
name = "draw"
increments = {increments}
move = [{{ constraint = "plug-B", position = [0.8, 0.1, 0] }}]
{more}
"#
    )
}

const SWEEP: &str = "[sweep.vary]\n\"branches.cable.length\" = { from = 0.9, to = 1.1, count = 200 }\n";

/// A folder in which the program is run.
struct Place(tempfile::TempDir);

/// How a program ended.
#[derive(Debug)]
struct Ended {
    code: Option<i32>,
    out: String,
    err: String,
}

impl Place {
    /// With a scenario `s.toml`.
    fn new(scenario: &str) -> Self {
        let place = Self(tempfile::tempdir().expect("a folder"));
        place.file("s.toml", scenario);
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A file, with the folders on the way to it.
    fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(&path, content).expect("room on the disk");
        path
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// A link to what is at `target`, seen from here.
    fn link(&self, name: &str, target: &str) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::os::unix::fs::symlink(self.path(target), path).expect("a link");
    }

    fn command(&self, arguments: &[&str]) -> Command {
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

    fn run(&self, arguments: &[&str]) -> Ended {
        ended(self.command(arguments).spawn().expect("the program runs"))
    }

    /// `result.json` without times.
    fn result(&self, folder: &str) -> serde_json::Value {
        let mut result: serde_json::Value =
            serde_json::from_str(&self.text(&format!("{folder}/result.json"))).expect("JSON");
        for step in result["steps"].as_array_mut().expect("steps") {
            step["minimiser"]["seconds"] = serde_json::Value::Null;
        }
        result
    }

    /// Starts a run or a sweep and waits until `file` is there.
    fn begun(&self, arguments: &[&str], file: &str) -> Child {
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

/// How a process ends; one that does not is killed.
fn ended(mut child: Child) -> Ended {
    let began = Instant::now();
    // What it prints is less than a pipe holds.
    while child.try_wait().expect("a state").is_none() {
        if began.elapsed() > PATIENCE {
            child.kill().expect("killed");
            panic!("it does not end: {:?}", child.wait_with_output());
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let Output { status, stdout, stderr } = child.wait_with_output().expect("ended");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    Ended { code: status.code(), out: text(stdout), err: text(stderr) }
}

fn kill(mut child: Child) {
    child.kill().expect("killed");
    child.wait().expect("ended");
}

impl Ended {
    /// Ended with this code, and said this on standard error; no panic.
    #[track_caller]
    fn says(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, Some(code), "{self:#?}");
        assert!(!self.err.contains("panicked"), "{self:#?}");
        for word in words {
            assert!(self.err.contains(word), "no `{word}` in {self:#?}");
        }
    }
}

/// All files below a folder, in order: names and bytes.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let (mut open, mut files) = (vec![folder.to_owned()], vec![]);
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder).expect("a folder") {
            let entry = entry.expect("an entry");
            if entry.file_type().expect("a type").is_dir() {
                open.push(entry.path());
            } else {
                files.push((entry.path(), fs::read(entry.path()).expect("bytes")));
            }
        }
    }
    files.sort();
    files
}

/// A copy of a folder. It shares its files with the first, since the program replaces files and never changes them.
fn copy(from: &Path, to: &Path) {
    for (file, _) in files(from) {
        let target = to.join(file.strip_prefix(from).expect("below it"));
        fs::create_dir_all(target.parent().expect("a folder")).expect("a folder");
        fs::hard_link(file, target).expect("a link");
    }
}

/// A named pipe, at which a reader waits for ever.
fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().expect("mkfifo").success());
}
