use super::shared::assembly::{assembled_force, free_directions, hold_basis, hold_entry};
use crate::layout::Range;
use crate::memory::Memory;

/// Minus the gradient, in the basis of each held variable and without held directions. If the step includes the
/// prescribed motion, the gradient is extrapolated by it.
pub(crate) fn assemble_right_hand_side(m: &mut Memory, range: &Range, k: usize, variant: usize) {
    let [own, variable] = [0, 1].map(|i| m.word(range.table as usize + 2 * k + i) as usize);
    let dead = m.number3(m.offsets.variables_numbers as usize + 4 * variable, variant);
    let mut r = dead - assembled_force(m, variable, variant);
    if let Some(held) = hold_entry(m, variable) {
        r = hold_basis(m, held, variant).tr_mul(&r).component_mul(&free_directions(m, held, variant));
    }
    m.set_vector3(3 * own, variant, &r);
}
