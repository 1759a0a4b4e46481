use super::shared::limits::{
    ARMIJO, FIRST_SHIFT, LARGEST_SHIFT, LAST_TURN, LOWER, POLISHES, RAISE_AFTER_SEARCH, SHORTEST, STALLED_AFTER, end,
    is_finite,
};
use crate::memory::Memory;
use crate::places::{Outcome, Phase};

/// Takes the state on trial or a shorter step, and says what comes next. The line search is by halving (Armijo), with the parabola through
/// value, slope and trial where it helps; where round-off hides what a step does to the energy, the forces say whether it was a good one.
pub(crate) fn judge(m: &mut Memory, _: usize, variant: usize) {
    let (mut energy, mut force, mut moment) = (0.0, 0.0_f64, 0.0_f64);
    for chunk in 0..m.places.chunks as usize {
        let at = m.places.partials_vectors as usize + 5 * chunk;
        energy += m.vector(at, variant);
        force = force.max(m.vector(at + 2, variant));
        moment = moment.max(m.vector(at + 3, variant));
    }
    let c = m.control[variant];
    let residual = f64::max(force.sqrt() / c.force_scale, moment.sqrt() / c.moment_scale);
    let finite = is_finite(energy) && is_finite(residual);
    let own = &mut m.control[variant];
    own.evaluations += 1;
    own.trial_energy = energy;
    own.trial_residual = residual;
    if c.begun == 0 {
        // The first state that is where its holds want it: there is nothing to compare it with.
        own.begun = 1;
        own.moving = 0;
        own.last_turn = c.alpha * c.largest_turn;
        if !finite {
            end(m, variant, Outcome::Failed);
            return;
        }
    } else {
        let noise = c.noise * c.energy.abs().max(c.moment_scale);
        let hidden = -c.slope <= noise;
        let lower = energy <= c.energy + ARMIJO * c.alpha * c.slope + noise;
        if !finite || !(lower || (hidden && residual <= 0.5 * c.residual)) {
            let parabola = -0.5 * c.slope * c.alpha * c.alpha / (energy - c.energy - c.slope * c.alpha);
            own.alpha = if finite && is_finite(parabola) {
                parabola.clamp(0.1 * c.alpha, 0.5 * c.alpha)
            } else {
                0.25 * c.alpha
            };
            if own.alpha >= SHORTEST {
                return;
            }
            if hidden {
                end(m, variant, Outcome::Stalled);
            } else if c.sigma < LARGEST_SHIFT * c.force_scale {
                own.sigma = f64::max(RAISE_AFTER_SEARCH * c.sigma, FIRST_SHIFT * c.force_scale);
                own.phase = Phase::Linearise as u32;
            } else {
                end(m, variant, Outcome::Failed);
            }
            return;
        }
        own.last_turn = c.alpha * c.largest_turn;
        own.stalled = if hidden && residual > 0.5 * c.residual { c.stalled + 1 } else { 0 };
        if c.sigma > 0.0 {
            let sigma = c.sigma * if c.alpha < 0.25 { 4.0 } else { LOWER };
            own.sigma = if sigma < 0.1 * FIRST_SHIFT * c.force_scale { 0.0 } else { sigma };
        }
    }
    own.current = 1 - c.current;
    own.energy = energy;
    own.residual = residual;
    let now = *own;
    if residual <= now.tolerance {
        let spent = now.polished == POLISHES || now.stalled > 0 || now.iterations >= now.max_iterations;
        if now.last_turn <= LAST_TURN || spent {
            end(m, variant, Outcome::Converged);
            return;
        }
        own.polished += 1;
        own.sigma = 0.0;
    }
    if now.stalled >= STALLED_AFTER {
        end(m, variant, Outcome::Stalled);
    } else if now.iterations >= now.max_iterations {
        end(m, variant, Outcome::IterationLimit);
    } else {
        own.phase = Phase::Linearise as u32;
    }
}
