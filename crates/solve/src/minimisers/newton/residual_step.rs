//! A step of Newton's method on the residual, for loads that have no potential.
//!
//! The symmetric part of the tangent need not be positive definite at a good equilibrium: a cantilever that an end moment bends to more than half
//! a circle has none. So the matrix is not shifted, and what judges a step is not an energy but the next correction with the same matrix,
//! in radians and lengths: `|K⁻¹ r(x ⊕ α u)| ≤ (1 − α/4) |u|` (the restricted monotonicity test, Deuflhard 2004, section 3.3). Where no fraction of the
//! step passes, the caller goes downhill.

use super::Workspace;
use crate::linear::assembly::System;
use crate::minimisers::step_control::SMALL_TURN;
use wireloom_core::problem::Problem;
use wireloom_core::{State, Tangent};

/// Fractions of the longest step that are tried: below the least the model says too little.
const FRACTIONS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
/// Turn (rad) below which a step is round-off.
const NO_TURN: f64 = 1e-10;

/// Size of the next correction above which a state in balance is not taken for resolved: forces along a cable that is rolled up add up.
const RESOLVED: f64 = 1e-8;

/// A step that was taken.
pub(super) struct ResidualStep {
    /// Its length.
    pub alpha: f64,
    /// Energy after it, J.
    pub energy: f64,
    /// Largest turn of any frame, rad; endless where the next one is still to be taken.
    pub turn: f64,
    /// Whether it was more than round-off.
    pub visible: bool,
    /// Whether forces may be predicted by it.
    pub mixed: bool,
}

impl Workspace {
    /// Takes the step from `state`, whose gradient is at hand, if it passes the test.
    pub(super) fn residual_step(
        &mut self,
        problem: &mut Problem<'_>,
        state: &mut State,
        mixed: bool,
    ) -> Option<ResidualStep> {
        problem.hessian(state, mixed.then_some(self.forces.as_slice()), &mut self.hessian);
        self.factorise(problem, state, 0.0);
        self.solve(problem, state, false, Some(0.0));
        let (length, turn) = (problem.scales().length, self.largest_turn());
        let size = size(&self.step, length);
        if !size.is_finite() {
            return None;
        }
        let longest = self.longest(problem, state);
        for fraction in FRACTIONS {
            let alpha = fraction * longest;
            let energy = self.try_step(problem, state, alpha);
            let next = if energy.is_finite() { next_size(self, problem, state, length) } else { f64::NAN };
            // NaN passes no test.
            if next <= (1.0 - 0.25 * alpha) * size {
                let left = if next > RESOLVED { f64::INFINITY } else { alpha * turn };
                let energy = energy + problem.moment_work(state, &self.step, alpha);
                self.accept(state);
                problem.update_held(state);
                let mixed = turn < SMALL_TURN && alpha == 1.0;
                return Some(ResidualStep { alpha, energy, turn: left, visible: alpha * turn > NO_TURN, mixed });
            }
        }
        None
    }
}

/// Size of the correction that the matrix at hand asks for at the trial.
fn next_size(ws: &mut Workspace, problem: &Problem<'_>, state: &State, length: f64) -> f64 {
    let Workspace { system: System { matrix, rhs, .. }, border, moments, trial_gradient, free, .. } = ws;
    matrix.right_hand_side(problem, trial_gradient, None, rhs);
    matrix.solve(rhs);
    free.clear();
    matrix.step(problem, state, rhs, None, free);
    if problem.has_slides() {
        border.complete_again(trial_gradient, free);
    }
    moments.complete(free);
    size(free, length)
}

/// Turns, and motions over a length.
fn size(step: &Tangent, length: f64) -> f64 {
    let frames: f64 = step.frames.iter().map(|v| v.norm_squared()).sum();
    let points: f64 = step.points.iter().map(|v| v.norm_squared()).sum();
    let slides: f64 = step.slides.iter().map(|s| s * s).sum();
    (frames + (points + slides) / (length * length)).sqrt()
}
