//! The two elastic laws everything is made of, each with value, gradient and Hessian.
//!
//! Derivatives along `x + δ`, `q ∘ exp(θ)`, θ in the body frame. Source of the energies: Cosserat rod on a
//! staggered grid, Spillmann and Teschner 2007 (CoRdE) and Lang, Linn and Arnold 2011 for the
//! quaternion form of the curvature; the second derivatives are derived in the comments below and tested
//! against finite differences.

use wireloom_core::rod::{CouplingHessian, SegmentHessian, StationHessian};
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
    /// `½ ∂E/∂v = G C (κ−κ°)` with `G = (1 + |v|²/6) I + v vᵀ/3`, N m.
    half_mu: Vector,
}

impl BendTwist {
    /// Between frames `qa` and `qb` at distance `lambda` (m), stiffness diagonal `c` (N m²), rest
    /// curvature `k0` (1/m).
    #[inline(always)]
    pub fn new(qa: &Rotation, qb: &Rotation, lambda: f64, c: &Vector, k0: &Vector) -> Self {
        let (w, v) = relative(qa, qb);
        let g = 1.0 + v.norm_squared() / 6.0;
        let curvature = v * (2.0 * g / lambda);
        let strain = curvature - k0;
        let moment = c.component_mul(&strain);
        Self { w, v, moment, strain, curvature, half_mu: conjugate(&v, &moment) }
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

    /// With `J_b = ½(w I + [v]ₓ)`, `J_a = −J_bᵀ`, `μ = ∂E/∂v` and, for `m = C (κ−κ°)`,
    /// `K = ∂²E/∂v² = (4/λ) G C G + ⅔ ((m·v) I + m vᵀ + v mᵀ)`:
    /// `H_bb = J_bᵀ K J_b − ¼(μ·v) I`, `H_aa = J_aᵀ K J_a − ¼(μ·v) I`,
    /// `H_ab = J_aᵀ K J_b + ¼(v μᵀ + μ vᵀ + w [μ]ₓ − (μ·v) I)`.
    #[inline(always)]
    pub fn hessian(&self, lambda: f64, c: &Vector) -> CouplingHessian {
        let (w, v, m) = (self.w, &self.v, &self.moment);
        let g = 1.0 + v.norm_squared() / 6.0;
        // G C G = g² C + (g/3)(C v vᵀ + v vᵀ C) + (vᵀ C v/9) v vᵀ; with y = (4/λ)((g/3) C v + (vᵀ C v/18) v) + ⅔ m the
        // rest is v yᵀ + y vᵀ.
        let cv = c.component_mul(v);
        let y = (cv * (g / 3.0) + v * (cv.dot(v) / 18.0)) * (4.0 / lambda) + m * (2.0 / 3.0);
        let mv = m.dot(v) * (2.0 / 3.0);
        let k = c * (4.0 * g * g / lambda);
        let (kxy, kxz, kyz) = (v.x * y.y + y.x * v.y, v.x * y.z + y.x * v.z, v.y * y.z + y.y * v.z);
        let k = Matrix::new(
            k.x + mv + 2.0 * v.x * y.x,
            kxy,
            kxz,
            kxy,
            k.y + mv + 2.0 * v.y * y.y,
            kyz,
            kxz,
            kyz,
            k.z + mv + 2.0 * v.z * y.z,
        );
        // With A = [v]ₓ K, so that K [v]ₓ = −Aᵀ, and B = [v]ₓ K [v]ₓ = A [v]ₓ:
        // 4 J K Jᵀ = w² K − B + w (A + Aᵀ), 4 Jᵀ K J = w² K − B − w (A + Aᵀ), 4 J K J = w² K + B + w (A − Aᵀ).
        let column = |i: usize| -> Vector { v.cross(&k.column(i)) };
        let a = Matrix::from_columns(&[column(0), column(1), column(2)]);
        let column = |i: usize| -> Vector { a.row(i).transpose().cross(v) };
        let b = Matrix::from_columns(&[column(0), column(1), column(2)]);
        let at = a.transpose();
        let k = k * (0.25 * w * w);
        let (b, symmetric, skew) = (b * 0.25, (a + at) * (0.25 * w), (a - at) * (0.25 * w));
        let geometric = Geometric::new(w, v, &self.half_mu);
        let diagonal = k - b + geometric.diagonal;
        CouplingHessian { aa: diagonal + symmetric, ab: geometric.mixed - k - b - skew, bb: diagonal - symmetric }
    }

    /// [`Self::hessian`] with the derivative `tangent` of the moment in κ (N m², symmetric) in place of C, by its
    /// formulas as they stand there.
    pub fn hessian_with(&self, lambda: f64, tangent: &Matrix) -> CouplingHessian {
        let (w, v, m) = (self.w, &self.v, &self.moment);
        let g = Matrix::identity() * (1.0 + v.norm_squared() / 6.0) + v * v.transpose() / 3.0;
        let outer = m * v.transpose();
        let curved = Matrix::identity() * m.dot(v) + outer + outer.transpose();
        let k = g * tangent * g * (4.0 / lambda) + curved * (2.0 / 3.0);
        let jb = (Matrix::identity() * w + skew(v)) * 0.5;
        let ja = -jb.transpose();
        let geometric = Geometric::new(w, v, &self.half_mu);
        CouplingHessian {
            aa: ja.transpose() * k * ja + geometric.diagonal,
            ab: ja.transpose() * k * jb + geometric.mixed,
            bb: jb.transpose() * k * jb + geometric.diagonal,
        }
    }
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

/// `G m` with `G = (1 + |v|²/6) I + v vᵀ/3`: half of ∂E/∂v.
#[inline(always)]
fn conjugate(v: &Vector, moment: &Vector) -> Vector {
    moment * (1.0 + v.norm_squared() / 6.0) + v * (v.dot(moment) / 3.0)
}

/// `(w, v)` of `q̄_a q_b`, with the sign that makes w ≥ 0.
#[inline(always)]
fn relative(qa: &Rotation, qb: &Rotation) -> (f64, Vector) {
    let (a, b) = (qa.imag(), qb.imag());
    let w = qa.w * qb.w + a.dot(&b);
    let v = b * qa.w - a * qb.w - a.cross(&b);
    if w < 0.0 { (-w, -v) } else { (w, v) }
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
/// The segment's tangent is blended with the station's: `Γ = v + v × φ − (1 + ε) e3` with `φ = Σ 2 β Re(r) Im(r)`,
/// `r = q̄ Q`, over the stations beside it: the turn from the segment's frame to theirs (the sine of its angle, smooth
/// for any turn). To leading order the plain staggered scheme differs from the rod by the functional
/// `(ℓ²/24) ([n·x″] − ∫ κ′ᵀ C κ′ ds)` (modified equation, per span between stations, dead loads aside). β = 1/12 takes
/// out its boundary term, which is the larger part; with β = 1/8 what is then left at the boundary works against the
/// integral too, and the error of clamped, hanging and branched references is least. At a station within a branch the
/// integral has two sides to be worked against: there β = 3/16 is best for what lies in a ring, and indifferent for a
/// clip.
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
    /// Γ.
    gamma: Vector,
    /// (1 + ε) e3.
    free: Vector,
    /// φ.
    phi: Vector,
    /// Of each station β and (w, Im) of q̄ Q.
    turns: [Option<(f64, f64, Vector)>; 2],
}

/// Share β of the tangent of a station at an end of the branch.
pub const END_BLEND: f64 = 1.0 / 8.0;
/// Share β of the tangent of a station within the branch.
pub const INNER_BLEND: f64 = 3.0 / 16.0;

impl BlendedStretchShear {
    /// At edge `e` (m) and frame `q` beside stations, each with its frame and β, for rest length `l` (m) and free
    /// strain ε.
    pub fn new(
        e: &Vector,
        q: &Rotation,
        stations: [Option<(&Rotation, f64)>; 2],
        [l, free_strain]: [f64; 2],
        stiffness: &SegmentStiffness,
    ) -> Self {
        let r = rotation_matrix(q);
        let v = r.tr_mul(e) / l;
        let turns = stations.map(|station| {
            station.map(|(station, blend)| {
                let (w, v) = relative(q, station);
                (blend, w, v)
            })
        });
        let phi = turns.iter().flatten().map(|(blend, w, v)| v * (2.0 * blend * w)).sum();
        let u = v + v.cross(&phi);
        let (c, beyond) = stiffness.at(&u);
        let free = Vector::z() * (1.0 + free_strain);
        let gamma = u - free;
        let n = stiffness.c.component_mul(&gamma) + Vector::z() * (beyond * u.z);
        Self { r, v, n, c, beyond, gamma, free, phi, turns }
    }

    /// (shear, stretch) energy, J.
    pub fn energy(&self, l: f64) -> (f64, f64) {
        let (n, g) = (&self.n, &self.gamma);
        (0.5 * l * (n.x * g.x + n.y * g.y), 0.5 * l * (n.z * g.z + self.beyond * (g.z + self.free.z)))
    }

    /// `n′ = n + φ × n`, the force conjugate to v.
    fn force(&self, n: &Vector) -> Vector {
        n + self.phi.cross(n)
    }

    /// As [`StretchShear::length_terms`], with `Γ + (1 + ε) e3` in place of v.
    pub fn length_terms(&self, l: f64) -> [f64; 2] {
        stretch_length_terms(&(self.gamma + self.free), self.free.z, l, &self.c, self.beyond)
    }

    /// As [`StretchShear::per_length`].
    pub fn per_length(self, l: f64) -> Self {
        Self { n: self.c.component_mul(&(self.gamma + self.free)) / -l, ..self }
    }

    /// World force on the edge, `R n′`, N.
    pub fn world_force(&self) -> Vector {
        self.r * self.force(&self.n)
    }

    /// `(∂E/∂e, ∂E/∂θ, [∂E/∂θ_station])`: as for the plain law with n′, and through φ with `∂E/∂φ = μ = ℓ n × v`;
    /// `∂φ/∂θ` and `∂φ/∂θ_station` are `−β (w (w I − [Im]ₓ) − Im Imᵀ)` and `β (w (w I + [Im]ₓ) − Im Imᵀ)`.
    pub fn gradient(&self, l: f64) -> (Vector, Vector, [Vector; 2]) {
        let force = self.force(&self.n);
        let mu = self.n.cross(&self.v) * l;
        let mut moment = force.cross(&self.v) * l;
        let mut at_stations = [Vector::zeros(); 2];
        for (turn, at) in self.turns.iter().zip(&mut at_stations) {
            if let Some((blend, w, im)) = turn {
                let [segment, station] = turn_jacobians(*w, im).map(|jacobian| jacobian * *blend);
                moment += segment.tr_mul(&mu);
                *at = station.tr_mul(&mu);
            }
        }
        (self.r * force, moment, at_stations)
    }

    /// `∂²E/∂e² = R A C Aᵀ Rᵀ/ℓ` with `Aᵀ = I − [φ]ₓ`, `∂Γ/∂e = Aᵀ Rᵀ/ℓ`.
    pub fn edge_stiffness(&self, l: f64) -> Matrix {
        edge_stiffness(&(self.r * (Matrix::identity() + skew(&self.phi))), l, &self.c)
    }

    /// δΓ for a step: `δv + δv × φ + v × δφ`, `δv = Rᵀ δe/ℓ + v × θ`.
    pub fn strain_change(&self, l: f64, de: &Vector, theta: &Vector, at_stations: [Vector; 2]) -> Vector {
        let dv = self.r.tr_mul(de) / l + self.v.cross(theta);
        let mut dphi = Vector::zeros();
        for (turn, at) in self.turns.iter().zip(&at_stations) {
            if let Some((blend, w, im)) = turn {
                let [segment, station] = turn_jacobians(*w, im).map(|jacobian| jacobian * *blend);
                dphi += segment * theta + station * at;
            }
        }
        dv + dv.cross(&self.phi) + self.v.cross(&dphi)
    }

    /// Second derivatives with `n` as the force of the geometric part: `ℓ Jᵀ C J` with `J = ∂Γ`, the second
    /// derivatives of `ℓ n′·v` in (e, θ) and of `μ·φ` in (θ, θ_Q), and `ℓ n·(δv × δφ)` twice.
    pub fn hessian(&self, l: f64, n: &Vector) -> (SegmentHessian, StationHessian) {
        let v = &self.v;
        let rt = self.r.transpose();
        let c = Matrix::from_diagonal(&self.c);
        // ∂v and ∂φ in (e, θ, Q_1, Q_2), then ∂Γ = (I − [φ]ₓ) ∂v + [v]ₓ ∂φ.
        let dv = [rt / l, skew(v), Matrix::zeros(), Matrix::zeros()];
        let mut dphi = [Matrix::zeros(); 4];
        for (k, turn) in self.turns.iter().enumerate() {
            if let Some((blend, w, im)) = turn {
                let [segment, station] = turn_jacobians(*w, im).map(|jacobian| jacobian * *blend);
                dphi[1] += segment;
                dphi[2 + k] = station;
            }
        }
        let along_v = Matrix::identity() - skew(&self.phi);
        let along_phi = skew(v);
        let dgamma: [Matrix; 4] = std::array::from_fn(|i| along_v * dv[i] + along_phi * dphi[i]);
        // n·(a × b) = aᵀ [n]ₓᵀ b
        let crossed = skew(n).transpose();
        let block = |i: usize, k: usize| -> Matrix {
            let cross = dv[i].transpose() * crossed * dphi[k] + dphi[i].transpose() * crossed.transpose() * dv[k];
            (dgamma[i].transpose() * c * dgamma[k] + cross) * l
        };
        let mut segment = SegmentHessian { ee: block(0, 0), te: block(1, 0), tt: block(1, 1) };
        // Second derivatives of v at fixed n′: as in the plain law.
        let force = self.force(n);
        segment.te += skew(&force) * rt;
        let outer = force * v.transpose();
        segment.tt += ((outer + outer.transpose()) * 0.5 - Matrix::identity() * force.dot(v)) * l;
        // Second derivatives of φ at fixed μ.
        let mu = n.cross(v) * l;
        let mut stations = StationHessian {
            se: [block(2, 0), block(3, 0)],
            st: [block(2, 1), block(3, 1)],
            ss: [block(2, 2), block(3, 3)],
            s1s0: block(3, 2),
        };
        for (k, turn) in self.turns.iter().enumerate() {
            if let Some((blend, w, im)) = turn {
                let [own, mixed, station] = turn_hessians(*w, im, &(mu * *blend));
                segment.tt += own;
                stations.ss[k] += station;
                stations.st[k] += mixed.transpose();
            }
        }
        (segment, stations)
    }
}

/// First derivatives of `φ = 2 w v`, (w, v) = q̄ Q, in the rotations of q and Q:
/// `−(w (w I − [v]ₓ) − v vᵀ)` and `w (w I + [v]ₓ) − v vᵀ`.
fn turn_jacobians(w: f64, v: &Vector) -> [Matrix; 2] {
    let (outer, diagonal, skew) = (v * v.transpose(), Matrix::identity() * (w * w), skew(v) * w);
    [outer + skew - diagonal, diagonal + skew - outer]
}

/// Second derivatives of `μ·φ = 2 w (μ·v)` in the rotation of q, in both (rows q, columns Q) and in that of Q: with
/// `a = ∂(μ·v)/∂θ = −½(w μ + v × μ)` and `b = ∂(μ·v)/∂θ_Q = ½(w μ − v × μ)` `−w (μ·v) I + v aᵀ + a vᵀ`,
/// `½ w (v μᵀ + μ vᵀ + w [μ]ₓ) + v bᵀ − a vᵀ + ½ (μ·v) [v]ₓ` and `−w (μ·v) I − v bᵀ − b vᵀ`.
fn turn_hessians(w: f64, v: &Vector, mu: &Vector) -> [Matrix; 3] {
    let (along, across) = (mu * w, v.cross(mu));
    let (a, b) = ((along + across) * -0.5, (along - across) * 0.5);
    let m = mu.dot(v);
    let diagonal = Matrix::identity() * (-w * m);
    let (va, vb, vmu) = (v * a.transpose(), v * b.transpose(), v * mu.transpose());
    let mixed = (vmu + vmu.transpose() + skew(mu) * w) * (0.5 * w) + vb - va.transpose() + skew(v) * (0.5 * m);
    [diagonal + va + va.transpose(), mixed, diagonal - vb - vb.transpose()]
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
