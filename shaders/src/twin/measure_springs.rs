use super::shared::algebra::rotation_matrix;
use super::shared::spring::{spring, spring_law};
use crate::memory::Memory;

/// Energy of every spring on trial, the force on its point and the moment on its frame.
pub(crate) fn measure_springs(m: &mut Memory, k: usize, variant: usize) {
    let law = spring_law(m, k, 1, variant);
    let s = spring(m, k, variant);
    let p = &m.places;
    let own = p.springs_parts as usize + 33 * k;
    let energy = (p.energies_vectors + p.segments + p.station_segments + p.couplings) as usize + k;
    m.set_vector(energy, variant, law.energy);
    m.set_part3(own, variant, &law.force);
    let moment = s.offset.cross(&law.r.tr_mul(&law.force)) + rotation_matrix(&s.rest) * law.moment;
    m.set_part3(own + 3, variant, &moment);
}
