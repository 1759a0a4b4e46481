//! Jumps: whether a harness that moved far in an increment snapped to another equilibrium on the way, and where.
//!
//! The two equilibria at the ends of an increment do not tell. So the increment is followed once more, from its
//! beginning, in halves: of each two, the one in which the harness moves farther is divided again. Where the path is
//! continuous, its move there goes to nothing. A move that does not is a jump. It goes as the square root of the part
//! where a straight strut buckles, and as the cube root next to a fold that has just closed: those are the slowest
//! ways (Thompson & Hunt 1973, A General Theory of Elastic Stability).
//!
//! Where a path is smooth, the mean of its speeds at both ends of an increment explains most of the move in it: that is
//! tried first, as it costs little ([`Driver::speeds_explain_move`]).
//!
//! Before a jump forces and bends change the faster the nearer it is: the requirements are checked at the last
//! equilibrium before it, too.

use super::driver::{Driver, is_balanced};
use crate::report::time_error::TimeError;
use crate::report::{Occurrence, result};
use crate::steps::checkpoint::Checkpoint;
use crate::steps::plan::Plan;
use wireloom_core::conditions::Conditions;
use wireloom_core::scales::nan_max;
use wireloom_core::status::Status;
use wireloom_core::{EventKind, EventPlace, Vector};

/// Number of times that an increment is halved.
const HALVINGS: i32 = 9;
/// Least move of a jump within the last part, as a fraction of the move of the whole increment: a cube root leaves an
/// eighth of it.
const AT_ONCE: f64 = 0.25;

/// Part of an increment over which its speed at an end is measured.
const SPEED_OVER: f64 = 1.0 / 64.0;
/// Largest part of a move that the speeds at the ends of a smooth path do not explain. Of 472 increments of harnesses
/// with three branches 29 had a jump, and at least 0.74 of their moves was not explained.
const NOT_EXPLAINED: f64 = 0.5;

impl Driver<'_, '_> {
    /// Checkpoint at the beginning of the increment, which began under the conditions `before`, with these errors by
    /// parts of time.
    fn before_increment(&self, (before, time_errors): (&Conditions, &[TimeError])) -> Checkpoint {
        Checkpoint {
            conditions: before.clone(),
            state: self.began.clone(),
            time_errors: time_errors.to_vec(),
            ..self.snapshot((0, 0), None, 0.0)
        }
    }

    /// Whether the speeds at both ends of the increment from one fraction of a plan to another, with this `beginning`
    /// ([`Self::before_increment`]) and an equilibrium as its end, explain most of the move in it: on a smooth path
    /// `x(b) − x(a) = (ẋ(a) + ẋ(b)) (b − a)/2`, but for terms of third order.
    pub(super) fn speeds_explain_move(
        &mut self,
        plan: &Plan,
        [a, b]: [f64; 2],
        beginning: (&Conditions, &[TimeError]),
    ) -> bool {
        if plan.takes_time() {
            // What creeps does not go back.
            return false;
        }
        let (network, stop, monitor) = (self.problem.network, self.stop, self.problem.monitor.clone());
        let part = SPEED_OVER * (b - a);
        let end = self.snapshot((0, 0), None, 0.0);
        // What of the move is not explained, by points.
        let mut rest: Vec<Vector> = self.state.points.iter().zip(&self.began.points).map(|(b, a)| b - a).collect();
        for (at, from, to) in [(self.before_increment(beginning), a, a + part), (end, b, b - part)] {
            let known = at.state.points.clone();
            let work = (self.iterations, self.polish, self.factorisations);
            let at = Checkpoint { work, ..at };
            let (mut trial, _) = Driver::at_checkpoint(network, &mut *self.minimiser, &stop, at, &monitor);
            let (status, _) = trial.reach(plan, from, to);
            (self.iterations, self.polish, self.factorisations) =
                (trial.iterations, trial.polish, trial.factorisations);
            if !is_balanced(status) {
                return false;
            }
            for ((rest, near), known) in rest.iter_mut().zip(&trial.state.points).zip(&known) {
                *rest -= (near - known) * (0.5 * (b - a) / (to - from));
            }
        }
        let most = rest.iter().map(Vector::norm).fold(0.0, nan_max);
        most <= NOT_EXPLAINED * result::farthest(&self.began, &self.state)
    }

    /// The jump in an increment from one fraction of a plan to another, with this `beginning` and an equilibrium as its
    /// end; `None` if the way there is continuous, or was not found again. Of several jumps it is the longest.
    pub(super) fn find_jump(
        &mut self,
        plan: &Plan,
        [a, b]: [f64; 2],
        beginning: (&Conditions, &[TimeError]),
    ) -> Option<Occurrence> {
        let least = AT_ONCE * result::farthest(&self.began, &self.state);
        let mut lower = self.before_increment(beginning);
        let mut upper = self.state.clone();
        let (mut from, mut to, mut moved) = (a, b, f64::INFINITY);
        let (network, stop, monitor) = (self.problem.network, self.stop, self.problem.monitor.clone());
        for _ in 0..HALVINGS {
            let middle = 0.5 * (from + to);
            let (mut trial, _) = Driver::at_checkpoint(network, &mut *self.minimiser, &stop, lower.clone(), &monitor);
            let before = (trial.iterations, trial.polish, trial.factorisations);
            let (status, _) = trial.reach(plan, from, middle);
            self.iterations += trial.iterations - before.0;
            self.polish += trial.polish - before.1;
            self.factorisations += trial.factorisations - before.2;
            if !is_balanced(status) {
                return None;
            }
            let [first, second] =
                [result::farthest(&lower.state, &trial.state), result::farthest(&trial.state, &upper)];
            moved = first.max(second);
            if moved < least {
                return None;
            }
            if first > second {
                to = middle;
                upper.copy_from(&trial.state);
            } else {
                from = middle;
                trial.problem.commit_rods_and_joints(&trial.state);
                let branches = trial.results_of_branches();
                trial.problem.commit(&trial.state, |constraint| result::tensions(constraint, &branches));
                lower = trial.snapshot((0, 0), None, 0.0);
            }
        }
        let place = if from == a {
            "at the beginning of the increment".to_owned()
        } else {
            self.check_before_jump(lower);
            format!("at {:.1} % of the increment", 100.0 * (to - a) / (b - a))
        };
        Some(Occurrence {
            kind: EventKind::Jump,
            place: EventPlace::default(),
            value: Some(moved),
            limit: None,
            message: format!("moved by {:.1} mm at once, {place}", 1e3 * moved),
        })
    }

    /// Checks the requirements at an equilibrium on the way through the increment.
    fn check_before_jump(&mut self, at: Checkpoint) {
        let (network, stop, monitor) = (self.problem.network, self.stop, self.problem.monitor.clone());
        let (mut before, _) = Driver::at_checkpoint(network, &mut *self.minimiser, &stop, at, &monitor);
        std::mem::swap(&mut before.log, &mut self.log);
        before.began.copy_from(&self.began);
        before.all_clearances = self.all_clearances;
        before.certify(Status::Stalled);
        before.check_on_the_way(false);
        self.log = before.log;
    }
}
