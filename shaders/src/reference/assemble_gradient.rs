use super::shared::assembly::{assembled_force, free_directions, hold_basis, hold_entry};
use crate::layout::Range;
use crate::memory::Memory;

/// The free gradient in a slot of the state: without held directions, in world axes (points) and body axes (frames).
pub(crate) fn assemble_gradient(m: &mut Memory, range: &Range, k: usize, variant: usize) {
    let dead = m.number3(m.offsets.variables_numbers as usize + 4 * k, variant);
    let mut g = assembled_force(m, k, variant) - dead;
    if let Some(held) = hold_entry(m, k) {
        let basis = hold_basis(m, held, variant);
        g = basis * basis.tr_mul(&g).component_mul(&free_directions(m, held, variant));
    }
    m.set_vector3(m.gradient_entry(k, range.slot, variant), variant, &g);
}
