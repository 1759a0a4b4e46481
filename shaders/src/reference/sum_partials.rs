use super::sum_state::larger;
use crate::layout::Range;
use crate::memory::Memory;

/// Sums and maxima of every n-th chunk, n = totals: what `sum_state` and `sum_step` left.
pub(crate) fn sum_partials(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let p = m.offsets;
    let mut all = [0.0; 7];
    for chunk in (k..p.chunks as usize).step_by(p.totals as usize) {
        let from = p.partials_vectors as usize + 7 * chunk;
        for (i, own) in all.iter_mut().enumerate() {
            let x = m.vector(from + i, variant);
            *own = if matches!(i, 2..=4) { larger(*own, x) } else { *own + x };
        }
    }
    for (i, x) in all.into_iter().enumerate() {
        m.set_vector(p.totals_vectors as usize + 7 * k + i, variant, x);
    }
}
