use super::shared::inertia::negative_pivots;
use crate::memory::Memory;
use crate::places::{Phase, Range};

/// After a factorisation for the points alone: where the energy is not convex in them they stay where they are.
pub(crate) fn inspect_points(m: &mut Memory, range: &Range, _: usize, variant: usize) {
    if negative_pivots(m, range, variant) > 0.0 {
        m.control[variant].phase = Phase::Judge as u32;
    }
}
