//! The two elastic laws everything is made of, each with value, gradient and Hessian.
//!
//! Derivatives along `x + δ`, `q ∘ exp(θ)`, θ in the body frame. Source of the energies: Cosserat rod on a
//! staggered grid, Spillmann and Teschner 2007 (CoRdE) and Lang, Linn and Arnold 2011 for the
//! quaternion form of the curvature; the second derivatives are derived in the comments below and tested
//! against finite differences.

use wireloom_core::rod::{CouplingHessian, SegmentHessian};
use wireloom_core::rotation::skew;
use wireloom_core::{Matrix, Rotation, Vector};

/// Stretch and shear of one segment: `Γ = Rᵀ e/ℓ − e3`, `E = ½ ℓ Γᵀ C Γ`, `C = diag(GA1, GA2, EA)`.
///
/// `v = Γ + e3`, `n = C Γ` (N, body frame).
pub struct StretchShear {
    /// R(q).
    pub r: Matrix,
    /// v = Rᵀ e/ℓ.
    pub v: Vector,
    /// n = C Γ.
    pub n: Vector,
}

impl StretchShear {
    /// At edge `e` (m) and frame `q`, for rest length `l` (m) and stiffness diagonal `c` (N).
    #[inline(always)]
    pub fn new(e: &Vector, q: &Rotation, l: f64, c: &Vector) -> Self {
        let r = rotation_matrix(q);
        let v = r.tr_mul(e) / l;
        let n = Vector::new(c.x * v.x, c.y * v.y, c.z * (v.z - 1.0));
        Self { r, v, n }
    }

    /// (shear, stretch) energy, J.
    #[inline(always)]
    pub fn energy(&self, l: f64) -> (f64, f64) {
        let (n, v) = (&self.n, &self.v);
        (0.5 * l * (n.x * v.x + n.y * v.y), 0.5 * l * n.z * (v.z - 1.0))
    }

    /// `(∂E/∂e, ∂E/∂θ) = (R n, ℓ n × v)`.
    #[inline(always)]
    pub fn gradient(&self, l: f64) -> (Vector, Vector) {
        (self.r * self.n, self.n.cross(&self.v) * l)
    }

    /// `∂²E/∂e² = R C Rᵀ/ℓ`, `∂²E/∂θ∂e = ([v]ₓᵀ C + [n]ₓ) Rᵀ`,
    /// `∂²E/∂θ² = ℓ ([v]ₓᵀ C [v]ₓ + sym(n vᵀ) − (n·v) I)`; `n` is the force of the geometric part.
    #[inline(always)]
    pub fn hessian(&self, l: f64, c: &Vector, n: &Vector) -> SegmentHessian {
        let (r, v) = (&self.r, &self.v);
        let rc = Matrix::from_columns(&[r.column(0) * c.x, r.column(1) * c.y, r.column(2) * c.z]);
        let ee = rc * r.transpose() / l;
        // [v]ₓᵀ C + [n]ₓ, written out.
        let b = Matrix::new(
            0.0,
            v.z * c.y - n.z,
            -v.y * c.z + n.y,
            -v.z * c.x + n.z,
            0.0,
            v.x * c.z - n.x,
            v.y * c.x - n.y,
            -v.x * c.y + n.x,
            0.0,
        );
        let te = b * r.transpose();
        // [v]ₓᵀ C [v]ₓ + sym(n vᵀ) − (n·v) I, written out.
        let nv = n.dot(v);
        let xx = v.z * v.z * c.y + v.y * v.y * c.z + n.x * v.x - nv;
        let yy = v.z * v.z * c.x + v.x * v.x * c.z + n.y * v.y - nv;
        let zz = v.y * v.y * c.x + v.x * v.x * c.y + n.z * v.z - nv;
        let xy = -v.x * v.y * c.z + 0.5 * (n.x * v.y + n.y * v.x);
        let xz = -v.x * v.z * c.y + 0.5 * (n.x * v.z + n.z * v.x);
        let yz = -v.y * v.z * c.x + 0.5 * (n.y * v.z + n.z * v.y);
        let tt = Matrix::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * l;
        SegmentHessian { ee, te, tt }
    }
}

/// Bending and twist between two frames: `r = q̄_a q_b` with real part w ≥ 0 and imaginary part v,
/// `κ = (2/λ) v`, `E = ½ λ (κ−κ°)ᵀ C (κ−κ°)`, `C = diag(EI1, EI2, GJ)`.
pub struct BendTwist {
    /// Real part of r.
    pub w: f64,
    /// Imaginary part of r.
    pub v: Vector,
    /// C (κ − κ°), N m.
    pub moment: Vector,
    /// κ − κ°, 1/m.
    pub strain: Vector,
}

impl BendTwist {
    /// Between frames `qa` and `qb` at distance `lambda` (m), stiffness diagonal `c` (N m²), rest
    /// curvature `k0` (1/m).
    #[inline(always)]
    pub fn new(qa: &Rotation, qb: &Rotation, lambda: f64, c: &Vector, k0: &Vector) -> Self {
        let (a, b) = (qa.imag(), qb.imag());
        let mut w = qa.w * qb.w + a.dot(&b);
        let mut v = b * qa.w - a * qb.w - a.cross(&b);
        if w < 0.0 {
            w = -w;
            v = -v;
        }
        let strain = v * (2.0 / lambda) - k0;
        Self { w, v, moment: c.component_mul(&strain), strain }
    }

    /// (bend, twist) energy, J.
    #[inline(always)]
    pub fn energy(&self, lambda: f64) -> (f64, f64) {
        let (m, k) = (&self.moment, &self.strain);
        (0.5 * lambda * (m.x * k.x + m.y * k.y), 0.5 * lambda * m.z * k.z)
    }

    /// `(∂E/∂θ_a, ∂E/∂θ_b)`: with `μ = ∂E/∂v = 2 C (κ−κ°)`, `∂v/∂θ_b = ½(w I + [v]ₓ)` and
    /// `∂v/∂θ_a = −½(w I − [v]ₓ)` they are `−½(w μ + v × μ)` and `½(w μ − v × μ)`.
    #[inline(always)]
    pub fn gradient(&self) -> (Vector, Vector) {
        let wm = self.moment * self.w;
        let vm = self.v.cross(&self.moment);
        (-(wm + vm), wm - vm)
    }

    /// With `J_b = ½(w I + [v]ₓ)`, `J_a = −J_bᵀ`, `K = (4/λ) C`, `μ = 2 C (κ−κ°)`:
    /// `H_bb = J_bᵀ K J_b − ¼(μ·v) I`, `H_aa = J_aᵀ K J_a − ¼(μ·v) I`,
    /// `H_ab = J_aᵀ K J_b + ¼(v μᵀ + μ vᵀ + w [μ]ₓ − (μ·v) I)`.
    #[inline(always)]
    pub fn hessian(&self, lambda: f64, c: &Vector) -> CouplingHessian {
        let (w, v) = (self.w, &self.v);
        let half_mu = &self.moment;
        let j = Matrix::new(w, -v.z, v.y, v.z, w, -v.x, -v.y, v.x, w) * 0.5;
        let k = c * (4.0 / lambda);
        let scaled = |m: &Matrix| Matrix::from_fn(|row, column| k[row] * m[(row, column)]);
        let kj = scaled(&j);
        let kjt = scaled(&j.transpose());
        let g = Matrix::identity() * (-0.5 * half_mu.dot(v));
        let outer = v * half_mu.transpose() * 0.5;
        CouplingHessian {
            aa: j * kjt + g,
            ab: -(j * kj) + outer + outer.transpose() + skew(half_mu) * (0.5 * w) + g,
            bb: j.tr_mul(&kj) + g,
        }
    }
}

/// R(q), by the usual quadratic form.
#[inline(always)]
pub fn rotation_matrix(q: &Rotation) -> Matrix {
    let (w, x, y, z) = (q.w, q.i, q.j, q.k);
    let (x2, y2, z2) = (x + x, y + y, z + z);
    let (xx, yy, zz) = (x * x2, y * y2, z * z2);
    let (xy, xz, yz) = (x * y2, x * z2, y * z2);
    let (wx, wy, wz) = (w * x2, w * y2, w * z2);
    Matrix::new(1.0 - (yy + zz), xy - wz, xz + wy, xy + wz, 1.0 - (xx + zz), yz - wx, xz - wy, yz + wx, 1.0 - (xx + yy))
}
