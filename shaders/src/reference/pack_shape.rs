use crate::layout::Range;
use crate::memory::Memory;

/// Packs the states of all variants for read-back, whichever third of the buffer is current.
pub(crate) fn pack_shape(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let at = m.state_entry(k, 0, variant);
    for i in 0..7 {
        let x = m.state[m.at(at + i, variant)];
        m.set_vector(m.offsets.shape_vectors as usize + 7 * k + i, variant, x);
    }
}
