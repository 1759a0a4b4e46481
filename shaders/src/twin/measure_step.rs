use super::shared::gather::{hold_basis, hold_entry};
use crate::memory::Memory;
use crate::places::Range;

/// A chunk of the step: from the bases of the held variables to world and body axes, with the prescribed motion; the slope of the
/// energy along it and its largest turn.
pub(crate) fn measure_step(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let p = m.places;
    let (mut slope, mut turn) = (0.0, 0.0_f64);
    for variable in (k..p.variables as usize).step_by(p.chunks as usize) {
        let mut step = m.vector3(3 * variable, variant);
        if let Some(held) = hold_entry(m, variable) {
            step = hold_basis(m, held, variant) * step + m.motion(variable, variant);
        }
        m.set_vector3(p.step_vectors as usize + 3 * variable, variant, &step);
        slope += m.vector3(m.gradient_entry(variable, 0, variant), variant).dot(&step);
        if m.word(p.kinds_program as usize + variable) == 1 {
            turn = turn.max(step.dot(&step));
        }
    }
    m.set_vector(p.partials_vectors as usize + 5 * k + 1, variant, slope);
    m.set_vector(p.partials_vectors as usize + 5 * k + 4, variant, turn);
}
