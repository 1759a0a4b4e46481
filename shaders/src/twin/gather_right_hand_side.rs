use super::shared::gather::{free_directions, gathered_force, hold_basis, hold_entry};
use crate::memory::Memory;
use crate::places::Range;

/// Minus the gradient (where the step is to carry the prescribed motion: as it is after that), in the basis of each held variable and without its held directions.
pub(crate) fn gather_right_hand_side(m: &mut Memory, range: &Range, k: usize, variant: usize) {
    let [own, variable] = [0, 1].map(|i| m.word(range.table as usize + 2 * k + i) as usize);
    let dead = m.number3(m.places.variables_numbers as usize + 4 * variable, variant);
    let mut r = dead - gathered_force(m, variable, variant);
    if let Some(held) = hold_entry(m, variable) {
        r = hold_basis(m, held, variant).tr_mul(&r).component_mul(&free_directions(m, held, variant));
    }
    m.set_vector3(3 * own, variant, &r);
}
