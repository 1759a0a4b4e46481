//! Reference of `shared/algebra.wgsl`.

use crate::memory::{Matrix, Rotation, Vector};
use nalgebra::Quaternion;

/// a bᵀ
pub(crate) fn outer(a: &Vector, b: &Vector) -> Matrix {
    a * b.transpose()
}

pub(crate) fn diagonal(c: &Vector) -> Matrix {
    Matrix::from_diagonal(c)
}

pub(crate) fn identity(a: f64) -> Matrix {
    Matrix::identity() * a
}

/// \[a\]ₓ
pub(crate) fn skew(a: &Vector) -> Matrix {
    Matrix::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// By the cross products of its columns.
pub(crate) fn inverse33(m: &Matrix) -> Matrix {
    let [a, b, c] = [0, 1, 2].map(|i| -> Vector { m.column(i).into() });
    let bc = b.cross(&c);
    let rows = Matrix::from_columns(&[bc, c.cross(&a), a.cross(&b)]);
    rows.transpose() * (1.0 / a.dot(&bc))
}

/// sym(a bᵀ) − (a·b) I
pub(crate) fn symmetric_outer(a: &Vector, b: &Vector) -> Matrix {
    let twice = outer(a, b);
    (twice + twice.transpose()) * 0.5 - identity(a.dot(b))
}

/// R(q), the quadratic form.
pub(crate) fn rotation_matrix(q: &Rotation) -> Matrix {
    let (x2, y2, z2) = (q.i + q.i, q.j + q.j, q.k + q.k);
    let (xx, yy, zz) = (q.i * x2, q.j * y2, q.k * z2);
    let (xy, xz, yz) = (q.i * y2, q.i * z2, q.j * z2);
    let (wx, wy, wz) = (q.w * x2, q.w * y2, q.w * z2);
    Matrix::new(1.0 - (yy + zz), xy - wz, xz + wy, xy + wz, 1.0 - (xx + zz), yz - wx, xz - wy, yz + wx, 1.0 - (xx + yy))
}

/// q̄_a q_b, with the sign that makes w ≥ 0.
pub(crate) fn relative(a: &Rotation, b: &Rotation) -> (f64, Vector) {
    let (va, vb) = (a.imag(), b.imag());
    let w = a.w * b.w + va.dot(&vb);
    let v = vb * a.w - va * b.w - va.cross(&vb);
    if w < 0.0 { (-w, -v) } else { (w, v) }
}

pub(crate) fn normalised(q: Rotation) -> Rotation {
    q * (1.0 / q.coords.norm_squared().sqrt())
}

/// q ∘ cay(θ)
pub(crate) fn rotated(q: &Rotation, theta: &Vector) -> Rotation {
    let (h, v) = (theta * 0.5, q.imag());
    normalised(Quaternion::from_parts(q.w - v.dot(&h), v + h * q.w + v.cross(&h)))
}

/// Second derivative with respect to θ of `force · R exp(θ) offset`, with f = Rᵀ force: sym(f oᵀ) − (f·o) I.
pub(crate) fn lever_hessian(r: &Matrix, force: &Vector, offset: &Vector) -> Matrix {
    let f = r.tr_mul(force);
    let twice = outer(&f, offset);
    (twice + twice.transpose()) * 0.5 - identity(f.dot(offset))
}
