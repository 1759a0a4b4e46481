//! State of a run: the problem with its conditions, the equilibrium reached last, and the work done so far.
//!
//! [`super::run`] walks through steps and increments, [`super::increment`] advances by one increment,
//! [`super::equilibrium`] solves under given conditions, [`super::step_result`] reports.

use crate::report::discretisation::NodalErrors;
use crate::report::driven::Driven;
use crate::report::time_error::TimeError;
use crate::report::{EventLog, Occurrence, TwistMonitor};
use crate::start::layout;
use crate::steps::certificate::{Certifier, Grade};
use crate::steps::checkpoint::Checkpoint;
use crate::steps::guide::Guide;
use crate::steps::plan::Plan;
use crate::steps::stability::Inspection;
use wireloom_core::conditions::Conditions;
use wireloom_core::equilibrium::{OperationResult, Outcome, PartFamily, PartFault, Run};
use wireloom_core::minimiser::{Minimiser, Stop};
use wireloom_core::problem::Problem;
use wireloom_core::status::Status;
use wireloom_core::steps::{Schedule, Step};
use wireloom_core::{Monitor, Network, State};

/// The run of a schedule.
pub(crate) struct Driver<'n, 'm> {
    pub(crate) problem: Problem<'n>,
    pub(crate) minimiser: &'m mut dyn Minimiser,
    pub(crate) stop: Stop,
    pub(crate) certifier: Certifier,
    pub(crate) state: State,
    /// State before the part of an increment in progress.
    pub(super) before: State,
    /// State at the beginning of the increment.
    pub(super) began: State,
    pub(super) iterations: usize,
    /// Iterations on the CPU that finish the single-precision result of a GPU; see
    /// [`wireloom_core::minimiser::Report`].
    pub(super) polish: usize,
    pub(super) factorisations: usize,
    pub(super) residual: f64,
    /// Whether the remaining forces exceed the tolerance, but by round-off only.
    pub(super) round_off: bool,
    /// Inspection of the second derivatives at the state, if they were evaluated there.
    pub(super) inspection: Option<Inspection>,
    /// Largest violation of the equations of constraints, in units of their scales.
    pub(super) violation: Option<f64>,
    /// Rod, joint, constraint or minimiser that cannot continue, and the reason.
    pub(crate) fault: Option<(PartFamily, usize, String)>,
    /// Whether the initial equilibrium is being searched for: nothing slides then.
    pub(crate) starting: bool,
    /// Whether the initial equilibrium was found without obstacles first.
    pub(super) started_without_obstacles: bool,
    pub(super) log: EventLog,
    /// Monitor of the twist; none before the initial equilibrium, whose twist is not prescribed.
    pub(super) twist_monitor: Option<TwistMonitor>,
    /// Largest number of turns that a constraint makes in the current step.
    pub(super) prescribed_turns: f64,
    /// Twist that the present state has lost.
    pub(super) lost_twist: Vec<Occurrence>,
    /// Whether the energy was convex wherever the minimiser went in the current increment.
    pub(super) convex: bool,
    /// Smallest part of the current increment that was tried in one piece.
    pub(super) smallest_part: f64,
    /// Largest displacement of a point in the last increment without a jump, m; `None` in the first increment of a step
    /// that releases a constraint, or adds one that does not lead the cable from where it is: any motion may follow.
    pub(super) previous_move: Option<f64>,
    /// Constraints and bodies that were driven into each other in the last increment.
    pub(super) driven: Vec<Driven>,
    /// Estimated discretisation errors of the last result, by branch.
    pub(super) errors: Vec<NodalErrors>,
    /// Errors that the parts of time up to here leave, by branch.
    pub(super) time_errors: Vec<TimeError>,
    /// Whether all clearances are kept, not only the required ones.
    pub(super) all_clearances: bool,
    /// Results so far of the operations of the current step.
    pub(super) operations: Vec<OperationResult>,
    /// Equilibria near which those of the increments are searched for.
    pub(super) guide: Option<Guide>,
}

/// Position of a checkpoint in its run, and the run's results so far.
pub(crate) struct RunPosition {
    pub(super) plan: Option<Plan>,
    pub(super) step_index: usize,
    pub(super) increment: usize,
    pub(super) seconds: f64,
    pub(super) status: Status,
    pub(super) notes: Vec<String>,
    pub(super) kept: usize,
}

/// Whether an increment may be followed by another one.
pub(crate) fn is_balanced(status: impl Into<Status>) -> bool {
    status.into().is_balanced()
}

/// Remark on an initial equilibrium that was not found.
pub(crate) fn unbalanced_start_note(grade: Grade) -> String {
    format!("the start was not balanced: {}", grade.status().word())
}

/// Run without results, of which no increment has ended.
pub(super) fn empty_run(schedule: &Schedule) -> Run {
    Run {
        scenario: schedule.scenario.clone(),
        outcome: Outcome::Graded(Status::Interrupted),
        notes: Vec::new(),
        events: Vec::new(),
        steps: Vec::new(),
        clearances: Vec::new(),
        requirements: Vec::new(),
        plugins: Vec::new(),
        identities: schedule.identities.clone(),
        drawn_start: None,
        sensitivities: Vec::new(),
    }
}

impl<'n, 'm> Driver<'n, 'm> {
    fn new(
        network: &'n Network,
        minimiser: &'m mut dyn Minimiser,
        stop: &Stop,
        state: State,
        conditions: Conditions,
        monitor: &Monitor,
    ) -> Self {
        let mut problem = Problem::new(network, conditions);
        problem.monitor = monitor.clone();
        Self {
            problem,
            minimiser,
            stop: *stop,
            certifier: Certifier::new(network),
            before: state.clone(),
            began: state.clone(),
            state,
            iterations: 0,
            polish: 0,
            factorisations: 0,
            residual: f64::INFINITY,
            round_off: false,
            inspection: None,
            violation: None,
            fault: None,
            starting: true,
            started_without_obstacles: false,
            log: EventLog::default(),
            twist_monitor: None,
            prescribed_turns: 0.0,
            lost_twist: Vec::new(),
            convex: true,
            smallest_part: 1.0,
            previous_move: None,
            driven: Vec::new(),
            errors: Vec::new(),
            time_errors: vec![TimeError::default(); network.branches.len()],
            all_clearances: false,
            operations: Vec::new(),
            guide: None,
        }
    }

    /// Driver at the initial shape, which is not in balance.
    pub(crate) fn at_start(
        network: &'n Network,
        minimiser: &'m mut dyn Minimiser,
        stop: &Stop,
        schedule: &Schedule,
        monitor: &Monitor,
    ) -> Self {
        let state = layout::place(network, schedule);
        let conditions =
            Conditions { rotation: schedule.rotation, ..Conditions::new(network, schedule.gravity, &state) };
        let mut driver = Self::new(network, minimiser, stop, state, conditions, monitor);
        driver.problem.allow_overlaps(&driver.state);
        driver
    }

    /// Driver at a checkpoint, and the checkpoint's position in its run.
    pub(crate) fn at_checkpoint(
        network: &'n Network,
        minimiser: &'m mut dyn Minimiser,
        stop: &Stop,
        checkpoint: Checkpoint,
        monitor: &Monitor,
    ) -> (Self, RunPosition) {
        let Checkpoint {
            conditions,
            state,
            log,
            plan,
            operations,
            time_errors,
            previous_move,
            step_index,
            increment,
            work,
            seconds,
            status,
            notes,
            kept,
        } = checkpoint;
        let mut driver = Driver::new(network, minimiser, stop, state, conditions, monitor);
        (driver.iterations, driver.polish, driver.factorisations) = work;
        (driver.log, driver.operations, driver.previous_move, driver.starting) =
            (log, operations, previous_move, false);
        driver.time_errors = time_errors;
        (driver, RunPosition { plan, step_index, increment, seconds, status, notes, kept })
    }

    /// Whether the computation ends: a part cannot continue, or a stop was requested.
    pub(crate) fn is_over(&self) -> bool {
        self.fault.is_some() || self.problem.monitor.is_stopped()
    }

    /// Checkpoint of a run.
    pub(super) fn checkpoint(&self, run: &Run, done: (usize, usize), plan: Option<&Plan>, seconds: f64) -> Checkpoint {
        let (notes, kept) = (run.notes.clone(), run.steps.len());
        Checkpoint { status: run.status(), notes, kept, ..self.snapshot(done, plan, seconds) }
    }

    /// Checkpoint without the run's results. Every field of the driver is named, so that a new one cannot be forgotten.
    pub(crate) fn snapshot(&self, done: (usize, usize), plan: Option<&Plan>, seconds: f64) -> Checkpoint {
        let Self {
            problem,
            state,
            iterations,
            polish,
            factorisations,
            log,
            operations,
            time_errors,
            previous_move,
            // Recomputed by the next increment, or the same in every run:
            minimiser: _,
            stop: _,
            certifier: _,
            before: _,
            began: _,
            residual: _,
            round_off: _,
            inspection: _,
            violation: _,
            fault: _,
            starting: _,
            started_without_obstacles: _,
            twist_monitor: _,
            prescribed_turns: _,
            lost_twist: _,
            convex: _,
            smallest_part: _,
            driven: _,
            errors: _,
            all_clearances: _,
            guide: _,
        } = self;
        Checkpoint {
            conditions: problem.conditions().clone(),
            state: state.clone(),
            log: log.clone(),
            plan: plan.cloned(),
            operations: operations.clone(),
            time_errors: time_errors.clone(),
            previous_move: *previous_move,
            step_index: done.0,
            increment: done.1,
            work: (*iterations, *polish, *factorisations),
            seconds,
            status: Status::Converged,
            notes: Vec::new(),
            kept: 0,
        }
    }

    /// Grades the present state.
    pub(crate) fn certify(&mut self, claimed: impl Into<Status>) -> Grade {
        let certificate = self.certifier.certify(&mut self.problem, &self.state, &self.stop, claimed);
        self.residual = certificate.residual;
        self.round_off = certificate.round_off;
        self.violation = certificate.constraint.map(|worst| worst.violation);
        // A state in balance fails if its twist is not the prescribed one.
        if self.lost_twist.is_empty() || !is_balanced(certificate.grade) { certificate.grade } else { Grade::FAILED }
    }

    /// The fault that ended the run, with the name of its part.
    pub(crate) fn part_fault(&self, step: &Step, increment: usize) -> Option<PartFault> {
        let (family, index, message) = self.fault.clone()?;
        let network = self.problem.network;
        let (name, kind) = match family {
            PartFamily::Constraint => {
                (network.constraints[index].name.as_str(), network.constraints[index].kind.as_str())
            }
            PartFamily::Joint => (network.joints[index].name.as_str(), network.joints[index].kind.as_str()),
            PartFamily::Rod => (network.branches[index].name.as_str(), network.branches[index].kind.as_str()),
            PartFamily::Minimiser => (self.minimiser.name(), self.minimiser.name()),
        };
        let (name, kind, step) = (name.to_owned(), kind.to_owned(), step.name.clone());
        Some(PartFault { family, name, kind, step, increment, message })
    }
}
