use super::shared::inertia::negative_pivots;
use super::shared::limits::{FIRST_SHIFT, SHIFT_INCREASE, can_be_raised};
use crate::layout::Phase;
use crate::layout::Range;
use crate::memory::Memory;

/// After a factorisation: if the matrix is not positive definite, increases the shift of the frames' diagonal and
/// refactorises.
pub(crate) fn check_inertia(m: &mut Memory, range: &Range, _: usize, variant: usize) {
    let negative = negative_pivots(m, range, variant);
    let control = &mut m.control[variant];
    control.negative = negative as u32;
    control.factorisations += 1;
    if negative > 0.0 && can_be_raised(control.sigma, control.force_scale) {
        control.sigma = (SHIFT_INCREASE * control.sigma).max(FIRST_SHIFT * control.force_scale);
        control.cycles += 1;
        control.phase = Phase::Refactor as u32;
    } else {
        control.since = 0;
        control.phase = Phase::Solve as u32;
    }
}
