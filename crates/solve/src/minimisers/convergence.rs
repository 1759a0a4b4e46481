//! When a minimiser is done: what all of them go by. Their own word counts for little: the state is graded by
//! [`crate::certificate`].

use wireloom_core::minimiser::Stop;
use wireloom_core::status::Status;

/// Turn (rad) of the last step above which a state in balance to the tolerance is refined: the energy may be flat there.
const LAST_TURN: f64 = 1e-3;
/// Steps that refine such a state.
const REFINEMENTS: usize = 3;
/// A residual above this fraction of the one before is no progress where the energy shows none.
pub(crate) const PROGRESS: f64 = 0.5;

/// Decision of the convergence monitor after an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Termination {
    /// Another step.
    Continue,
    /// Another step, though the state is in balance: the last one still turned much.
    Refine,
    /// No more steps.
    Stop(Status),
}

/// Convergence monitor: follows the residuals of a minimiser's iterations.
pub(crate) struct ConvergenceMonitor {
    stop: Stop,
    /// Iterations without progress at round-off after which the state is called stalled.
    patience: usize,
    stalled: usize,
    refined: usize,
    /// Largest turn (rad) of any frame in the last step.
    last_turn: f64,
    /// The residual of the state at hand.
    pub residual: f64,
    /// The least so far.
    least: f64,
}

impl ConvergenceMonitor {
    /// Monitor before the first residual.
    pub fn new(stop: &Stop, patience: usize) -> Self {
        let (residual, least) = (f64::INFINITY, f64::INFINITY);
        Self { stop: *stop, patience, stalled: 0, refined: 0, last_turn: 0.0, residual, least }
    }

    /// Takes the residual of the first state.
    pub fn begin(&mut self, residual: f64) {
        (self.residual, self.least) = (residual, residual);
    }

    /// Decision after so many iterations.
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

    /// Takes the largest turn (rad) of a step, whether it lowered the energy visibly (by more than round-off), and the
    /// residual after it.
    pub fn moved(&mut self, turn: f64, visible: bool, residual: f64) {
        self.stalled = if !visible && residual > PROGRESS * self.least { self.stalled + 1 } else { 0 };
        self.last_turn = turn;
        self.residual = residual;
        self.least = self.least.min(residual);
    }

    /// Notes that no step lowers the energy by more than round-off.
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
    fn a_state_stalls_where_neither_energy_nor_forces_get_less() {
        let mut monitor = monitor();
        monitor.begin(1.0);
        monitor.moved(0.1, false, 0.4);
        assert_eq!(monitor.termination(1), Termination::Continue);
        // What the energy shows is progress, though the forces grow.
        monitor.moved(0.1, true, 0.5);
        // The least so far counts, not the last.
        monitor.moved(0.1, false, 0.21);
        assert_eq!(monitor.termination(3), Termination::Continue);
        monitor.moved(0.1, false, 0.2);
        assert_eq!(monitor.termination(4), Termination::Stop(Status::Stalled));
    }

    #[test]
    fn iterations_are_counted_and_what_is_no_number_has_failed() {
        let mut monitor = monitor();
        monitor.begin(1.0);
        assert_eq!(monitor.termination(10), Termination::Stop(Status::IterationLimit));
        monitor.moved(0.1, true, f64::NAN);
        assert_eq!(monitor.termination(2), Termination::Stop(Status::Failed));
    }
}
