//! Equilibrium under given conditions: updates of friction and multipliers around the minimiser.

use super::driver::{Driver, is_balanced};
use crate::contact::multipliers::{self, ContactHistory};
use crate::contact::sliding_friction;
use crate::steps::certificate::{FEASIBLE, Grade};
use wireloom_core::equilibrium::PartFamily;
use wireloom_core::minimiser::Report;
use wireloom_core::status::Status;

/// Largest number of friction updates; the increment is cut back if friction has not converged by then.
const FRICTION_UPDATES: usize = 40;
/// Largest number of multiplier updates; the increment is cut back if constraints and contact are not satisfied by
/// then.
const MULTIPLIER_UPDATES: usize = 40;
/// Force tolerance above which the tolerance of contact grows in proportion: such states are intermediate ones.
const STRICT: f64 = 1e-3;

impl Driver<'_, '_> {
    /// Equilibrium under the present conditions, with friction, and without the constraints that the cable has run out
    /// of.
    pub(crate) fn solve(&mut self) -> Grade {
        let mut status = self.minimise();
        for _ in 0..FRICTION_UPDATES {
            if self.starting || !is_balanced(status) {
                return status;
            }
            let ran_out = self.release_run_out();
            if !(sliding_friction::update(&mut self.problem, &self.state, &self.certifier.gradient) || ran_out) {
                return status;
            }
            status = self.minimise();
        }
        Grade::ITERATION_LIMIT
    }

    /// Minimum of the energy under the present conditions. With equations of constraints or contact, multipliers are
    /// updated around the minimiser until the violations are within tolerance (Hestenes 1969, Powell 1969).
    fn minimise(&mut self) -> Grade {
        let (mut last, mut history) = (Vec::new(), ContactHistory::default());
        let allowed = (self.stop.force_tolerance / STRICT).max(1.0);
        for update in 1..=MULTIPLIER_UPDATES {
            let report = self.minimise_once();
            self.iterations += report.iterations;
            self.polish += report.polish;
            self.factorisations += report.factorisations;
            self.convex &= report.convex;
            if self.problem.monitor.is_stopped() {
                return Grade::INTERRUPTED;
            }
            let balanced = is_balanced(report.status);
            let tolerance = FEASIBLE * self.stop.force_tolerance;
            let feasible = self.problem.worst_residual(&self.state).is_none_or(|worst| worst.violation <= tolerance)
                && self.problem.contact_violation(&self.state).is_none_or(|violation| violation <= allowed);
            // Contact between the contact points is checked once it is satisfied at them.
            let refined = balanced
                && feasible
                && update < MULTIPLIER_UPDATES
                && self.lost_twist.is_empty()
                && self.problem.refine_contact_points(&self.state);
            if refined {
                continue;
            }
            if !balanced || feasible || update == MULTIPLIER_UPDATES || !self.lost_twist.is_empty() {
                let status = self.certify(if balanced && !feasible { Status::IterationLimit } else { report.status });
                let found = self.problem.fault(!is_balanced(status));
                let own = self.minimiser.fault().map(|message| (PartFamily::Minimiser, 0, message));
                self.fault = self.fault.take().or(found).or(own);
                if is_balanced(status) && self.fault.is_none() {
                    self.fault = self.problem.contradiction(&self.state);
                }
                return if self.fault.is_some() { Grade::FAILED } else { status };
            }
            multipliers::update_constraints(&mut self.problem, &self.state, tolerance, &mut last);
            multipliers::update_contacts(&mut self.problem, &self.state, &mut history);
        }
        Grade::ITERATION_LIMIT
    }

    /// One call of the minimiser, under the twist monitor.
    fn minimise_once(&mut self) -> Report {
        self.lost_twist.clear();
        let Some(twist_monitor) = &mut self.twist_monitor else {
            return self.minimiser.minimise(&mut self.problem, &mut self.state, &self.stop);
        };
        twist_monitor.begin(&self.problem, &self.state);
        let report = self.minimiser.minimise(&mut self.problem, &mut self.state, &self.stop);
        if twist_monitor.end(&self.problem, &self.state) {
            self.lost_twist = twist_monitor.occurrences(&self.problem, &self.before, self.prescribed_turns);
        }
        report
    }
}
