//! Checkpoint of a run: all data needed to continue it later, in another process, to the same bits.
//!
//! Checkpoints are made at the beginning of every step and after every increment. There the minimiser clears its memory
//! in every run, whether the checkpoint is kept or not. So a resumed run has the same results as an uninterrupted one,
//! except for times.

use crate::report::EventLog;
use crate::report::discretisation::NodalErrors;
use crate::report::time_error::TimeError;
use crate::steps::guide::Guide;
use crate::steps::plan::Plan;
use crate::steps::progress::{Control, Progress};
use serde::{Deserialize, Serialize};
use wireloom_core::conditions::Conditions;
use wireloom_core::equilibrium::{OperationResult, StepResult};
use wireloom_core::{Monitor, Network, State, Status, Vector};

/// Largest difference of equal states: move as a fraction of the longest branch, and turn (rad).
const SAME: f64 = 1e-4;

/// Position and state of a run. Its contents are private and may change between versions of the program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    pub(crate) conditions: Conditions,
    pub(crate) state: State,
    pub(crate) log: EventLog,
    /// Plan of the step; `None` before it begins.
    pub(crate) plan: Option<Plan>,
    /// Results so far of the operations of the step.
    pub(crate) operations: Vec<OperationResult>,
    /// Errors that the parts of time up to here leave, by branch.
    pub(crate) time_errors: Vec<TimeError>,
    /// Largest move of a point in the last increment without a jump, m; `None` where any motion may follow.
    pub(crate) previous_move: Option<f64>,
    pub(crate) step_index: usize,
    /// Number of increments of the step that are done.
    pub(crate) increment: usize,
    /// Iterations, polishing iterations, and factorisations of the step so far.
    pub(crate) work: (usize, usize, usize),
    /// Computing time of the step so far, s.
    pub(crate) seconds: f64,
    /// Status of the run so far; before the first increment that of the initial equilibrium.
    pub(crate) status: Status,
    pub(crate) notes: Vec<String>,
    /// Number of results kept so far.
    pub(crate) kept: usize,
}

impl Checkpoint {
    /// Number of results that the run has kept.
    pub fn kept(&self) -> usize {
        self.kept
    }

    /// Positions of the points of the network, m.
    pub fn points(&self) -> &[Vector] {
        &self.state.points
    }

    /// State of the harness.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Whether it is the initial equilibrium, before any step.
    pub fn is_balanced_start(&self) -> bool {
        let is_start = (self.step_index, self.increment) == (0, 0) && self.plan.is_none();
        is_start && self.status == Status::Converged
    }

    /// Whether another checkpoint of the same network has the same state, up to the tolerance of a minimiser.
    pub fn is_same_state(&self, other: &Checkpoint, network: &Network) -> bool {
        let length = network.branches.iter().map(|branch| branch.rod.mesh().length()).fold(0.0, f64::max);
        let (one, other) = (&self.state, &other.state);
        let mut moves = one.points.iter().zip(&other.points).map(|(a, b)| (a - b).norm() / length);
        let mut turns = one.frames.iter().zip(&other.frames).map(|(a, b)| a.angle_to(b));
        moves.all(|fraction| fraction <= SAME) && turns.all(|angle| angle <= SAME)
    }

    /// Whether its dimensions are those of this network.
    pub fn fits(&self, network: &Network) -> bool {
        let (state, conditions) = (&self.state, &self.conditions);
        (state.points.len(), state.compensation.len(), state.rest_lengths.len())
            == (network.points, network.points, network.points)
            && (state.frames.len(), state.coupling_lengths.len()) == (network.frames, network.frames)
            && (conditions.active.len(), conditions.targets.len())
                == (network.constraints.len(), network.constraints.len())
            && conditions.constraints.len() == network.constraints.len()
            && network.constraints.iter().zip(&conditions.constraints).all(|(constraint, own)| {
                let count = constraint.residuals.len();
                (own.multipliers.len(), own.penalties.len()) == (count, count)
                    && own.beside.len() + 1 == constraint.stations.len().max(1)
                    && own.memory.len() == constraint.model.memory().len()
            })
            && (conditions.rods.len(), self.time_errors.len()) == (network.branches.len(), network.branches.len())
            && network.branches.iter().zip(&conditions.rods).all(|(b, own)| own.memory.len() == b.rod.memory().len())
            && conditions.joints.len() == network.joints.len()
            && network.joints.iter().zip(&conditions.joints).all(|(joint, own)| own.fits(joint))
            && (conditions.load_factors.len(), conditions.sliding.len()) == (network.loads.len(), network.slides.len())
            && conditions.temperatures.len() == network.branches.len()
            && conditions.mechanisms.len() == network.mechanisms.len()
            && network.mechanisms.iter().zip(&conditions.mechanisms).all(|(own, values)| own.freedoms() == values.len())
    }
}

/// A run to resume.
#[derive(Clone, Debug, PartialEq)]
pub struct Resumed {
    /// Checkpoint to continue from.
    pub checkpoint: Checkpoint,
    /// Results kept by then: [`Checkpoint::kept`] of them.
    pub steps: Vec<StepResult>,
}

/// Observer of a run.
pub trait Observer {
    /// Called at the end of an increment; `kept`: its result will be part of the run in any case.
    fn increment(&mut self, progress: &Progress, end: &StepResult, kept: bool) -> Control;

    /// Called before [`Self::increment`] with the state at its end, and the estimated discretisation errors of all
    /// branches there.
    fn state(&mut self, _: &State, _: &[NodalErrors]) {}

    /// Called with a checkpoint from which the run can be resumed.
    fn checkpoint(&mut self, _: &Checkpoint) {}

    /// Monitor of the run, requested once at its beginning: it can stop the run at any time, and shows its iterations.
    /// An increment that was stopped is not part of the result.
    fn monitor(&self) -> Monitor {
        Monitor::default()
    }

    /// Equilibria near which those of the run are searched for, requested once at its beginning.
    fn guide(&self) -> Option<Guide> {
        None
    }
}

/// Observer of increments only.
pub struct IncrementObserver<'a>(
    /// Called at the end of each increment.
    pub &'a mut dyn FnMut(&Progress, &StepResult) -> Control,
);

impl Observer for IncrementObserver<'_> {
    fn increment(&mut self, progress: &Progress, end: &StepResult, _: bool) -> Control {
        (self.0)(progress, end)
    }
}
