//! Chains of points in other processes: a plugin may end its process or never return, and the sweep goes on.
//!
//! A process that ends is replaced, and its chain is computed again: with cold starts, if it ended at a warm one;
//! without the point, if it ended at a cold one. So rows depend on the chain alone, as they do where the program
//! panics.

use super::job::Job;
use crate::arguments::SweepArguments;
use crate::failure::Failure;
use crate::interrupt;
use crate::messages::{Computed, Message, Request};
use crate::plugin::supervise::how;
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};
use wireloom::sweep::{CRASHED, Points, TIME_LIMIT, Without, Work};

/// Time beyond the time limit of a point after which its process is ended: within it a point ends by itself, unless a
/// call of a plugin does not return.
const GRACE: Duration = Duration::from_secs(2);
/// Time between two looks at time limits and interruptions.
const PAUSE: Duration = Duration::from_millis(50);

/// Computes chains of points, given by their indices, on all cores until there is an interruption. Where native code of
/// plugins takes part, they are computed in other processes. `keep` is called with each chain that is done, `done` for
/// each point.
pub fn compute(
    (job, points): (&Job, &Points<'_>),
    arguments: &SweepArguments,
    chains: &[usize],
    done: &(dyn Fn() + Sync),
    keep: impl Fn(usize, Computed) -> Result<(), Failure> + Sync,
) -> Result<(), Failure> {
    if job.has_plugins() && points.batch.is_none() {
        Pool::new(arguments, job).compute(chains, done, keep)
    } else {
        points.compute(chains, interrupt::monitor(), done, |k, chain| keep(k, Computed::of(chain)))
    }
}

/// Processes that compute the chains of a sweep.
struct Pool<'p> {
    arguments: &'p SweepArguments,
    file: &'p Path,
    /// Hash of everything that the points depend on.
    origin: String,
    time_limit: Option<Duration>,
}

/// A process.
struct Process {
    child: Child,
    requests: ChildStdin,
    messages: Receiver<Message>,
}

/// End of the attempt to compute a chain.
enum Attempt {
    Done(Computed),
    Interrupted,
    /// The process ended, at this point (and whether its start was cold), with a status and a reason for its row.
    Ended(Option<(usize, bool)>, &'static str, String),
}

impl<'p> Pool<'p> {
    /// For this sweep.
    fn new(arguments: &'p SweepArguments, job: &'p Job) -> Self {
        let time_limit = job.sweep().time_limit.map(Duration::from_secs_f64);
        Self { arguments, file: &job.file, origin: job.origin.hash(), time_limit }
    }

    fn compute(
        &self,
        chains: &[usize],
        done: &(dyn Fn() + Sync),
        keep: impl Fn(usize, Computed) -> Result<(), Failure> + Sync,
    ) -> Result<(), Failure> {
        let next = AtomicUsize::new(0);
        let failed: Mutex<Option<Failure>> = Mutex::new(None);
        let failed_yet = || failed.lock().unwrap_or_else(PoisonError::into_inner);
        let work = || {
            let mut process = None;
            while let Some(&k) = chains.get(next.fetch_add(1, Ordering::Relaxed)) {
                if failed_yet().is_some() || interrupt::asked() {
                    return;
                }
                let computed = self.chain(k, &mut process, done);
                if let Err(failure) = computed.and_then(|computed| computed.map_or(Ok(()), |chain| keep(k, chain))) {
                    failed_yet().get_or_insert(failure);
                    return;
                }
            }
        };
        thread::scope(|scope| {
            for _ in 0..chains.len().min(wireloom::sweep::threads()) {
                scope.spawn(work);
            }
        });
        failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }

    /// Computes a chain; `None` after an interruption.
    fn chain(&self, chain: usize, process: &mut Option<Process>, done: &dyn Fn()) -> Result<Option<Computed>, Failure> {
        let mut request = Request { chain, without: Without::default() };
        let mut told = 0;
        loop {
            let running = match process {
                Some(running) => running,
                None => match self.start()? {
                    Some(started) => process.insert(started),
                    None => return Ok(None),
                },
            };
            match self.attempt(running, &request, &mut told, done)? {
                Attempt::Done(computed) => return Ok(Some(computed)),
                Attempt::Interrupted => return Ok(None),
                Attempt::Ended(None, _, reason) => return Err(Failure::Plugin(reason)),
                Attempt::Ended(Some((_, false)), ..) => request.without.cold = true,
                Attempt::Ended(Some((point, true)), status, reason) => {
                    request.without.points.insert(point, (status.to_owned(), reason));
                }
            }
            *process = None;
        }
    }

    /// Lets a process compute a chain. `told` counts the points for which `done` was called.
    fn attempt(
        &self,
        process: &mut Process,
        request: &Request,
        told: &mut usize,
        done: &dyn Fn(),
    ) -> Result<Attempt, Failure> {
        let (mut at, mut end, mut counted, mut fault) = (None, None, 0, None);
        let line = serde_json::to_string(request).map_err(|error| broken(error.into()))?;
        // If it has ended, its messages end, too.
        let _ = writeln!(process.requests, "{line}").and_then(|()| process.requests.flush());
        loop {
            if interrupt::asked() {
                return Ok(Attempt::Interrupted);
            }
            match process.messages.recv_timeout(PAUSE) {
                Ok(Message::Work(Work::Begins { point, cold })) => {
                    at = Some((point, cold));
                    end = self.time_limit.map(|limit| Instant::now() + limit + GRACE);
                }
                Ok(Message::Work(Work::Done)) => {
                    counted += 1;
                    if counted > *told {
                        *told = counted;
                        done();
                    }
                }
                Ok(Message::Chain(text)) => {
                    let damaged = || broken(io::ErrorKind::InvalidData.into());
                    return Computed::decode(&text).map(Attempt::Done).ok_or_else(damaged);
                }
                Ok(Message::Fault { late, reason }) => fault = Some((if late { TIME_LIMIT } else { CRASHED }, reason)),
                Ok(Message::Ready(_)) => {}
                Err(RecvTimeoutError::Timeout) => {
                    if end.is_some_and(|end| Instant::now() >= end) {
                        let limit = self.time_limit.unwrap_or_default().as_secs_f64();
                        let reason = format!(
                            "not done within {limit} s: its process was ended, because it did not stop by itself (a \
                             call of a plugin that does not return?)"
                        );
                        return Ok(Attempt::Ended(at, TIME_LIMIT, reason));
                    }
                }
                Err(RecvTimeoutError::Disconnected) => {
                    let how = process.how_it_ended()?;
                    let (status, reason) =
                        fault.unwrap_or_else(|| (CRASHED, format!("the process that computed it ended with {how}")));
                    return Ok(Attempt::Ended(at, status, reason));
                }
            }
        }
    }

    /// Starts a process; `None` after an interruption.
    fn start(&self) -> Result<Option<Process>, Failure> {
        let program = std::env::current_exe().map_err(broken)?;
        let SweepArguments { minimiser, allowed, .. } = self.arguments;
        let mut words: Vec<OsString> = vec!["sweep-process".into()];
        let mut option =
            |name: &str, value: &Path| words.push([name.as_ref(), value.as_os_str()].into_iter().collect());
        minimiser.iter().for_each(|kind| option("--minimiser=", kind.as_ref()));
        allowed.device.iter().for_each(|device| option("--device=", device.as_ref()));
        allowed.allow_plugin.iter().for_each(|plugin| option("--allow-plugin=", plugin));
        words.extend(["--".into(), self.file.into()]);
        let mut command = Command::new(program);
        // Each process works on one thread: together they use all cores.
        command.args(words).env("RAYON_NUM_THREADS", "1").stdin(Stdio::piped()).stdout(Stdio::piped());
        // Ctrl-C is for this process alone, which ends the others.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(broken)?;
        let missing = || broken(io::ErrorKind::BrokenPipe.into());
        let requests = child.stdin.take().ok_or_else(missing)?;
        let output = child.stdout.take().ok_or_else(missing)?;
        let (sender, messages) = channel();
        let listen = move || {
            let mut lines = BufReader::new(output).split(b'\n');
            while let Some(Ok(line)) = lines.next() {
                let line = String::from_utf8_lossy(&line);
                match Message::read(&line) {
                    Some(message) => drop(sender.send(message)),
                    None if line.is_empty() => {}
                    // Printed by a plugin. If standard error is closed, nothing is lost.
                    None => drop(writeln!(io::stderr(), "{line}")),
                }
            }
        };
        thread::Builder::new().name("messages".to_owned()).spawn(listen).map_err(broken)?;
        let mut process = Process { child, requests, messages };
        while !interrupt::asked() {
            match process.messages.recv_timeout(PAUSE) {
                Ok(Message::Ready(origin)) if origin == self.origin => return Ok(Some(process)),
                Ok(Message::Fault { reason, .. }) => return Err(Failure::Plugin(reason)),
                Ok(_) => {
                    let file = self.file.display();
                    return Err(Failure::Input(format!(
                        "{file}, or a file that it names, has changed since the sweep began: the same command begins \
                         anew"
                    )));
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    let how = process.how_it_ended()?;
                    return Err(Failure::Plugin(format!("a process of the sweep ended with {how} before it began")));
                }
            }
        }
        Ok(None)
    }
}

/// A process that cannot be started or reached.
fn broken(source: io::Error) -> Failure {
    Failure::Io { what: "cannot compute in another process".to_owned(), source }
}

impl Process {
    /// How it ended, in words.
    fn how_it_ended(&mut self) -> Result<String, Failure> {
        let status = self.child.wait().map_err(broken)?;
        Ok(how(status))
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
