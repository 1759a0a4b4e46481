//! A process of its own for work in which plugins take part. Plugins are native code: one that calls `_exit`, or
//! damages memory, ends its process in ways that nothing in this process can report. So the program starts itself once
//! more, and waits for the other process to say that it came to its end. What the other process tells is in
//! [`crate::plugin::supervised`].

use crate::arguments::{Command, PluginFault, PluginTask};
use crate::failure::{Failure, Outcome};
use crate::files::load;
use crate::files::saved::{self, Origin};
use crate::interrupt;
use crate::plugin::fault;
use crate::plugin::supervised::{CALLS, END, ENDED_BY_INTERRUPT, FOLDER, PLACE, Place, STOP, shared};
use std::io::{self, Write};
use std::path::Path;
use std::process::{Child, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};
use wireloom::plugins::{RecordedCall, begin_record, recorded_calls};

/// Time after Ctrl-C after which the other process is ended if it is in a call of a plugin.
const PATIENCE: Duration = Duration::from_millis(600);
/// Time between two looks at the other process.
const PAUSE: Duration = Duration::from_millis(5);

/// Carries out the command in another process if plugins take part in it. Returns the exit code; `None`: they do not,
/// or this is that process.
///
/// # Errors
/// If a plugin ended that process.
pub fn carry_out(command: &Command, out: &mut dyn Write) -> Result<Option<u8>, Failure> {
    if cfg!(not(unix)) || shared().is_some() || !with_plugins(command) {
        return Ok(None);
    }
    let folder = tempfile::Builder::new().prefix("wireloom-").tempdir().map_err(broken)?;
    begin_record(&folder.path().join(CALLS)).map_err(broken)?;
    interrupt::listen();
    let mut other = Other::start(folder.path())?;
    let ended = other.wait()?;
    if folder.path().join(END).exists() {
        return match ended.code().and_then(|code| u8::try_from(code).ok()) {
            Some(code) => Ok(Some(code)),
            None => {
                let how = how(ended);
                Err(Failure::Plugin(format!("its process ended with {how}, after its work: a plugin damaged memory")))
            }
        };
    }
    let place: Option<Place> =
        std::fs::read(folder.path().join(PLACE)).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    if interrupt::asked() {
        let Some(place) = place else { return Ok(Some(ENDED_BY_INTERRUPT)) };
        fault::interrupted(&place.folder)?;
        let words = format!("interrupted; `wireloom run --resume {}` resumes the run", place.folder.display());
        writeln!(out, "{words}").map_err(Failure::standard_output)?;
        return Ok(Some(Outcome::NotConverged.code()));
    }
    let calls = recorded_calls(&folder.path().join(CALLS)).map_err(broken)?;
    let Some(call) = calls.into_iter().next() else {
        return Err(Failure::Plugin(format!("its process ended with {}, before any plugin was called", how(ended))));
    };
    let happened = match (call.runs(), ended.code()) {
        (true, Some(code)) => format!("ended the process without a trace (_exit, exit code {code})"),
        (true, None) => format!("ended the process with {}", how(ended)),
        (false, _) => format!(
            "was the last one called when the process ended with {}, outside of all calls: it may have damaged memory",
            how(ended)
        ),
    };
    let (folder, step, increment) = place
        .map_or((None, None, None), |Place { folder, step, increment }| (Some(folder), Some(step), Some(increment)));
    let RecordedCall { site, function, .. } = call;
    fault::report(&PluginFault { folder, step, increment, sweep: false, site, function, happened }, out)
        .map(|outcome| Some(outcome.code()))
}

/// Whether plugins take part. A file that cannot be read is reported by the command itself.
fn with_plugins(command: &Command) -> bool {
    let file = match command {
        Command::Plugin { task: PluginTask::Check { .. } } => return true,
        Command::Verify(arguments) => Some(arguments.file.clone()),
        Command::Sensitivities(arguments) => Some(arguments.file.clone()),
        Command::Identify(arguments) => Some(arguments.file.clone()),
        Command::Optimise(arguments) => Some(arguments.file.clone()),
        Command::Run(arguments) => match &arguments.resume {
            Some(folder) => saved::interrupted(folder).and_then(|folder| Origin::read(&folder)).map(|o| o.file).ok(),
            None => arguments.file.clone(),
        },
        _ => None,
    };
    let text = file.and_then(|file| load::text(&file).ok());
    text.is_some_and(|text| !wireloom::scenario::plugins(&text).load.is_empty())
}

/// The other process.
struct Other<'f> {
    child: Child,
    folder: &'f Path,
}

impl<'f> Other<'f> {
    fn start(folder: &'f Path) -> Result<Self, Failure> {
        let mut command = std::process::Command::new(std::env::current_exe().map_err(broken)?);
        command.args(std::env::args_os().skip(1)).env(FOLDER, folder).stdin(Stdio::piped());
        // Ctrl-C is for this process alone, which tells the other.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        Ok(Self { child: command.spawn().map_err(broken)?, folder })
    }

    /// Waits for its end. After Ctrl-C it is told to stop; if it does not return from a call of a plugin then, it is
    /// ended.
    fn wait(&mut self) -> Result<ExitStatus, Failure> {
        let mut told: Option<Instant> = None;
        loop {
            if let Some(ended) = self.child.try_wait().map_err(broken)? {
                return Ok(ended);
            }
            match told {
                None if interrupt::asked() => {
                    // If it has just ended, that is seen in a moment.
                    let _ = self.child.stdin.as_mut().map(|to| writeln!(to, "{STOP}").and_then(|()| to.flush()));
                    told = Some(Instant::now());
                }
                Some(when) if when.elapsed() > PATIENCE => {
                    let calls = recorded_calls(&self.folder.join(CALLS)).map_err(broken)?;
                    if calls.first().is_some_and(RecordedCall::runs) {
                        self.child.kill().map_err(broken)?;
                    }
                }
                _ => {}
            }
            thread::sleep(PAUSE);
        }
    }
}

impl Drop for Other<'_> {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A process that cannot be started or reached.
fn broken(source: io::Error) -> Failure {
    Failure::Io { what: "cannot work in another process".to_owned(), source }
}

/// How a process ended, in words.
pub fn how(ended: ExitStatus) -> String {
    signal(ended).unwrap_or_else(|| format!("exit code {}", ended.code().unwrap_or_default()))
}

/// The signal that ended a process.
#[cfg(unix)]
fn signal(ended: ExitStatus) -> Option<String> {
    let signal = std::os::unix::process::ExitStatusExt::signal(&ended)?;
    Some(signal_hook::low_level::signal_name(signal).map_or_else(|| format!("signal {signal}"), str::to_owned))
}

#[cfg(not(unix))]
fn signal(_: ExitStatus) -> Option<String> {
    None
}
