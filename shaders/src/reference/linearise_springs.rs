use super::shared::algebra::{identity, lever_hessian, rotation_matrix, skew};
use super::shared::spring::{spring, spring_law};
use crate::harness::NONE;
use crate::layout::Range;
use crate::memory::{Memory, Vector};

/// Second derivatives of every spring, and first derivatives extrapolated by the prescribed motion; ∂X/∂θ = −R
/// \[o\]ₓ.
pub(crate) fn linearise_springs(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let law = spring_law(m, k, 0, variant);
    let s = spring(m, k, variant);
    let links = m.offsets.springs_program as usize + 2 * k;
    let (point, frame) = (m.word(links) as usize, m.word(links + 1));
    let rest = rotation_matrix(&s.rest);
    let lever = -(law.r * skew(&s.offset));
    let xx = identity(s.k);
    let tx = lever.transpose() * s.k;
    let tt = tx * lever + rest * law.hessian * rest.transpose() + lever_hessian(&law.r, &law.force, &s.offset);
    let dx = m.motion(point, variant);
    let theta = if frame == NONE { Vector::zeros() } else { m.motion(frame as usize, variant) };
    let own = m.offsets.springs_parts as usize + 33 * k;
    let moment = s.offset.cross(&law.r.tr_mul(&law.force)) + rest * law.moment;
    m.set_part3(own, variant, &(law.force + xx * dx + tx.tr_mul(&theta)));
    m.set_part3(own + 3, variant, &(moment + tx * dx + tt * theta));
    m.set_part33(own + 6, variant, &xx);
    m.set_part33(own + 15, variant, &tx);
    m.set_part33(own + 24, variant, &tt);
}
