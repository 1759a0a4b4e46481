//! A session: a harness that is moved by hand, each time to a new equilibrium. It lives in a thread of its own.

use crate::failure::Failure;
use crate::parts;
use crate::result::Step;
use crate::source::Source;
use crate::worker::{answer, caught, spawn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Mutex, PoisonError};
use wireloom::geometry::{Rotation, Vector, columns, shortest};
use wireloom::session::drag::{Goal, quaternion};
use wireloom::session::{Monitor, Refusal, Session as Harness, SessionError};

/// Why a session of a scenario of this name could not do something.
fn failure(name: &str, error: SessionError) -> Failure {
    match error {
        SessionError::Refused { text, faults } => Failure::Refused { name: name.to_owned(), text, faults },
        SessionError::Key { fault, .. } => Failure::Key(fault),
        SessionError::Part(fault) => Failure::Part(fault.to_string()),
        error => {
            let Refusal { message, help } = error.into();
            Failure::Request(message, help)
        }
    }
}

/// Opens a session in the calling thread.
fn open(source: &Source, monitor: Monitor) -> Result<Harness, Failure> {
    source.refuse_plugins()?;
    Harness::open(&source.text, Box::new(source.files()), parts::registry(&source.parts)?, monitor)
        .map_err(|error| failure(&source.name, error))
}

/// The orientation of a target, of which at most one of both is given.
fn facing(
    harness: &Harness,
    constraint: &str,
    orientation: Option<[f64; 4]>,
    tangent: Option<[f64; 3]>,
) -> Result<Option<[f64; 4]>, SessionError> {
    let refused = |message: String, help: &str| SessionError::Value(Refusal::new(message, help));
    match (orientation, tangent) {
        (given, None) => Ok(given),
        (Some(_), Some(_)) => Err(refused("orientation and tangent are both given".to_owned(), "give one of them")),
        (None, Some(d)) => {
            let turned = along(&harness.target(constraint)?.orientation, d);
            let none = || refused(format!("{d:?} is not a direction"), "give a vector [x, y, z] that is not zero");
            Ok(Some(quaternion(&turned.ok_or_else(none)?)))
        }
    }
}

/// An orientation, turned by the shortest way so that its d3 has a direction.
fn along(from: &Rotation, direction: [f64; 3]) -> Option<Rotation> {
    let d = Vector::from(direction).try_normalize(0.0).filter(|d| d.iter().all(|x| x.is_finite()))?;
    Some(shortest(&columns(from)[2], &d) * from)
}

/// Work on the harness; returns whether the session goes on.
type Job = Box<dyn FnOnce(&mut Harness) -> bool + Send>;

/// Handle of a session.
#[pyclass(frozen, module = "wireloom._wireloom")]
pub struct Session {
    jobs: Mutex<Option<Sender<Job>>>,
    monitor: Monitor,
    /// Name of the scenario in diagnostics.
    name: String,
}

impl Session {
    /// Asks the session's thread, and waits for the answer.
    fn ask<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Harness) -> Result<T, SessionError> + Send + 'static,
    ) -> PyResult<T> {
        let (sender, messages) = channel();
        let (monitor, name) = (self.monitor.clone(), self.name.clone());
        let job: Job = Box::new(move |harness| {
            // Ctrl-C has stopped an earlier motion.
            monitor.go_on();
            let done = caught(|| work(harness).map_err(|error| failure(&name, error))).flatten();
            // After a panic the state is unknown.
            let goes_on = !matches!(done, Err(Failure::Internal(_)));
            // Nobody waits after the interpreter has gone.
            let _ = sender.send(done);
            goes_on
        });
        let jobs = self.jobs.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if jobs.is_none_or(|jobs| jobs.send(job).is_err()) {
            return Err(Failure::Closed.into());
        }
        self.wait(py, messages)
    }

    /// Does something, and returns the new equilibrium.
    fn go(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Harness) -> Result<(), SessionError> + Send + 'static,
    ) -> PyResult<Step> {
        self.ask(py, |harness| {
            work(harness)?;
            Ok(Step::alone(harness.end().clone()))
        })
    }

    fn wait<T: Send>(&self, py: Python<'_>, messages: Receiver<Result<T, Failure>>) -> PyResult<T> {
        let (answer, outcome) = answer(py, messages, &self.monitor);
        outcome?;
        Ok(answer.unwrap_or(Err(Failure::Closed))?)
    }
}

#[pymethods]
impl Session {
    #[new]
    fn new(py: Python<'_>, source: Source) -> PyResult<Self> {
        let monitor = Monitor::default();
        let (jobs, queue) = channel::<Job>();
        let (sender, messages) = channel();
        let (stopped_by, name) = (monitor.clone(), source.name.clone());
        spawn(move || {
            let opened = caught(|| open(&source, stopped_by)).flatten();
            let (done, harness) = match opened {
                Ok(harness) => (Ok(()), Some(harness)),
                Err(failure) => (Err(failure), None),
            };
            if sender.send(done).is_err() {
                return;
            }
            // Whoever opens the session waits until this is gone.
            drop(sender);
            let Some(mut harness) = harness else { return };
            while let Ok(job) = queue.recv() {
                if !job(&mut harness) {
                    return;
                }
            }
        })?;
        let session = Self { jobs: Mutex::new(Some(jobs)), monitor, name };
        session.wait(py, messages)?;
        Ok(session)
    }

    /// The current equilibrium.
    fn state(&self, py: Python<'_>) -> PyResult<Step> {
        self.go(py, |_| Ok(()))
    }

    /// Names of the constraints that can be moved, and whether they can be turned.
    fn constraints(&self, py: Python<'_>) -> PyResult<Vec<(String, bool)>> {
        self.ask(py, |harness| {
            Ok(harness.movable().into_iter().map(|(name, turns)| (name.to_owned(), turns)).collect())
        })
    }

    /// The text of the scenario, with what was done by hand.
    fn text(&self, py: Python<'_>) -> PyResult<String> {
        self.ask(py, |harness| harness.text())
    }

    /// Moves a constraint to a pose.
    #[pyo3(name = "move")]
    fn move_to(
        &self,
        py: Python<'_>,
        name: String,
        position: Option<[f64; 3]>,
        orientation: Option<[f64; 4]>,
        tangent: Option<[f64; 3]>,
    ) -> PyResult<Step> {
        self.go(py, move |harness| {
            let orientation = facing(harness, &name, orientation, tangent)?;
            harness.move_to(&name, &Goal { position, orientation })
        })
    }

    /// Takes hold of the cable with a new handle.
    fn hold(&self, py: Python<'_>, branch: String, s: f64, name: String) -> PyResult<Step> {
        self.go(py, move |harness| harness.hold(&branch, s, &name))
    }

    /// Releases a constraint.
    fn release(&self, py: Python<'_>, name: String) -> PyResult<Step> {
        self.go(py, move |harness| harness.release(&name))
    }

    /// Drives a joint of a mechanism to a value.
    fn drive(&self, py: Python<'_>, joint: String, value: f64) -> PyResult<Step> {
        self.go(py, move |harness| harness.drive(&joint, value))
    }

    /// Moves an obstacle to a pose.
    fn move_obstacle(
        &self,
        py: Python<'_>,
        name: String,
        position: Option<[f64; 3]>,
        orientation: Option<[f64; 4]>,
    ) -> PyResult<Step> {
        self.go(py, move |harness| harness.move_obstacle(&name, &Goal { position, orientation }))
    }

    /// Sets the value of a key, which is JSON, and carries out all steps again.
    fn set(&self, py: Python<'_>, key: String, json: &str) -> PyResult<Step> {
        let value = serde_json::from_str(json).map_err(|error| PyValueError::new_err(format!("not JSON: {error}")))?;
        self.go(py, move |harness| harness.set(&key, &value))
    }

    /// Takes the last operation back.
    fn undo(&self, py: Python<'_>) -> PyResult<Step> {
        self.go(py, Harness::undo)
    }

    /// Ends the session's thread; a motion that goes on is stopped.
    fn close(&self) {
        self.monitor.stop();
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner).take();
    }
}
