use crate::elimination::{PIVOT, UPDATE};
use crate::layout::Range;
use crate::memory::{Memory, Vector};

/// A task of the forward substitution: z_j = D_j⁻¹ (r_j + Σ u − Σ B_jk z_k), and its updates for later tasks.
pub(crate) fn solve_forward(m: &mut Memory, range: &Range, k: usize, variant: usize) {
    let table = range.table as usize;
    let end = table + m.word(table + k + 1) as usize;
    let mut at = table + m.word(table + k) as usize;
    while at < end {
        let [own, flags, pivot, adds, products] = [0, 1, 2, 3, 4].map(|i| m.word(at + i));
        let own = 3 * own as usize;
        at += 5;
        let mut sum = if flags & UPDATE == 0 { m.vector3(own, variant) } else { Vector::zeros() };
        for _ in 0..adds {
            sum += m.vector3(3 * m.word(at) as usize, variant);
            at += 1;
        }
        for _ in 0..products {
            sum -= m.block33(m.word(at) as usize, variant) * m.vector3(3 * m.word(at + 1) as usize, variant);
            at += 2;
        }
        if flags & PIVOT != 0 {
            sum = m.block33(pivot as usize, variant) * sum;
        }
        m.set_vector3(own, variant, &sum);
    }
}
