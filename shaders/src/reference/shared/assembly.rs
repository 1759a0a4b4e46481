//! Reference of `shared/assembly.wgsl`.

use crate::harness::NONE;
use crate::memory::{Matrix, Memory, Vector};
use crate::plan::NEGATIVE;

/// Sum of the parts' first derivatives with respect to a variable, without dead forces.
pub(crate) fn assembled_force(m: &Memory, variable: usize, variant: usize) -> Vector {
    let table = m.offsets.forces_program as usize;
    let mut sum = Vector::zeros();
    for at in m.word(table + variable)..m.word(table + variable + 1) {
        let source = m.word(table + at as usize);
        let own = m.part3((source & !NEGATIVE) as usize, variant);
        sum += if source & NEGATIVE != 0 { -own } else { own };
    }
    sum
}

/// Entry of a variable's hold; `None` if it has none.
pub(crate) fn hold_entry(m: &Memory, variable: usize) -> Option<usize> {
    let hold = m.word(m.offsets.holds_program as usize + variable);
    (hold != NONE).then(|| m.offsets.holds_numbers as usize + 20 * hold as usize)
}

/// Columns of a hold's basis.
pub(crate) fn hold_basis(m: &Memory, entry: usize, variant: usize) -> Matrix {
    Matrix::from_columns(&[0, 3, 6].map(|k| m.number3(entry + k, variant)))
}

/// 0 in the held directions, 1 in the others.
pub(crate) fn free_directions(m: &Memory, entry: usize, variant: usize) -> Vector {
    let count = m.number(entry + 9, variant);
    Vector::from_fn(|k, _| if count > k as f64 + 0.5 { 0.0 } else { 1.0 })
}
