use crate::layout::Range;
use crate::memory::Memory;

/// The step: steepest descent in the current metric plus β times the last step; β is 0 in Newton's method.
pub(crate) fn combine_directions(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let entry = m.offsets.step_vectors as usize + 3 * k;
    let mut step = m.vector3(m.offsets.descent_vectors as usize + 3 * k, variant);
    let beta = m.control[variant].beta;
    if beta > 0.0 {
        step += m.vector3(entry, variant) * beta;
    }
    m.set_vector3(entry, variant, &step);
}
