use crate::layout::Range;
use crate::memory::Memory;

/// Where every variable is, all in one place: what a host reads back, whichever third of the state a variant is in.
pub(crate) fn pack_shape(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let at = m.state_entry(k, 0, variant);
    for i in 0..7 {
        let x = m.state[m.at(at + i, variant)];
        m.set_vector(m.offsets.shape_vectors as usize + 7 * k + i, variant, x);
    }
}
