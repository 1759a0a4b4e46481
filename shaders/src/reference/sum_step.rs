use super::shared::assembly::{hold_basis, hold_entry};
use crate::layout::Range;
use crate::memory::Memory;

/// Sums over a chunk of the step: transforms the descent direction from the bases of held variables to world and body
/// axes, adds the prescribed motion, and computes the products with the current and the previous gradient, the product
/// of the last step with the gradient, and the largest rotation.
pub(crate) fn sum_step(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let p = m.offsets;
    let (mut slope, mut before, mut last, mut turn) = (0.0, 0.0, 0.0, 0.0_f64);
    let (since, previous) = (m.control[variant].since, m.control[variant].previous);
    for variable in (k..p.variables as usize).step_by(p.chunks as usize) {
        let mut descent = m.vector3(3 * variable, variant);
        if let Some(held) = hold_entry(m, variable) {
            descent = hold_basis(m, held, variant) * descent + m.motion(variable, variant);
        }
        m.set_vector3(p.descent_vectors as usize + 3 * variable, variant, &descent);
        let gradient = m.vector3(m.gradient_entry(variable, 0, variant), variant);
        slope += gradient.dot(&descent);
        if since > 0 {
            before += m.vector3(m.gradient_of(previous, variable), variant).dot(&descent);
            last += gradient.dot(&m.vector3(p.step_vectors as usize + 3 * variable, variant));
        }
        if m.word(p.kinds_program as usize + variable) == 1 {
            turn = turn.max(descent.norm_squared());
        }
    }
    let at = p.partials_vectors as usize + 7 * k;
    m.set_vector(at + 1, variant, slope);
    m.set_vector(at + 4, variant, turn);
    m.set_vector(at + 5, variant, before);
    m.set_vector(at + 6, variant, last);
}
