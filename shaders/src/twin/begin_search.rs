use super::shared::limits::{LARGEST_TURN, end, is_finite};
use crate::memory::Memory;
use crate::places::Range;
use crate::places::{Outcome, Phase};

/// The slope of the energy along the step, and the longest share of it that turns no frame too far.
pub(crate) fn begin_search(m: &mut Memory, _: &Range, _: usize, variant: usize) {
    let (mut slope, mut turn) = (0.0, 0.0_f64);
    for chunk in 0..m.places.chunks as usize {
        let at = m.places.partials_vectors as usize + 5 * chunk;
        slope += m.vector(at + 1, variant);
        turn = turn.max(m.vector(at + 4, variant));
    }
    turn = turn.sqrt();
    let control = &mut m.control[variant];
    control.slope = slope;
    control.largest_turn = turn;
    control.alpha = f64::min(1.0, LARGEST_TURN / turn.max(LARGEST_TURN));
    control.phase = Phase::Search as u32;
    if !is_finite(slope) || !is_finite(turn) {
        end(m, variant, Outcome::Failed);
    }
}
