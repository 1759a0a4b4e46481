use super::shared::gather::{free_directions, gathered_force, hold_basis, hold_entry};
use crate::memory::Memory;

/// Minus the gradient as it is after the prescribed motion, in the basis of each held variable and without its held directions.
pub(crate) fn gather_right_hand_side(m: &mut Memory, k: usize, variant: usize) {
    let dead = m.number3(m.places.variables_numbers as usize + 4 * k, variant);
    let mut r = dead - gathered_force(m, k, variant);
    if let Some(held) = hold_entry(m, k) {
        r = hold_basis(m, held, variant).tr_mul(&r).component_mul(&free_directions(m, held, variant));
    }
    m.set_vector3(3 * k, variant, &r);
}
