//! Rotations: maps that nalgebra does not provide in the form needed here.

use crate::{Matrix, Rotation, Vector};
use nalgebra::{Quaternion, Unit};

/// `[a]ₓ`, the matrix with `[a]ₓ b = a × b`.
#[inline]
pub fn skew(a: &Vector) -> Matrix {
    Matrix::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// Second derivative in θ of `f · R exp(θ) o`: with `f_b = Rᵀ f` it is `sym(f_b oᵀ) − (f_b·o) I`.
pub fn lever_hessian(q: &Rotation, force: &Vector, offset: &Vector) -> Matrix {
    let f = q.inverse_transform_vector(force);
    let outer = f * offset.transpose();
    (outer + outer.transpose()) * 0.5 - Matrix::identity() * f.dot(offset)
}

/// `q ∘ cay(θ)`, with θ (rad) in the body frame.
///
/// `cay(θ) = (1, θ/2)/√(1 + |θ|²/4)` agrees with `exp(θ)` up to third order, so first and second derivatives at
/// θ = 0 are those of the exponential map; it needs no trigonometric functions, and its angle is less than π for any
/// θ.
#[inline]
pub fn turned(q: &Rotation, theta: &Vector) -> Rotation {
    let (w, v) = (q.w, q.imag());
    let h = theta * 0.5;
    let new_w = w - v.dot(&h);
    let new_v = v + h * w + v.cross(&h);
    let scale = 1.0 / (new_w * new_w + new_v.norm_squared()).sqrt();
    Unit::new_unchecked(Quaternion::from_parts(new_w * scale, new_v * scale))
}

/// Frame whose third column is along `tangent` and whose first column is along the part of `up` orthogonal to it.
/// `None` where one of them vanishes or they are parallel.
pub fn frame_from(tangent: &Vector, up: &Vector) -> Option<Rotation> {
    let d3 = tangent.try_normalize(1e-300)?;
    let d1 = (up - d3 * d3.dot(up)).try_normalize(1e-9 * up.norm().max(1e-300))?;
    let d2 = d3.cross(&d1);
    let matrix = nalgebra::Rotation3::from_matrix_unchecked(Matrix::from_columns(&[d1, d2, d3]));
    Some(Rotation::from_rotation_matrix(&matrix))
}

/// A unit vector orthogonal to `a` (not zero): the world axis with the smallest component of `a`, projected.
pub fn orthogonal(a: &Vector) -> Vector {
    let axis = [Vector::x(), Vector::y(), Vector::z()][a.iamin()];
    (axis - a * (a.dot(&axis) / a.norm_squared())).normalize()
}

/// Smallest rotation (world) that maps direction `from` to direction `to` (neither zero); half a turn about an
/// orthogonal axis where they are opposite. Exact to round-off for nearly equal directions.
pub fn shortest(from: &Vector, to: &Vector) -> Rotation {
    let (a, b) = (from.normalize(), to.normalize());
    let w = 1.0 + a.dot(&b);
    if w < 1e-12 {
        return Rotation::from_axis_angle(&Unit::new_normalize(orthogonal(&a)), std::f64::consts::PI);
    }
    Unit::new_normalize(Quaternion::from_parts(w, a.cross(&b)))
}

/// Twist angle (rad, in [−π, π]) of a relative rotation about its third axis: `2 atan2(r_z, r_w)`
/// with the sign of r chosen so that `r_w ≥ 0`.
#[inline]
pub fn twist_angle(r: &Rotation) -> f64 {
    let sign = if r.w < 0.0 { -1.0 } else { 1.0 };
    2.0 * (sign * r.k).atan2(sign * r.w)
}

/// `q` or `−q`, whichever is nearer to `to`, so that quaternions are continuous where rotations are.
#[inline]
pub fn nearer_sign(q: Rotation, to: &Rotation) -> Rotation {
    if q.coords.dot(&to.coords) < 0.0 { Unit::new_unchecked(-q.into_inner()) } else { q }
}

/// First, second and third column of the rotation matrix of `q`.
#[inline]
pub fn columns(q: &Rotation) -> [Vector; 3] {
    let m = q.to_rotation_matrix();
    let m = m.matrix();
    [m.column(0).into(), m.column(1).into(), m.column(2).into()]
}
