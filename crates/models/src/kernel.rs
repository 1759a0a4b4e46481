//! The two elastic laws everything is made of, each with value, gradient and Hessian.
//!
//! Derivatives along `x + δ`, `q ∘ exp(θ)`, θ in the body frame. Source of the energies: Cosserat rod on a
//! staggered grid, Spillmann and Teschner 2007 (CoRdE) and Lang, Linn and Arnold 2011 for the
//! quaternion form of the curvature; the second derivatives are derived in the comments below and tested
//! against finite differences.

use nalgebra::{Quaternion, Unit};
use wireloom_core::rod::{CouplingHessian, NeighbourHessian, SegmentHessian};
use wireloom_core::rotation::skew;
use wireloom_core::{Matrix, Rotation, Vector};

/// Stiffness of a segment: `W = ½ Γᵀ C Γ + ½ B min(v3, 0)²` is the energy per length, `v = Γ + e3`. B acts on an edge
/// that points against its frame, and makes C there `diag(GA1, GA2, EA + B)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentStiffness {
    /// C: diag(GA1, GA2, EA), N.
    pub c: Vector,
    /// B, N. Where GA is above 2 EA an overturned segment would be a minimum of the energy; with `B ≥ GA` it is none.
    pub overturned: f64,
}

impl SegmentStiffness {
    /// The second derivative of W at v, its part beyond EA in EA's place, N.
    #[inline(always)]
    fn at(&self, v: &Vector) -> (Vector, f64) {
        let beyond = if v.z < 0.0 { self.overturned } else { 0.0 };
        (Vector::new(self.c.x, self.c.y, self.c.z + beyond), beyond)
    }
}

/// Stretch and shear of one segment: `Γ = Rᵀ e/ℓ − (1 + ε) e3`, `E = ½ ℓ Γᵀ C Γ`, `C = diag(GA1, GA2, EA)`, with ε the
/// stretch without force ([`wireloom_core::BranchShape::free_strain`]); see [`SegmentStiffness`] for edges that are
/// overturned.
///
/// `v = Rᵀ e/ℓ`, `n = C Γ` (N, body frame).
pub struct StretchShear {
    /// R(q).
    pub r: Matrix,
    /// v = Rᵀ e/ℓ.
    pub v: Vector,
    /// n = C Γ.
    pub n: Vector,
    /// C at v.
    pub c: Vector,
    /// Part of it that belongs to frame B.
    beyond: f64,
    /// 1 + ε.
    free: f64,
}

impl StretchShear {
    /// At edge `e` (m) and frame `q`, for rest length `l` (m) and free strain ε.
    #[inline(always)]
    pub fn new(e: &Vector, q: &Rotation, [l, free_strain]: [f64; 2], stiffness: &SegmentStiffness) -> Self {
        let r = rotation_matrix(q);
        let v = r.tr_mul(e) * (1.0 / l);
        let (c, beyond) = stiffness.at(&v);
        let free = 1.0 + free_strain;
        let n = Vector::new(c.x * v.x, c.y * v.y, stiffness.c.z * (v.z - free) + beyond * v.z);
        Self { r, v, n, c, beyond, free }
    }

    /// Γ.
    pub fn strain(&self) -> Vector {
        self.v - Vector::z() * self.free
    }

    /// The same segment with this force (N) in place of C Γ.
    pub fn with_force(self, n: Vector) -> Self {
        Self { n, ..self }
    }

    /// δΓ for a step: `Rᵀ δe/ℓ + v × θ`.
    #[inline(always)]
    pub fn strain_change(&self, l: f64, de: &Vector, theta: &Vector) -> Vector {
        self.r.tr_mul(de) / l + self.v.cross(theta)
    }

    /// (shear, stretch) energy, J.
    #[inline(always)]
    pub fn energy(&self, l: f64) -> (f64, f64) {
        let (n, v) = (&self.n, &self.v);
        (0.5 * l * (n.x * v.x + n.y * v.y), 0.5 * l * (n.z * (v.z - self.free) + self.beyond * v.z))
    }

    /// `(∂E/∂e, ∂E/∂θ) = (R n, ℓ n × v)`.
    #[inline(always)]
    pub fn gradient(&self, l: f64) -> (Vector, Vector) {
        (self.r * self.n, self.n.cross(&self.v) * l)
    }

    /// `[∂E/∂ℓ, ∂²E/∂ℓ²]` with e and q fixed, where `v = Rᵀ e/ℓ` goes with 1/ℓ: `½ (EA (1 + ε)² − vᵀ C v)` and
    /// `vᵀ C v/ℓ`.
    pub fn length_terms(&self, l: f64) -> [f64; 2] {
        stretch_length_terms(&self.v, self.free, l, &self.c, self.beyond)
    }

    /// The law whose gradient is the derivative of the gradient in ℓ: that with `∂n/∂ℓ = −C v/ℓ` in place of n.
    pub fn per_length(self, l: f64) -> Self {
        Self { n: self.c.component_mul(&self.v) / -l, ..self }
    }

    /// [`Self::hessian`] with T, the derivative of the force in Γ (N, symmetric), in place of C.
    pub fn hessian_with(&self, l: f64, n: &Vector, tangent: &Matrix) -> SegmentHessian {
        let (rt, v) = (self.r.transpose(), skew(&self.v));
        let outer = n * self.v.transpose() * 0.5;
        let geometric = outer + outer.transpose() - Matrix::identity() * n.dot(&self.v);
        SegmentHessian {
            ee: self.r * tangent * rt / l,
            te: (v.transpose() * tangent + skew(n)) * rt,
            tt: (v.transpose() * tangent * v + geometric) * l,
        }
    }

    /// `∂²E/∂e² = R C Rᵀ/ℓ`, `∂²E/∂θ∂e = ([v]ₓᵀ C + [n]ₓ) Rᵀ`,
    /// `∂²E/∂θ² = ℓ ([v]ₓᵀ C [v]ₓ + sym(n vᵀ) − (n·v) I)`; `n` is the force of the geometric part.
    #[inline(always)]
    pub fn hessian(&self, l: f64, n: &Vector) -> SegmentHessian {
        let c = &self.c;
        let (r, v) = (&self.r, &self.v);
        let ee = edge_stiffness(r, l, c);
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

/// `R C Rᵀ/ℓ`.
#[inline(always)]
pub fn edge_stiffness(r: &Matrix, l: f64, c: &Vector) -> Matrix {
    let c_l = c * (1.0 / l);
    let rc = Matrix::from_columns(&[r.column(0) * c_l.x, r.column(1) * c_l.y, r.column(2) * c_l.z]);
    rc * r.transpose()
}

/// Bending and twist between two frames: `r = q̄_a q_b` with real part w ≥ 0 and imaginary part v,
/// `κ = (2/λ) (1 + |v|²/6) v`, `E = ½ λ (κ−κ°)ᵀ C (κ−κ°)`, `C = diag(EI1, EI2, GJ)`.
///
/// The plain law `(2/λ) v` measures the sine of half the angle, which in tight bends costs as much accuracy as the
/// whole rest of the scheme; with the next term of the arcsine the curvature is the angle over the length up to the
/// fourth power of the angle.
#[derive(Clone, Copy)]
pub struct BendTwist {
    /// Real part of r.
    pub w: f64,
    /// Imaginary part of r.
    pub v: Vector,
    /// C (κ − κ°), N m.
    pub moment: Vector,
    /// κ − κ°, 1/m.
    pub strain: Vector,
    /// κ, 1/m.
    curvature: Vector,
    /// 1/λ, 1/m.
    pub by_length: f64,
    /// `½ ∂E/∂v = G C (κ−κ°)` with `G = (1 + |v|²/6) I + v vᵀ/3`, N m.
    half_mu: Vector,
}

impl BendTwist {
    /// Between frames `qa` and `qb` at distance `lambda` (m), stiffness diagonal `c` (N m²), rest
    /// curvature `k0` (1/m).
    #[inline(always)]
    pub fn new(qa: &Rotation, qb: &Rotation, lambda: f64, c: &Vector, k0: &Vector) -> Self {
        let (w, v) = relative(qa, qb);
        let by_length = 1.0 / lambda;
        let curvature = v * (2.0 * metric(&v) * by_length);
        let strain = curvature - k0;
        let moment = c.component_mul(&strain);
        Self { w, v, moment, strain, curvature, by_length, half_mu: conjugate(&v, &moment) }
    }

    /// κ, 1/m.
    pub fn curvature(&self) -> Vector {
        self.curvature
    }

    /// The same coupling with this moment (N m) in place of `C (κ − κ°)`.
    pub fn with_moment(self, moment: Vector) -> Self {
        Self { moment, half_mu: conjugate(&self.v, &moment), ..self }
    }

    /// (bend, twist) energy, J.
    #[inline(always)]
    pub fn energy(&self, lambda: f64) -> (f64, f64) {
        let (m, k) = (&self.moment, &self.strain);
        (0.5 * lambda * (m.x * k.x + m.y * k.y), 0.5 * lambda * m.z * k.z)
    }

    /// `[∂E/∂λ, ∂²E/∂λ²]` with both frames fixed, where κ goes with 1/λ: `½ (κ°ᵀ C κ° − κᵀ C κ)` and `κᵀ C κ/λ`.
    pub fn length_terms(&self, lambda: f64, c: &Vector) -> [f64; 2] {
        length_terms(&self.curvature, &(self.curvature - self.strain), lambda, c)
    }

    /// The law whose gradient is the derivative of the gradient in λ: that with `∂m/∂λ = −C κ/λ` in place of m.
    pub fn per_length(self, lambda: f64, c: &Vector) -> Self {
        let moment = c.component_mul(&self.curvature) / -lambda;
        Self { moment, half_mu: conjugate(&self.v, &moment), ..self }
    }

    /// `(∂E/∂θ_a, ∂E/∂θ_b)`: with `μ = ∂E/∂v`, `∂v/∂θ_b = ½(w I + [v]ₓ)` and `∂v/∂θ_a = −½(w I − [v]ₓ)` they
    /// are `−½(w μ + v × μ)` and `½(w μ − v × μ)`.
    #[inline(always)]
    pub fn gradient(&self) -> (Vector, Vector) {
        let wm = self.half_mu * self.w;
        let vm = self.v.cross(&self.half_mu);
        (-(wm + vm), wm - vm)
    }

    /// [`Self::hessian_with`] with C, diagonal, as the derivative of the moment.
    #[inline(always)]
    pub fn hessian(&self, c: &Vector) -> CouplingHessian {
        let g = self.metric();
        self.hessian_of(Matrix::from_diagonal(&(c * (4.0 * g * g * self.by_length))), c.component_mul(&self.v))
    }

    /// With `J_b = ½(w I + [v]ₓ)`, `J_a = −J_bᵀ`, `μ = ∂E/∂v`, T = `tangent` the derivative of the moment m in κ (N m²,
    /// symmetric) and `K = ∂²E/∂v² = (4/λ) G T G + ⅔ ((m·v) I + m vᵀ + v mᵀ)`:
    /// `H_bb = J_bᵀ K J_b − ¼(μ·v) I`, `H_aa = J_aᵀ K J_a − ¼(μ·v) I`,
    /// `H_ab = J_aᵀ K J_b + ¼(v μᵀ + μ vᵀ + w [μ]ₓ − (μ·v) I)`.
    #[inline(always)]
    pub fn hessian_with(&self, tangent: &Matrix) -> CouplingHessian {
        let g = self.metric();
        self.hessian_of(tangent * (4.0 * g * g * self.by_length), tangent * self.v)
    }

    /// g of `G = g I + v vᵀ/3`: `1 + |v|²/6`.
    #[inline(always)]
    fn metric(&self) -> f64 {
        metric(&self.v)
    }

    /// The Hessian from `(4/λ) g² T` and T v.
    #[inline(always)]
    fn hessian_of(&self, plain: Matrix, tv: Vector) -> CouplingHessian {
        let (w, v, m) = (self.w, &self.v, &self.moment);
        let g = self.metric();
        // G T G = g² T + (g/3)(T v vᵀ + v vᵀ T) + (vᵀ T v/9) v vᵀ; with y = (4/λ)((g/3) T v + (vᵀ T v/18) v) + ⅔ m the
        // rest is v yᵀ + y vᵀ.
        let y = (tv * (g * (1.0 / 3.0)) + v * (tv.dot(v) * (1.0 / 18.0))) * (4.0 * self.by_length) + m * (2.0 / 3.0);
        let mv = m.dot(v) * (2.0 / 3.0);
        let kxy = plain.m12 + v.x * y.y + y.x * v.y;
        let kxz = plain.m13 + v.x * y.z + y.x * v.z;
        let kyz = plain.m23 + v.y * y.z + y.y * v.z;
        let k = Matrix::new(
            plain.m11 + mv + 2.0 * v.x * y.x,
            kxy,
            kxz,
            kxy,
            plain.m22 + mv + 2.0 * v.y * y.y,
            kyz,
            kxz,
            kyz,
            plain.m33 + mv + 2.0 * v.z * y.z,
        );
        // With A = [v]ₓ K, so that K [v]ₓ = −Aᵀ, and B = [v]ₓ K [v]ₓ = A [v]ₓ:
        // 4 J K Jᵀ = w² K − B + w (A + Aᵀ), 4 Jᵀ K J = w² K − B − w (A + Aᵀ), 4 J K J = w² K + B + w (A − Aᵀ).
        let a = crossed_from_left(v, &k);
        let b = crossed_from_right(&a, v);
        let at = a.transpose();
        let k = k * (0.25 * w * w);
        let (b, symmetric, skew) = (b * 0.25, (a + at) * (0.25 * w), (a - at) * (0.25 * w));
        let geometric = Geometric::new(w, v, &self.half_mu);
        let diagonal = k - b + geometric.diagonal;
        CouplingHessian { aa: diagonal + symmetric, ab: geometric.mixed - k - b - skew, bb: diagonal - symmetric }
    }

    /// Second derivatives of an energy with `∂²E/∂κ∂κ′ = mixed` in the frames of this coupling (κ) and the next one
    /// (κ′): rows its first and second frame, columns those of the next. With `B = (1/λλ′) G mixed
    /// G′` and `∂κ/∂θ_b = (1/λ) G (w I + [v]ₓ)`, `∂κ/∂θ_a = −(1/λ) G (w I − [v]ₓ)` they are `∓(w I ± [v]ₓ) B (∓(w′ I ∓
    /// [v′]ₓ))`, upper signs for the first frames.
    #[inline(always)]
    pub fn hessian_across(&self, next: &Self, mixed: &Matrix) -> [[Matrix; 2]; 2] {
        let (v, u) = (&self.v, &next.v);
        let (g, f) = (self.metric(), next.metric());
        // G mixed G′, as in `hessian_of`.
        let (from_left, from_right) = (mixed.tr_mul(v), mixed * u);
        let b = mixed * (g * f)
            + v * (from_left * (f * (1.0 / 3.0)) + u * (from_left.dot(u) * (1.0 / 9.0))).transpose()
            + (from_right * (g * (1.0 / 3.0))) * u.transpose();
        let b = b * (self.by_length * next.by_length);
        let (along, across) = (b * self.w, crossed_from_left(v, &b));
        [-along - across, along - across].map(|row| {
            let (along, across) = (row * next.w, crossed_from_right(&row, u));
            [across - along, across + along]
        })
    }
}

/// `[v]ₓ M`.
#[inline(always)]
fn crossed_from_left(v: &Vector, m: &Matrix) -> Matrix {
    let column = |i: usize| -> Vector { v.cross(&m.column(i)) };
    Matrix::from_columns(&[column(0), column(1), column(2)])
}

/// `M [v]ₓ`.
#[inline(always)]
fn crossed_from_right(m: &Matrix, v: &Vector) -> Matrix {
    let (x, y, z) = (m.column(0), m.column(1), m.column(2));
    Matrix::from_columns(&[y * v.z - z * v.y, z * v.x - x * v.z, x * v.y - y * v.x])
}

/// The same of a segment at v: `[½ (EA (1 + ε)² − vᵀ C v), vᵀ C v/ℓ]`, EA being C3 but for what lies beyond it.
fn stretch_length_terms(v: &Vector, free: f64, l: f64, c: &Vector, beyond: f64) -> [f64; 2] {
    let [first, second] = length_terms(v, &(Vector::z() * free), l, c);
    [first - 0.5 * beyond * (free * free), second]
}

/// `[½ (e°ᵀ C e° − eᵀ C e), eᵀ C e/ℓ]`: derivatives in ℓ of `½ ℓ (e−e°)ᵀ C (e−e°)` where e goes with 1/ℓ.
fn length_terms(e: &Vector, rest: &Vector, l: f64, c: &Vector) -> [f64; 2] {
    let twice = c.dot(&e.component_mul(e));
    [0.5 * (c.dot(&rest.component_mul(rest)) - twice), twice / l]
}

/// `1 + |v|²/6`.
#[inline(always)]
fn metric(v: &Vector) -> f64 {
    1.0 + v.norm_squared() * (1.0 / 6.0)
}

/// `G m` with `G = (1 + |v|²/6) I + v vᵀ/3`: half of ∂E/∂v.
#[inline(always)]
fn conjugate(v: &Vector, moment: &Vector) -> Vector {
    moment * metric(v) + v * (v.dot(moment) * (1.0 / 3.0))
}

/// `(w, v)` of `q̄_a q_b`, with the sign that makes w ≥ 0.
#[inline(always)]
fn relative(qa: &Rotation, qb: &Rotation) -> (f64, Vector) {
    let (a, b) = (qa.imag(), qb.imag());
    let w = qa.w * qb.w + a.dot(&b);
    let v = b * qa.w - a * qb.w - a.cross(&b);
    if w < 0.0 { (-w, -v) } else { (w, v) }
}

/// The rotation between two frames at a distance λ (m) with the curvature κ (1/m): its imaginary part v has
/// `(1 + |v|²/6) v = (λ/2) κ`.
pub fn turn_of_curvature(curvature: &Vector, lambda: f64) -> Rotation {
    let half = curvature * (0.5 * lambda);
    let wanted = half.norm();
    if wanted == 0.0 {
        return Rotation::identity();
    }
    let mut v = wanted.sin();
    for _ in 0..20 {
        v -= (v * (1.0 + v * v / 6.0) - wanted) / (1.0 + 0.5 * v * v);
    }
    let w = (1.0 - v * v).max(0.0).sqrt();
    Unit::new_normalize(Quaternion::from_parts(w, half * (v / wanted)))
}

/// Second derivatives of `μ·v` with μ fixed: `−¼(μ·v) I` in either frame alone, `¼(v μᵀ + μ vᵀ + w [μ]ₓ − (μ·v) I)`
/// in both (rows a, columns b).
struct Geometric {
    diagonal: Matrix,
    mixed: Matrix,
}

impl Geometric {
    #[inline(always)]
    fn new(w: f64, v: &Vector, half_mu: &Vector) -> Self {
        let diagonal = Matrix::identity() * (-0.5 * half_mu.dot(v));
        let outer = v * half_mu.transpose() * 0.5;
        Self { mixed: outer + outer.transpose() + skew(half_mu) * (0.5 * w) + diagonal, diagonal }
    }
}

/// Stretch and shear of a segment beside a station (or between two).
///
/// The strain is that of an edge corrected by frames beside it: `Γ = u − (1 + ε) e3`, `v = B u`, `B = I − Σ a (I − R′)`
/// with `R′ = Rᵀ R_k` over the neighbours k. A node between segments stands for the point `x − (ℓ²/24) x″` of the
/// centre line, a station for the point itself; so the edge between them is short of the tangent at its middle by
/// `(ℓ/24) x″` at the station Q, and ℓ x″ there is a difference of the tangents `R u` of Q, of the segment and, to
/// second order, of the next one: see [`Stencil`].
pub struct BlendedStretchShear {
    /// R(q).
    pub r: Matrix,
    /// v = Rᵀ e/ℓ.
    pub v: Vector,
    /// n = C Γ.
    pub n: Vector,
    /// C at Γ + e3.
    pub c: Vector,
    /// Part of it that belongs to frame B.
    beyond: f64,
    /// u.
    u: Vector,
    /// 1 + ε.
    free: f64,
    /// B⁻¹.
    inverse: Matrix,
    /// a and R′ of each neighbour.
    turns: [Option<(f64, Matrix)>; 2],
}

/// Coefficients a of [`BlendedStretchShear`].
///
/// `ℓ x″ ≈ 2 (t_½ − t_Q)` is of first order in ℓ and gives a = 1/12 to the station; with the next segment
/// `ℓ x″ ≈ −(8/3) t_Q + 3 t_½ − (1/3) t_{3/2}`, of second order, gives 1/9 to the station and 1/72 to that.
///
/// Without [`crate::variation::Variation`] the scheme is of second order: to leading order it differs from the rod by
/// the functional `(ℓ²/24) ([n·x″] − ∫ κ′ᵀ C κ′ ds)` (modified equation, per span between stations, dead loads aside).
/// a = 1/12 takes out its boundary term; with a = 1/8 what is then left at the boundary works against the integral too,
/// and the error of clamped, hanging and branched references is least. At a station within a branch the integral has
/// two sides to be worked against: there 3/16 is best for what lies in a ring, and indifferent for a clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stencil {
    /// Of a station.
    pub station: f64,
    /// Of the next segment.
    pub next: f64,
}

impl Stencil {
    /// Of second order, in which the next segment takes part.
    pub const WIDE: Self = Self { station: 1.0 / 9.0, next: 1.0 / 72.0 };
    /// Of first order.
    pub const NARROW: Self = Self { station: 1.0 / 12.0, next: 0.0 };
    /// At an end of the branch, for a scheme of second order.
    pub const END: Self = Self { station: 1.0 / 8.0, next: 0.0 };
    /// Within the branch, for a scheme of second order.
    pub const INNER: Self = Self { station: 3.0 / 16.0, next: 0.0 };
}

impl BlendedStretchShear {
    /// At edge `e` (m) and frame `q` with neighbours, each with its frame and a, for rest length `l` (m) and free
    /// strain ε.
    pub fn new(
        e: &Vector,
        q: &Rotation,
        neighbours: [Option<(&Rotation, f64)>; 2],
        [l, free_strain]: [f64; 2],
        stiffness: &SegmentStiffness,
    ) -> Self {
        let r = rotation_matrix(q);
        let v = r.tr_mul(e) / l;
        let turns = neighbours.map(|k| k.map(|(frame, a)| (a, r.tr_mul(&rotation_matrix(frame)))));
        let mut b = Matrix::identity();
        for (a, turn) in turns.iter().flatten() {
            b += (turn - Matrix::identity()) * *a;
        }
        // The sum of all a is less than a half, so B is regular.
        let inverse = b.try_inverse().unwrap_or(Matrix::repeat(f64::NAN));
        let u = inverse * v;
        let (c, beyond) = stiffness.at(&u);
        let free = 1.0 + free_strain;
        let n = stiffness.c.component_mul(&(u - Vector::z() * free)) + Vector::z() * (beyond * u.z);
        Self { r, v, n, c, beyond, u, free, inverse, turns }
    }

    /// Γ.
    pub fn strain(&self) -> Vector {
        self.u - Vector::z() * self.free
    }

    /// As [`StretchShear::with_force`].
    pub fn with_force(self, n: Vector) -> Self {
        Self { n, ..self }
    }

    /// u.
    pub fn corrected(&self) -> &Vector {
        &self.u
    }

    /// (shear, stretch) energy, J.
    pub fn energy(&self, l: f64) -> (f64, f64) {
        let (n, u) = (&self.n, &self.u);
        (0.5 * l * (n.x * u.x + n.y * u.y), 0.5 * l * (n.z * (u.z - self.free) + self.beyond * u.z))
    }

    /// As [`StretchShear::length_terms`], with u in place of v.
    pub fn length_terms(&self, l: f64) -> [f64; 2] {
        stretch_length_terms(&self.u, self.free, l, &self.c, self.beyond)
    }

    /// As [`StretchShear::per_length`].
    pub fn per_length(self, l: f64) -> Self {
        Self { n: self.c.component_mul(&self.u) / -l, ..self }
    }

    /// World force on the edge, `R p` with `p = B⁻ᵀ n`, N.
    pub fn world_force(&self) -> Vector {
        self.r * self.inverse.tr_mul(&self.n)
    }

    /// `(∂E/∂e, ∂E/∂θ, [∂E/∂θ_k])`: with p, which is conjugate to v, `R p` and `ℓ (p × v + Σ a (R′ u) × p)`, and
    /// `ℓ a z × u` with `z = R′ᵀ p` on a neighbour.
    pub fn gradient(&self, l: f64) -> (Vector, Vector, [Vector; 2]) {
        let p = self.inverse.tr_mul(&self.n);
        let mut moment = p.cross(&self.v);
        let mut at_neighbours = [Vector::zeros(); 2];
        for (turn, at) in self.turns.iter().zip(&mut at_neighbours) {
            if let Some((a, turn)) = turn {
                moment += (turn * self.u).cross(&p) * *a;
                *at = turn.tr_mul(&p).cross(&self.u) * (a * l);
            }
        }
        (self.r * p, moment * l, at_neighbours)
    }

    /// `∂²E/∂e² = R B⁻ᵀ C B⁻¹ Rᵀ/ℓ`.
    pub fn edge_stiffness(&self, l: f64) -> Matrix {
        edge_stiffness(&(self.r * self.inverse.transpose()), l, &self.c)
    }

    /// [`Self::edge_stiffness`] with T in place of C; see [`StretchShear::hessian_with`].
    pub fn edge_stiffness_with(&self, l: f64, tangent: &Matrix) -> Matrix {
        let r = self.r * self.inverse.transpose();
        r * tangent * r.transpose() / l
    }

    /// J = ∂u in (e, θ, θ_1, θ_2): `B⁻¹ Rᵀ/ℓ`, `B⁻¹ ([v]ₓ − Σ a [R′ u]ₓ)` and `a B⁻¹ R′ [u]ₓ`.
    fn jacobians(&self, l: f64) -> [Matrix; 4] {
        let skew_u = skew(&self.u);
        let mut all = [self.r.transpose() / l, skew(&self.v), Matrix::zeros(), Matrix::zeros()];
        for (k, turn) in self.turns.iter().enumerate() {
            if let Some((a, turn)) = turn {
                all[1] -= skew(&(turn * self.u)) * *a;
                all[2 + k] = turn * skew_u * *a;
            }
        }
        all.map(|of_v| self.inverse * of_v)
    }

    /// δΓ for a step.
    pub fn strain_change(&self, l: f64, de: &Vector, theta: &Vector, at_neighbours: [Vector; 2]) -> Vector {
        let [by_edge, own, first, second] = self.jacobians(l);
        by_edge * de + own * theta + first * at_neighbours[0] + second * at_neighbours[1]
    }

    /// [`Self::hessian_with`] with C, diagonal, as the derivative of the force.
    pub fn hessian(&self, l: f64, n: &Vector) -> (SegmentHessian, NeighbourHessian) {
        self.hessian_with(l, n, &Matrix::from_diagonal(&self.c))
    }

    /// Second derivatives with `n` as the force of the geometric part and C its derivative in Γ: `ℓ Jᵀ C J`, and those
    /// of `ℓ n·u`. By `B δ²u = δ²v − 2 δB δu − δ²B u` these are, with `p = B⁻ᵀ n`, the second derivatives of `ℓ p·v` at
    /// fixed p, `−ℓ (L J + Jᵀ Lᵀ)` with `δᵀ L w = p·δB w`, and for each neighbour, with `y = R′ u` and `z = R′ᵀ p`,
    /// those of `−ℓ a p·exp(−θ) R′ exp(θ_k) u` at fixed u:
    ///
    /// ```text
    /// L: rows θ   Σ a [p]ₓ R′,    rows θ_k  −a [z]ₓ
    /// θ θ         −ℓ a (sym(p yᵀ) − (p·y) I)
    /// θ_k θ_k     −ℓ a (sym(z uᵀ) − (z·u) I)
    /// θ_k θ       ℓ a ([p]ₓ R′ [u]ₓ)ᵀ
    /// ```
    pub fn hessian_with(&self, l: f64, n: &Vector, c: &Matrix) -> (SegmentHessian, NeighbourHessian) {
        let p = self.inverse.tr_mul(n);
        let rt = self.r.transpose();
        let jacobians = self.jacobians(l);
        let mut turned = [Matrix::zeros(); 4];
        for (k, turn) in self.turns.iter().enumerate() {
            if let Some((a, turn)) = turn {
                turned[1] += skew(&p) * turn * *a;
                turned[2 + k] = skew(&turn.tr_mul(&p)) * -*a;
            }
        }
        let block = |i: usize, k: usize| -> Matrix {
            let (a, b) = (&jacobians[i], &jacobians[k]);
            (a.transpose() * c * b - turned[i] * b - a.transpose() * turned[k].transpose()) * l
        };
        let symmetric = |a: &Vector, b: &Vector| -> Matrix {
            let outer = a * b.transpose() * 0.5;
            outer + outer.transpose() - Matrix::identity() * a.dot(b)
        };
        let mut segment = SegmentHessian { ee: block(0, 0), te: block(1, 0), tt: block(1, 1) };
        segment.te += skew(&p) * rt;
        segment.tt += symmetric(&p, &self.v) * l;
        let mut neighbours = NeighbourHessian {
            se: [block(2, 0), block(3, 0)],
            st: [block(2, 1), block(3, 1)],
            ss: [block(2, 2), block(3, 3)],
            s1s0: block(3, 2),
        };
        for (k, turn) in self.turns.iter().enumerate() {
            if let Some((a, turn)) = turn {
                let (y, z) = (turn * self.u, turn.tr_mul(&p));
                segment.tt -= symmetric(&p, &y) * (a * l);
                neighbours.ss[k] -= symmetric(&z, &self.u) * (a * l);
                neighbours.st[k] += (skew(&p) * turn * skew(&self.u)).transpose() * (a * l);
            }
        }
        (segment, neighbours)
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
