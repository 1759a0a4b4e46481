//! Law of creep within a section: Maxwell elements, integrated exactly where the curvature changes evenly.
//!
//! An element of stiffness k and time τ has the curvature q of its dashpot: its moment is `k (e − q)`, and
//! `q′ = (e − q)/τ`. Over an increment of duration Δt, in which the curvature goes evenly from `e₀` to e, the exact
//! solution is, with `x = Δt/τ`, `a = exp(−x)` and `g = (1 − a)/x`,
//!
//! ```text
//! m = k g (e − p)        p  = q₀ + (1 − a/g) (e₀ − q₀)
//! q = p + (1 − g) (e − p)
//! ```
//!
//! the derivative of the energy `½ k g |e − p|²` in e. So each increment ends in the minimum of an energy, a curvature
//! that is held relaxes exactly, and one that changes does so to second order in Δt (the recurrence of Taylor, Pister
//! and Goudreau 1970, Thermomechanical analysis of viscoelastic solids, International Journal for Numerical Methods in
//! Engineering 2). How long an increment may be is decided by the driver (`solve::steps::time`). Without a duration p
//! is q₀, and the element is a spring. The dashpot dissipates `∫ |m|²/(k τ) dt`, with the moment `a m₀ + k (e − e₀) g`
//! of a part of the increment in place of that of all.

use nalgebra::SVector;
use wireloom_core::section::{CreepElement, SectionCreep};
use wireloom_core::{Matrix, Vector};

/// x below which [`of_ramp`] is summed as a series: above it the closed form loses less than 1e-11 to round-off.
const SMALL: f64 = 0.02;

/// What an element is in an increment of this duration.
#[derive(Clone, Copy)]
struct Factors {
    /// x.
    x: f64,
    /// a.
    a: f64,
    /// g.
    g: f64,
}

impl Factors {
    fn new(own: CreepElement, duration: f64) -> Self {
        let x = duration / own.time;
        if x == 0.0 { Self { x, a: 1.0, g: 1.0 } } else { Self { x, a: (-x).exp(), g: -(-x).exp_m1() / x } }
    }

    /// `∫₀¹ ((1 − exp(−x t))/x)² dt`.
    fn of_ramp(&self) -> f64 {
        let Self { x, a, g } = *self;
        if x < SMALL {
            // The next term is −x⁵/96.
            return 1.0 / 3.0 + x * (-0.25 + x * (7.0 / 60.0 + x * (-1.0 / 24.0 + x * (31.0 / 2520.0))));
        }
        (1.0 - 2.0 * g + 0.5 * g * (1.0 + a)) / (x * x)
    }
}

/// An element in D directions: 2 in bending, 1 in torsion.
struct Element<const D: usize> {
    k: f64,
    factors: Factors,
    /// e.
    strain: SVector<f64, D>,
    /// e₀.
    before: SVector<f64, D>,
    /// q₀.
    flow: SVector<f64, D>,
    /// p.
    free: SVector<f64, D>,
}

impl<const D: usize> Element<D> {
    /// `e − p`.
    fn stretch(&self) -> SVector<f64, D> {
        self.strain - self.free
    }

    /// J/m.
    fn energy(&self) -> f64 {
        0.5 * self.k * self.factors.g * self.stretch().norm_squared()
    }

    /// N m.
    fn moment(&self) -> SVector<f64, D> {
        self.stretch() * (self.k * self.factors.g)
    }

    /// q.
    fn flown(&self) -> SVector<f64, D> {
        self.free + self.stretch() * (1.0 - self.factors.g)
    }

    /// J/m.
    fn dissipated(&self) -> f64 {
        let Factors { x, a, g } = self.factors;
        let (held, change) = (self.before - self.flow, self.strain - self.before);
        let squares = held.norm_squared() * 0.5 * g * (1.0 + a)
            + held.dot(&change) * g * g
            + change.norm_squared() * self.factors.of_ramp();
        // Round-off may leave less than nothing.
        (self.k * x * squares).max(0.0)
    }
}

/// Elements of a coupling at a curvature beyond that at rest, at the end of an increment, with their memory: e₀ in
/// bending and q₀ of each element there, and the same in torsion; nothing where there are no elements.
pub struct Creep<'a> {
    law: &'a SectionCreep,
    /// e, 1/m.
    strain: Vector,
    memory: &'a [f64],
    /// Δt, s.
    duration: f64,
}

impl<'a> Creep<'a> {
    /// Number of state variables of a coupling.
    pub fn width(law: &SectionCreep) -> usize {
        Self::of_bending(law) + if law.torsion.is_empty() { 0 } else { 1 + law.torsion.len() }
    }

    fn of_bending(law: &SectionCreep) -> usize {
        if law.bending.is_empty() { 0 } else { 2 + 2 * law.bending.len() }
    }

    /// At the curvature `strain` beyond that at rest (1/m), with the memory of the coupling, at the end of an increment
    /// of this duration (s).
    ///
    /// # Panics
    /// If the memory has not [`Self::width`] numbers.
    pub fn new(law: &'a SectionCreep, strain: Vector, memory: &'a [f64], duration: f64) -> Self {
        assert_eq!(memory.len(), Self::width(law), "the memory of a coupling");
        Self { law, strain, memory, duration }
    }

    fn elements<'s, const D: usize>(
        &'s self,
        law: &'s [CreepElement],
        strain: SVector<f64, D>,
        memory: &'s [f64],
    ) -> impl Iterator<Item = Element<D>> + 's {
        let (before, flows) = memory.split_at(D.min(memory.len()));
        law.iter().zip(flows.chunks_exact(D)).map(move |(own, flow)| {
            let factors = Factors::new(*own, self.duration);
            let [before, flow] = [before, flow].map(SVector::from_column_slice);
            let free = flow + (before - flow) * (1.0 - factors.a / factors.g);
            Element { k: own.stiffness, factors, strain, before, flow, free }
        })
    }

    fn bending(&self) -> impl Iterator<Item = Element<2>> {
        self.elements(&self.law.bending, self.strain.xy(), &self.memory[..Self::of_bending(self.law)])
    }

    fn torsion(&self) -> impl Iterator<Item = Element<1>> {
        let twist = SVector::<f64, 1>::new(self.strain.z);
        self.elements(&self.law.torsion, twist, &self.memory[Self::of_bending(self.law)..])
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

    /// Its derivative in the curvature, N m².
    pub fn tangent(&self) -> Matrix {
        let sum = |law: &[CreepElement]| -> f64 {
            law.iter().map(|own| own.stiffness * Factors::new(*own, self.duration).g).sum()
        };
        let [bending, torsion] = [sum(&self.law.bending), sum(&self.law.torsion)];
        Matrix::from_diagonal(&Vector::new(bending, bending, torsion))
    }

    /// Writes the memory at the end of the increment; returns the energy dissipated in it, J/m.
    pub fn commit(&self, memory: &mut [f64]) -> f64 {
        let (in_bending, in_torsion) = memory.split_at_mut(Self::of_bending(self.law));
        written(self.bending(), in_bending) + written(self.torsion(), in_torsion)
    }
}

/// Writes e and q of each element; returns the energy dissipated, J/m.
fn written<const D: usize>(elements: impl Iterator<Item = Element<D>>, memory: &mut [f64]) -> f64 {
    let (before, flows) = memory.split_at_mut(D.min(memory.len()));
    let mut dissipated = 0.0;
    for (element, flow) in elements.zip(flows.chunks_exact_mut(D)) {
        before.copy_from_slice(element.strain.as_slice());
        flow.copy_from_slice(element.flown().as_slice());
        dissipated += element.dissipated();
    }
    dissipated
}
