use crate::layout::Range;
use crate::memory::Memory;
use crate::plan::sizes;

/// Distributes what was uploaded of a variant: its numbers, then its current state.
pub(crate) fn unpack(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let numbers = m.offsets.numbers as usize;
    let length = numbers + sizes::STATE as usize * m.offsets.variables as usize;
    let x = m.transfer[variant * length + k];
    if k < numbers {
        let at = m.at(k, variant);
        m.numbers[at] = x;
    } else {
        let at = m.at(m.state_entry(0, 0, variant) + k - numbers, variant);
        m.state[at] = x;
    }
}
