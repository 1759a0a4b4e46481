//! A run between two increments: all that is needed to go on from there later, in another process, to the same bits.
//!
//! Checkpoints are made where every step begins and after every increment. There the minimiser forgets what it
//! remembers, in every run, whether anybody keeps the checkpoint or not: so a run that was taken up again walks the same way
//! as one that was never interrupted. Only clock times differ.

use crate::report::EventLog;
use crate::steps::plan::Plan;
use crate::steps::progress::{Control, Progress};
use serde::{Deserialize, Serialize};
use wireloom_core::conditions::Conditions;
use wireloom_core::equilibrium::{OperationResult, StepResult};
use wireloom_core::{Monitor, Network, State, Status, Vector};

/// States are the same where nothing is farther away than this fraction of the longest branch, and nothing turned by more than this (rad).
const SAME: f64 = 1e-4;

/// Where a run stands. What it is made of is no business of those who keep it: it may change from one version of the
/// program to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    pub(crate) conditions: Conditions,
    pub(crate) state: State,
    pub(crate) log: EventLog,
    /// The plan of the step; `None`: it has not begun.
    pub(crate) plan: Option<Plan>,
    /// What its operations came to so far.
    pub(crate) operations: Vec<OperationResult>,
    /// How far the harness moved in the last increment, m.
    pub(crate) pace: Option<f64>,
    pub(crate) step_index: usize,
    /// Increments of it that are done.
    pub(crate) increment: usize,
    /// Iterations, those of them that polished, and factorisations of the step so far.
    pub(crate) work: (usize, usize, usize),
    /// Time spent in the step so far, s.
    pub(crate) seconds: f64,
    pub(crate) status: Status,
    pub(crate) notes: Vec<String>,
    /// Results kept so far.
    pub(crate) kept: usize,
}

impl Checkpoint {
    /// How many results the run had kept.
    pub fn kept(&self) -> usize {
        self.kept
    }

    /// Where the nodes of the network are, m.
    pub fn points(&self) -> &[Vector] {
        &self.state.points
    }

    /// Whether nothing has happened yet but that a balanced start was found.
    pub fn is_balanced_start(&self) -> bool {
        // What is said before the first step is that its start was not balanced.
        (self.step_index, self.increment) == (0, 0) && self.plan.is_none() && self.notes.is_empty()
    }

    /// Whether the state of a checkpoint of the same network is that of this one, but for what a minimiser leaves.
    pub fn is_same_state(&self, other: &Checkpoint, network: &Network) -> bool {
        let length = network.branches.iter().map(|branch| branch.rod.mesh().length()).fold(0.0, f64::max);
        let (one, other) = (&self.state, &other.state);
        let mut moves = one.points.iter().zip(&other.points).map(|(a, b)| (a - b).norm() / length);
        let mut turns = one.frames.iter().zip(&other.frames).map(|(a, b)| a.angle_to(b));
        moves.all(|fraction| fraction <= SAME) && turns.all(|angle| angle <= SAME)
    }

    /// Whether it can be one of this network.
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
            && (conditions.load_factors.len(), conditions.sliding.len()) == (network.loads.len(), network.slides.len())
    }
}

/// A run that is taken up again.
#[derive(Clone, Debug, PartialEq)]
pub struct Resumed {
    /// Where it stood.
    pub checkpoint: Checkpoint,
    /// The results it had kept: [`Checkpoint::kept`] of them.
    pub steps: Vec<StepResult>,
}

/// Who watches a run.
pub trait Observer {
    /// An increment has ended; `kept`: its end is part of the result, whatever comes.
    fn increment(&mut self, progress: &Progress, end: &StepResult, kept: bool) -> Control;

    /// From here the run can be taken up again.
    fn checkpoint(&mut self, _: &Checkpoint) {}

    /// Asked for once, before anything is computed: through it the run can be stopped at any time, and its iterations seen. An increment
    /// that was stopped is no part of the result.
    fn monitor(&self) -> Monitor {
        Monitor::default()
    }
}

/// Watches increments only.
pub struct Watching<'a>(
    /// Sees each of them.
    pub &'a mut dyn FnMut(&Progress, &StepResult) -> Control,
);

impl Observer for Watching<'_> {
    fn increment(&mut self, progress: &Progress, end: &StepResult, _: bool) -> Control {
        (self.0)(progress, end)
    }
}
