//! Computations in a thread of their own, while the calling thread releases the GIL, looks for Ctrl-C and calls Python
//! functions. A panic becomes an exception.

use crate::failure::Failure;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use wireloom::session::Monitor;

/// Time between two looks for Ctrl-C.
const PAUSE: Duration = Duration::from_millis(30);
/// Stack of a computing thread, bytes: that of a main thread.
const STACK: usize = 8 << 20;

/// The words of a panic.
fn words(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "panic".to_owned())
}

/// The result of `work`, or the words of its panic.
pub fn caught<T>(work: impl FnOnce() -> T) -> Result<T, Failure> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| Failure::Internal(words(&*panic)))
}

/// Short work in the calling thread, without the GIL.
pub fn guarded<T: Send>(py: Python<'_>, work: impl FnOnce() -> Result<T, Failure> + Send) -> PyResult<T> {
    Ok(py.detach(|| caught(work).flatten())?)
}

/// Starts a thread for computations.
pub fn spawn<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<JoinHandle<T>, Failure> {
    thread::Builder::new().name("wireloom".to_owned()).stack_size(STACK).spawn(work).map_err(Failure::Io)
}

/// Receives all messages of a computation, with the GIL at hand for each, until its sender is gone. Between them the
/// GIL is free. Ctrl-C, or an exception in `on_message`, stops the computation; the exception is returned when the
/// sender is gone.
pub fn attend<M: Send>(
    py: Python<'_>,
    mut messages: Receiver<M>,
    monitor: &Monitor,
    mut on_message: impl FnMut(M) -> PyResult<()>,
) -> PyResult<()> {
    let mut outcome = Ok(());
    loop {
        let next;
        (next, messages) = py.detach(move || (messages.recv_timeout(PAUSE), messages));
        let seen = match next {
            Ok(message) => on_message(message),
            Err(RecvTimeoutError::Timeout) => Ok(()),
            Err(RecvTimeoutError::Disconnected) => return outcome,
        };
        if let Err(error) = seen.and_then(|()| py.check_signals())
            && outcome.is_ok()
        {
            monitor.stop();
            outcome = Err(error);
        }
    }
}

/// Waits for the one answer of a computation; `None` if its thread has gone without one.
pub fn answer<T: Send>(py: Python<'_>, messages: Receiver<T>, monitor: &Monitor) -> (Option<T>, PyResult<()>) {
    let mut answer = None;
    let outcome = attend(py, messages, monitor, |message| {
        answer = Some(message);
        Ok(())
    });
    (answer, outcome)
}

/// Work in a thread of its own, which Ctrl-C stops.
pub fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Monitor) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let (monitor, (sender, messages)) = (Monitor::default(), channel());
    let own = monitor.clone();
    spawn(move || sender.send(caught(|| work(&own)).flatten()))?;
    let (answer, outcome) = answer(py, messages, &monitor);
    outcome.and_then(|()| Ok(answer.unwrap_or_else(|| Err(Failure::Internal("the work has vanished".to_owned())))?))
}

/// Panics where computations do, for the tests of the package.
#[pyfunction]
pub fn panic_for_tests(py: Python<'_>, in_thread: bool) -> PyResult<()> {
    let failing = || -> Result<(), Failure> { panic!("a panic for tests") };
    if !in_thread {
        return guarded(py, failing);
    }
    let (sender, messages) = channel();
    spawn(move || sender.send(caught(failing).flatten()))?;
    let (answer, outcome) = answer(py, messages, &Monitor::default());
    outcome.and_then(|()| Ok(answer.unwrap_or(Err(Failure::Closed))?))
}
