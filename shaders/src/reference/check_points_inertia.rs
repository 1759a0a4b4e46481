use super::shared::inertia::negative_pivots;
use crate::layout::{Phase, Range};
use crate::memory::Memory;

/// After a factorisation for the points alone: if the energy is not convex in the points, they stay where they are.
pub(crate) fn check_points_inertia(m: &mut Memory, range: &Range, _: usize, variant: usize) {
    if negative_pivots(m, range, variant) > 0.0 {
        m.control[variant].phase = Phase::Accept as u32;
    }
}
