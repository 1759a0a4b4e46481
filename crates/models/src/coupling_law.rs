//! What a coupling has beside its linear stiffness: a curve of moment over curvature, friction, creep.
//!
//! All act in parallel, on the curvature e beyond that at rest. The curve f is that of its size in bending: the energy
//! per length is `F(|e|)`, `F′ = f`, with the moment `f e/|e|` and the derivative `f′ n nᵀ + (f/|e|) (I − n nᵀ)`,
//! `n = e/|e|`. It is convex where f increases.

use crate::creep::Creep;
use crate::friction::Friction;
use wireloom_core::constitutive::{Point, strain_under};
use wireloom_core::curve::Curve;
use wireloom_core::section::{SectionCreep, SectionFriction};
use wireloom_core::{Matrix, Section, Vector};

/// The laws of a section in bending and torsion, without its linear stiffness.
pub struct CouplingLaw {
    /// f, N m over 1/m.
    pub curve: Option<Curve>,
    /// What slips or yields.
    pub friction: SectionFriction,
    /// What relaxes.
    pub creep: SectionCreep,
}

impl CouplingLaw {
    /// Those of a section.
    pub fn of(section: &Section) -> Self {
        let laws = &section.laws;
        Self { curve: laws.bending.clone(), friction: section.slipping(), creep: laws.creep.clone() }
    }

    /// Number of state variables of a coupling: first those of friction, then those of creep.
    pub fn width(&self) -> usize {
        Friction::width(&self.friction) + Creep::width(&self.creep)
    }

    /// At the curvature `strain` beyond that at rest (1/m), with the memory of a coupling, at the end of an increment
    /// of this duration (s).
    ///
    /// # Panics
    /// If the memory has not [`Self::width`] numbers.
    pub fn at<'a>(&'a self, strain: Vector, memory: &'a [f64], duration: f64) -> Bent<'a> {
        let (slips, flows) = memory.split_at(Friction::width(&self.friction));
        Bent {
            curve: self.curve.as_ref(),
            strain,
            friction: Friction::new(&self.friction, strain, slips),
            creep: Creep::new(&self.creep, strain, flows, duration),
        }
    }

    /// The curvature beyond that at rest under a moment (N m) at the end of an increment of this duration (s), 1/m,
    /// beside a linear stiffness `c` (N m², a diagonal): the root of `C e + ∂h = m`.
    pub fn strain_under(&self, c: &Vector, moment: &Vector, memory: &[f64], duration: f64) -> Vector {
        strain_under(moment, |e| {
            let bent = self.at(*e, memory, duration);
            let (bend, twist) = bent.energy();
            Point {
                energy: 0.5 * e.dot(&c.component_mul(e)) + bend + twist,
                gradient: c.component_mul(e) + bent.moment(),
                hessian: bent.tangent() + Matrix::from_diagonal(c),
            }
        })
    }
}

/// The laws of a coupling at a curvature.
pub struct Bent<'a> {
    curve: Option<&'a Curve>,
    /// e, 1/m.
    strain: Vector,
    friction: Friction<'a>,
    creep: Creep<'a>,
}

impl Bent<'_> {
    /// (bending, twist) energy per length, J/m.
    pub fn energy(&self) -> (f64, f64) {
        let ((bend, twist), (creep_bend, creep_twist)) = (self.friction.energy(), self.creep.energy());
        let of_curve = self.curve.map_or(0.0, |curve| curve.integral(self.strain.xy().norm()));
        (of_curve + bend + creep_bend, twist + creep_twist)
    }

    /// Moment, N m.
    pub fn moment(&self) -> Vector {
        let mut moment = self.friction.moment() + self.creep.moment();
        if let Some((curve, size)) = self.curve.zip(size(&self.strain)) {
            let by_size = curve.value(size) / size;
            moment.x += by_size * self.strain.x;
            moment.y += by_size * self.strain.y;
        }
        moment
    }

    /// Its derivative in the curvature, N m²; symmetric, no eigenvalue negative.
    pub fn tangent(&self) -> Matrix {
        let mut tangent = self.friction.tangent() + self.creep.tangent();
        if let Some(curve) = self.curve {
            let (along, across, n) = match size(&self.strain) {
                Some(size) => (curve.slope(size), curve.value(size) / size, self.strain / size),
                None => (curve.slope(0.0), curve.slope(0.0), Vector::zeros()),
            };
            tangent.m11 += across + (along - across) * n.x * n.x;
            tangent.m22 += across + (along - across) * n.y * n.y;
            let mixed = (along - across) * n.x * n.y;
            tangent.m12 += mixed;
            tangent.m21 += mixed;
        }
        tangent
    }

    /// Writes the memory at the end of the increment; returns the energy dissipated in it, J/m.
    pub fn commit(&self, law: &CouplingLaw, memory: &mut [f64]) -> f64 {
        let (slips, flows) = memory.split_at_mut(Friction::width(&law.friction));
        self.friction.commit(slips) + self.creep.commit(flows)
    }
}

/// Size of the bending; `None` where it is straight.
fn size(strain: &Vector) -> Option<f64> {
    let size = strain.xy().norm();
    // Written so that a size that is not a number stays one.
    (size != 0.0).then_some(size)
}
