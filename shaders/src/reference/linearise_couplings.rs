use super::shared::algebra::rotation_matrix;
use super::shared::coupling::{Coupling, bend_twist, bend_twist_hessian, moment_on_first, moment_on_second};
use crate::layout::Range;
use crate::memory::Memory;

/// Second derivatives of every coupling, and first derivatives extrapolated by the prescribed motion.
pub(crate) fn linearise_couplings(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let entry = m.offsets.couplings_numbers as usize + 15 * k;
    let c = Coupling {
        c: m.number3(entry, variant),
        lambda: m.number(entry + 3, variant),
        k0: m.number3(entry + 4, variant),
    };
    let links = m.offsets.couplings_program as usize + 2 * k;
    let [a, b] = [0, 1].map(|i| m.word(links + i) as usize);
    let (rest_a, rest_b) = (m.number4(entry + 7, variant), m.number4(entry + 11, variant));
    let qa = m.value4(m.state_entry(a, 0, variant), variant) * rest_a;
    let qb = m.value4(m.state_entry(b, 0, variant), variant) * rest_b;
    let law = bend_twist(&qa, &qb, &c);
    let (ra, rb) = (rotation_matrix(&rest_a), rotation_matrix(&rest_b));
    let own = m.offsets.couplings_parts as usize + 33 * k;
    let h = bend_twist_hessian(&law, &c);
    let aa = ra * h.aa * ra.transpose();
    let ab = ra * h.ab * rb.transpose();
    let bb = rb * h.bb * rb.transpose();
    let theta_a = m.motion(a, variant);
    let theta_b = m.motion(b, variant);
    m.set_part3(own, variant, &(ra * moment_on_first(&law) + aa * theta_a + ab * theta_b));
    m.set_part3(own + 3, variant, &(rb * moment_on_second(&law) + ab.tr_mul(&theta_a) + bb * theta_b));
    m.set_part33(own + 6, variant, &aa);
    m.set_part33(own + 15, variant, &ab);
    m.set_part33(own + 24, variant, &bb);
}
