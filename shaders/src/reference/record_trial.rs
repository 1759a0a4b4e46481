use super::shared::limits::{CONDENSED_FRACTION, is_finite};
use super::shared::totals::totals;
use crate::layout::{Phase, Range};
use crate::memory::Memory;

/// Takes note of the state on trial, and whether its points are to be settled: a turn leaves segments longer by the share ½ θ², which is a
/// force far above all others (see solve::settle).
pub(crate) fn record_trial(m: &mut Memory, _: &Range, _: usize, variant: usize) {
    let trial = totals(m, variant);
    let control = &mut m.control[variant];
    control.trial_energy = trial.energy;
    control.trial_residual = trial.residual;
    control.evaluations += 1;
    let condensed = trial.force <= CONDENSED_FRACTION * control.tolerance * control.force_scale;
    control.phase = if condensed || !is_finite(trial.force) { Phase::Accept } else { Phase::Condense } as u32;
}
