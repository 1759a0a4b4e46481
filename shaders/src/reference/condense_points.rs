use super::shared::assembly::{hold_basis, hold_entry};
use super::shared::sum::{set_point, two_sum};
use crate::harness::NONE;
use crate::layout::Range;
use crate::memory::Memory;

/// Static condensation: the trial state with its points in equilibrium for fixed frames.
pub(crate) fn condense_points(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let at = m.state_entry(k, 1, variant);
    let to = m.state_entry(k, 2, variant);
    for i in 0..7 {
        let (from, to) = (m.at(at + i, variant), m.at(to + i, variant));
        m.state[to] = m.state[from];
    }
    let own = m.word(m.offsets.condensation_program as usize + k);
    if own == NONE {
        return;
    }
    let mut step = m.vector3(3 * own as usize, variant);
    if let Some(held) = hold_entry(m, k) {
        step = hold_basis(m, held, variant) * step;
    }
    let moved = two_sum(&m.value3(at, variant), &m.compensation3(at, variant), &step);
    set_point(m, to, variant, moved);
}
