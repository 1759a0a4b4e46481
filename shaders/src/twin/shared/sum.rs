//! Twin of `shared/sum.wgsl`.

use crate::memory::{Memory, Vector};

/// x + δ with its rounding error: the error-free sum of Knuth. `unit` is 1, which no compiler can know: so none takes the error for 0.
pub(crate) fn add_exactly(x: &Vector, carry: &Vector, step: &Vector, unit: f64) -> (Vector, Vector) {
    let delta = step + carry;
    let sum = (x + delta) * unit;
    let rounded = (sum - x) * unit;
    (sum, (x - (sum - rounded) * unit) + (delta - rounded))
}

pub(crate) fn set_point(m: &mut Memory, entry: usize, variant: usize, (sum, error): (Vector, Vector)) {
    m.set_value3(entry, variant, &sum);
    m.set_value3(entry + 4, variant, &error);
}
