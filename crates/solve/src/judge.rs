//! When a minimiser is done: what all of them go by. Their own word counts for little: the state is graded by
//! [`crate::certificate`].

use wireloom_core::minimiser::{Status, Stop};

/// Turn (rad) of the last step above which a state in balance to the tolerance is not taken for resolved yet: it may be flat there.
const LAST_TURN: f64 = 1e-3;
/// Steps that such a state is given.
const POLISHES: usize = 3;
/// A residual above this share of the one before is no progress where the energy shows none.
pub(crate) const PROGRESS: f64 = 0.5;

/// What comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// A step.
    Step,
    /// A step, though the state is in balance: it still turned much.
    Polish,
    /// Nothing.
    Over(Status),
}

/// Judges the states that a minimiser comes by.
pub(crate) struct Judge {
    stop: Stop,
    /// Iterations without progress at round-off after which the state is called stalled.
    patience: usize,
    stalled: usize,
    polished: usize,
    /// Largest turn (rad) of any frame in the last step.
    last_turn: f64,
    /// The residual of the state at hand.
    pub residual: f64,
    /// The least so far.
    least: f64,
}

impl Judge {
    /// Nothing is known yet.
    pub fn new(stop: &Stop, patience: usize) -> Self {
        let (residual, least) = (f64::INFINITY, f64::INFINITY);
        Self { stop: *stop, patience, stalled: 0, polished: 0, last_turn: 0.0, residual, least }
    }

    /// The residual of the first state.
    pub fn begin(&mut self, residual: f64) {
        (self.residual, self.least) = (residual, residual);
    }

    /// After so many iterations.
    pub fn verdict(&mut self, iterations: usize) -> Verdict {
        let (used_up, stalled) = (iterations >= self.stop.max_iterations, self.stalled >= self.patience);
        let balanced = self.residual <= self.stop.force_tolerance;
        match () {
            () if !self.residual.is_finite() => Verdict::Over(Status::Failed),
            () if balanced
                && (self.last_turn <= LAST_TURN || self.polished == POLISHES || self.stalled > 0 || used_up) =>
            {
                Verdict::Over(Status::Converged)
            }
            () if stalled => Verdict::Over(Status::Stalled),
            () if used_up => Verdict::Over(Status::IterationLimit),
            () if balanced => {
                self.polished += 1;
                Verdict::Polish
            }
            () => Verdict::Step,
        }
    }

    /// A step was taken that turned so far (rad), in which the energy went down by more than round-off or did not, to this residual.
    pub fn moved(&mut self, turn: f64, visible: bool, residual: f64) {
        self.stalled = if !visible && residual > PROGRESS * self.least { self.stalled + 1 } else { 0 };
        self.last_turn = turn;
        self.residual = residual;
        self.least = self.least.min(residual);
    }

    /// There is no step that lowers the energy by more than round-off.
    pub fn stall(&mut self) {
        self.stalled = self.patience;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judge() -> Judge {
        let stop = Stop { force_tolerance: 1e-8, max_iterations: 10 };
        Judge::new(&stop, 2)
    }

    #[test]
    fn a_state_in_balance_that_still_turns_is_polished_so_many_times() {
        let mut judge = judge();
        judge.begin(1.0);
        assert_eq!(judge.verdict(0), Verdict::Step);
        for iteration in 1..=3 {
            judge.moved(0.1, true, 1e-9);
            assert_eq!(judge.verdict(iteration), Verdict::Polish);
        }
        assert_eq!(judge.verdict(4), Verdict::Over(Status::Converged));
        judge.polished = 0;
        judge.moved(1e-4, true, 1e-9);
        assert_eq!(judge.verdict(5), Verdict::Over(Status::Converged));
    }

    #[test]
    fn a_state_stalls_where_neither_energy_nor_forces_get_less() {
        let mut judge = judge();
        judge.begin(1.0);
        judge.moved(0.1, false, 0.4);
        assert_eq!(judge.verdict(1), Verdict::Step);
        // What the energy shows is progress, though the forces grow.
        judge.moved(0.1, true, 0.5);
        // The least so far counts, not the last.
        judge.moved(0.1, false, 0.21);
        assert_eq!(judge.verdict(3), Verdict::Step);
        judge.moved(0.1, false, 0.2);
        assert_eq!(judge.verdict(4), Verdict::Over(Status::Stalled));
    }

    #[test]
    fn iterations_are_counted_and_what_is_no_number_has_failed() {
        let mut judge = judge();
        judge.begin(1.0);
        assert_eq!(judge.verdict(10), Verdict::Over(Status::IterationLimit));
        judge.moved(0.1, true, f64::NAN);
        assert_eq!(judge.verdict(2), Verdict::Over(Status::Failed));
    }
}
