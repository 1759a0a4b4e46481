//! The process in which Open CASCADE reads a file: native code that a strange file may crash or hold up.

use crate::error::{REQUIRED, StepError};
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};
use wireloom_core::Monitor;

/// What Python runs.
pub(crate) const SCRIPT: &str = include_str!("read.py");
/// Its exit code where Open CASCADE is missing.
const MISSING: i32 = 3;
/// Oldest version of it.
const OLDEST: u32 = 8;
/// Limit of the question for the version, s.
const SECONDS_OF_VERSION: u64 = 60;
/// Time between two looks at the process.
const PAUSE: Duration = Duration::from_millis(5);
/// Seconds for which the process ends itself later than it is ended, if this one can no longer do so.
const LATER: u64 = 2;
/// Lines of what it said that a message shows.
const LINES: usize = 3;

/// Interpreter, time limit, and who may stop it.
pub(crate) struct Process<'a> {
    pub python: &'a str,
    pub seconds: u64,
    pub monitor: &'a Monitor,
}

impl Process<'_> {
    /// Name and version of the package.
    pub fn version(&self) -> Result<String, StepError> {
        let folder = folder()?;
        let limited = Self { seconds: SECONDS_OF_VERSION, ..*self };
        let said = limited.run(folder.path(), &[])?;
        let version = said.trim().to_owned();
        let major = version.rsplit(' ').next().and_then(|number| number.split('.').next()?.parse::<u32>().ok());
        if major.is_some_and(|major| major >= OLDEST) {
            return Ok(version);
        }
        let found = format!("{} instead of {REQUIRED}", if version.is_empty() { "an unknown one" } else { &version });
        Err(StepError::NoPackage { program: self.python.to_owned(), found })
    }

    /// What `read.py` writes for the bytes of a STEP file; `deflection` in m.
    pub fn read(&self, bytes: &[u8], deflection: f64) -> Result<Vec<u8>, StepError> {
        let folder = folder()?;
        let [input, output] = ["in.step", "out"].map(|name| folder.path().join(name));
        fs::write(&input, bytes).map_err(|source| StepError::Io { what: "write", path: input.clone(), source })?;
        let numbers = [format!("{:e}", deflection * 1e3), (self.seconds + LATER).to_string()];
        let said = self.run(folder.path(), &["in.step", "out", &numbers[0], &numbers[1]])?;
        let faults: Vec<&str> = said.lines().filter(|line| line.contains("ERR Step")).collect();
        if !faults.is_empty() {
            let words = faults.iter().map(|line| plain(line)).collect::<Vec<_>>().join("; ");
            return Err(StepError::Faulty {
                line: line_in(&words),
                said: format!("Open CASCADE finds faults in it: {words}"),
            });
        }
        fs::read(&output).map_err(|_| crashed("it wrote nothing".to_owned(), &said))
    }

    /// Runs the script; returns what it printed.
    fn run(&self, folder: &Path, arguments: &[&str]) -> Result<String, StepError> {
        let io = |what, path: &Path| {
            let path = path.to_owned();
            move |source| StepError::Io { what, path, source }
        };
        let [script, said] = ["read.py", "said"].map(|name| folder.join(name));
        fs::write(&script, SCRIPT).map_err(io("write", &script))?;
        let out = File::create(&said).map_err(io("write", &said))?;
        let errors = out.try_clone().map_err(io("write", &said))?;
        let mut command = Command::new(self.python);
        command.arg("read.py").args(arguments).current_dir(folder);
        let started = command.stdin(Stdio::null()).stdout(out).stderr(errors).spawn();
        let mut child = started.map_err(|source| StepError::NoPython { program: self.python.to_owned(), source })?;
        let began = Instant::now();
        let ended = loop {
            let ended = child.try_wait().map_err(io("wait for", Path::new(self.python)))?;
            let stop = if self.monitor.is_stopped() {
                Some(StepError::Interrupted)
            } else if began.elapsed() > Duration::from_secs(self.seconds) {
                Some(StepError::TimeLimit { seconds: self.seconds })
            } else {
                None
            };
            match (ended, stop) {
                (Some(ended), _) => break ended,
                (None, Some(error)) => {
                    // It may end at this moment.
                    let _ = child.kill();
                    let _ = child.wait();
                    return Err(error);
                }
                (None, None) => thread::sleep(PAUSE),
            }
        };
        let said = fs::read(&said).map_err(io("read", &said))?;
        let said = String::from_utf8_lossy(&said).into_owned();
        match ended.code() {
            Some(0) => Ok(said),
            Some(MISSING) => {
                let found = format!("no {REQUIRED}{}", tail(&said));
                Err(StepError::NoPackage { program: self.python.to_owned(), found })
            }
            // Ctrl-C ends it before it ends this process.
            None if self.monitor.is_stopped() || signal(ended) == Some(SIGINT) => Err(StepError::Interrupted),
            _ => Err(crashed(ended.to_string(), &said)),
        }
    }
}

const SIGINT: i32 = 2;

#[cfg(unix)]
fn signal(ended: ExitStatus) -> Option<i32> {
    std::os::unix::process::ExitStatusExt::signal(&ended)
}

#[cfg(not(unix))]
fn signal(_: ExitStatus) -> Option<i32> {
    None
}

/// A folder that goes when the process has ended.
fn folder() -> Result<tempfile::TempDir, StepError> {
    let failed = |source: io::Error| StepError::Io { what: "make a folder in", path: std::env::temp_dir(), source };
    tempfile::Builder::new().prefix("wireloom-").tempdir().map_err(failed)
}

fn crashed(how: String, said: &str) -> StepError {
    StepError::Crashed { how, said: tail(said).trim_start_matches(": ").to_owned() }
}

/// The last lines, after a colon; empty where there are none.
fn tail(said: &str) -> String {
    let lines: Vec<String> = said.lines().map(plain).filter(|line| !line.is_empty()).collect();
    let last = &lines[lines.len().saturating_sub(LINES)..];
    if last.is_empty() { String::new() } else { format!(": {}", last.join("; ")) }
}

/// The number of a line that Open CASCADE names.
fn line_in(words: &str) -> Option<usize> {
    let (_, after) = words.split_once("Line ")?;
    after.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
}

/// A line of Open CASCADE without colours and stars.
pub(crate) fn plain(line: &str) -> String {
    let mut words = String::new();
    let mut rest = line;
    while let Some((before, after)) = rest.split_once('\u{1b}') {
        words += before;
        rest = after.split_once('m').map_or("", |(_, after)| after);
    }
    words += rest;
    let words: String = words.chars().filter(|c| !c.is_control()).collect();
    words.trim().trim_matches('*').trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_lose_their_colours_and_stars() {
        let line = "\u{1b}[31;1m**** ERR StepFile : Undefined Parsing: Line 982: Incorrect syntax    ****\u{1b}[0m";
        assert_eq!(plain(line), "ERR StepFile : Undefined Parsing: Line 982: Incorrect syntax");
        assert_eq!(plain("\u{1b}["), "");
        assert_eq!((line_in(&plain(line)), line_in("Fails Count : 1")), (Some(982), None));
    }

    #[test]
    fn without_python_the_message_says_what_to_install() {
        let process = Process { python: "no-such-python", seconds: 1, monitor: &Monitor::default() };
        let error = process.version().expect_err("there is none");
        assert!(error.to_string().contains("`no-such-python` cannot be started"), "{error}");
        assert!(error.help().contains("pip install \"cadquery-ocp-novtk>=8\""), "{}", error.help());
    }
}
