use crate::layout::Range;
use crate::memory::Memory;
use crate::plan::sizes;

/// Collects the current state of a variant for read-back.
pub(crate) fn pack_shape(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let x = m.state[m.at(m.state_entry(0, 0, variant) + k, variant)];
    let length = sizes::STATE as usize * m.offsets.variables as usize;
    m.transfer[variant * length + k] = x;
}
