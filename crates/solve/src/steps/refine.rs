//! Refinement at the end of an increment: Newton steps until the next one hardly moves the harness.

use super::driver::Driver;
use crate::steps::certificate::{Certifier, Grade};
use wireloom_core::status::Status;

/// Target of the refinement: move in the next Newton step, as a fraction of the longest branch, and turn (rad). The
/// tolerance that decides on the status is that of the [certificate](super::certificate).
const REFINED: f64 = 1e-7;
/// Largest number of refinement steps: near a limit point the first ones converge slowly.
const REFINEMENTS: usize = 12;
/// Largest ratio of successive steps; above it the minimiser is called with a tolerance smaller by [`FINER`].
const CONTRACTION: f64 = 0.7;
/// Factor on the force tolerance of a refining call of the minimiser.
const FINER: f64 = 1e-2;
/// Largest number of refining calls of the minimiser.
const REFINING_SOLVES: usize = 3;

impl Driver<'_, '_> {
    /// Refines a state in balance as long as the next Newton step would move it: near a limit point, or in a harness
    /// that is soft beside its loads, forces are within tolerance long before the shape is accurate.
    pub(super) fn refine(&mut self, status: Grade) -> Grade {
        self.inspection = None;
        if status != Status::Converged {
            return status;
        }
        let stop = self.stop;
        let mut inspection = self.certifier.inspect(&mut self.problem, &self.state);
        let (mut solves, mut tolerance) = (0, stop.force_tolerance);
        for _ in 0..REFINEMENTS {
            let small = inspection.relative <= REFINED || inspection.is_flat();
            if small && !inspection.is_uncertain || inspection.in_contact || inspection.relative.is_nan() {
                break;
            }
            if self.problem.monitor.is_stopped() {
                return Grade::INTERRUPTED;
            }
            let before = self.state.clone();
            self.problem.retract(&before, self.certifier.next_step(), 1.0, &mut self.state);
            self.problem.place_held(&mut self.state);
            let refined = self.certify(Status::Stalled);
            let next = self.certifier.inspect(&mut self.problem, &self.state);
            if refined == Status::Converged && next.relative <= (CONTRACTION * inspection.relative).max(REFINED) {
                inspection = next;
                continue;
            }
            self.state = before.clone();
            self.certify(status);
            solves += 1;
            if Certifier::grade_shape(status, &inspection) == Status::Converged || solves > REFINING_SOLVES {
                break;
            }
            // The Newton step does not contract: minimise to smaller forces.
            let conditions = self.problem.conditions().clone();
            tolerance = FINER * self.residual.min(tolerance);
            self.stop.force_tolerance = tolerance;
            self.solve();
            // The result is graded by the tolerance of the scenario.
            self.stop = stop;
            if self.fault.is_some() {
                return Grade::FAILED;
            }
            if self.certify(Status::Stalled) != Status::Converged {
                self.state = before;
                self.take_back(&conditions);
                self.certify(status);
                break;
            }
            inspection = self.certifier.inspect(&mut self.problem, &self.state);
        }
        self.inspection = Some(inspection);
        Certifier::grade_shape(status, &inspection)
    }
}
