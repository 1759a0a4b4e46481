//! Twin of `shared/limits.wgsl`.

use crate::layout::{Outcome, Phase};
use crate::memory::Memory;

/// Largest turn of a frame in a step, rad.
pub(crate) const MAX_ROTATION: f64 = 1.0;
/// First shift, per length of cable and in force scales.
pub(crate) const FIRST_SHIFT: f64 = 1e-6;
/// How many times larger the next one is.
pub(crate) const SHIFT_INCREASE: f64 = 8.0;
/// The same after a step that lowers nothing.
pub(crate) const SHIFT_INCREASE_AFTER_SEARCH: f64 = 16.0;
/// By how much a shift is lowered after a step that it let succeed.
pub(crate) const SHIFT_DECREASE: f64 = 0.1;
/// Shift, in force scales, at which a step that still does not lower the energy is given up.
pub(crate) const MAX_SHIFT: f64 = 1e6;
/// Share of the predicted decrease that a step must bring.
pub(crate) const ARMIJO: f64 = 1e-4;
/// Shortest share of a step that is tried.
pub(crate) const MIN_STEP: f64 = 1e-10;
/// Turn (rad) of the last step above which a state is not taken for resolved yet.
pub(crate) const RESOLVED_ROTATION: f64 = 1e-3;
/// Steps that such a state is given.
pub(crate) const MAX_POLISHING_STEPS: u32 = 3;
/// Share of the tolerance below which forces on points are not settled.
pub(crate) const CONDENSED_FRACTION: f64 = 0.1;
/// Steps of the gradient method from one factorisation to the next.
pub(crate) const MAX_METRIC_AGE: u32 = 20;
/// Share of a step below which the metric has become too old.
pub(crate) const MIN_REUSED_STEP: f64 = 0.25;
/// Numbers from here on count as infinite: their squares may be.
const OVERFLOW: f64 = 1e18;

/// False for what is not a number, too.
pub(crate) fn is_finite(x: f64) -> bool {
    x.abs() < OVERFLOW
}

/// Whether a shift can still be raised.
pub(crate) fn can_be_raised(sigma: f64, force_scale: f64) -> bool {
    sigma < OVERFLOW * force_scale
}

/// A variant is done.
pub(crate) fn end(m: &mut Memory, variant: usize, outcome: Outcome) {
    m.control[variant].outcome = outcome as u32;
    m.control[variant].phase = Phase::Done as u32;
}
