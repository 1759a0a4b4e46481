use super::shared::algebra::diagonal;
use super::shared::segment::{segment, segment_energy, segment_law};
use crate::layout::Range;
use crate::memory::Memory;

/// Energy of every segment in a slot of the state, ∂E/∂e = R n, ∂E/∂θ = ℓ n × v and ∂²E/∂e² = R C Rᵀ/ℓ.
pub(crate) fn evaluate_segments(m: &mut Memory, range: &Range, k: usize, variant: usize) {
    let s = segment(m, k, variant);
    let links = m.offsets.segments_program as usize + 3 * k;
    let [a, b, f] = [0, 1, 2].map(|i| m.state_entry(m.word(links + i) as usize, range.slot, variant));
    let law = segment_law(&s, &m.edge(a, b, variant), &m.value4(f, variant));
    let entry = m.offsets.segments_parts as usize + 33 * k;
    m.set_vector(m.offsets.energies_vectors as usize + k, variant, segment_energy(&law, s.l));
    m.set_part3(entry, variant, &(law.r * law.n));
    m.set_part3(entry + 3, variant, &(law.n.cross(&law.v) * s.l));
    let ee = (law.r * diagonal(&law.c) * law.r.transpose()) * (1.0 / s.l);
    m.set_part33(entry + 6, variant, &ee);
}
