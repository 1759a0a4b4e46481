use super::shared::algebra::{identity, rotation_matrix};
use super::shared::spring::{spring, spring_law};
use crate::layout::Range;
use crate::memory::Memory;

/// Energy of every spring in a slot of the state, the force on its point, the moment on its frame and ∂²E/∂X².
pub(crate) fn evaluate_springs(m: &mut Memory, range: &Range, k: usize, variant: usize) {
    let law = spring_law(m, k, range.slot, variant);
    let s = spring(m, k, variant);
    let p = &m.offsets;
    let own = p.springs_parts as usize + 33 * k;
    let energy = (p.energies_vectors + p.segments + p.station_segments + p.couplings) as usize + k;
    m.set_vector(energy, variant, law.energy);
    m.set_part3(own, variant, &law.force);
    let moment = s.offset.cross(&law.r.tr_mul(&law.force)) + rotation_matrix(&s.rest) * law.moment;
    m.set_part3(own + 3, variant, &moment);
    m.set_part33(own + 6, variant, &identity(s.k));
}
