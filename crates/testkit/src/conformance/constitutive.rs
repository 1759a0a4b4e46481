//! Checks of [`ConstitutiveLaw`], one for each clause of its contract, on a rod that has such laws. How the rod uses
//! them is checked as of every other one ([`super::rod`]).

use super::numeric::*;
use super::rod::{Factory, section};
use fastrand::Rng;
use nalgebra::DMatrix;
use wireloom_core::constitutive::{ConstitutiveLaw, ConstitutiveLaws, Point, Response};
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
/// Relative round-off.
const ROUND_OFF: f64 = 1e-11;

/// A rod of ten segments, straight at rest.
fn rod(factory: &Factory<'_>) -> Box<dyn RodSegment> {
    let mesh = Mesh::new(vec![0.1; 10], vec![0, 10]);
    factory(RodSpec { name: "branch".into(), section: section(), mesh, curvature: Vector::zeros() })
}

/// Calls `check` with each law, its name, and strains of each size: whether they are the least ones, and all in random
/// directions.
fn each_law(factory: &Factory<'_>, mut check: impl FnMut(&str, &dyn ConstitutiveLaw, bool, &[Vector])) {
    let rod = rod(factory);
    let ConstitutiveLaws { stretch, bend } = rod.constitutive().expect("constitutive laws");
    let mut rng = Rng::with_seed(1);
    for (name, law, sizes) in [("stretch", stretch, STRETCHES), ("bending", bend, CURVATURES)] {
        for (k, size) in sizes.into_iter().enumerate() {
            let strains: Vec<Vector> = (0..EACH).map(|_| *random_direction(&mut rng) * size).collect();
            if let Some(law) = law {
                check(&format!("{name} at {size:e}"), law.as_ref(), k < 2, &strains);
                assert_eq!(law.fault(), None, "{name} at {size:e}");
            }
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
    each_law(factory, |name, law, small, strains| {
        for e in strains {
            let (point, line) = (law.at(e), *random_direction(&mut rng) * e.norm());
            let got = point.gradient.dot(&line);
            let tolerance = if small { SMALL } else { DIFFERENCES };
            assert_one_near(name, got, point.energy, tolerance, |h| derivative(h, |t| law.at(&(e + line * t)).energy));
        }
    });
}

/// # Panics
/// If second derivatives are not what differences of the forces say, or not symmetric.
pub fn hessian_is_the_derivative_of_the_forces(factory: &Factory<'_>) {
    let mut rng = Rng::with_seed(3);
    each_law(factory, |name, law, small, strains| {
        for e in strains {
            let Point { gradient, hessian, .. } = law.at(e);
            assert_near(name, (hessian - hessian.transpose()).amax(), 0.0, ROUND_OFF * hessian.amax());
            let (line, along) = (*random_direction(&mut rng) * e.norm(), random_direction(&mut rng));
            let got = along.dot(&(hessian * line));
            let tolerance = if small { SMALL } else { DIFFERENCES };
            assert_one_near(name, got, gradient.norm(), tolerance, |h| {
                derivative(h, |t| along.dot(&law.at(&(e + line * t)).gradient))
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
        let found = laws.contradiction([&segments, &couplings]);
        assert_eq!(found, None, "strains of about {stretch:e}, curvatures of about {curvature:e}");
    }
}

/// # Panics
/// If a law has an energy or a force at rest, or a negative energy anywhere.
pub fn there_is_no_energy_at_rest_and_nowhere_less(factory: &Factory<'_>) {
    each_law(factory, |name, law, _, strains| {
        let rest = law.at(&Vector::zeros());
        let one = law.at(&strains[0]);
        assert_near(&format!("{name}: energy at rest"), rest.energy, 0.0, ROUND_OFF * one.energy);
        assert_near(&format!("{name}: force at rest"), rest.gradient.norm(), 0.0, ROUND_OFF * one.gradient.norm());
        for e in strains {
            let energy = law.at(e).energy;
            assert!(energy >= 0.0, "{name}: {energy} J/m");
        }
    });
}

/// # Panics
/// If the sign of the first component, which is another one where the branch is run from its other end, changes more
/// than the signs of what belongs to it.
pub fn the_sign_of_the_first_component_changes_nothing(factory: &Factory<'_>) {
    let mirror = Matrix::from_diagonal(&Vector::new(-1.0, 1.0, 1.0));
    each_law(factory, |name, law, _, strains| {
        for e in strains {
            let (one, other) = (law.at(e), law.at(&(mirror * e)));
            assert_near(&format!("{name}: energy"), other.energy, one.energy, ROUND_OFF * one.energy);
            let (got, size) = (mirror * other.gradient, one.gradient.norm());
            assert_near(&format!("{name}: force"), (got - one.gradient).norm(), 0.0, ROUND_OFF * size);
        }
    });
}

/// # Panics
/// If the second derivatives of stretch have a negative eigenvalue.
pub fn stretch_is_convex(factory: &Factory<'_>) {
    each_law(factory, |name, law, _, strains| {
        for hessian in strains.iter().map(|e| law.at(e).hessian).filter(|_| name.starts_with("stretch")) {
            let least = hessian.symmetric_eigenvalues().min();
            assert!(least >= -ROUND_OFF * hessian.amax(), "{name}: an eigenvalue is {least:e} N");
        }
    });
}

/// # Panics
/// If a law does not answer a block of strains, asked for some of its outputs, as it answers each strain alone.
pub fn a_block_is_answered_as_each_of_its_strains(factory: &Factory<'_>) {
    each_law(factory, |name, law, _, strains| {
        let n = strains.len();
        for asked in 0..8 {
            let (mut energy, mut gradient) = (vec![f64::NAN; n], vec![Vector::repeat(f64::NAN); n]);
            let mut hessian = vec![Matrix::repeat(f64::NAN); n];
            let mut response = Response {
                energy: (asked & 1 != 0).then_some(&mut energy),
                gradient: (asked & 2 != 0).then_some(&mut gradient),
                hessian: (asked & 4 != 0).then_some(&mut hessian),
            };
            law.respond(strains, &mut response);
            for (k, e) in strains.iter().enumerate() {
                let alone = law.at(e);
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

/// A check of [`constitutive_conformance`](crate::constitutive_conformance).
pub type Check = fn(&Factory<'_>);

crate::constitutive_checks! { listed_checks CHECKS, }
