//! Checks of [`ConstitutiveLaw`], one for each clause of its contract, on a rod that has such laws. How the rod uses
//! them is checked as of every other one ([`super::rod`]).

use super::numeric::*;
use super::rod::{Factory, section};
use fastrand::Rng;
use nalgebra::DMatrix;
use wireloom_core::constitutive::{ConstitutiveLaw, ConstitutiveLaws, Past, Point, Response};
use wireloom_core::rod::{Mesh, RodSpec};
use wireloom_core::{Matrix, RodSegment, Vector};

pub use super::rod::{
    energies_by_effect_are_not_negative_and_add_up, extra_curvature_shifts_the_rest_curvature,
    forces_and_moments_agree_with_the_gradient, free_strain_stretches_the_rest_shape,
    inner_forces_and_moments_sum_to_zero, non_finite_input_gives_non_finite_output,
    rest_shape_has_no_energy_and_no_gradient, rigid_motion_changes_nothing,
    running_the_branch_from_its_other_end_changes_nothing, same_input_gives_same_bits,
    the_sign_of_a_quaternion_does_not_matter,
};

/// Largest strains of stretch, by their size: from those of a cable that hardly pulls to those of none.
const STRETCHES: [f64; 5] = [1e-6, 1e-5, 1e-3, 0.03, 0.5];
/// Likewise curvatures, 1/m.
const CURVATURES: [f64; 5] = [1e-4, 1e-2, 1.0, 30.0, 300.0];
/// Number of strains of each size.
const EACH: usize = 8;
/// Relative error allowed to differences.
const DIFFERENCES: f64 = 1e-6;
/// Relative error allowed to derivatives at strains at which energies may lie in the round-off of what they are made
/// of.
const SMALL: f64 = 1e-3;
/// Steps of the differences, in the size of the strain: laws may bend within a thousandth of it.
const STEPS: [f64; 5] = [3e-2, 3e-3, 3e-4, 3e-5, 3e-6];
/// Relative error allowed to what a second call must not change: laws may state it in other terms.
const SAME: f64 = 1e-9;
/// Relative round-off.
const ROUND_OFF: f64 = 1e-11;

/// A rod of ten segments, straight at rest.
fn rod(factory: &Factory<'_>) -> Box<dyn RodSegment> {
    let mesh = Mesh::new(vec![0.1; 10], vec![0, 10]);
    factory(RodSpec { name: "branch".into(), sections: section().into(), mesh, curvature: Vector::zeros() })
}

/// A law with strains of one size at which it is checked.
struct Trial<'t> {
    name: String,
    law: &'t dyn ConstitutiveLaw,
    /// Whether their size is one of the least.
    small: bool,
    /// In random directions.
    strains: Vec<Vector>,
    /// Memory of each; that at first, or, of a law that remembers, after increments that ended at other strains.
    memory: Vec<f64>,
}

/// Time that an increment takes, s.
const DURATION: f64 = 10.0;

impl Trial<'_> {
    /// The past of all strains.
    fn past(&self) -> Past<'_> {
        Past { memory: &self.memory, duration: DURATION }
    }

    /// The law at a strain with the past of strain k.
    fn at(&self, k: usize, strain: &Vector) -> Point {
        self.law.at(strain, self.past().of(k, self.law.memory()))
    }

    /// Ends an increment at these strains; returns the energy dissipated at each, J/m.
    fn commit(&mut self, strains: &[Vector]) -> Vec<f64> {
        let mut dissipated = vec![0.0; strains.len()];
        self.law.commit(strains, DURATION, &mut self.memory, &mut dissipated);
        dissipated
    }
}

/// Calls `check` with each law at strains of each size; one that remembers once more with a memory.
fn each_law(factory: &Factory<'_>, mut check: impl FnMut(Trial<'_>)) {
    let rod = rod(factory);
    let ConstitutiveLaws { stretch, bend } = rod.constitutive().expect("constitutive laws");
    let mut rng = Rng::with_seed(1);
    for (name, law, sizes) in [("stretch", stretch, STRETCHES), ("bending", bend, CURVATURES)] {
        for (k, size) in sizes.into_iter().enumerate() {
            let mut some = || -> Vec<Vector> { (0..EACH).map(|_| *random_direction(&mut rng) * size).collect() };
            let (strains, before) = (some(), [some(), some()]);
            let Some(law) = law else { continue };
            let (law, name) = (law.as_ref(), format!("{name} at {size:e}"));
            for remembers in [false, true].into_iter().take(1 + usize::from(law.memory() > 0)) {
                let name = if remembers { format!("{name} with a memory") } else { name.clone() };
                let (strains, memory) = (strains.clone(), vec![0.0; EACH * law.memory()]);
                let mut trial = Trial { name, law, small: k < 2, strains, memory };
                for strains in before.iter().filter(|_| remembers) {
                    trial.commit(strains);
                }
                check(trial);
            }
            assert_eq!(law.fault(), None, "{name}");
        }
    }
}

/// Asserts that `got` is near one of the derivatives by differences, for different steps.
#[track_caller]
fn assert_one_near(name: &str, got: f64, size: f64, tolerance: f64, of: impl Fn(f64) -> f64) {
    let all = STEPS.map(&of);
    let best = all.iter().copied().min_by(|a, b| (a - got).abs().total_cmp(&(b - got).abs())).unwrap_or(f64::NAN);
    assert_near(name, got, best, tolerance * (best.abs() + size));
}

/// # Panics
/// If forces are not what differences of the energy say.
pub fn forces_are_the_derivative_of_the_energy(factory: &Factory<'_>) {
    let mut rng = Rng::with_seed(2);
    each_law(factory, |trial| {
        for (k, e) in trial.strains.iter().enumerate() {
            let (point, line) = (trial.at(k, e), *random_direction(&mut rng) * e.norm());
            let got = point.gradient.dot(&line);
            let tolerance = if trial.small { SMALL } else { DIFFERENCES };
            assert_one_near(&trial.name, got, point.energy, tolerance, |h| {
                derivative(h, |t| trial.at(k, &(e + line * t)).energy)
            });
        }
    });
}

/// # Panics
/// If second derivatives are not what differences of the forces say, or not symmetric.
pub fn hessian_is_the_derivative_of_the_forces(factory: &Factory<'_>) {
    let mut rng = Rng::with_seed(3);
    each_law(factory, |trial| {
        let name = &trial.name;
        for (k, e) in trial.strains.iter().enumerate() {
            let Point { gradient, hessian, .. } = trial.at(k, e);
            assert_near(name, (hessian - hessian.transpose()).amax(), 0.0, ROUND_OFF * hessian.amax());
            let (line, along) = (*random_direction(&mut rng) * e.norm(), random_direction(&mut rng));
            let got = along.dot(&(hessian * line));
            let tolerance = if trial.small { SMALL } else { DIFFERENCES };
            assert_one_near(name, got, gradient.norm(), tolerance, |h| {
                derivative(h, |t| along.dot(&trial.at(k, &(e + line * t)).gradient))
            });
        }
    });
}

/// # Panics
/// If the comparison of slopes that a run makes at each equilibrium finds derivatives wrong.
pub fn a_run_finds_no_derivatives_wrong(factory: &Factory<'_>) {
    let rod = rod(factory);
    let laws = rod.constitutive().expect("constitutive laws");
    let mut rng = Rng::with_seed(4);
    for (stretch, curvature) in STRETCHES.into_iter().zip(CURVATURES) {
        let [segments, couplings] =
            [stretch, curvature].map(|size| (0..40).map(|_| random_vector(&mut rng, 2.0 * size)).collect::<Vec<_>>());
        let memory = vec![0.0; couplings.len() * laws.memory()];
        let found = laws.contradiction([&segments, &couplings], Past { memory: &memory, duration: DURATION });
        assert_eq!(found, None, "strains of about {stretch:e}, curvatures of about {curvature:e}");
    }
}

/// # Panics
/// If a law has an energy or a force at rest with the memory at first, or a negative energy anywhere.
pub fn there_is_no_energy_at_rest_and_nowhere_less(factory: &Factory<'_>) {
    each_law(factory, |trial| {
        let name = &trial.name;
        if trial.memory.iter().all(|x| *x == 0.0) {
            let (rest, one) = (trial.at(0, &Vector::zeros()), trial.at(0, &trial.strains[0]));
            assert_near(&format!("{name}: energy at rest"), rest.energy, 0.0, ROUND_OFF * one.energy);
            assert_near(&format!("{name}: force at rest"), rest.gradient.norm(), 0.0, ROUND_OFF * one.gradient.norm());
        }
        for (k, e) in trial.strains.iter().enumerate() {
            let energy = trial.at(k, e).energy;
            assert!(energy >= 0.0, "{name}: {energy} J/m");
        }
    });
}

/// # Panics
/// If the sign of the first component, which is another one where the branch is run from its other end, changes more
/// than the signs of what belongs to it.
pub fn the_sign_of_the_first_component_changes_nothing(factory: &Factory<'_>) {
    let mirror = Matrix::from_diagonal(&Vector::new(-1.0, 1.0, 1.0));
    each_law(factory, |trial| {
        let name = &trial.name;
        // What is remembered belongs to the directions: compared is a law that remembers nothing yet.
        for e in trial.strains.iter().filter(|_| trial.memory.iter().all(|x| *x == 0.0)) {
            let (one, other) = (trial.at(0, e), trial.at(0, &(mirror * e)));
            assert_near(&format!("{name}: energy"), other.energy, one.energy, ROUND_OFF * one.energy);
            let (got, size) = (mirror * other.gradient, one.gradient.norm());
            assert_near(&format!("{name}: force"), (got - one.gradient).norm(), 0.0, ROUND_OFF * size);
        }
    });
}

/// # Panics
/// If the second derivatives of stretch have a negative eigenvalue.
pub fn stretch_is_convex(factory: &Factory<'_>) {
    each_law(factory, |trial| {
        let name = &trial.name;
        for e in trial.strains.iter().filter(|_| name.starts_with("stretch")) {
            let hessian = trial.at(0, e).hessian;
            let least = hessian.symmetric_eigenvalues().min();
            assert!(least >= -ROUND_OFF * hessian.amax(), "{name}: an eigenvalue is {least:e} N");
        }
    });
}

/// # Panics
/// If a law does not answer a block of strains, asked for some of its outputs, as it answers each strain alone.
pub fn a_block_is_answered_as_each_of_its_strains(factory: &Factory<'_>) {
    each_law(factory, |trial| {
        let Trial { name, law, strains, .. } = &trial;
        let n = strains.len();
        for asked in 0..8 {
            let (mut energy, mut gradient) = (vec![f64::NAN; n], vec![Vector::repeat(f64::NAN); n]);
            let mut hessian = vec![Matrix::repeat(f64::NAN); n];
            let mut response = Response {
                energy: (asked & 1 != 0).then_some(&mut energy),
                gradient: (asked & 2 != 0).then_some(&mut gradient),
                hessian: (asked & 4 != 0).then_some(&mut hessian),
            };
            law.respond(strains, trial.past(), &mut response);
            for (k, e) in strains.iter().enumerate() {
                let alone = trial.at(k, e);
                let all = |point: &[f64]| DMatrix::from_row_slice(1, point.len(), point);
                let check = |bit: i32, got: &[f64], want: &[f64]| {
                    if asked & bit != 0 {
                        assert_eq!(all(got), all(want), "{name}: strain {k} of {n}");
                    }
                };
                check(1, &[energy[k]], &[alone.energy]);
                check(2, gradient[k].as_slice(), alone.gradient.as_slice());
                check(4, hessian[k].as_slice(), alone.hessian.as_slice());
            }
        }
    });
}

/// # Panics
/// If what a law remembers of an increment changes its moments, is another at a second call, or if a negative energy is
/// dissipated.
pub fn an_increment_is_remembered_once(factory: &Factory<'_>) {
    each_law(factory, |mut trial| {
        let (name, strains) = (trial.name.clone(), trial.strains.clone());
        let before: Vec<Point> = strains.iter().enumerate().map(|(k, e)| trial.at(k, e)).collect();
        let dissipated = trial.commit(&strains);
        assert!(dissipated.iter().all(|lost| *lost >= 0.0), "{name}: {dissipated:?} J/m");
        for (k, (e, before)) in strains.iter().zip(&before).enumerate() {
            let past = Past { memory: &trial.memory, duration: 0.0 }.of(k, trial.law.memory());
            let change = (trial.law.at(e, past).gradient - before.gradient).norm();
            assert_near(&format!("{name}: force"), change, 0.0, SAME * before.gradient.norm());
        }
        let mut again = trial.memory.clone();
        let mut lost = vec![0.0; strains.len()];
        trial.law.commit(&strains, 0.0, &mut again, &mut lost);
        let most = before.iter().map(|point| point.energy).fold(0.0, f64::max);
        assert!(lost.iter().all(|lost| (0.0..=SAME * most).contains(lost)), "{name}, a second time: {lost:?} J/m");
        let most = trial.memory.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        for (one, other) in trial.memory.iter().zip(&again) {
            assert_near(&format!("{name}, a second time: memory"), *other, *one, SAME * most);
        }
    });
}

/// A check of [`constitutive_conformance`](crate::constitutive_conformance).
pub type Check = fn(&Factory<'_>);

crate::constitutive_checks! { listed_checks CHECKS, }
