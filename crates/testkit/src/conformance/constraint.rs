//! Checks of [`Constraint`] and [`Potential`], one for each clause of their contracts.

use super::numeric::*;
use fastrand::Rng;
use nalgebra::{DMatrix, DVector};
use wireloom_core::{Action, Constraint, Hold, Pose, Potential, RotationHold, Vector};

/// Makes the constraint under test.
pub type Factory<'f> = dyn Fn() -> Box<dyn Constraint> + 'f;

const ROUND_OFF: f64 = 1e-12;
const DIFFERENCES: f64 = 1e-8;
const STEP: f64 = 1e-3;

fn potential(constraint: &dyn Constraint) -> &dyn Potential {
    match constraint.action() {
        Action::Potential(potential) => potential,
        Action::Prescribed(hold) => panic!("prescribes {hold:?} instead of pulling"),
    }
}

fn hold(constraint: &dyn Constraint) -> &Hold {
    match constraint.action() {
        Action::Prescribed(hold) => hold,
        Action::Potential(_) => panic!("pulls instead of prescribing"),
    }
}

/// Pairs of station and target, apart and turned by little and by much.
fn poses() -> Vec<(Pose, Pose)> {
    let mut rng = Rng::with_seed(21);
    let mut all = Vec::new();
    for (apart, turn) in [(1e-3, 1e-3), (0.1, 0.3), (1.0, 1.5), (0.3, 2.9)] {
        for _ in 0..5 {
            let target = Pose { position: random_vector(&mut rng, 1.0), orientation: random_rotation(&mut rng) };
            let local = Pose { position: random_vector(&mut rng, apart), orientation: random_turn(&mut rng, turn) };
            all.push((target.compose(&local), target));
        }
    }
    all
}

fn moved(at: &Pose, i: usize, h: f64) -> Pose {
    let mut to = *at;
    let mut step = Vector::zeros();
    step[i % 3] = h;
    if i < 3 {
        to.position += step;
    } else {
        to.orientation = turned(&to.orientation, &step);
    }
    to
}

fn gradient(potential: &dyn Potential, at: &Pose, target: &Pose) -> DVector<f64> {
    let (force, moment) = potential.gradient(at, target);
    flat([&force, &moment])
}

/// # Panics
/// If the constraint prescribes instead.
pub fn is_a_potential(factory: &Factory<'_>) {
    potential(factory().as_ref());
}

/// # Panics
/// If the gradient is not what differences of the energy say.
pub fn gradient_is_the_derivative_of_the_energy(factory: &Factory<'_>) {
    let constraint = factory();
    let potential = potential(constraint.as_ref());
    for (at, target) in poses() {
        let got = gradient(potential, &at, &target);
        let want = DVector::from_fn(6, |i, _| derivative(STEP, |h| potential.energy(&moved(&at, i, h), &target)));
        assert_all_near("gradient", &got, &want, DIFFERENCES * (1.0 + want.amax()));
    }
}

/// # Panics
/// If the Hessian is not the symmetric part of the derivative of the gradient.
pub fn hessian_is_the_second_derivative_of_the_energy(factory: &Factory<'_>) {
    let constraint = factory();
    let potential = potential(constraint.as_ref());
    for (at, target) in poses() {
        let [xx, tx, tt] = potential.hessian(&at, &target);
        let mut got = DMatrix::zeros(6, 6);
        got.fixed_view_mut::<3, 3>(0, 0).copy_from(&xx);
        got.fixed_view_mut::<3, 3>(3, 0).copy_from(&tx);
        got.fixed_view_mut::<3, 3>(0, 3).copy_from(&tx.transpose());
        got.fixed_view_mut::<3, 3>(3, 3).copy_from(&tt);
        let columns: Vec<_> =
            (0..6).map(|i| derivative_of_all(STEP, |h| gradient(potential, &moved(&at, i, h), &target))).collect();
        let want = symmetric(&DMatrix::from_columns(&columns));
        assert_matrix_near("hessian", &got, &want, DIFFERENCES * (1.0 + want.amax()));
    }
}

/// # Panics
/// If energy or body moment change, or the force does not turn along, when station and target undergo the same
/// rigid motion.
pub fn moving_station_and_target_together_changes_nothing(factory: &Factory<'_>) {
    let constraint = factory();
    let potential = potential(constraint.as_ref());
    let mut rng = Rng::with_seed(22);
    for (at, target) in poses() {
        let motion = Pose { position: random_vector(&mut rng, 1.0), orientation: random_rotation(&mut rng) };
        let (at2, target2) = (motion.compose(&at), motion.compose(&target));
        let energy = potential.energy(&at, &target);
        assert_near("energy", potential.energy(&at2, &target2), energy, ROUND_OFF * (1.0 + energy));
        let (force, moment) = potential.gradient(&at, &target);
        let want = flat([&(motion.orientation * force), &moment]);
        assert_all_near("gradient", &gradient(potential, &at2, &target2), &want, 1e-11 * (1.0 + want.amax()));
    }
}

/// # Panics
/// If `−q` for `q`, which is the same frame, at the station or its target changes energy, gradient or Hessian.
pub fn the_sign_of_a_quaternion_does_not_matter(factory: &Factory<'_>) {
    let constraint = factory();
    let potential = potential(constraint.as_ref());
    for (at, target) in poses() {
        let energy = potential.energy(&at, &target);
        let want = gradient(potential, &at, &target);
        let want_hessian = potential.hessian(&at, &target);
        let other = |pose: &Pose| Pose { orientation: negated(&pose.orientation), ..*pose };
        for (at, target) in [(other(&at), target), (at, other(&target)), (other(&at), other(&target))] {
            assert_near("energy", potential.energy(&at, &target), energy, ROUND_OFF * (1.0 + energy));
            assert_all_near("gradient", &gradient(potential, &at, &target), &want, 1e-11 * (1.0 + want.amax()));
            for (got, want) in potential.hessian(&at, &target).iter().zip(&want_hessian) {
                assert_near("hessian", (got - want).amax(), 0.0, 1e-11 * (1.0 + want.amax()));
            }
        }
    }
}

/// # Panics
/// If there is an energy, force or moment at the target.
pub fn at_the_target_there_is_no_energy_and_no_force(factory: &Factory<'_>) {
    let constraint = factory();
    let potential = potential(constraint.as_ref());
    for (_, target) in poses() {
        let scale = potential.hessian(&target, &target).iter().map(|h| h.amax()).fold(0.0, f64::max);
        assert_near("energy", potential.energy(&target, &target), 0.0, 1e-29 * scale);
        assert_near("gradient", gradient(potential, &target, &target).amax(), 0.0, 1e-15 * scale);
    }
}

/// # Panics
/// If an energy is negative, at however small a distance from the target.
pub fn energy_is_not_negative(factory: &Factory<'_>) {
    let constraint = factory();
    let potential = potential(constraint.as_ref());
    let mut rng = Rng::with_seed(23);
    for (at, target) in poses() {
        let turn = random_turn(&mut rng, 1e-8);
        let near = Pose { position: target.position, orientation: target.orientation * turn };
        for at in [&at, &near, &target] {
            let energy = potential.energy(at, &target);
            assert!(energy >= 0.0, "{energy:e}");
        }
    }
}

/// # Panics
/// If a potential says it needs no frame but exerts moments.
pub fn without_need_of_a_frame_there_is_no_moment(factory: &Factory<'_>) {
    let constraint = factory();
    let potential = potential(constraint.as_ref());
    if constraint.needs_frame() {
        return;
    }
    for (at, target) in poses() {
        let [_, tx, tt] = potential.hessian(&at, &target);
        assert_eq!(potential.gradient(&at, &target).1, Vector::zeros(), "moment");
        assert_eq!((tx.amax(), tt.amax()), (0.0, 0.0), "second derivatives");
    }
}

/// # Panics
/// If a position that is not finite gives a finite energy or gradient.
pub fn non_finite_input_gives_non_finite_output(factory: &Factory<'_>) {
    let constraint = factory();
    let potential = potential(constraint.as_ref());
    for (mut at, target) in poses() {
        at.position.z = f64::NAN;
        let g = gradient(potential, &at, &target);
        assert!(!potential.energy(&at, &target).is_finite(), "energy");
        assert!(g.iter().any(|x| !x.is_finite()), "gradient");
    }
}

/// # Panics
/// If two potentials of one specification give different bits.
pub fn same_input_gives_same_bits(factory: &Factory<'_>) {
    let (one, other) = (factory(), factory());
    let bits = |p: &dyn Potential, at: &Pose, target: &Pose| -> Vec<u64> {
        let energy = p.energy(at, target);
        gradient(p, at, target).iter().chain([&energy]).map(|x| x.to_bits()).collect()
    };
    for (at, target) in poses() {
        let first = bits(potential(one.as_ref()), &at, &target);
        assert_eq!(first, bits(potential(other.as_ref()), &at, &target));
    }
}

/// # Panics
/// If the constraint is a potential instead.
pub fn prescribes_freedoms(factory: &Factory<'_>) {
    let constraint = factory();
    let hold = hold(constraint.as_ref());
    assert!(hold.position || hold.rotation != RotationHold::Free, "{hold:?} holds nothing");
}

/// # Panics
/// If rails and held directions are not an orthonormal basis of space where the position is held, or a held
/// direction exists where it is not.
pub fn rails_and_held_directions_span_space(factory: &Factory<'_>) {
    let constraint = factory();
    let hold = hold(constraint.as_ref());
    let held = hold.held_directions();
    if !hold.position {
        assert!(held.is_empty(), "{hold:?} holds {held:?}");
        return;
    }
    let all: Vec<Vector> = hold.rails.iter().copied().chain(held).collect();
    assert_eq!(all.len(), 3, "{all:?}");
    for (i, a) in all.iter().enumerate() {
        for (k, b) in all.iter().enumerate() {
            assert_near("product of directions", a.dot(b), f64::from(u8::from(i == k)), 1e-14);
        }
    }
}

/// # Panics
/// If the constraint asks for a frame without holding a rotation, or the other way round.
pub fn needs_a_frame_exactly_if_it_holds_a_rotation(factory: &Factory<'_>) {
    let constraint = factory();
    let hold = hold(constraint.as_ref());
    assert_eq!(constraint.needs_frame(), hold.rotation != RotationHold::Free, "{hold:?}");
    if let RotationHold::Hinge(axis) = hold.rotation {
        assert_near("length of the hinge's axis", axis.norm(), 1.0, 1e-14);
    }
}

/// # Panics
/// If two constraints of one specification, or two questions, get different answers.
pub fn describes_the_same_hold_every_time(factory: &Factory<'_>) {
    let (one, other) = (factory(), factory());
    assert_eq!(hold(one.as_ref()), hold(one.as_ref()));
    assert_eq!(hold(one.as_ref()), hold(other.as_ref()));
}
