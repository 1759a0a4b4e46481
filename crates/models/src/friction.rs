//! Law of friction within a section: the Prandtl–Ishlinskii operator as the minimum of an energy.
//!
//! An element of stiffness k and limit M has the slip p, and at the curvature e (beyond that at rest) the stored energy
//! `½ k |e − p|²`. A slip from p to p′ dissipates `M |p′ − p|`. At the end of an increment that began with p,
//!
//! ```text
//! h(e − p) = min over p′ of ½ k |e − p′|² + M |p′ − p|,    h(d) = ½ k |d|²            where |d| ≤ M/k: it sticks
//!                                                                 M |d| − M²/(2 k)    elsewhere: it slips
//! ```
//!
//! with the minimum at `p′ = p + (1 − M/(k |d|)) d` where it slips (radial return). h is convex, and its first
//! derivative, the moment of the element, is continuous: `k d`, or `M d/|d|`. The second is `k I`, or
//! `(M/|d|) (I − d dᵀ/|d|²)`. For one increment after the other this is the play-and-stop form of the
//! Prandtl–Ishlinskii operator (Visintin 1994, Differential Models of Hysteresis, chapter III), as the law of a bent
//! wire rope (Papailiou 1997, On the bending stiffness of transmission line conductors, IEEE Transactions on Power
//! Delivery 12) and of cables in assembly. One element that is a part of the bending stiffness is linear kinematic
//! hardening (Prager 1949): what yields is a slip.

use nalgebra::SVector;
use wireloom_core::section::{FrictionElement, SectionFriction};
use wireloom_core::{Matrix, Vector};

/// Fraction of the limit (and of the slip) by which an element must be beyond its limit to slip for good: above the
/// round-off of e and p, so that a state that has been committed does not slip again.
const ROUND_OFF: f64 = 1e-12;
/// Fraction of the limit (and of the slip) within which an element counts as slipping in second derivatives. After a
/// slip it is at its limit, where the second derivative jumps. The smaller one is then taken: no equilibrium is called
/// stable for a stiffness that it has in one direction only.
const AT_LIMIT: f64 = 1e-9;

/// An element in D directions: 2 in bending, 1 in torsion.
struct Element<const D: usize> {
    own: FrictionElement,
    /// d = e − p.
    d: SVector<f64, D>,
    /// p.
    slip: SVector<f64, D>,
}

impl<const D: usize> Element<D> {
    fn new(own: FrictionElement, e: SVector<f64, D>, memory: &[f64]) -> Self {
        let slip = SVector::from_column_slice(memory);
        Self { own, d: e - slip, slip }
    }

    /// Whether |d| is beyond the limit by more than a fraction of limit and slip.
    fn is_beyond(&self, fraction: f64) -> bool {
        let limit = self.own.limit();
        self.d.norm() > limit + fraction * (limit + self.slip.norm())
    }

    /// h, J/m.
    fn energy(&self) -> f64 {
        let FrictionElement { stiffness: k, moment: m } = self.own;
        let d = self.d.norm();
        // Written so that a d that is not a number stays one.
        if d > self.own.limit() { m * d - 0.5 * m * m / k } else { 0.5 * k * d * d }
    }

    /// ∂h, N m.
    fn moment(&self) -> SVector<f64, D> {
        let d = self.d.norm();
        if d > self.own.limit() { self.d * (self.own.moment / d) } else { self.d * self.own.stiffness }
    }

    /// ∂²h, N m²: M/|d| (of what is normal to d) and k (of all), one of them 0.
    fn tangent(&self) -> (f64, f64) {
        if self.is_beyond(-AT_LIMIT) { (self.own.moment / self.d.norm(), 0.0) } else { (0.0, self.own.stiffness) }
    }

    /// p′, and the energy dissipated, J/m.
    fn slipped(&self) -> (SVector<f64, D>, f64) {
        if !self.is_beyond(ROUND_OFF) {
            return (self.slip, 0.0);
        }
        let change = self.d * (1.0 - self.own.limit() / self.d.norm());
        (self.slip + change, self.own.moment * change.norm())
    }
}

/// Elements of a coupling at a curvature beyond that at rest, with their memory.
pub struct Friction<'a> {
    law: &'a SectionFriction,
    /// e, 1/m.
    strain: Vector,
    memory: &'a [f64],
}

impl<'a> Friction<'a> {
    /// Number of state variables of a coupling: p of every element.
    pub fn width(law: &SectionFriction) -> usize {
        2 * law.bending.len() + law.torsion.len()
    }

    /// At the curvature `strain` beyond that at rest (1/m), with the memory of the coupling.
    ///
    /// # Panics
    /// If the memory has not [`Self::width`] numbers.
    pub fn new(law: &'a SectionFriction, strain: Vector, memory: &'a [f64]) -> Self {
        assert_eq!(memory.len(), Self::width(law), "the memory of a coupling");
        Self { law, strain, memory }
    }

    fn bending(&self) -> impl Iterator<Item = Element<2>> {
        let slips = self.memory.chunks_exact(2);
        self.law.bending.iter().zip(slips).map(|(own, slip)| Element::new(*own, self.strain.xy(), slip))
    }

    fn torsion(&self) -> impl Iterator<Item = Element<1>> {
        let slips = self.memory[2 * self.law.bending.len()..].chunks_exact(1);
        let twist = SVector::<f64, 1>::new(self.strain.z);
        self.law.torsion.iter().zip(slips).map(move |(own, slip)| Element::new(*own, twist, slip))
    }

    /// (bending, twist) energy per length, J/m.
    pub fn energy(&self) -> (f64, f64) {
        (self.bending().map(|element| element.energy()).sum(), self.torsion().map(|element| element.energy()).sum())
    }

    /// Moment, N m.
    pub fn moment(&self) -> Vector {
        let bending: SVector<f64, 2> = self.bending().map(|element| element.moment()).sum();
        let torsion: SVector<f64, 1> = self.torsion().map(|element| element.moment()).sum();
        Vector::new(bending.x, bending.y, torsion.x)
    }

    /// Its derivative in the curvature, N m²; symmetric, no eigenvalue negative.
    pub fn tangent(&self) -> Matrix {
        let mut tangent = Matrix::zeros();
        for element in self.bending() {
            let (normal, all) = element.tangent();
            let n = element.d / element.d.norm().max(f64::MIN_POSITIVE);
            tangent.m11 += all + normal * n.y * n.y;
            tangent.m22 += all + normal * n.x * n.x;
            tangent.m12 -= normal * n.x * n.y;
        }
        tangent.m21 = tangent.m12;
        tangent.m33 = self.torsion().map(|element| element.tangent().1).sum();
        tangent
    }

    /// Writes the memory at the end of the increment; returns the energy dissipated in it, J/m.
    pub fn commit(&self, memory: &mut [f64]) -> f64 {
        let (in_bending, in_torsion) = memory.split_at_mut(2 * self.law.bending.len());
        let mut dissipated = 0.0;
        for (element, slip) in self.bending().zip(in_bending.chunks_exact_mut(2)) {
            let (new, energy) = element.slipped();
            slip.copy_from_slice(new.as_slice());
            dissipated += energy;
        }
        for (element, slip) in self.torsion().zip(in_torsion) {
            let (new, energy) = element.slipped();
            *slip = new.x;
            dissipated += energy;
        }
        dissipated
    }
}
