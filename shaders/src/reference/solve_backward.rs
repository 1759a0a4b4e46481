use crate::layout::Range;
use crate::memory::{Memory, Vector};

/// A task of the backward substitution: x_j = z_j − D_j⁻¹ Σ B_ijᵀ x_i.
pub(crate) fn solve_backward(m: &mut Memory, range: &Range, k: usize, variant: usize) {
    let table = range.table as usize;
    let end = table + m.word(table + k + 1) as usize;
    let mut at = table + m.word(table + k) as usize;
    while at < end {
        let [own, pivot, products] = [0, 1, 2].map(|i| m.word(at + i));
        at += 3;
        let mut sum = Vector::zeros();
        for _ in 0..products {
            let x = m.vector3(3 * m.word(at + 1) as usize, variant);
            sum += m.block33(m.word(at) as usize, variant).tr_mul(&x);
            at += 2;
        }
        let x = m.vector3(3 * own as usize, variant) - m.block33(pivot as usize, variant) * sum;
        m.set_vector3(3 * own as usize, variant, &x);
    }
}
