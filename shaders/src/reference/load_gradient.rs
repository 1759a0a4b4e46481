use super::shared::assembly::{free_directions, hold_basis, hold_entry};
use crate::layout::Range;
use crate::memory::Memory;

/// Minus the free gradient of the current state, in the basis of each held variable: the right-hand side of the
/// gradient method, which reuses the last factorised matrix as a preconditioner.
pub(crate) fn load_gradient(m: &mut Memory, range: &Range, k: usize, variant: usize) {
    let [own, variable] = [0, 1].map(|i| m.word(range.table as usize + 2 * k + i) as usize);
    let mut r = -m.vector3(m.gradient_entry(variable, 0, variant), variant);
    if let Some(held) = hold_entry(m, variable) {
        r = hold_basis(m, held, variant).tr_mul(&r).component_mul(&free_directions(m, held, variant));
    }
    m.set_vector3(3 * own, variant, &r);
}
