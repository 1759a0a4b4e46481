//! Checks of [`PointLoad`] and [`LineLoad`], one for each clause of their contracts.

use super::numeric::*;
use fastrand::Rng;
use nalgebra::{DMatrix, DVector};
use wireloom_core::load::{Axes, LineLoad, PointLoad};
use wireloom_core::{Matrix, Rotation, Vector};

/// Diameter of the cable on which loads along it are tried, m.
const DIAMETER: f64 = 0.012;
const ROUND_OFF: f64 = 1e-12;
const DIFFERENCES: f64 = 1e-8;

/// What both kinds of loads have: the dead force, what is exerted beside it (force, moment), and the derivatives of
/// that.
trait Exerts {
    fn dead_force(&self) -> Vector;
    fn has_potential(&self) -> bool;
    /// In its own axes.
    fn on(&self, frame: &Rotation) -> Vec<Vector>;
    fn derivative(&self, frame: &Rotation) -> Vec<Matrix>;
    fn turns_with_the_frame(&self) -> bool;
    fn largest(&self) -> Vec<f64>;
}

impl Exerts for Box<dyn PointLoad> {
    fn dead_force(&self) -> Vector {
        self.as_ref().dead_force()
    }
    fn has_potential(&self) -> bool {
        self.without_potential().is_none()
    }
    fn on(&self, frame: &Rotation) -> Vec<Vector> {
        self.as_ref().on(frame).to_vec()
    }
    fn derivative(&self, frame: &Rotation) -> Vec<Matrix> {
        self.as_ref().derivative(frame).to_vec()
    }
    fn turns_with_the_frame(&self) -> bool {
        self.axes() == Axes::Frame
    }
    fn largest(&self) -> Vec<f64> {
        self.as_ref().largest().to_vec()
    }
}

impl Exerts for Box<dyn LineLoad> {
    fn dead_force(&self) -> Vector {
        self.as_ref().dead_force()
    }
    fn has_potential(&self) -> bool {
        self.without_potential().is_none()
    }
    fn on(&self, frame: &Rotation) -> Vec<Vector> {
        vec![self.as_ref().on(frame, DIAMETER)]
    }
    fn derivative(&self, frame: &Rotation) -> Vec<Matrix> {
        vec![self.as_ref().derivative(frame, DIAMETER)]
    }
    fn turns_with_the_frame(&self) -> bool {
        false
    }
    fn largest(&self) -> Vec<f64> {
        vec![self.as_ref().largest(DIAMETER)]
    }
}

fn frames() -> impl Iterator<Item = Rotation> {
    let mut rng = Rng::with_seed(31);
    [Rotation::identity()].into_iter().chain((0..20).map(move |_| random_rotation(&mut rng)))
}

/// # Panics
/// If the derivatives are not what differences of force and moment say.
fn derivative_is_that_of(load: &impl Exerts) {
    let numbers = |frame: &Rotation| flat(&load.on(frame));
    for frame in frames() {
        let got = load.derivative(&frame);
        let got = DMatrix::from_fn(3 * got.len(), 3, |i, k| got[i / 3][(i % 3, k)]);
        let want = agreeing(&got, DIFFERENCES, |step| {
            let slope = |k: usize| derivative_of_all(step, |h| numbers(&turned(&frame, &Vector::ith(k, h))));
            DMatrix::from_columns(&[0, 1, 2].map(slope))
        });
        assert_matrix_near("derivative", &got, &want, DIFFERENCES * (1.0 + want.amax()));
    }
}

/// # Panics
/// If what a load exerts does not turn along when the world and the cable are turned together.
fn turns_along(make: impl Fn(&Rotation) -> Box<dyn Exerts>) {
    let mut rng = Rng::with_seed(32);
    let one = make(&Rotation::identity());
    for frame in frames() {
        let turn = random_rotation(&mut rng);
        let other = make(&turn);
        let of_world = |v: &Vector| if one.turns_with_the_frame() { *v } else { turn * v };
        let want: Vec<Vector> = one.on(&frame).iter().map(of_world).collect();
        let (got, want) = (flat(&other.on(&(turn * frame))), flat(&want));
        assert_all_near("force and moment", &got, &want, ROUND_OFF * (1.0 + want.amax()));
        let (got, want) = (flat(&[other.dead_force()]), flat(&[turn * one.dead_force()]));
        assert_all_near("dead force", &got, &want, ROUND_OFF * (1.0 + want.amax()));
    }
}

/// # Panics
/// If a load whose dead force is said to be all of it exerts anything else.
fn potential_is_that_of_the_dead_force(load: &impl Exerts) {
    for frame in frames().filter(|_| load.has_potential()) {
        assert_eq!(flat(&load.on(&frame)).amax(), 0.0, "it exerts more than its dead force");
    }
}

/// # Panics
/// If a load is larger than the largest that it says, or that is not finite.
fn keeps_below(load: &impl Exerts) {
    let largest = load.largest();
    assert!(largest.iter().all(|size| size.is_finite()), "{largest:?}");
    for frame in frames() {
        let turn = if load.turns_with_the_frame() { frame } else { Rotation::identity() };
        let mut exerted: Vec<Vector> = load.on(&frame).iter().map(|v| turn * v).collect();
        exerted[0] += load.dead_force();
        for (v, largest) in exerted.iter().zip(&largest) {
            assert!(v.norm() <= largest * (1.0 + 1e-9), "{v} is larger than {largest}");
        }
    }
}

/// # Panics
/// If `−q` for `q`, which is the same frame, or a second call gives something else.
fn depends_on_the_frame_alone(load: &impl Exerts) {
    let all = |frame: &Rotation| -> DVector<f64> {
        let derivatives = load.derivative(frame);
        let numbers = flat(&load.on(frame));
        let more = derivatives.iter().flat_map(|m| m.iter().copied().collect::<Vec<_>>());
        DVector::from_iterator(numbers.len() + 9 * derivatives.len(), numbers.iter().copied().chain(more))
    };
    let bits = |frame: &Rotation| all(frame).iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    for frame in frames() {
        assert_eq!(bits(&frame), bits(&frame), "two calls");
        let want = all(&frame);
        assert_all_near("the other quaternion", &all(&negated(&frame)), &want, ROUND_OFF * (1.0 + want.amax()));
    }
}

/// The checks of one of the two traits.
macro_rules! checks {
    ($module:ident, $load:ty, $what:literal) => {
        #[doc = $what]
        pub mod $module {
            use super::*;

            /// Makes the load under test in a world that is turned by a rotation: directions of the world are turned by
            /// it, those of the cable's frame are as they are.
            pub type Factory<'f> = dyn Fn(&Rotation) -> Box<$load> + 'f;
            /// A check; it panics where the load fails it.
            pub type Check = fn(&Factory<'_>);

            fn straight(make: &Factory<'_>) -> Box<$load> {
                make(&Rotation::identity())
            }

            /// # Panics
            /// If the derivatives are not what differences of force and moment say.
            pub fn derivative_is_that_of_force_and_moment(make: &Factory<'_>) {
                derivative_is_that_of(&straight(make));
            }

            /// # Panics
            /// If what it exerts does not turn along when the world and the cable are turned together.
            pub fn turning_world_and_cable_turns_what_it_exerts(make: &Factory<'_>) {
                turns_along(|turn| Box::new(make(turn)));
            }

            /// # Panics
            /// If it says that it has a potential, and exerts more than its dead force.
            pub fn with_a_potential_it_exerts_its_dead_force_alone(make: &Factory<'_>) {
                potential_is_that_of_the_dead_force(&straight(make));
            }

            /// # Panics
            /// If it is larger than the largest that it says.
            pub fn it_is_never_larger_than_it_says(make: &Factory<'_>) {
                keeps_below(&straight(make));
            }

            /// # Panics
            /// If `−q` for `q`, which is the same frame, or a second call gives something else.
            pub fn it_depends_on_the_frame_alone(make: &Factory<'_>) {
                depends_on_the_frame_alone(&straight(make));
            }

            crate::load_checks! { listed_checks CHECKS, }
        }
    };
}

checks! { point_load, dyn PointLoad, "Checks of [`PointLoad`], a load at a place." }
checks! { line_load, dyn LineLoad, "Checks of [`LineLoad`], a load along a cable." }
