//! Reference of `shared/limits.wgsl`.

use crate::layout::{Outcome, Phase};
use crate::memory::Memory;

/// Largest rotation of a frame in a step, rad.
pub(crate) const MAX_ROTATION: f64 = 1.0;
/// First shift, per length of cable and relative to the force scale.
pub(crate) const FIRST_SHIFT: f64 = 1e-6;
/// Factor by which the shift is increased.
pub(crate) const SHIFT_INCREASE: f64 = 8.0;
/// The same after a failed line search.
pub(crate) const SHIFT_INCREASE_AFTER_SEARCH: f64 = 16.0;
/// Factor by which the shift is reduced after a successful step.
pub(crate) const SHIFT_DECREASE: f64 = 0.1;
/// Largest shift, relative to the force scale; beyond it a failed step ends the minimisation.
pub(crate) const MAX_SHIFT: f64 = 1e6;
/// Required fraction of the predicted decrease (Armijo).
pub(crate) const ARMIJO: f64 = 1e-4;
/// Smallest step length.
pub(crate) const MIN_STEP: f64 = 1e-10;
/// Rotation (rad) of the last step above which a state needs further steps.
pub(crate) const RESOLVED_ROTATION: f64 = 1e-3;
/// Largest number of such steps.
pub(crate) const MAX_POLISHING_STEPS: u32 = 3;
/// Fraction of the tolerance below which forces on points need no condensation.
pub(crate) const CONDENSED_FRACTION: f64 = 0.1;
/// Number of steps of the gradient method between factorisations.
pub(crate) const MAX_METRIC_AGE: u32 = 20;
/// Step length below which the preconditioner is out of date.
pub(crate) const MIN_REUSED_STEP: f64 = 0.25;
/// Larger numbers count as infinite, because their squares may be.
const OVERFLOW: f64 = 1e18;

/// Also false for NaN.
pub(crate) fn is_finite(x: f64) -> bool {
    x.abs() < OVERFLOW
}

/// Whether a shift can still be increased.
pub(crate) fn can_be_raised(sigma: f64, force_scale: f64) -> bool {
    sigma < OVERFLOW * force_scale
}

/// Ends a variant.
pub(crate) fn end(m: &mut Memory, variant: usize, outcome: Outcome) {
    m.control[variant].outcome = outcome as u32;
    m.control[variant].phase = Phase::Done as u32;
}
