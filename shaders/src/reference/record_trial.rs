use super::shared::limits::{CONDENSED_FRACTION, is_finite};
use super::shared::totals::totals;
use crate::layout::{Phase, Range};
use crate::memory::Memory;

/// Records energy and residual of the trial state, and whether its points need condensation: a rotation by θ stretches
/// segments by the fraction ½ θ², which causes forces far above all others (see the static condensation of `solve`).
pub(crate) fn record_trial(m: &mut Memory, _: &Range, _: usize, variant: usize) {
    let trial = totals(m, variant);
    let control = &mut m.control[variant];
    control.trial_energy = trial.energy;
    control.trial_residual = trial.residual;
    control.evaluations += 1;
    let condensed = trial.force <= CONDENSED_FRACTION * control.tolerance * control.force_scale;
    control.phase = if condensed || !is_finite(trial.force) { Phase::Accept } else { Phase::Condense } as u32;
}
