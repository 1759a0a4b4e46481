use super::shared::segment::{segment, segment_energy, segment_law};
use crate::memory::Memory;

/// Energy of every segment on trial, ∂E/∂e = R n and ∂E/∂θ = ℓ n × v.
pub(crate) fn measure_segments(m: &mut Memory, k: usize, variant: usize) {
    let s = segment(m, k, variant);
    let links = m.places.segments_program as usize + 3 * k;
    let [a, b, f] = [0, 1, 2].map(|i| m.state_entry(m.word(links + i) as usize, 1, variant));
    let law = segment_law(&s, &m.edge(a, b, variant), &m.value4(f, variant));
    let entry = m.places.segments_parts as usize + 33 * k;
    m.set_vector(m.places.energies_vectors as usize + k, variant, segment_energy(&law, s.l));
    m.set_part3(entry, variant, &(law.r * law.n));
    m.set_part3(entry + 3, variant, &(law.n.cross(&law.v) * s.l));
}
