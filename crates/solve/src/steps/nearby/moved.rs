//! Equilibria with one constraint elsewhere.

use super::{Kept, Nearby, NotFound, Settled, has_history};
use crate::report::EventLog;
use crate::steps::checkpoint::Checkpoint;
use wireloom_core::conditions::Partner;
use wireloom_core::minimiser::Stop;
use wireloom_core::{Moment, Network, Pose, Problem, Vector};

/// The equilibrium at a checkpoint, and those near it with one constraint moved. Everything else stays, history
/// included.
pub struct Moved<'n> {
    kept: Kept<'n>,
    network: &'n Network,
    stop: Stop,
    /// Index of the step; `None` before the first one.
    step: Option<usize>,
    /// Whether it is the end of a step.
    ends_step: bool,
}

impl<'n> Moved<'n> {
    /// Finds the equilibrium at a checkpoint more exactly, and keeps its factor.
    ///
    /// # Errors
    /// If it is no equilibrium that has neighbours.
    pub fn new(network: &'n Network, stop: &Stop, checkpoint: &Checkpoint) -> Result<Self, NotFound> {
        let (begun, increments) = checkpoint.done();
        let ends_step = increments == 0;
        let step = if ends_step { begun.checked_sub(1) } else { Some(begun) };
        let checkpoint = Box::new(Checkpoint { log: EventLog::default(), ..checkpoint.clone() });
        Ok(Self { kept: Kept::new(network, checkpoint)?, network, stop: *stop, step, ends_step })
    }

    /// The equilibrium with the target of a constraint moved by `by` (m), with its sheet.
    ///
    /// # Errors
    /// If there is none nearby.
    pub fn find(&mut self, constraint: usize, by: Vector) -> Result<Nearby, NotFound> {
        let mut problem = Problem::new(self.network, self.kept.checkpoint.conditions.clone());
        let base = problem.conditions().constraints[constraint].base;
        problem.set_target(constraint, Pose { position: base.position + by, ..base });
        let mut state = self.kept.checkpoint.state.clone();
        let distance = self.kept.settle(&mut problem, &mut state)?;
        let moment = Moment { step: String::new(), step_index: self.step.unwrap_or(0), increment: 0 };
        Settled { problem, state, distance }.measured(&self.stop, moment, Some((self.step, self.ends_step)))
    }

    /// Whether the equilibrium depends on its history: friction, slip, or a part that remembers.
    pub fn has_history(&self) -> bool {
        has_history(self.network, &self.kept.checkpoint.conditions)
    }

    /// Name of a branch and what it touches at a contact point.
    pub fn words(&self, touching: (u32, Partner)) -> String {
        self.kept.words(touching)
    }
}
