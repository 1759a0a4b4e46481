//! Energy of the variation of curvature within the cells of couplings, which makes the staggered scheme one of fourth
//! order.
//!
//! A coupling measures one curvature κ over its cell of length λ: the rotation vector from one end to the other over λ.
//! The mean of the curvature over the cell is, with its rate D along the cable (Magnus 1954; Iserles and Nørsett 1999,
//! On the solution of linear differential equations in Lie groups),
//!
//! ```text
//! κ̄ = κ − (λ²/12) κ × D,     ½ ∫ εᵀ C ε ds = ½ λ ε̄ᵀ C ε̄ + (λ³/24) Dᵀ C D,     ε = κ − κ°
//! ```
//!
//! to the order of λ⁵. With both, the discrete energy of bending and twist loses its error `−(ℓ²/24) ∫ κ′ᵀ C κ′ ds` and
//! that of the rotation vector. D is the difference of the curvatures of two neighbouring couplings a and b over the
//! distance `h = ½ (λ_a + λ_b)` of their middles, and each pair has a share p of both cells:
//!
//! ```text
//! E = Σ_k ½ p_k λ_k (r_kᵀ C r_k − ε_kᵀ C ε_k) + w uᵀ C u           k = a, b
//! r_k = ε_k − β_k (κ_a × κ_b − κ°_a × κ°_b)                        β_k = λ_k²/(12 h)
//! u   = ε_b − ε_a                                                  w = f (p_a λ_a³ + p_b λ_b³)/(24 h²)
//! ```
//!
//! The part `½ p λ εᵀ C ε` that is taken off belongs to the couplings themselves ([`crate::kernel::BendTwist`]), so the
//! sum of all is not negative. f is 1, or what the rod's own parts add to the error of the grid
//! ([`crate::rods::kirchhoff`]).

use crate::kernel::BendTwist;
use wireloom_core::rotation::skew;
use wireloom_core::{Matrix, Vector};

/// One pair of neighbouring couplings of the same stiffness.
pub struct Variation {
    /// λ_a, λ_b, m.
    lengths: [f64; 2],
    /// 1/λ_a, 1/λ_b, 1/m.
    inverses: [f64; 2],
    /// p_a, p_b.
    shares: [f64; 2],
    /// f.
    factor: f64,
    /// C: diag(EI1, EI2, GJ), N m².
    c: Vector,
    /// κ_a, κ_b, 1/m.
    curvatures: [Vector; 2],
    /// ε_a, ε_b, 1/m.
    strains: [Vector; 2],
    /// `κ°_a × κ°_b`, 1/m².
    rest_cross: Vector,
    /// β_a, β_b, m.
    betas: [f64; 2],
    /// r_a, r_b, 1/m.
    means: [Vector; 2],
    /// w, m.
    weight: f64,
}

/// Derivatives of a pair's energy in the lengths λ_a and λ_b of its couplings, with the frames fixed.
pub struct LengthDerivatives {
    /// `∂E/∂λ_a, ∂E/∂λ_b`, N.
    pub first: [f64; 2],
    /// `∂²E/∂λ_a², ∂²E/∂λ_b²`, N/m.
    pub second: [f64; 2],
    /// `∂²E/∂λ_a∂λ_b`, N/m.
    pub mixed: f64,
}

impl Variation {
    /// Of two couplings with these lengths λ (m), shares p, factor f and stiffness C (N m²).
    #[inline(always)]
    pub fn new(couplings: [&BendTwist; 2], lengths: [f64; 2], shares: [f64; 2], factor: f64, c: &Vector) -> Self {
        let curvatures = couplings.map(BendTwist::curvature);
        let strains = couplings.map(|own| own.strain);
        let rest = [curvatures[0] - strains[0], curvatures[1] - strains[1]];
        let rest_cross = rest[0].cross(&rest[1]);
        let cross = curvatures[0].cross(&curvatures[1]) - rest_cross;
        let by_distance = 2.0 / (lengths[0] + lengths[1]);
        let squares = lengths.map(|length| length * length);
        let betas = squares.map(|square| square * (by_distance * (1.0 / 12.0)));
        let mean = |k: usize| strains[k] - cross * betas[k];
        let cubes = shares[0] * squares[0] * lengths[0] + shares[1] * squares[1] * lengths[1];
        Self {
            lengths,
            inverses: couplings.map(|own| own.by_length),
            shares,
            factor,
            c: *c,
            curvatures,
            strains,
            rest_cross,
            betas,
            means: [mean(0), mean(1)],
            weight: cubes * (factor * (1.0 / 24.0)) * (by_distance * by_distance),
        }
    }

    /// h.
    fn distance(&self) -> f64 {
        0.5 * (self.lengths[0] + self.lengths[1])
    }

    /// u.
    fn change(&self) -> Vector {
        self.strains[1] - self.strains[0]
    }

    /// (bend, twist) energy, J.
    #[inline(always)]
    pub fn energy(&self) -> (f64, f64) {
        let u = self.change();
        let mut sum = u.component_mul(&u) * self.weight;
        for k in 0..2 {
            let (r, e) = (&self.means[k], &self.strains[k]);
            sum += (r.component_mul(r) - e.component_mul(e)) * (0.5 * self.shares[k] * self.lengths[k]);
        }
        let sum = self.c.component_mul(&sum);
        (sum.x + sum.y, sum.z)
    }

    /// `M = Σ p λ β C r`, N m³.
    #[inline(always)]
    fn crossed(&self) -> Vector {
        let part = |k: usize| self.means[k] * (self.shares[k] * self.lengths[k] * self.betas[k]);
        self.c.component_mul(&(part(0) + part(1)))
    }

    /// `∂E/∂κ_k/λ_k` of both couplings, N m: what is added to their moments. `∂E/∂κ_a = p_a λ_a C (r_a − ε_a) − κ_b × M
    /// − 2 w C u` and `∂E/∂κ_b = p_b λ_b C (r_b − ε_b) − M × κ_a + 2 w C u`.
    #[inline(always)]
    pub fn moments(&self) -> [Vector; 2] {
        let m = self.crossed();
        let [ka, kb] = &self.curvatures;
        let by_rate = self.c.component_mul(&self.change()) * (2.0 * self.weight);
        let by_mean = |k: usize| self.c.component_mul(&(self.means[k] - self.strains[k])) * self.shares[k];
        [
            by_mean(0) - (kb.cross(&m) + by_rate) * self.inverses[0],
            by_mean(1) - (m.cross(ka) - by_rate) * self.inverses[1],
        ]
    }

    /// `∂²E/∂κ_a²`, `∂²E/∂κ_a∂κ_b` (rows a) and `∂²E/∂κ_b²`, N m³. With `K = [κ]ₓ`, `q_k = p_k λ_k β_k` and
    /// `γ = Σ q_k β_k`, by the derivatives of r_k, `I ± β_k K` in the own and `∓ β_k K` in the other curvature:
    ///
    /// ```text
    /// a a   q_a (C K_b + K_bᵀ C) + γ K_bᵀ C K_b + 2 w C
    /// a b   −q_a C K_a + q_b K_bᵀ C − γ K_bᵀ C K_a − 2 w C + [M]ₓ
    /// b b   −q_b (C K_a + K_aᵀ C) + γ K_aᵀ C K_a + 2 w C
    /// ```
    #[inline(always)]
    pub fn hessian(&self) -> [Matrix; 3] {
        let [ka, kb] = &self.curvatures;
        let q = [0, 1].map(|k| self.shares[k] * self.lengths[k] * self.betas[k]);
        let gamma = q[0] * self.betas[0] + q[1] * self.betas[1];
        let by_rate = Matrix::from_diagonal(&(self.c * (2.0 * self.weight)));
        let (of_a, of_b) = (self.scaled_skew(ka), self.scaled_skew(kb));
        let aa = (of_b + of_b.transpose()) * q[0] + self.sandwich(kb, kb) * gamma + by_rate;
        let ab =
            of_b.transpose() * q[1] - of_a * q[0] - self.sandwich(kb, ka) * gamma - by_rate + skew(&self.crossed());
        let bb = self.sandwich(ka, ka) * gamma - (of_a + of_a.transpose()) * q[1] + by_rate;
        [aa, ab, bb]
    }

    /// `C [k]ₓ`.
    #[inline(always)]
    fn scaled_skew(&self, k: &Vector) -> Matrix {
        let c = &self.c;
        Matrix::new(0.0, -c.x * k.z, c.x * k.y, c.y * k.z, 0.0, -c.y * k.x, -c.z * k.y, c.z * k.x, 0.0)
    }

    /// `[a]ₓᵀ C [b]ₓ`.
    #[inline(always)]
    fn sandwich(&self, a: &Vector, b: &Vector) -> Matrix {
        let c = &self.c;
        Matrix::new(
            c.y * a.z * b.z + c.z * a.y * b.y,
            -c.z * a.y * b.x,
            -c.y * a.z * b.x,
            -c.z * a.x * b.y,
            c.x * a.z * b.z + c.z * a.x * b.x,
            -c.x * a.z * b.y,
            -c.y * a.x * b.z,
            -c.x * a.y * b.z,
            c.x * a.y * b.y + c.y * a.x * b.x,
        )
    }

    /// `xᵀ C y`, N.
    fn form(&self, x: &Vector, y: &Vector) -> f64 {
        x.dot(&self.c.component_mul(y))
    }

    /// ∂r_k/∂λ_i with the frames fixed, 1/m²: κ goes with 1/λ.
    fn mean_rate(&self, k: usize, i: usize) -> Vector {
        self.strain_rate(k, i) - self.cross_rate(k, i)
    }

    /// ∂ε_k/∂λ_i, 1/m².
    fn strain_rate(&self, k: usize, i: usize) -> Vector {
        if k == i { self.curvatures[k] / -self.lengths[k] } else { Vector::zeros() }
    }

    /// `β_k κ_a × κ_b` and `β_k κ°_a × κ°_b` go with `λ_k²/(h λ_a λ_b)` and `λ_k²/h`.
    fn crosses(&self, k: usize) -> [Vector; 2] {
        let beta = self.betas[k];
        [self.curvatures[0].cross(&self.curvatures[1]) * beta, self.rest_cross * beta]
    }

    /// Logarithmic derivatives in λ_i of the factors in [`Self::crosses`], 1/m.
    fn cross_logarithms(&self, k: usize, i: usize) -> [f64; 2] {
        let of_square = if k == i { 2.0 / self.lengths[i] } else { 0.0 };
        let of_distance = 0.5 / self.distance();
        [of_square - of_distance - 1.0 / self.lengths[i], of_square - of_distance]
    }

    /// `∂(β_k (κ_a × κ_b − κ°_a × κ°_b))/∂λ_i`, 1/m².
    fn cross_rate(&self, k: usize, i: usize) -> Vector {
        let ([bent, rest], [of_bent, of_rest]) = (self.crosses(k), self.cross_logarithms(k, i));
        bent * of_bent - rest * of_rest
    }

    /// Second derivative of the same in λ_i and λ_j, 1/m³: the product of the logarithmic derivatives and their change.
    fn cross_curvature(&self, k: usize, i: usize, j: usize) -> Vector {
        let ([bent, rest], h) = (self.crosses(k), self.distance());
        let ([bent_i, rest_i], [bent_j, rest_j]) = (self.cross_logarithms(k, i), self.cross_logarithms(k, j));
        let own = if i == j { self.lengths[i].powi(-2) } else { 0.0 };
        let of_rest = 0.25 / (h * h) - if k == i { 2.0 * own } else { 0.0 };
        bent * (bent_i * bent_j + of_rest + own) - rest * (rest_i * rest_j + of_rest)
    }

    /// `∂w/∂λ_i`.
    fn weight_rate(&self, i: usize) -> f64 {
        let h = self.distance();
        let square = self.factor * self.shares[i] * self.lengths[i].powi(2);
        square / (8.0 * h * h) - self.weight / h
    }

    /// `∂²w/∂λ_i∂λ_j`, 1/m.
    fn weight_curvature(&self, i: usize, j: usize) -> f64 {
        let h = self.distance();
        let square = |k: usize| self.factor * self.shares[k] * self.lengths[k].powi(2) / (8.0 * h * h);
        let own = if i == j { 2.0 * square(i) / self.lengths[i] } else { 0.0 };
        own - (square(i) + square(j)) / h + 1.5 * self.weight / (h * h)
    }

    /// Derivatives of the energy in the lengths of the couplings, with the frames fixed.
    pub fn length_derivatives(&self) -> LengthDerivatives {
        // Of ½ p λ (rᵀ C r − εᵀ C ε).
        let u = self.change();
        let difference =
            |k: usize| self.form(&self.means[k], &self.means[k]) - self.form(&self.strains[k], &self.strains[k]);
        let difference_rate = |k: usize, i: usize| {
            let (r, e) = (&self.means[k], &self.strains[k]);
            2.0 * (self.form(r, &self.mean_rate(k, i)) - self.form(e, &self.strain_rate(k, i)))
        };
        let difference_curvature = |k: usize, i: usize, j: usize| {
            let (r, e) = (&self.means[k], &self.strains[k]);
            let bent =
                if k == i && k == j { self.curvatures[k] * (2.0 / self.lengths[k].powi(2)) } else { Vector::zeros() };
            let means = self.form(&self.mean_rate(k, i), &self.mean_rate(k, j))
                + self.form(r, &(bent - self.cross_curvature(k, i, j)));
            let strains = self.form(&self.strain_rate(k, i), &self.strain_rate(k, j)) + self.form(e, &bent);
            2.0 * (means - strains)
        };
        let change_rate = |i: usize| self.strain_rate(1, i) - self.strain_rate(0, i);
        let first = |i: usize| {
            let mut sum = 0.5 * self.shares[i] * difference(i);
            for k in 0..2 {
                sum += 0.5 * self.shares[k] * self.lengths[k] * difference_rate(k, i);
            }
            sum + self.weight_rate(i) * self.form(&u, &u) + 2.0 * self.weight * self.form(&u, &change_rate(i))
        };
        let second = |i: usize, j: usize| {
            let mut sum = 0.5 * (self.shares[i] * difference_rate(i, j) + self.shares[j] * difference_rate(j, i));
            for k in 0..2 {
                sum += 0.5 * self.shares[k] * self.lengths[k] * difference_curvature(k, i, j);
            }
            let (rate_i, rate_j) = (change_rate(i), change_rate(j));
            let sign = if i == 1 { 2.0 } else { -2.0 };
            let bent = if i == j { self.curvatures[i] * (sign / self.lengths[i].powi(2)) } else { Vector::zeros() };
            sum + self.weight_curvature(i, j) * self.form(&u, &u)
                + 2.0 * (self.weight_rate(i) * self.form(&u, &rate_j) + self.weight_rate(j) * self.form(&u, &rate_i))
                + 2.0 * self.weight * (self.form(&rate_i, &rate_j) + self.form(&u, &bent))
        };
        LengthDerivatives { first: [first(0), first(1)], second: [second(0, 0), second(1, 1)], mixed: second(0, 1) }
    }

    /// Derivative of [`Self::moments`], taken as `∂E/∂φ` in the turns `φ = λ κ`, where the lengths change at these
    /// rates.
    pub fn moments_per_length(&self, rates: [f64; 2]) -> [Vector; 2] {
        let along = |rate: &dyn Fn(usize) -> Vector| rate(0) * rates[0] + rate(1) * rates[1];
        let c = |x: Vector| self.c.component_mul(&x);
        let [la, lb] = self.lengths;
        let m = self.crossed();
        // M = Σ p λ³/(12 h) C r.
        let of_distance = 0.25 * (rates[0] + rates[1]) / self.distance();
        let change_of_m = |k: usize| {
            let factor = self.shares[k] * self.lengths[k] * self.betas[k];
            let logarithm = 3.0 * rates[k] / self.lengths[k] - 2.0 * of_distance;
            (self.means[k] * logarithm + along(&|i| self.mean_rate(k, i))) * factor
        };
        let change_of_m = c(change_of_m(0) + change_of_m(1));
        let u = self.change();
        let weight = self.weight_rate(0) * rates[0] + self.weight_rate(1) * rates[1];
        let by_rate = c(u * (2.0 * self.weight));
        let change_by_rate =
            c(u * (2.0 * weight) + along(&|i| self.strain_rate(1, i) - self.strain_rate(0, i)) * (2.0 * self.weight));
        let by_mean = |k: usize| c(along(&|i| self.cross_rate(k, i))) * -self.shares[k];
        // κ_b/λ_a and κ_a/λ_b go with 1/(λ_a λ_b).
        let both = rates[0] / la + rates[1] / lb;
        let [ka, kb] = &self.curvatures;
        [
            by_mean(0) - (kb.cross(&(change_of_m - m * both)) + change_by_rate - by_rate * (rates[0] / la)) / la,
            by_mean(1) - ((change_of_m - m * both).cross(ka) - change_by_rate + by_rate * (rates[1] / lb)) / lb,
        ]
    }
}
