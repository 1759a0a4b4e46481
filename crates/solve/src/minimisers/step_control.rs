//! Limits of steps, shifts of the Hessian, and tolerances that the minimisers share.

use wireloom_core::Problem;
use wireloom_core::minimiser::Stop;
use wireloom_core::scales::LocalScale;

/// Largest turn (rad) of any frame in one line-search step; beyond it the quadratic model says nothing.
pub(super) const LARGEST_TURN: f64 = 1.0;
/// Largest turn (rad) of a step that counts as small: a linear prediction says something of what comes after it.
pub(super) const SMALL_TURN: f64 = 0.3;
/// Share of the tolerance below which forces on points are not condensed.
pub(super) const CONDENSED_FRACTION: f64 = 0.1;
/// First shift of the frames' diagonal that is tried, in units of [`System::weights`]; one tenth of it is none.
pub(super) const FIRST_SHIFT: f64 = 1e-6;
/// How many times larger the next shift is that is tried where the matrix is not positive definite yet.
pub(super) const RAISE: f64 = 8.0;
/// How often a step is solved for, where something else will touch than was taken to.
pub(super) const ACTIVE_SET_UPDATES: usize = 12;
/// A larger shift than `sigma`.
pub(super) fn raised(sigma: f64, factor: f64) -> f64 {
    (factor * sigma).max(FIRST_SHIFT)
}

/// Force (N) below which a point counts as condensed: a fraction of what the softest branch may have left.
pub(super) fn condensed_force(problem: &Problem<'_>, stop: &Stop) -> f64 {
    let allowed = |scale: &LocalScale| (stop.force_tolerance * scale.force).max(scale.round_off[0]);
    CONDENSED_FRACTION * problem.local_scales().iter().map(allowed).fold(f64::INFINITY, f64::min)
}
