//! A session: a harness whose constraints are moved one by one, each time to a new equilibrium. It lives in a thread
//! of its own.

use crate::failure::Failure;
use crate::result::Step;
use crate::source::{Loaded, Source};
use crate::worker::{answer, caught, spawn};
use pyo3::prelude::*;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Mutex, PoisonError};
use wireloom::StepResult;
use wireloom::geometry::{Pose, Rotation, Vector, columns, shortest};
use wireloom::harness::{Network, Schedule};
use wireloom::result::Status;
use wireloom::scenario::Built;
use wireloom::scenario::record::rotation;
use wireloom::session::drag::{Goal, MAX_DISTANCE, MAX_MOTION, approach, quaternion, step_to, turning};
use wireloom::session::{Checkpoint, Ended, InteractiveDriver, Interruption, Monitor};

/// The harness of a session.
struct Live {
    network: Network,
    driver: InteractiveDriver,
    at: Checkpoint,
    /// The equilibrium.
    end: StepResult,
    /// The constraint that is being moved; its step is open.
    moving: Option<usize>,
}

fn request(message: impl Into<String>, help: impl Into<String>) -> Failure {
    Failure::Request(message.into(), help.into())
}

fn interruption(interruption: Interruption) -> Failure {
    match interruption {
        Interruption::Stopped => request("the motion was stopped", "repeat it"),
        Interruption::Fault(fault) => Failure::Part(fault.to_string()),
    }
}

/// Whether another increment may follow.
fn is_balanced(ended: &Ended) -> bool {
    matches!(ended.end.status, Status::Converged | Status::Stalled)
}

impl Live {
    /// Finds the initial equilibrium and carries out the steps of the scenario.
    fn open(source: &Source, monitor: &Monitor) -> Result<Self, Failure> {
        let Loaded { built, .. } = source.load_with_mesh(monitor)?;
        let Built { network, coarse, schedule, minimiser, stop, .. } = built;
        let mut driver = InteractiveDriver::new(minimiser, stop, schedule.clearances, monitor.clone());
        let start = driver.start(&network, coarse.as_ref(), &schedule).map_err(interruption)?;
        let mut live = Self { network, driver, at: start.checkpoint, end: start.end, moving: None };
        live.carry_out(&schedule)?;
        Ok(live)
    }

    fn carry_out(&mut self, schedule: &Schedule) -> Result<(), Failure> {
        while let Some(step) = schedule.steps.get(self.at.done().0) {
            let ended = self.driver.advance(&self.network, step, &self.at).map_err(interruption)?;
            self.take(ended)?;
        }
        Ok(())
    }

    /// An equilibrium becomes the current one.
    fn take(&mut self, ended: Ended) -> Result<(), Failure> {
        if !is_balanced(&ended) {
            let message = format!("no equilibrium was found: {}", ended.end.status.word());
            return Err(request(message, "the harness is where it was; move in smaller steps, or elsewhere"));
        }
        (self.at, self.end) = (ended.checkpoint, ended.end);
        Ok(())
    }

    /// Index of an active constraint that can be moved.
    fn constraint(&self, name: &str) -> Result<usize, Failure> {
        let active = || (0..self.network.constraints.len()).filter(|f| self.at.acts(*f));
        let index = active().find(|f| self.network.constraints[*f].name == name).ok_or_else(|| {
            let names: Vec<&str> = active().map(|f| self.network.constraints[f].name.as_str()).collect();
            request(format!("no constraint \"{name}\" is active"), format!("active: {}", names.join(", ")))
        })?;
        if self.network.constraints[index].stations.is_empty() {
            let message = format!("\"{name}\" acts along a part of a branch and cannot be moved");
            return Err(request(message, "move another constraint"));
        }
        Ok(index)
    }

    /// The target and where the constraint is, both as its mechanism is drawn, or what is wrong with the target.
    fn goal(&self, index: usize, target: &Target) -> Result<(Goal, Pose), Failure> {
        let name = &self.network.constraints[index].name;
        let from = self.at.target(index).unwrap_or_else(Pose::identity);
        let Target { position, orientation, tangent } = *target;
        if let Some(to) = position {
            let total: f64 = self.network.branches.iter().map(|branch| branch.rod.mesh().length()).sum();
            let far = MAX_DISTANCE * total;
            let distance = (Vector::from(to) - from.position).norm();
            if distance.is_nan() || distance > far {
                let message = format!("{to:?} is not a valid position for \"{name}\"");
                return Err(request(message, format!("give a position within {far:.1} m of where it is")));
            }
        }
        let turned = match (orientation, tangent) {
            (None, None) => None,
            (Some(_), Some(_)) => {
                return Err(request("orientation and tangent are both given", "give one of them"));
            }
            (Some(q), None) => {
                let whole = q.iter().all(|x| x.is_finite()).then(|| rotation(q)).flatten();
                let finite = whole.filter(|q| q.coords.iter().all(|x| x.is_finite()));
                let help = "give a quaternion [w, x, y, z] that is not zero";
                Some(finite.ok_or_else(|| request(format!("{q:?} is not an orientation"), help))?)
            }
            (None, Some(d)) => Some(along(&from.orientation, d).ok_or_else(|| {
                request(format!("{d:?} is not a direction"), "give a vector [x, y, z] that is not zero")
            })?),
        };
        if turned.is_some() && turning(&self.network.constraints[index]).is_none() {
            let message = format!("\"{name}\" does not hold the orientation of the cable, so it cannot be turned");
            return Err(request(message, "use a constraint that holds position, tangent and twist"));
        }
        if position.is_none() && turned.is_none() {
            return Err(request(
                format!("the target of \"{name}\" is empty"),
                "give a position, an orientation, or both",
            ));
        }
        let goal = Goal { position, orientation: turned.map(|q| quaternion(&q)) };
        let body = self.at.body_under(&self.network, index);
        Ok((goal.on(&body), self.at.drawn_target(&self.network, index).unwrap_or(from)))
    }

    /// Moves a constraint, in as many increments as the way needs.
    fn move_to(&mut self, name: &str, target: &Target) -> Result<(), Failure> {
        let index = self.constraint(name)?;
        let (goal, mut from) = self.goal(index, target)?;
        if self.moving.is_some_and(|other| other != index) {
            self.end_motion();
        }
        let how = turning(&self.network.constraints[index]);
        let lengths = self.network.branches.iter().map(|branch| branch.rod.mesh().length());
        let reach = MAX_MOTION * lengths.fold(0.0, f64::max);
        let step_name = format!("move {name}");
        loop {
            let (passed, reached) = approach(&from, &goal, how, reach);
            let step = step_to(&step_name, index, &passed);
            let ended = self.driver.advance_open(&self.network, &step, &self.at).map_err(interruption)?;
            self.take(ended)?;
            self.moving = Some(index);
            if reached {
                return Ok(());
            }
            from = self.at.drawn_target(&self.network, index).unwrap_or(from);
        }
    }

    fn end_motion(&mut self) {
        if self.moving.take().is_some() {
            (self.at, _) = self.driver.end_step(&self.network, self.at.clone(), &mut self.end);
        }
    }
}

/// An orientation, turned by the shortest way so that its d3 has a direction.
fn along(from: &Rotation, direction: [f64; 3]) -> Option<Rotation> {
    let d = Vector::from(direction).try_normalize(0.0).filter(|d| d.iter().all(|x| x.is_finite()))?;
    Some(shortest(&columns(from)[2], &d) * from)
}

/// A target pose.
struct Target {
    position: Option<[f64; 3]>,
    orientation: Option<[f64; 4]>,
    tangent: Option<[f64; 3]>,
}

/// Work on the harness; returns whether the session goes on.
type Job = Box<dyn FnOnce(&mut Live) -> bool + Send>;

/// Handle of a session.
#[pyclass(frozen, module = "wireloom._wireloom")]
pub struct Session {
    jobs: Mutex<Option<Sender<Job>>>,
    monitor: Monitor,
}

impl Session {
    /// Asks the session's thread, and waits for the answer.
    fn ask<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Live) -> Result<T, Failure> + Send + 'static,
    ) -> PyResult<T> {
        let (sender, messages) = channel();
        let monitor = self.monitor.clone();
        let job: Job = Box::new(move |live| {
            // Ctrl-C has stopped an earlier motion.
            monitor.go_on();
            let done = caught(|| work(live)).flatten();
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
        let stopped_by = monitor.clone();
        spawn(move || {
            let opened = caught(|| Live::open(&source, &stopped_by)).flatten();
            let (done, live) = match opened {
                Ok(live) => (Ok(()), Some(live)),
                Err(failure) => (Err(failure), None),
            };
            if sender.send(done).is_err() {
                return;
            }
            // Whoever opens the session waits until this is gone.
            drop(sender);
            let Some(mut live) = live else { return };
            while let Ok(job) = queue.recv() {
                if !job(&mut live) {
                    return;
                }
            }
        })?;
        let session = Self { jobs: Mutex::new(Some(jobs)), monitor };
        session.wait(py, messages)?;
        Ok(session)
    }

    /// The current equilibrium.
    fn state(&self, py: Python<'_>) -> PyResult<Step> {
        self.ask(py, |live| Ok(Step::alone(live.end.clone())))
    }

    /// Names of the constraints that can be moved, and whether they can be turned.
    fn constraints(&self, py: Python<'_>) -> PyResult<Vec<(String, bool)>> {
        self.ask(py, |live| {
            let active = (0..live.network.constraints.len()).filter(|f| live.at.acts(*f));
            let own = active.map(|f| &live.network.constraints[f]).filter(|own| !own.stations.is_empty());
            Ok(own.map(|own| (own.name.clone(), turning(own).is_some())).collect())
        })
    }

    /// Moves a constraint to a pose; returns the new equilibrium.
    #[pyo3(name = "move")]
    fn move_to(
        &self,
        py: Python<'_>,
        name: String,
        position: Option<[f64; 3]>,
        orientation: Option<[f64; 4]>,
        tangent: Option<[f64; 3]>,
    ) -> PyResult<Step> {
        self.ask(py, move |live| {
            live.move_to(&name, &Target { position, orientation, tangent })?;
            Ok(Step::alone(live.end.clone()))
        })
    }

    /// Ends the session's thread; a motion that goes on is stopped.
    fn close(&self) {
        self.monitor.stop();
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner).take();
    }
}
