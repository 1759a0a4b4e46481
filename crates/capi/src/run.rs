//! Runs.

use crate::call::{WireloomError, call};
use crate::cancel::{self, WireloomCancel};
use crate::failure::{Failure, WireloomCode};
use crate::pointers::{self, SizedStruct};
use crate::result::{self, WireloomResult};
use crate::scenario::{Source, WireloomScenario, source};
use crate::words::Words;
use crate::worker;
use std::ffi::{c_char, c_int, c_void};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use wireloom::session::{Monitor, Observer, Progress};
use wireloom::{Control, Run, StepResult};

/// How far a run has come.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomProgress {
    /// sizeof(WireloomProgress) of the library.
    pub size: usize,
    /// Name of the step, valid during the call.
    pub step: *const c_char,
    /// Index of the step, from 0.
    pub step_index: usize,
    /// Number of steps.
    pub step_count: usize,
    /// Number of the increment that has ended, from 1.
    pub increment: usize,
    /// Increments of the step.
    pub increment_count: usize,
}

/// A function of the host that is called at the end of every increment, in the thread that called wireloom_run. The
/// run ends if it does not return 0. It must return: no exception, no longjmp.
pub type WireloomOnProgress =
    Option<unsafe extern "C" fn(user: *mut c_void, progress: *const WireloomProgress) -> c_int>;

/// What a run may be given: `WireloomRunOptions options = {sizeof options};`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomRunOptions {
    /// sizeof(WireloomRunOptions), set by the caller.
    pub size: usize,
    /// Called at the end of every increment; may be null.
    pub on_progress: WireloomOnProgress,
    /// Handed to `on_progress`.
    pub user: *mut c_void,
    /// Cancels the run, from any thread; {0}: nothing does.
    pub cancel: WireloomCancel,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomRunOptions {}

/// The end of an increment, and where the decision about the next one goes.
type Message = (Progress, SyncSender<Control>);

/// The observer of a run: hands increments to the calling thread, if it asked for them, and waits for its decision.
struct Watcher {
    messages: Option<Sender<Message>>,
    monitor: Monitor,
}

impl Observer for Watcher {
    fn increment(&mut self, progress: &Progress, _: &StepResult, _: bool) -> Control {
        let Some(messages) = &self.messages else { return Control::Continue };
        let (reply, answer) = sync_channel(1);
        // Without a calling thread nobody wants the rest.
        let sent = messages.send((progress.clone(), reply));
        if sent.is_err() { Control::Stop } else { answer.recv().unwrap_or(Control::Stop) }
    }

    fn monitor(&self) -> Monitor {
        self.monitor.clone()
    }
}

fn carry_out(source: &Source, mut watcher: Watcher) -> Result<Run, Failure> {
    let (_, built) = source.load_with_mesh(&wireloom::registry(), &watcher.monitor)?;
    Ok(wireloom::run_observed(built, None, &mut watcher))
}

/// Calls the host's function with every message, until the run has ended.
fn attend(messages: &Receiver<Message>, on_progress: WireloomOnProgress, user: *mut c_void) {
    let Some(on_progress) = on_progress else { return };
    for (now, reply) in messages {
        let words = Words::default();
        let progress = WireloomProgress {
            size: size_of::<WireloomProgress>(),
            step: words.of(&now.step),
            step_index: now.step_index,
            step_count: now.steps,
            increment: now.increment,
            increment_count: now.increments,
        };
        // SAFETY: it is a function of the host for such a call, and what it is given is valid during it.
        let goes_on = unsafe { on_progress(user, &raw const progress) } == 0;
        // The run waits for this.
        let _ = reply.send(if goes_on { Control::Continue } else { Control::Stop });
    }
}

/// Carries a scenario out. `options` may be null.
///
/// A run that does not converge, or that is cancelled, is a result, too: see the status in wireloom_result_get, which
/// is WIRELOOM_STATUS_INTERRUPTED after a cancellation. A scenario with faults is refused.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_run(
    scenario: WireloomScenario,
    options: *const WireloomRunOptions,
    result: *mut WireloomResult,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let source = source(scenario)?;
        pointers::place(result, "result")?;
        let options = pointers::given(options, "options")?;
        let monitor = options.map_or_else(|| Ok(Monitor::default()), |options| cancel::monitor(options.cancel))?;
        let (on_progress, user) = options.map_or((None, std::ptr::null_mut()), |own| (own.on_progress, own.user));
        let (messages, received) = channel();
        let watcher = Watcher { messages: on_progress.map(|_| messages), monitor };
        let run = worker::attended(|| carry_out(&source, watcher), || attend(&received, on_progress, user))?;
        result::hand_over(run, result)
    })
}
