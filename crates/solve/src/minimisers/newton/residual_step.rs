//! Step of Newton's method on the residual, for loads without a potential.
//!
//! The symmetric part of the tangent need not be positive definite at a stable equilibrium: for a cantilever bent by an
//! end moment to more than half a circle it is not. So the matrix is not shifted, and a step is not tested by an energy
//! but by the next correction with the same matrix, in radians and lengths:
//! `|K⁻¹ r(x ⊕ α u)| ≤ (1 − α/4) |u|` (restricted monotonicity test, Deuflhard 2004, section 3.3). If no
//! tried length passes, the caller takes a descent step.

use super::Workspace;
use crate::minimisers::step_control::SMALL_TURN;
use wireloom_core::problem::Problem;
use wireloom_core::{State, Tangent};

/// Fractions of the longest step that are tried; steps below the least one hardly make progress.
const FRACTIONS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
/// Turn (rad) below which a step is round-off.
const NO_TURN: f64 = 1e-10;
/// Decrease of the next correction that is required, per unit of α: ¼ in the test above.
const DECREASE: f64 = 0.25;

/// Size of the next correction above which a state in balance is iterated on: residual forces along a rolled-up cable
/// add up.
const RESOLVED: f64 = 1e-8;

/// An accepted step.
pub(super) struct ResidualStep {
    /// Step length α.
    pub alpha: f64,
    /// Energy after it, J.
    pub energy: f64,
    /// Largest turn of any frame, rad; infinite if the next correction is not negligible.
    pub turn: f64,
    /// Whether the step was more than round-off.
    pub visible: bool,
    /// Whether the forces may be predicted by the step.
    pub mixed: bool,
}

impl Workspace {
    /// Takes the step from `state`, where the gradient was evaluated last, if a length passes the test.
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
            // NaN does not pass.
            if next <= (1.0 - DECREASE * alpha) * size {
                let left = if next > RESOLVED { f64::INFINITY } else { alpha * turn };
                let energy = energy + problem.work_without_potential(state, &self.step, alpha);
                self.accept(state);
                problem.update_held(state);
                let mixed = turn < SMALL_TURN && alpha == 1.0;
                return Some(ResidualStep { alpha, energy, turn: left, visible: alpha * turn > NO_TURN, mixed });
            }
        }
        None
    }
}

/// Size of the correction at the trial with the present matrix.
fn next_size(ws: &mut Workspace, problem: &Problem<'_>, state: &State, length: f64) -> f64 {
    let Workspace { system, border, without, trial_gradient, free, .. } = ws;
    border.step_again(system, problem, state, trial_gradient, None, free);
    without.complete(system, border, problem, state, free);
    size(free, length)
}

/// Norm of a step: turns (rad), and motions divided by `length`.
fn size(step: &Tangent, length: f64) -> f64 {
    let frames: f64 = step.frames.iter().map(|v| v.norm_squared()).sum();
    let points: f64 = step.points.iter().map(|v| v.norm_squared()).sum();
    let slides: f64 = step.slides.iter().map(|s| s * s).sum();
    (frames + (points + slides) / (length * length)).sqrt()
}
