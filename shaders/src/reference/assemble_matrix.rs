use super::shared::algebra::{diagonal, identity};
use super::shared::assembly::{free_directions, hold_basis, hold_entry};
use crate::layout::Range;
use crate::memory::{Matrix, Memory, Vector};
use crate::plan::{NEGATIVE, TRANSPOSED};

/// A block of the matrix of all variables, or of the points alone: the sum of the parts' second derivatives, and σ
/// times the weight on the diagonal of frames. Rows and columns of held directions become those of the identity, in the
/// basis of each held variable.
pub(crate) fn assemble_matrix(m: &mut Memory, range: &Range, k: usize, variant: usize) {
    let table = range.table as usize;
    let [block, row, column] = [1, 2, 3].map(|i| m.word(table + 4 * k + i) as usize);
    let mut sum = Matrix::zeros();
    for at in m.word(table + 4 * k)..m.word(table + 4 * k + 4) {
        let source = m.word(table + at as usize);
        let mut own = m.part33((source & !(NEGATIVE | TRANSPOSED)) as usize, variant);
        if source & TRANSPOSED != 0 {
            own = own.transpose();
        }
        if source & NEGATIVE != 0 {
            own = -own;
        }
        sum += own;
    }
    if row == column {
        let weight = m.number(m.offsets.variables_numbers as usize + 4 * row + 3, variant);
        sum += identity(m.control[variant].sigma * weight);
    }
    if let Some(held) = hold_entry(m, row) {
        let free = free_directions(m, held, variant);
        sum = diagonal(&free) * (hold_basis(m, held, variant).transpose() * sum);
    }
    if let Some(held) = hold_entry(m, column) {
        let free = free_directions(m, held, variant);
        sum = sum * hold_basis(m, held, variant) * diagonal(&free);
        if row == column {
            sum += diagonal(&(Vector::repeat(1.0) - free));
        }
    }
    m.set_block33(block, variant, &sum);
}
