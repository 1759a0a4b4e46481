use super::shared::limits::{
    ARMIJO, FIRST_SHIFT, MAX_METRIC_AGE, MAX_POLISHING_STEPS, MAX_SHIFT, MIN_REUSED_STEP, MIN_STEP, RESOLVED_ROTATION,
    SHIFT_DECREASE, SHIFT_INCREASE_AFTER_SEARCH, end, is_finite,
};
use super::shared::totals::totals;
use crate::layout::Range;
use crate::layout::{Outcome, Phase};
use crate::memory::Memory;

/// Accepts the trial state, condensed if that lowers its energy, or shortens the step; then selects the next phase.
/// Backtracking line search (Armijo), with the parabola through value, slope and trial value where possible. If
/// round-off hides the change of the energy, the residual decides.
pub(crate) fn accept_step(m: &mut Memory, _: &Range, _: usize, variant: usize) {
    m.control[variant].cycles += 1;
    let c = m.control[variant];
    let noise = c.noise * c.energy.abs().max(c.moment_scale);
    let (mut energy, mut residual, mut slot) = (c.trial_energy, c.trial_residual, 1);
    if c.phase == Phase::Condense as u32 {
        let condensed = totals(m, variant);
        m.control[variant].evaluations += 1;
        // If round-off hides the difference, the residual decides.
        let close = condensed.energy <= energy + noise && condensed.residual < residual;
        if condensed.energy <= energy || close {
            (energy, residual, slot) = (condensed.energy, condensed.residual, 2);
        }
    }
    let finite = is_finite(energy) && is_finite(residual);
    let own = &mut m.control[variant];
    if c.begun == 0 {
        // The first state that satisfies all holds: there is no previous energy to compare with.
        own.begun = 1;
        own.moving = 0;
        own.last_rotation = c.alpha * c.max_rotation;
        if !finite {
            end(m, variant, Outcome::Failed);
            return;
        }
    } else {
        let hidden = -c.slope <= noise;
        let lower = energy <= c.energy + ARMIJO * c.alpha * c.slope + noise;
        if !finite || !(lower || (hidden && residual <= 0.5 * c.residual)) {
            let parabola = -0.5 * c.slope * c.alpha * c.alpha / (energy - c.energy - c.slope * c.alpha);
            own.alpha = if finite && is_finite(parabola) {
                parabola.clamp(0.1 * c.alpha, 0.5 * c.alpha)
            } else {
                0.25 * c.alpha
            };
            own.phase = Phase::Search as u32;
            if own.alpha >= MIN_STEP {
                return;
            }
            if c.since > 1 {
                // Refactorise before giving up.
                own.phase = Phase::Linearise as u32;
            } else if hidden {
                end(m, variant, Outcome::Stalled);
            } else if c.sigma < MAX_SHIFT * c.force_scale {
                own.sigma = f64::max(SHIFT_INCREASE_AFTER_SEARCH * c.sigma, FIRST_SHIFT * c.force_scale);
                own.phase = Phase::Linearise as u32;
            } else {
                end(m, variant, Outcome::Failed);
            }
            return;
        }
        own.last_rotation = c.alpha * c.max_rotation;
        own.stalled = if hidden && residual > 0.5 * c.residual { c.stalled + 1 } else { 0 };
        if own.stalled >= c.patience && c.residual <= residual {
            // The current state is better.
            end(m, variant, Outcome::Stalled);
            return;
        }
        if c.sigma > 0.0 {
            let sigma = c.sigma * if c.alpha < 0.25 { 4.0 } else { SHIFT_DECREASE };
            own.sigma = if sigma < 0.1 * FIRST_SHIFT * c.force_scale { 0.0 } else { sigma };
        }
    }
    own.previous = c.current;
    own.current = (c.current + slot) % 3;
    own.energy = energy;
    own.residual = residual;
    let now = *own;
    if residual <= now.tolerance {
        let spent = now.polished == MAX_POLISHING_STEPS || now.stalled > 0 || now.iterations >= now.max_iterations;
        if now.last_rotation <= RESOLVED_ROTATION || spent {
            end(m, variant, Outcome::Converged);
            return;
        }
        own.polished += 1;
        own.sigma = 0.0;
    }
    if now.stalled >= now.patience {
        end(m, variant, Outcome::Stalled);
    } else if now.iterations >= now.max_iterations {
        end(m, variant, Outcome::IterationLimit);
    } else if now.algorithm == 1 && c.begun == 1 && now.since < MAX_METRIC_AGE && c.alpha >= MIN_REUSED_STEP {
        own.phase = Phase::Descend as u32;
    } else {
        own.phase = Phase::Linearise as u32;
    }
}
