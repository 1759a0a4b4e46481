//! Factorisation `A = L D Lᵀ` of a block matrix in place, and the solve.
//!
//! Right-looking, column by column in elimination order. Along a branch every column has two blocks below its diagonal,
//! and the next column begins with the later of their rows: such columns need no index look-up. Pivots are 3 × 3
//! blocks, themselves factorised without exchanges; the signs of their scalar pivots give the inertia of the matrix
//! (Sylvester).

use crate::linear::elimination_tree::Part;
use crate::linear::matrix::BlockMatrix;
use crate::linear::symbolic::{Pattern, Structure};
use nalgebra::SymmetricEigen;
use wireloom_core::{Matrix, Vector};

/// Signs of scalar pivots.
#[derive(Clone, Copy)]
pub struct Signs {
    /// Negative pivots.
    pub negative: u32,
    /// Pivots that are exactly zero: the inverse is not finite.
    pub zero: u32,
}

/// `P⁻¹` of a symmetric 3 × 3 block, through `P = L D Lᵀ`, with the signs of D.
#[inline(always)]
pub fn invert(p: &Matrix) -> (Matrix, Signs) {
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
    let count = |is: fn(f64) -> bool| u32::from(is(a11)) + u32::from(is(d2)) + u32::from(is(d3));
    let signs = Signs { negative: count(|d| d < 0.0), zero: count(|d| d == 0.0) };
    (Matrix::new(x11, x12, x13, x12, x22, x23, x13, x23, i3), signs)
}

/// Which pivots an elimination counts.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Counted {
    /// The negative ones.
    Negative,
    /// Those that are negative or zero, up to the first block that has any: the rest is not eliminated.
    FirstNotPositive,
}

/// Eliminates the columns of a part; `diagonal` and `below` are the blocks of these columns. Contributions to later
/// rows are left in the part's updates. Returns the number of pivots that are counted.
fn eliminate(
    part: &mut Part,
    pattern: &Pattern,
    diagonal: &mut [Matrix],
    below: &mut [Matrix],
    counted: Counted,
) -> usize {
    let first = part.columns.start;
    let end = part.columns.end as u32;
    let first_block = pattern.starts[first] as usize;
    part.updates.fill(Matrix::zeros());
    let mut count = eliminate_all(&mut part.children, pattern, diagonal, below, counted);
    if counted == Counted::FirstNotPositive && count > 0 {
        return count;
    }
    let Part { children, beyond, updates, .. } = part;
    for child in children {
        for (i, &row) in child.beyond.iter().enumerate() {
            for (j, &column) in child.beyond[..=i].iter().enumerate() {
                let update = &child.updates[Part::place(i, j)];
                if column >= end {
                    updates[Part::update_of(beyond, row, column)] += update;
                } else if row == column {
                    diagonal[row as usize - first] += update;
                } else if let Some(slot) = pattern.find(row, column) {
                    below[slot - first_block] += update;
                }
            }
        }
    }
    let rows = &pattern.rows[first_block..];
    for p in part.own..part.columns.end {
        let local = p - first;
        let (inverse, signs) = invert(&diagonal[local]);
        count += signs.negative as usize;
        if counted == Counted::FirstNotPositive {
            count += signs.zero as usize;
            if count > 0 {
                return count;
            }
        }
        diagonal[local] = inverse;
        let (start, stop) = (pattern.starts[p] as usize - first_block, pattern.starts[p + 1] as usize - first_block);
        // The rows of a column from k on are also rows of column k of the factor, in the same order.
        let slot_from = |column: u32, row: u32| {
            let mut slot = pattern.starts[column as usize] as usize - first_block;
            while rows[slot] != row {
                slot += 1;
            }
            slot
        };
        if let [i, j, k] = rows[start..stop]
            && k < end
        {
            // As along a branch.
            let (ij, ik, jk) = (slot_from(i, j), slot_from(i, k), slot_from(j, k));
            let b = [below[start], below[start + 1], below[start + 2]];
            let w = b.map(|b| b * inverse);
            let (wi, wj) = (w[0].transpose(), w[1].transpose());
            diagonal[i as usize - first] -= w[0] * b[0].transpose();
            below[ij] -= b[1] * wi;
            below[ik] -= b[2] * wi;
            diagonal[j as usize - first] -= w[1] * b[1].transpose();
            below[jk] -= b[2] * wj;
            diagonal[k as usize - first] -= w[2] * b[2].transpose();
            below[start..stop].copy_from_slice(&w);
            continue;
        }
        // A_ik −= B_i P⁻¹ B_kᵀ = B_i W_kᵀ for all pairs of rows i ≥ k of the column. The rows from k on are also rows
        // of column k of the factor, in the same order.
        for k in start..stop {
            let (column, w) = (rows[k], below[k] * inverse);
            let (on_diagonal, transposed) = (w * below[k].transpose(), w.transpose());
            if column < end {
                diagonal[column as usize - first] -= on_diagonal;
                let mut slot = pattern.starts[column as usize] as usize - first_block;
                for i in k + 1..stop {
                    while rows[slot] != rows[i] {
                        slot += 1;
                    }
                    let update = below[i] * transposed;
                    below[slot] -= update;
                }
            } else {
                let later = beyond.binary_search(&column).expect("a row beyond");
                updates[Part::place(later, later)] -= on_diagonal;
                let mut place = later;
                for i in k + 1..stop {
                    while beyond[place] != rows[i] {
                        place += 1;
                    }
                    updates[Part::place(place, later)] -= below[i] * transposed;
                }
            }
            below[k] = w;
        }
    }
    count
}

/// Eliminates consecutive independent parts in parallel.
fn eliminate_all(
    parts: &mut [Part],
    pattern: &Pattern,
    diagonal: &mut [Matrix],
    below: &mut [Matrix],
    counted: Counted,
) -> usize {
    match parts {
        [] => 0,
        [part] => {
            let (columns, first_block) = (part.columns.len(), pattern.starts[part.columns.start]);
            let blocks = (pattern.starts[part.columns.end] - first_block) as usize;
            eliminate(part, pattern, &mut diagonal[..columns], &mut below[..blocks], counted)
        }
        _ => {
            let (parts, others) = parts.split_at_mut(parts.len() / 2);
            let (first, cut) = (parts[0].columns.start, others[0].columns.start);
            let (diagonal, other_diagonal) = diagonal.split_at_mut(cut - first);
            let (below, other_below) = below.split_at_mut((pattern.starts[cut] - pattern.starts[first]) as usize);
            let (a, b) = rayon::join(
                || eliminate_all(parts, pattern, diagonal, below, counted),
                || eliminate_all(others, pattern, other_diagonal, other_below, counted),
            );
            a + b
        }
    }
}

impl BlockMatrix {
    /// Factorises in place: `diagonal` then holds the inverse pivots, `below` the blocks of L. Returns the number of
    /// negative pivots. Non-finite numbers in the factor are not reported; they appear in the solution.
    pub fn factorise(&mut self) -> usize {
        let Structure { pattern, parts, .. } = &mut self.structure;
        eliminate(parts, pattern, &mut self.diagonal, &mut self.below, Counted::Negative)
    }

    /// Factorises in place as [`Self::factorise`] does, and stops at the first pivot that is negative or zero. Returns
    /// whether there is none; otherwise there is no factor.
    pub fn factorise_if_positive(&mut self) -> bool {
        let Structure { pattern, parts, .. } = &mut self.structure;
        eliminate(parts, pattern, &mut self.diagonal, &mut self.below, Counted::FirstNotPositive) == 0
    }

    /// Direction u of negative curvature, `uᵀ A u < 0`, in elimination order, after [`Self::factorise`]: the sum over
    /// the negative pivots of `L⁻ᵀ e`, each with a largest entry of 1. Returns whether there is a negative pivot.
    pub fn negative_direction(&self, u: &mut [Vector]) -> bool {
        let mut one = vec![Vector::zeros(); u.len()];
        let mut some = false;
        u.fill(Vector::zeros());
        for (p, inverse) in self.diagonal.iter().enumerate() {
            if !inverse.iter().all(|x| x.is_finite()) {
                continue;
            }
            let pivot = SymmetricEigen::new(*inverse);
            for (_, d) in pivot.eigenvalues.iter().zip(pivot.eigenvectors.column_iter()).filter(|(e, _)| **e < 0.0) {
                // The sign of an eigenvector is arbitrary: make its largest entry positive.
                let d: Vector = d.into();
                one.fill(Vector::zeros());
                one[p] = d * d[d.iamax()].signum();
                self.solve_transposed(&mut one[..=p]);
                let largest = one[..=p].iter().map(Vector::amax).fold(0.0, f64::max);
                u.iter_mut().zip(&one).for_each(|(u, one)| *u += one / largest);
                some = true;
            }
        }
        some
    }

    /// Solves `Lᵀ u = rhs` in place, for a right-hand side that is zero from its end on.
    fn solve_transposed(&self, rhs: &mut [Vector]) {
        let Pattern { starts, rows } = &self.structure.pattern;
        for p in (0..rhs.len()).rev() {
            let column = starts[p] as usize..starts[p + 1] as usize;
            let blocks = rows[column.clone()].iter().zip(&self.below[column]);
            let known: Vector = blocks.filter_map(|(row, block)| Some(block.tr_mul(rhs.get(*row as usize)?))).sum();
            rhs[p] -= known;
        }
    }

    /// Solves `L D Lᵀ u = rhs` in place.
    pub fn solve(&self, rhs: &mut [Vector]) {
        let n = self.structure.len();
        let Pattern { starts, rows } = &self.structure.pattern;
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
