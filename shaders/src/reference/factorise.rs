use crate::elimination::{PIVOT, UPDATE};
use crate::layout::Range;
use crate::memory::{Matrix, Memory};

/// P⁻¹ and the number of negative pivots of P, by P = L D Lᵀ.
fn invert(p: &Matrix) -> (Matrix, f64) {
    let i1 = 1.0 / p[(0, 0)];
    let (l21, l31) = (p[(1, 0)] * i1, p[(2, 0)] * i1);
    let d2 = p[(1, 1)] - l21 * p[(1, 0)];
    let i2 = 1.0 / d2;
    let e32 = p[(2, 1)] - l31 * p[(1, 0)];
    let l32 = e32 * i2;
    let d3 = p[(2, 2)] - l31 * p[(2, 0)] - l32 * e32;
    let i3 = 1.0 / d3;
    // L⁻¹ = [1, 0, 0; −l21, 1, 0; m31, −l32, 1]
    let m31 = l21 * l32 - l31;
    let (x13, x23) = (m31 * i3, -l32 * i3);
    let (x12, x22) = (m31 * x23 - l21 * i2, i2 - l32 * x23);
    let x11 = i1 + l21 * l21 * i2 + m31 * x13;
    let negative = [p[(0, 0)], d2, d3].iter().filter(|pivot| **pivot < 0.0).count();
    (Matrix::new(x11, x12, x13, x12, x22, x23, x13, x23, i3), negative as f64)
}

/// A task of the factorisation A = B D⁻¹ Bᵀ, block by block: A_ij + Σ U − Σ B_ik D_k⁻¹ B_jkᵀ. Pivots are
/// inverted in place; negative ones are added to those of earlier tasks (Sylvester's law of inertia).
pub(crate) fn factorise(m: &mut Memory, range: &Range, k: usize, variant: usize) {
    let table = range.table as usize;
    let end = table + m.word(table + k + 1) as usize;
    let mut at = table + m.word(table + k) as usize;
    let mut negative = 0.0;
    let negatives = m.offsets.negatives_vectors as usize;
    let children = m.word(at) as usize;
    for i in 1..=children {
        negative += m.vector(negatives + m.word(at + i) as usize, variant);
    }
    at += 1 + children;
    while at < end {
        let [block, flags, adds, products] = [0, 1, 2, 3].map(|i| m.word(at + i));
        at += 4;
        let mut sum = if flags & UPDATE == 0 { m.block33(block as usize, variant) } else { Matrix::zeros() };
        for _ in 0..adds {
            sum += m.block33(m.word(at) as usize, variant);
            at += 1;
        }
        for _ in 0..products {
            let [ik, jk, k] = [0, 1, 2].map(|i| m.block33(m.word(at + i) as usize, variant));
            sum -= (ik * k) * jk.transpose();
            at += 3;
        }
        if flags & PIVOT != 0 {
            let (inverse, own) = invert(&sum);
            sum = inverse;
            negative += own;
        }
        m.set_block33(block as usize, variant, &sum);
    }
    m.set_vector(negatives + k, variant, negative);
}
