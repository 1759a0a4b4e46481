//! Step limits, shifts of the Hessian, tolerances and threads common to the minimisers.

use wireloom_core::minimiser::Stop;
use wireloom_core::scales::LocalScale;
use wireloom_core::{Network, Problem};

/// Largest turn (rad) of any frame in one line-search step: beyond it the quadratic model is meaningless.
pub(super) const LARGEST_TURN: f64 = 1.0;
/// Largest turn (rad) of a small step: up to it a linear prediction is useful.
pub(super) const SMALL_TURN: f64 = 0.3;
/// Fraction of the force tolerance below which forces on points are not condensed.
pub(super) const CONDENSED_FRACTION: f64 = 0.1;
/// First shift of the frames' diagonal, in units of [`weights`](crate::linear::assembly::System::weights).
pub(super) const FIRST_SHIFT: f64 = 1e-6;
/// Factor on the shift while the matrix is not positive definite.
pub(super) const RAISE: f64 = 8.0;
/// Largest number of active-set updates of contact in one step.
pub(super) const ACTIVE_SET_UPDATES: usize = 12;

/// Shift larger than `sigma` by a factor, at least the first one.
pub(super) fn raised(sigma: f64, factor: f64) -> f64 {
    (factor * sigma).max(FIRST_SHIFT)
}

/// Does work of a minimiser; for a harness that several threads evaluate inside their pool, so that scheduling parallel
/// work is cheap.
pub(super) fn in_pool<R: Send>(network: &Network, work: impl FnOnce() -> R + Send) -> R {
    if network.is_shared() {
        let span = tracing::Span::current();
        rayon::scope(|_| span.in_scope(work))
    } else {
        work()
    }
}

/// Force (N) below which a point counts as condensed: a fraction of the force tolerance of the softest branch.
pub(super) fn condensed_force(problem: &Problem<'_>, stop: &Stop) -> f64 {
    let allowed = |scale: &LocalScale| (stop.force_tolerance * scale.force).max(scale.round_off[0]);
    CONDENSED_FRACTION * problem.local_scales().iter().map(allowed).fold(f64::INFINITY, f64::min)
}
