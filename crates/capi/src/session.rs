//! Sessions: a harness that is moved by hand. Each one lives in a thread of its own.

use crate::call::{WireloomError, call};
use crate::cancel::{self, WireloomCancel};
use crate::failure::{Failure, WireloomCode, caught};
use crate::result::{self, WireloomResult};
use crate::scenario::{Source, WireloomScenario, not_set, source, value_of};
use crate::text::{self, WireloomText};
use crate::{handles, pointers, worker};
use std::ffi::c_char;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use wireloom::session::drag::Goal;
use wireloom::session::{Monitor, Refusal, Session, SessionError};

/// What the handle is called.
const WHAT: &str = "session";

/// A harness that is moved by hand, each time to a new equilibrium, while the scenario is recorded: a run of its text
/// ends in the same equilibrium. Calls from several threads are carried out one after the other.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomSession {
    /// 0: none.
    pub id: u64,
}

/// Work on the harness; returns whether the session goes on.
type Job = Box<dyn FnOnce(&mut Session) -> bool + Send>;

/// What the handle stands for.
struct Kept {
    jobs: Mutex<Option<Sender<Job>>>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Kept {
    fn drop(&mut self) {
        // The thread ends when no more work can come.
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner).take();
        // It has caught its panics.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn closed() -> Failure {
    Failure::new(WireloomCode::Closed, "the session has ended", "free it, and open another one")
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        let code = match &error {
            SessionError::Refused { text, faults } => return Self::refused(text, faults),
            SessionError::Key { text, fault } => return Self::of_fault(WireloomCode::NotFound, text, fault),
            SessionError::Stopped => {
                return Self::new(WireloomCode::Cancelled, "it was cancelled", "reset the cancel handle");
            }
            SessionError::Unknown(_) => WireloomCode::NotFound,
            SessionError::Value(_) => WireloomCode::BadValue,
            SessionError::Request(_) => WireloomCode::Request,
            SessionError::Part(_) => WireloomCode::Part,
        };
        let Refusal { message, help } = error.into();
        Self::new(code, message, help)
    }
}

/// Opens a session in the calling thread.
fn open(source: Source, monitor: Monitor) -> Result<Session, Failure> {
    source.refuse_plugins().map_err(|faults| Failure::refused(&source.text, &faults))?;
    Ok(Session::open(&source.text, Box::new(source.files), wireloom::registry(), monitor)?)
}

/// Work on the harness of a session, in its thread.
fn ask<T: Send + 'static, E: Into<Failure>>(
    session: WireloomSession,
    work: impl FnOnce(&mut Session) -> Result<T, E> + Send + 'static,
) -> Result<T, Failure> {
    let kept = handles::get::<Kept>(session.id, WHAT)?;
    let (sender, answer) = channel();
    let job: Job = Box::new(move |session| {
        let done = caught(|| work(session).map_err(E::into));
        // After a panic the state is unknown.
        let goes_on = !done.as_ref().is_err_and(Failure::is_internal);
        // The caller waits.
        let _ = sender.send(done);
        goes_on
    });
    let jobs = kept.jobs.lock().unwrap_or_else(PoisonError::into_inner).clone();
    jobs.ok_or_else(closed)?.send(job).map_err(|_| closed())?;
    answer.recv().unwrap_or_else(|_| Err(closed()))
}

/// The target that a host gives.
fn goal(position: *const f64, orientation: *const f64) -> Result<Goal, Failure> {
    Ok(Goal {
        position: pointers::numbers_if_given(position, "position")?,
        orientation: pointers::numbers_if_given(orientation, "orientation")?,
    })
}

/// Opens a session: finds the initial equilibrium and carries out the steps of the scenario. `cancel` cancels this and
/// what the session does later; {0}: nothing does.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_session_open(
    scenario: WireloomScenario,
    cancel: WireloomCancel,
    session: *mut WireloomSession,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let source = source(scenario)?;
        pointers::place(session, "session")?;
        let monitor = cancel::monitor(cancel)?;
        let (jobs, queue) = channel::<Job>();
        let (opened, opening) = channel();
        let work = move || {
            let (done, session) = match caught(|| open(source, monitor)) {
                Ok(session) => (Ok(()), Some(session)),
                Err(failure) => (Err(failure), None),
            };
            // The caller waits.
            let _ = opened.send(done);
            let Some(mut session) = session else { return };
            while let Ok(job) = queue.recv() {
                if !job(&mut session) {
                    return;
                }
            }
        };
        let thread = worker::builder().spawn(work).map_err(|error| worker::no_thread(&error))?;
        let kept = Kept { jobs: Mutex::new(Some(jobs)), thread: Some(thread) };
        opening.recv().unwrap_or_else(|_| Err(closed()))?;
        pointers::put(session, "session", WireloomSession { id: handles::new(kept) })
    })
}

/// The current equilibrium: a result of one step, with the events and requirements so far.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_session_result(
    session: WireloomSession,
    result: *mut WireloomResult,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        pointers::place(result, "result")?;
        result::hand_over(ask(session, |session| Ok::<_, Failure>(session.run()))?, result)
    })
}

/// Moves a constraint that acts to a pose, in as many increments as the way needs.
///
/// `position`: three numbers, m; null: where it is. `orientation`: a quaternion w, x, y, z of any length but zero;
/// null: as it is. Motions of one constraint that follow each other are one step of the scenario, and are undone
/// together. A motion that fails on the way stays at the last equilibrium before.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_session_move(
    session: WireloomSession,
    constraint: *const c_char,
    position: *const f64,
    orientation: *const f64,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let name = pointers::text(constraint, "constraint")?.to_owned();
        let goal = goal(position, orientation)?;
        ask(session, move |session| session.move_to(&name, &goal))
    })
}

/// Takes hold of the cable where it is, at the node of a branch nearest to the arc length `s` (m), with a new handle of
/// this name, which can then be moved and released.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_session_hold(
    session: WireloomSession,
    branch: *const c_char,
    s: f64,
    handle: *const c_char,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let branch = pointers::text(branch, "branch")?.to_owned();
        let handle = pointers::text(handle, "handle")?.to_owned();
        ask(session, move |session| session.hold(&branch, s, &handle))
    })
}

/// Releases a constraint that acts.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_session_release(
    session: WireloomSession,
    constraint: *const c_char,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let name = pointers::text(constraint, "constraint")?.to_owned();
        ask(session, move |session| session.release(&name))
    })
}

/// Drives a joint of a mechanism, MECHANISM/JOINT or JOINT, to a value in rad or m, along its arc.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_session_drive(
    session: WireloomSession,
    joint: *const c_char,
    value: f64,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let joint = pointers::text(joint, "joint")?.to_owned();
        ask(session, move |session| session.drive(&joint, value))
    })
}

/// Moves a body of the surroundings to a pose, in as many increments as the way needs; `position` and `orientation` as
/// in wireloom_session_move.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_session_move_body(
    session: WireloomSession,
    body: *const c_char,
    position: *const f64,
    orientation: *const f64,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let name = pointers::text(body, "body")?.to_owned();
        let goal = goal(position, orientation)?;
        ask(session, move |session| session.move_obstacle(&name, &goal))
    })
}

/// Sets the value of a key as wireloom_scenario_set does, and carries out all steps again, with those by hand. So a
/// joint gets another model: "joints.J.model", "\"fused\"".
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_session_set(
    session: WireloomSession,
    key: *const c_char,
    json: *const c_char,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let key = pointers::text(key, "key")?.to_owned();
        let value = value_of(&key, pointers::text(json, "json")?)?;
        ask(session, move |session| {
            session.set(&key, &value).map_err(|error| match error {
                SessionError::Key { text, fault } => not_set(&text, &value, &fault),
                error => error.into(),
            })
        })
    })
}

/// Takes the last operation back, up to 100 of them.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_session_undo(session: WireloomSession, error: *mut WireloomError) -> WireloomCode {
    call(error, || ask(session, Session::undo))
}

/// The scenario as TOML, with all that was done by hand as its steps.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_session_text(
    session: WireloomSession,
    text: *mut WireloomText,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        pointers::place(text, "text")?;
        text::hand_over(ask(session, |session| session.text())?.into_bytes(), text)
    })
}

/// Frees a session.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_session_free(session: WireloomSession) -> WireloomCode {
    call(std::ptr::null_mut(), || handles::free::<Kept>(session.id, WHAT))
}
