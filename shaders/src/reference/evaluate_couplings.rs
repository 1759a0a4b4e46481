use super::shared::algebra::rotation_matrix;
use super::shared::coupling::{Coupling, bend_twist, bend_twist_energy, moment_on_first, moment_on_second};
use crate::layout::Range;
use crate::memory::Memory;

/// Energy of every coupling in a slot of the state, and the moments on the carriers of its frames.
pub(crate) fn evaluate_couplings(m: &mut Memory, range: &Range, k: usize, variant: usize) {
    let entry = m.offsets.couplings_numbers as usize + 15 * k;
    let c = Coupling {
        c: m.number3(entry, variant),
        lambda: m.number(entry + 3, variant),
        k0: m.number3(entry + 4, variant),
    };
    let links = m.offsets.couplings_program as usize + 2 * k;
    let [a, b] = [0, 1].map(|i| m.word(links + i) as usize);
    let (rest_a, rest_b) = (m.number4(entry + 7, variant), m.number4(entry + 11, variant));
    let qa = m.value4(m.state_entry(a, range.slot, variant), variant) * rest_a;
    let qb = m.value4(m.state_entry(b, range.slot, variant), variant) * rest_b;
    let law = bend_twist(&qa, &qb, &c);
    let (ra, rb) = (rotation_matrix(&rest_a), rotation_matrix(&rest_b));
    let own = m.offsets.couplings_parts as usize + 33 * k;
    let energy = (m.offsets.energies_vectors + m.offsets.segments + m.offsets.station_segments) as usize + k;
    m.set_vector(energy, variant, bend_twist_energy(&law, &c));
    m.set_part3(own, variant, &(ra * moment_on_first(&law)));
    m.set_part3(own + 3, variant, &(rb * moment_on_second(&law)));
}
