//! Factorisation `A = L D Lᵀ` of a block matrix in place, and the solve.
//!
//! Right-looking, column by column in elimination order. Along a branch every column has two blocks below its
//! diagonal, in the next two rows; those columns are handled without any index look-up. Pivots are 3 × 3
//! blocks, themselves factorised without exchanges; the signs of their scalars give the inertia of the
//! matrix (Sylvester).

use crate::matrix::BlockMatrix;
use wireloom_core::{Matrix, Vector};

/// `(P⁻¹, negative pivots)` of a symmetric 3 × 3 block, through `P = L D Lᵀ`.
#[inline(always)]
fn invert(p: &Matrix) -> (Matrix, u32) {
    let (a11, a21, a31) = (p[(0, 0)], p[(1, 0)], p[(2, 0)]);
    let (a22, a32, a33) = (p[(1, 1)], p[(2, 1)], p[(2, 2)]);
    let i1 = 1.0 / a11;
    let (l21, l31) = (a21 * i1, a31 * i1);
    let d2 = a22 - l21 * a21;
    let i2 = 1.0 / d2;
    let e32 = a32 - l31 * a21;
    let l32 = e32 * i2;
    let d3 = a33 - l31 * a31 - l32 * e32;
    let i3 = 1.0 / d3;
    // L⁻¹ = [1, 0, 0; −l21, 1, 0; m31, −l32, 1]
    let m31 = l21 * l32 - l31;
    let (x13, x23) = (m31 * i3, -l32 * i3);
    let (x12, x22) = (-l21 * i2 + m31 * x23, i2 - l32 * x23);
    let x11 = i1 + l21 * l21 * i2 + m31 * x13;
    let negative = u32::from(a11 < 0.0) + u32::from(d2 < 0.0) + u32::from(d3 < 0.0);
    (Matrix::new(x11, x12, x13, x12, x22, x23, x13, x23, i3), negative)
}

impl BlockMatrix {
    /// Factorises in place: `diagonal` then holds the inverse pivots, `below` the blocks of L. Returns the number
    /// of negative pivots; not finite numbers in the factor show in the solution.
    pub fn factorise(&mut self) -> usize {
        let n = self.structure.len();
        let starts = &self.structure.starts;
        let rows = &self.structure.rows;
        let mut negative = 0;
        for p in 0..n {
            let (inverse, signs) = invert(&self.diagonal[p]);
            negative += signs as usize;
            self.diagonal[p] = inverse;
            let (start, end) = (starts[p] as usize, starts[p + 1] as usize);
            if end == start + 2 && rows[start] as usize == p + 1 && rows[start + 1] as usize == p + 2 {
                let (b1, b2) = (self.below[start], self.below[start + 1]);
                let (w1, w2) = (b1 * inverse, b2 * inverse);
                self.diagonal[p + 1] -= w1 * b1.transpose();
                // Column p + 1 begins with row p + 2: there is no row between.
                self.below[end] -= w2 * b1.transpose();
                self.diagonal[p + 2] -= w2 * b2.transpose();
                self.below[start] = w1;
                self.below[start + 1] = w2;
                continue;
            }
            for i in start..end {
                let row = rows[i];
                let w = self.below[i] * inverse;
                // The blocks before this one are multiplied by the inverse already: A_ij −= (B_i P⁻¹) B_jᵀ = B_i W_jᵀ.
                for (j, &column) in (start..i).zip(&rows[start..i]) {
                    let update = self.below[i] * self.below[j].transpose();
                    let slot = self.structure.slot(row, column);
                    self.below[slot] -= update;
                }
                self.diagonal[row as usize] -= w * self.below[i].transpose();
                self.below[i] = w;
            }
        }
        negative
    }

    /// Solves `L D Lᵀ u = rhs` in place.
    pub fn solve(&self, rhs: &mut [Vector]) {
        let n = self.structure.len();
        let starts = &self.structure.starts;
        let rows = &self.structure.rows;
        for p in 0..n {
            let r = rhs[p];
            for i in starts[p] as usize..starts[p + 1] as usize {
                rhs[rows[i] as usize] -= self.below[i] * r;
            }
        }
        for p in (0..n).rev() {
            let mut u = self.diagonal[p] * rhs[p];
            for i in starts[p] as usize..starts[p + 1] as usize {
                u -= self.below[i].tr_mul(&rhs[rows[i] as usize]);
            }
            rhs[p] = u;
        }
    }
}
