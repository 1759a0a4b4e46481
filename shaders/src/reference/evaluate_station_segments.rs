use super::shared::algebra::diagonal;
use super::shared::station_segment::{
    conjugate_force, station, station_energy, station_law, station_moment, station_segment, station_turn,
};
use crate::layout::Range;
use crate::memory::Memory;

/// Energy of every segment with stations in a slot of the state, ∂E/∂e = R p, ∂E/∂θ = ℓ (p × v + Σ β (R′ u) × p), the
/// moments on its stations, and ∂²E/∂e² = R B⁻ᵀ C B⁻¹ Rᵀ/ℓ.
pub(crate) fn evaluate_station_segments(m: &mut Memory, range: &Range, k: usize, variant: usize) {
    let s = station_segment(m, k, variant);
    let links = m.offsets.station_segments_program as usize + 5 * k;
    let [a, b, f] = [0, 1, 2].map(|i| m.word(links + i) as usize);
    let q = m.value4(m.state_entry(f, range.slot, variant), variant);
    let first = station(m, k, 0, &q, range.slot, variant);
    let second = station(m, k, 1, &q, range.slot, variant);
    let nodes = m.edge(m.state_entry(a, range.slot, variant), m.state_entry(b, range.slot, variant), variant);
    let e = nodes + (second.r * second.offset - first.r * first.offset);
    let law = station_law(&s, &e, &q, &first, &second);
    let p = conjugate_force(&law);
    let force = law.r * p;
    let turned = (station_turn(&first) + station_turn(&second)) * law.u;
    let entry = m.offsets.station_segments_parts as usize + 102 * k;
    let energy = (m.offsets.energies_vectors + m.offsets.segments) as usize + k;
    m.set_vector(energy, variant, station_energy(&law, s.l));
    m.set_part3(entry, variant, &force);
    m.set_part3(entry + 3, variant, &((p.cross(&law.v) + turned.cross(&p)) * s.l));
    m.set_part3(entry + 6, variant, &station_moment(&first, &-force, &p, &law.u, s.l));
    m.set_part3(entry + 9, variant, &station_moment(&second, &force, &p, &law.u, s.l));
    let along = law.r * law.inverse.transpose();
    m.set_part33(entry + 12, variant, &((along * diagonal(&law.c) * along.transpose()) * (1.0 / s.l)));
}
