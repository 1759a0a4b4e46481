//! Reference of `shared/inertia.wgsl`.

use crate::layout::Range;
use crate::memory::Memory;

/// Number of negative pivots of a factorisation: the sum over the root tasks, which the table lists after their number.
pub(crate) fn negative_pivots(m: &Memory, range: &Range, variant: usize) -> f64 {
    let table = range.table as usize;
    let negatives = m.offsets.negatives_vectors as usize;
    (1..=m.word(table) as usize).map(|i| m.vector(negatives + m.word(table + i) as usize, variant)).sum()
}
