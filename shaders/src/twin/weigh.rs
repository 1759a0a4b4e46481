use super::shared::limits::{SETTLED_SHARE, is_finite};
use super::shared::partials::measured;
use crate::memory::Memory;
use crate::places::{Phase, Range};

/// Takes note of the state on trial, and whether its points are to be settled: a turn leaves segments longer by the share ½ θ², which is a
/// force far above all others (see solve::settle).
pub(crate) fn weigh(m: &mut Memory, _: &Range, _: usize, variant: usize) {
    let trial = measured(m, variant);
    let control = &mut m.control[variant];
    control.trial_energy = trial.energy;
    control.trial_residual = trial.residual;
    control.evaluations += 1;
    let settled = trial.force <= SETTLED_SHARE * control.tolerance * control.force_scale;
    control.phase = if settled || !is_finite(trial.force) { Phase::Judge } else { Phase::Settle } as u32;
}
