//! Reference of `shared/strain.wgsl`; f64 needs no extended precision here.

use crate::memory::{Matrix, Rotation, Vector};

/// Γ = Rᵀ (e/ℓ − d3), with the d3 of q/|q|, so that deviations of |q| from 1 have no effect.
pub(crate) fn strain(r: &Matrix, e: &Vector, l: f64, q: &Rotation) -> Vector {
    let (x, y, z, w) = (q.i, q.j, q.k, q.w);
    let (across, along) = (x * x + y * y, z * z + w * w);
    let d3 = Vector::new(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), along - across) / (across + along);
    r.tr_mul(&(e / l - d3))
}
