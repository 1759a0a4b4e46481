//! Restoration of lengths after a step that did not lower the energy.
//!
//! A step turns frames about fixed axes. In a cable between two held ends a turn θ so asks for the length `½ θ²` more
//! than there is, and condensation cannot give it: the cable stretches, a little in length and much in energy, and the
//! line search would cut the step. Restoring steps follow the trial instead: Newton steps with a shift so large that
//! bending hardly moves, and stretch relaxes (second-order correction: Fletcher 1982; restoration: Martínez and
//! Pilotta 2000). The geometric stiffness has the forces that the step before predicts, not those of the stretch.

use super::{Workspace, predict_forces};
use crate::minimisers::step_control::{LARGEST_TURN, raised};
use wireloom_core::State;
use wireloom_core::problem::Problem;

/// Largest number of restoring steps after a trial.
const MOST: usize = 2;
/// Shift of a restoring step, in units of that of the trial: above bending, far below stretch.
const STIFFER: f64 = 1e3;

impl Workspace {
    /// Whether steps are restored: not with contact, sliding and loads without a potential, whose steps have models of
    /// their own.
    pub(super) fn restores(problem: &Problem<'_>) -> bool {
        problem.contact().is_idle() && !problem.has_slides() && problem.has_potential()
    }

    /// Restores lengths after the trial of the whole step from `state` with the shift `sigma`; the trial has the energy
    /// `trial` (J). Returns the energy reached, with the end in the trial, if it is at most `allowed`.
    pub(super) fn restore(
        &mut self,
        problem: &mut Problem<'_>,
        state: &State,
        sigma: f64,
        [trial, allowed]: [f64; 2],
    ) -> Option<f64> {
        if !trial.is_finite() {
            return None;
        }
        let mut from = self.restored.take()?;
        from.copy_from(state);
        self.whole_step.copy_from(&self.step);
        self.first_gradient.copy_from(&self.gradient);
        let mut least = trial;
        for _ in 0..MOST {
            predict_forces(problem, &from, &self.step, &mut self.forces);
            std::mem::swap(&mut *from, &mut self.trial);
            std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
            self.assemble(problem, &from, true, raised(sigma, STIFFER));
            self.solve_once(problem, &from, false);
            let turn = self.largest_turn();
            let energy = if turn <= LARGEST_TURN { self.try_step(problem, &from, 1.0) } else { f64::INFINITY };
            if energy >= least || energy.is_nan() {
                std::mem::swap(&mut *from, &mut self.trial);
                std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
                break;
            }
            least = energy;
        }
        self.restored = Some(from);
        self.step.copy_from(&self.whole_step);
        self.gradient.copy_from(&self.first_gradient);
        (least <= allowed).then_some(least)
    }
}
