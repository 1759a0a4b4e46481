//! Constitutive laws of the cross-sections of a branch: what a rod is made of, without its kinematics.
//!
//! ```text
//! E = Σ_j ℓ_j W(Γ_j) + Σ_c λ_c V(κ_c − κ°_c)
//! ```
//!
//! A rod measures the strains of its segments and couplings ([`crate::rod::Mesh`]), free strain and extra curvature
//! taken off; a law answers with energies per length and their derivatives, for a whole branch in one call. W is the
//! law of stretch and shear, V that of bending and twist. As segments and couplings lie at different places, no law
//! depends on both strains: stretch cannot be coupled with twist.
//!
//! A law of bending and twist may remember: V is then the incremental potential for the memory z at the start of an
//! increment (see [`crate::RodSegment`]).

use crate::terms::slope::{Contradiction, Line, Slope};
use crate::{Matrix, Section, Vector};

/// Energy per length at a strain, and its derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// W, J/m.
    pub energy: f64,
    /// ∂W: force (N), or moment (N m).
    pub gradient: Vector,
    /// ∂²W, N or N m²; symmetric.
    pub hessian: Matrix,
}

/// What a law is asked for, one entry for each strain; `None` is not asked for.
#[derive(Debug)]
pub struct Response<'r> {
    /// W, J/m.
    pub energy: Option<&'r mut [f64]>,
    /// ∂W: forces (N), or moments (N m).
    pub gradient: Option<&'r mut [Vector]>,
    /// ∂²W, N or N m².
    pub hessian: Option<&'r mut [Matrix]>,
}

/// What a law knows beside the strain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Past<'p> {
    /// Memory at the start of the increment: [`ConstitutiveLaw::memory`] numbers for each strain, in their order.
    pub memory: &'p [f64],
    /// Time that the increment takes, s.
    pub duration: f64,
}

impl<'p> Past<'p> {
    /// That of one strain of a block, of a law with so many numbers for each; without any where there are too few.
    pub fn of(&self, k: usize, numbers: usize) -> Self {
        Self { memory: self.memory.get(k * numbers..(k + 1) * numbers).unwrap_or_default(), ..*self }
    }
}

impl Response<'_> {
    /// Writes what is asked for, strain by strain; `law` gets the index of each, too.
    pub fn each(&mut self, strains: &[Vector], law: impl Fn(usize, &Vector) -> Point) {
        for (k, strain) in strains.iter().enumerate() {
            let point = law(k, strain);
            if let Some(all) = &mut self.energy {
                all[k] = point.energy;
            }
            if let Some(all) = &mut self.gradient {
                all[k] = point.gradient;
            }
            if let Some(all) = &mut self.hessian {
                all[k] = point.hessian;
            }
        }
    }
}

/// An energy per length over a strain: `Γ` (shear along d1 and d2, then stretch), or `κ − κ°` (bending about d1 and d2,
/// then twist; 1/m).
///
/// Contract: `W ≥ 0`; at the strain 0 energy and first derivative are 0; second derivatives are symmetric, and those of
/// stretch have no negative eigenvalue; a change of sign of the first component changes no energy (a branch that is run
/// from its other end has such strains). At the strain 0 the second derivative should be near the stiffness that the
/// section states: scales and error estimates rest on that. [`Self::respond`] neither allocates nor fails, writes all
/// that it is asked for, and gives the same bits for the same strain wherever it stands. Strains that are not finite
/// give numbers that are not finite.
///
/// A law with a memory is asked at the memory that [`Self::commit`] wrote last, all numbers of which are 0 at first:
/// what is said above of the strain 0 holds for these, all else for any memory.
pub trait ConstitutiveLaw: Send + Sync {
    /// Writes what is asked for. The memory does not change.
    fn respond(&self, strains: &[Vector], past: Past<'_>, response: &mut Response<'_>);

    /// Number of state variables for each strain; 0: the law is elastic. Only laws of bending and twist may have any.
    fn memory(&self) -> usize {
        0
    }

    /// Updates the memory (as in [`Past`]) to the strains at the end of an increment of this duration (s), and writes
    /// the energy per length that was dissipated at each of them (J/m, never negative; 0 on entry). With the new memory
    /// and no duration the law gives the same moments; a second call then changes no bit and dissipates nothing.
    fn commit(&self, _strains: &[Vector], _duration: f64, _memory: &mut [f64], _dissipated: &mut [f64]) {}

    /// Message of a fatal fault, if one has occurred; see [`crate::Constraint::fault`].
    fn fault(&self) -> Option<String> {
        None
    }
}

impl dyn ConstitutiveLaw + '_ {
    /// The law at one strain, with its past.
    pub fn at(&self, strain: &Vector, past: Past<'_>) -> Point {
        let (mut energy, mut gradient, mut hessian) = ([f64::NAN], [Vector::zeros()], [Matrix::zeros()]);
        let (of_energy, of_gradient, of_hessian) = (Some(&mut energy[..]), Some(&mut gradient[..]), &mut hessian[..]);
        let mut response = Response { energy: of_energy, gradient: of_gradient, hessian: Some(of_hessian) };
        self.respond(&[*strain], past, &mut response);
        Point { energy: energy[0], gradient: gradient[0], hessian: hessian[0] }
    }

    /// The strain under a force (N) or moment (N m), with its past.
    pub fn strain_under(&self, load: &Vector, past: Past<'_>) -> Vector {
        strain_under(load, |strain| self.at(strain, past))
    }

    /// Compares one slope of the energies along a line through these strains with differences, and one slope of the
    /// forces along it if the law remembers nothing; see [`crate::terms::slope`]. Strains that are nowhere above
    /// `least` are not judged: there laws that are written down plainly are round-off.
    fn contradiction(&self, strains: &[Vector], past: Past<'_>, least: f64) -> Option<(Derivatives, Contradiction)> {
        let n = strains.len();
        let size = strains.iter().map(Vector::norm).fold(0.0, f64::max);
        if size.is_nan() || size < least {
            return None;
        }
        let own = Line::at(strains.iter().flatten());
        let line = |k: usize| own.along(k) * (REACH * size);
        let moved = |t: f64| -> Vec<Vector> { strains.iter().enumerate().map(|(k, e)| e + line(k) * t).collect() };
        let (mut gradient, mut hessian) = (vec![Vector::zeros(); n], vec![Matrix::zeros(); n]);
        let mut response = Response { energy: None, gradient: Some(&mut gradient), hessian: Some(&mut hessian) };
        self.respond(strains, past, &mut response);
        let (mut first, mut second) = (Slope::default(), Slope::default());
        for k in 0..n {
            first.add(&gradient[k], &line(k));
            second.add(&(hessian[k] * line(k)), &line(k));
        }
        let found = first.contradiction(|t| {
            let mut energy = vec![f64::NAN; n];
            self.respond(&moved(t), past, &mut Response { energy: Some(&mut energy), gradient: None, hessian: None });
            energy.iter().sum()
        });
        if let Some(found) = found {
            return Some((Derivatives::First, found));
        }
        if !past.memory.is_empty() {
            return None;
        }
        let found = second.contradiction(|t| {
            self.respond(&moved(t), past, &mut Response { energy: None, gradient: Some(&mut gradient), hessian: None });
            gradient.iter().enumerate().map(|(k, force)| force.dot(&line(k))).sum()
        });
        found.map(|found| (Derivatives::Second, found))
    }
}

/// Length of a line along which slopes are compared, in the largest strain: the longest step is 3 % of it.
const REACH: f64 = 30.0;
/// Least strains that are judged: stretch, and curvature (1/m).
const LEAST: [f64; 2] = [1e-6, 1e-4];

/// Which derivatives are not those of what they are derived from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derivatives {
    /// The first ones, of the values.
    First,
    /// The second ones, of the first.
    Second,
}

/// The laws of a branch that are not those of its section.
#[derive(Default)]
pub struct ConstitutiveLaws {
    /// W of stretch and shear; `None`: linear, with EA and GA of the section.
    pub stretch: Option<Box<dyn ConstitutiveLaw>>,
    /// V of bending and twist; `None`: linear, with EI and GJ of the section.
    pub bend: Option<Box<dyn ConstitutiveLaw>>,
}

impl ConstitutiveLaws {
    /// The first fault of a law; see [`ConstitutiveLaw::fault`].
    pub fn fault(&self) -> Option<String> {
        [&self.stretch, &self.bend].into_iter().flatten().find_map(|law| law.fault())
    }

    /// The first derivatives of a law, at these strains of segments and couplings and with the past of these, that
    /// contradict its values.
    pub fn contradiction(
        &self,
        [segments, couplings]: [&[Vector]; 2],
        past: Past<'_>,
    ) -> Option<(Derivatives, Contradiction)> {
        let [stretch, bend] = [&self.stretch, &self.bend];
        let of_stretch = stretch.as_ref().and_then(|law| law.contradiction(segments, Past::default(), LEAST[0]));
        of_stretch.or_else(|| bend.as_ref()?.contradiction(couplings, past, LEAST[1]))
    }

    /// Number of state variables of each coupling.
    pub fn memory(&self) -> usize {
        self.bend.as_ref().map_or(0, |law| law.memory())
    }
}

/// Input of a factory of laws.
#[derive(Clone, Debug)]
pub struct ConstitutiveSpec {
    /// Name of the branch.
    pub name: String,
    /// Its section.
    pub section: Section,
    /// Its unstressed length, m.
    pub length: f64,
    /// Its rest curvature about d1 and d2 and rest twist, 1/m.
    pub curvature: Vector,
}

/// Largest number of iterations for a strain under a load; it needs a few for each piece of a law.
const ITERATIONS: usize = 200;
/// Smallest part of a step that is tried.
const SMALLEST_PART: f64 = 1e-9;

/// The strain e under a load f: the root of `∂W = f`, by Newton's method on the convex `W − f·e`. A step is taken where
/// it halves the residual, or else as much of it as lowers the potential enough. NaN where the law has no stiffness on
/// the way there.
pub fn strain_under(load: &Vector, law: impl Fn(&Vector) -> Point) -> Vector {
    let mut e = Vector::zeros();
    let mut here = law(&e);
    for _ in 0..ITERATIONS {
        let left = here.gradient - load;
        let Some(step) = here.hessian.cholesky().map(|factor| factor.solve(&left)) else {
            return if left == Vector::zeros() { e } else { Vector::repeat(f64::NAN) };
        };
        let (now, slope) = (here.energy - load.dot(&e), left.dot(&step));
        let mut part = 1.0;
        let mut next = law(&(e - step));
        if (next.gradient - load).norm() > 0.5 * left.norm() {
            while part > SMALLEST_PART && next.energy - load.dot(&(e - step * part)) > now - 1e-4 * part * slope {
                part *= 0.5;
                next = law(&(e - step * part));
            }
        }
        // At round-off no part of the step lowers the potential.
        if part <= SMALLEST_PART || step.norm() <= f64::EPSILON * e.norm() {
            break;
        }
        e -= step * part;
        here = next;
    }
    e
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `V = ½ k κ²`, with derivatives that are wrong by these factors.
    struct Spring([f64; 2]);

    impl ConstitutiveLaw for Spring {
        fn respond(&self, strains: &[Vector], _: Past<'_>, response: &mut Response<'_>) {
            let Self([first, second]) = self;
            response.each(strains, |_, e| Point {
                energy: 1.5 * e.norm_squared(),
                gradient: e * (3.0 * first),
                hessian: Matrix::identity() * (3.0 * second),
            });
        }
    }

    fn found(factors: [f64; 2], size: f64) -> Option<Derivatives> {
        let strains: Vec<Vector> = (0..40).map(|k| Line::at(&[]).along(k) * size).collect();
        let laws = ConstitutiveLaws { stretch: None, bend: Some(Box::new(Spring(factors))) };
        laws.contradiction([&[], &strains], Past::default()).map(|(which, _)| which)
    }

    #[test]
    fn derivatives_that_are_not_those_of_the_energy_are_found_at_any_strain_that_counts() {
        for size in [1e-3, 1.0, 50.0] {
            assert_eq!(found([1.0, 1.0], size), None);
            for lie in [2.0, 0.0, -1.0, 1.1] {
                assert_eq!(found([lie, lie], size), Some(Derivatives::First), "{lie} at {size} 1/m");
                assert_eq!(found([1.0, lie], size), Some(Derivatives::Second), "{lie} at {size} 1/m");
            }
        }
        assert_eq!(found([2.0, 2.0], 1e-6), None, "there is nothing to be seen");
        assert_eq!(found([1.0, 1.0], f64::NAN), None);
    }

    #[test]
    fn the_strain_under_a_load_has_that_load() {
        let law: Box<dyn ConstitutiveLaw> = Box::new(Spring([1.0, 1.0]));
        let load = Vector::new(0.3, -0.6, 1.2);
        assert!((law.strain_under(&load, Past::default()) - load / 3.0).norm() < 1e-15);
    }
}
