//! The end of an increment: Newton steps until the next one would hardly move the harness.

use super::driver::Driver;
use crate::steps::certificate::Certifier;
use wireloom_core::status::Status;

/// Newton steps are taken from an increment's end until the next one moves the harness by less than this fraction of its longest branch, and
/// turns it by less than this, in rad; what is allowed in the end is [`crate::certificate`]'s.
const REFINED: f64 = 1e-7;
/// So many of them: next to a limit point the first ones converge slowly.
const REFINEMENTS: usize = 12;
/// Each must be shorter than this fraction of the one before, or the minimiser is asked for forces smaller by [`FINER`].
const SHRINKS: f64 = 0.7;
/// See [`SHRINKS`].
const FINER: f64 = 1e-2;
/// So often it is asked.
const REFINING_SOLVES: usize = 3;

impl Driver<'_, '_> {
    /// Goes on from a balanced state as long as the next Newton step would move it: where the harness is next to a limit point, or soft beside
    /// what acts on it, forces are in balance long before the shape is right.
    pub(super) fn refine(&mut self, status: Status) -> Status {
        self.inspection = None;
        if status != Status::Converged || self.problem.has_dead_moments() {
            return status;
        }
        let stop = self.stop;
        let mut inspection = self.certifier.inspect(&mut self.problem, &self.state);
        let (mut solves, mut tolerance) = (0, stop.force_tolerance);
        for _ in 0..REFINEMENTS {
            let small = inspection.relative <= REFINED || inspection.is_flat();
            if small && !inspection.is_blurred || inspection.touches || inspection.relative.is_nan() {
                break;
            }
            if self.problem.monitor.is_stopped() {
                return Status::Interrupted;
            }
            let before = self.state.clone();
            self.problem.retract(&before, self.certifier.next_step(), 1.0, &mut self.state);
            self.problem.place_held(&mut self.state);
            let refined = self.certify(Status::Stalled);
            let next = self.certifier.inspect(&mut self.problem, &self.state);
            if refined == Status::Converged && next.relative <= (SHRINKS * inspection.relative).max(REFINED) {
                inspection = next;
                continue;
            }
            self.state = before.clone();
            self.certify(status);
            solves += 1;
            if Certifier::grade_shape(status, &inspection) == Status::Converged || solves > REFINING_SOLVES {
                break;
            }
            // Newton's method alone does not get there: downhill, then, to forces that are smaller still.
            let conditions = self.problem.conditions().clone();
            tolerance = FINER * self.residual.min(tolerance);
            self.stop.force_tolerance = tolerance;
            self.solve();
            // It is graded by the tolerance that was asked for.
            self.stop = stop;
            if self.fault.is_some() {
                return Status::Failed;
            }
            if self.certify(Status::Stalled) != Status::Converged {
                self.state = before;
                self.problem.set_multipliers(&conditions);
                self.problem.set_contacts(&conditions);
                self.certify(status);
                break;
            }
            inspection = self.certifier.inspect(&mut self.problem, &self.state);
        }
        self.inspection = Some(inspection);
        Certifier::grade_shape(status, &inspection)
    }
}
