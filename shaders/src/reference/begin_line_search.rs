use super::shared::limits::{MAX_ROTATION, end, is_finite};
use crate::layout::{Outcome, Phase, Range};
use crate::memory::Memory;

/// Slope of the energy along the step, and the largest step length with bounded rotations. The gradient
/// method adds β times the last step, `β = g·M⁻¹(g − g°)/(g°·M⁻¹g°)` if that is positive and the sum is
/// a descent direction (Polak and Ribière 1969, Polyak 1969); M is the matrix.
pub(crate) fn begin_line_search(m: &mut Memory, _: &Range, _: usize, variant: usize) {
    let (mut slope, mut before, mut last, mut turn) = (0.0, 0.0, 0.0, 0.0_f64);
    for k in 0..m.offsets.totals as usize {
        let at = m.offsets.totals_vectors as usize + 7 * k;
        slope += m.vector(at + 1, variant);
        turn = turn.max(m.vector(at + 4, variant));
        before += m.vector(at + 5, variant);
        last += m.vector(at + 6, variant);
    }
    turn = turn.sqrt();
    let control = &mut m.control[variant];
    let mut beta = 0.0;
    if control.since > 0 {
        beta = f64::max((before - slope) / control.product, 0.0);
        if slope + beta * last >= 0.0 || beta.is_nan() {
            beta = 0.0;
        }
    }
    control.beta = beta;
    control.product = -slope;
    control.since += 1;
    control.iterations += 1;
    slope += beta * last;
    // Upper bound for the rotation by both directions.
    turn += beta * control.max_rotation;
    control.slope = slope;
    control.max_rotation = turn;
    control.alpha = f64::min(1.0, MAX_ROTATION / turn.max(MAX_ROTATION));
    control.phase = Phase::Combine as u32;
    if !is_finite(slope) || !is_finite(turn) {
        end(m, variant, Outcome::Failed);
    }
}
