//! Reference of `shared/sum.wgsl`.

use crate::memory::{Memory, Vector};

/// x + δ with its rounding error: Knuth's error-free sum. (The Rust compiler does not reorder it.)
pub(crate) fn two_sum(x: &Vector, compensation: &Vector, step: &Vector) -> (Vector, Vector) {
    let delta = step + compensation;
    let sum = x + delta;
    let rounded = sum - x;
    (sum, (x - (sum - rounded)) + (delta - rounded))
}

pub(crate) fn set_point(m: &mut Memory, entry: usize, variant: usize, (sum, error): (Vector, Vector)) {
    m.set_value3(entry, variant, &sum);
    m.set_value3(entry + 4, variant, &error);
}
