//! Convergence monitor of the minimisers. The final grade of a state is given by [`crate::steps::certificate`].

use wireloom_core::minimiser::Stop;
use wireloom_core::status::Status;

/// Turn (rad) of the last step above which a state in balance is refined: the energy may be flat there.
const LAST_TURN: f64 = 1e-3;
/// Largest number of refinement steps.
const REFINEMENTS: usize = 3;
/// A residual above this fraction of the least one is no progress if the energy does not decrease visibly.
pub(crate) const PROGRESS: f64 = 0.5;

/// Decision of the convergence monitor after an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Termination {
    /// Another step.
    Continue,
    /// Another step, although the state is in balance: the last step turned a frame far.
    Refine,
    /// No further step.
    Stop(Status),
}

/// Convergence monitor of a minimiser's iterations.
pub(crate) struct ConvergenceMonitor {
    stop: Stop,
    /// Number of iterations without progress at round-off after which the minimiser has stalled.
    patience: usize,
    stalled: usize,
    refined: usize,
    /// Largest turn (rad) of any frame in the last step.
    last_turn: f64,
    /// Residual of the present state.
    pub residual: f64,
    /// Least residual so far.
    least: f64,
}

impl ConvergenceMonitor {
    /// Monitor without a residual.
    pub fn new(stop: &Stop, patience: usize) -> Self {
        let (residual, least) = (f64::INFINITY, f64::INFINITY);
        Self { stop: *stop, patience, stalled: 0, refined: 0, last_turn: 0.0, residual, least }
    }

    /// Begins with the residual of the first state.
    pub fn begin(&mut self, residual: f64) {
        (self.residual, self.least) = (residual, residual);
    }

    /// Decision after this number of iterations.
    pub fn termination(&mut self, iterations: usize) -> Termination {
        let (used_up, stalled) = (iterations >= self.stop.max_iterations, self.stalled >= self.patience);
        let balanced = self.residual <= self.stop.force_tolerance;
        match () {
            () if !self.residual.is_finite() => Termination::Stop(Status::Failed),
            () if balanced
                && (self.last_turn <= LAST_TURN || self.refined == REFINEMENTS || self.stalled > 0 || used_up) =>
            {
                Termination::Stop(Status::Converged)
            }
            () if stalled => Termination::Stop(Status::Stalled),
            () if used_up => Termination::Stop(Status::IterationLimit),
            () if balanced => {
                self.refined += 1;
                Termination::Refine
            }
            () => Termination::Continue,
        }
    }

    /// Records a step: its largest turn (rad), whether it lowered the energy visibly (by more than round-off), and the
    /// residual after it.
    pub fn moved(&mut self, turn: f64, visible: bool, residual: f64) {
        self.stalled = if !visible && residual > PROGRESS * self.least { self.stalled + 1 } else { 0 };
        self.last_turn = turn;
        self.residual = residual;
        self.least = self.least.min(residual);
    }

    /// Records that no step lowers the energy by more than round-off.
    pub fn stall(&mut self) {
        self.stalled = self.patience;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn monitor() -> ConvergenceMonitor {
        let stop = Stop { force_tolerance: 1e-8, max_iterations: 10 };
        ConvergenceMonitor::new(&stop, 2)
    }

    #[test]
    fn a_state_in_balance_that_still_turns_is_refined_so_many_times() {
        let mut monitor = monitor();
        monitor.begin(1.0);
        assert_eq!(monitor.termination(0), Termination::Continue);
        for iteration in 1..=3 {
            monitor.moved(0.1, true, 1e-9);
            assert_eq!(monitor.termination(iteration), Termination::Refine);
        }
        assert_eq!(monitor.termination(4), Termination::Stop(Status::Converged));
        monitor.refined = 0;
        monitor.moved(1e-4, true, 1e-9);
        assert_eq!(monitor.termination(5), Termination::Stop(Status::Converged));
    }

    #[test]
    fn a_state_stalls_where_neither_energy_nor_forces_decrease() {
        let mut monitor = monitor();
        monitor.begin(1.0);
        monitor.moved(0.1, false, 0.4);
        assert_eq!(monitor.termination(1), Termination::Continue);
        // A visible decrease of the energy is progress, although the forces grow.
        monitor.moved(0.1, true, 0.5);
        // The least residual so far counts, not the last one.
        monitor.moved(0.1, false, 0.21);
        assert_eq!(monitor.termination(3), Termination::Continue);
        monitor.moved(0.1, false, 0.2);
        assert_eq!(monitor.termination(4), Termination::Stop(Status::Stalled));
    }

    #[test]
    fn iterations_are_limited_and_a_residual_that_is_nan_fails() {
        let mut monitor = monitor();
        monitor.begin(1.0);
        assert_eq!(monitor.termination(10), Termination::Stop(Status::IterationLimit));
        monitor.moved(0.1, true, f64::NAN);
        assert_eq!(monitor.termination(2), Termination::Stop(Status::Failed));
    }
}
