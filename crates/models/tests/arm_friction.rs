//! Friction between an arm and its compliant hub: one arm against the analytic Prandtl–Ishlinskii operator.

use wireloom_core::joint::{Arm, ArmSpring, JointModel, JointShape, JointSpec};
use wireloom_core::section::{FrictionElement, SectionFriction};
use wireloom_core::{Rotation, Vector};
use wireloom_models::joints::compliant_hub::CompliantHub;
use wireloom_testkit::closed_forms::FrictionOperator;
use wireloom_testkit::conformance::rod::section;

/// k (N m/rad) and M (N m): limits of 2, 5 and 10 mrad.
const BENDING: [[f64; 2]; 3] = [[0.5, 0.001], [0.4, 0.002], [0.2, 0.002]];
const TORSION: [[f64; 2]; 2] = [[0.3, 0.0012], [0.1, 0.001]];
/// Of the spring, N m/rad.
const K: f64 = 0.3;
/// Turns of the path are up to this, rad. The turn in the energy is that of the frames to the fourth power.
const LARGEST: f64 = 0.02;
const TOLERANCE: f64 = 1e-8;

fn elements(all: &[[f64; 2]]) -> Vec<FrictionElement> {
    all.iter().map(|&[stiffness, moment]| FrictionElement { stiffness, moment }).collect()
}

/// A hub with two arms, of which the first is turned, and what it remembers.
struct Turned {
    hub: CompliantHub,
    rest: [Rotation; 2],
    memory: Vec<f64>,
    dissipated: [f64; 2],
}

impl Turned {
    fn new() -> Self {
        let rest = [Vector::new(0.3, 1.1, -0.4), Vector::new(-2.0, 0.2, 0.7)].map(Rotation::from_scaled_axis);
        let arm = |rest: &Rotation| Arm {
            branch: "arm".into(),
            starts_here: true,
            rest: *rest,
            offset: Vector::zeros(),
            section: section(),
            segment_length: 0.01,
            length: 0.5,
            curvature: Vector::zeros(),
            spring: ArmSpring {
                bending: Some([K; 2]),
                torsion: Some(K),
                friction: SectionFriction { bending: elements(&BENDING), torsion: elements(&TORSION) },
            },
        };
        let spec = JointSpec { name: "joint".into(), arms: rest.iter().map(arm).collect(), wires: vec![] };
        let hub = CompliantHub::new(&spec).expect("springs");
        Self { memory: hub.memory(), hub, rest, dissipated: [0.0; 2] }
    }

    /// Reads the joint with the first arm turned from its rest direction by this, rad, about its axes.
    fn at<T>(&self, turn: Vector, read: impl Fn(&CompliantHub, &JointShape<'_>) -> T) -> T {
        let hub = Rotation::from_scaled_axis(Vector::new(0.9, -0.3, 2.0));
        let [first, second] = self.rest;
        let frames = [hub * first * Rotation::from_scaled_axis(turn), hub * second, hub];
        read(&self.hub, &JointShape { frames: &frames, memory: &self.memory })
    }

    /// Moment that turns it so far, N m, in the axes of the arm.
    fn moment(&self, turn: Vector) -> Vector {
        self.at(turn, |hub, shape| {
            let mut gradient = [Vector::zeros(); 3];
            hub.add_gradient(shape, &mut gradient);
            gradient[0]
        })
    }

    /// Ends an increment; returns the moment, N m.
    fn turn(&mut self, turn: Vector) -> Vector {
        let moment = self.moment(turn);
        let (memory, dissipated) = self.at(turn, |hub, shape| {
            let (mut memory, mut dissipated) = (self.memory.clone(), self.dissipated);
            hub.commit(shape, &mut memory, &mut dissipated);
            (memory, dissipated)
        });
        assert!(dissipated[0] >= self.dissipated[0] && dissipated[1] == 0.0, "{dissipated:?} J");
        (self.memory, self.dissipated) = (memory, dissipated);
        moment
    }
}

/// Numbers between −1 and 1 without an order: the Weyl sequence of the golden ratio.
fn scattered(k: u32) -> f64 {
    2.0 * (f64::from(k + 1) * 0.618_033_988_749_894_9).fract() - 1.0
}

fn close(got: f64, want: f64, scale: f64, what: &str) {
    assert!((got - want).abs() <= TOLERANCE * scale, "{what}: {got:e} instead of {want:e}");
}

/// Along any path about any axis across the arm, and in torsion, moment, stored and dissipated energy and the set are
/// those of the operator.
#[test]
fn loops_of_an_arm_are_those_of_the_operator() {
    let bending =
        [0.0, 0.7, std::f64::consts::FRAC_PI_2, 4.0].map(|a: f64| (Vector::new(a.cos(), a.sin(), 0.0), &BENDING[..]));
    let corners = [0.3, -0.3, 0.3, 0.1, 0.25, 0.0, 0.6, -0.8, 0.8].map(|share| share * LARGEST);
    let path: Vec<f64> = corners.into_iter().chain((0..200).map(|k| LARGEST * scattered(k))).collect();
    for (axis, elements) in bending.into_iter().chain([(Vector::z(), &TORSION[..])]) {
        let (mut arm, mut operator) = (Turned::new(), FrictionOperator::new(K, elements));
        let mut largest = 0.0_f64;
        for (k, &turn) in path.iter().enumerate() {
            let (moment, want) = (arm.turn(axis * turn), operator.bend(turn));
            largest = largest.max(want.abs());
            close(moment.dot(&axis), want, largest, &format!("moment at corner {k} about {axis:?}"));
            assert!((moment - axis * moment.dot(&axis)).norm() <= TOLERANCE * largest, "corner {k}: across the path");
            let stored = arm.at(axis * turn, |hub, shape| hub.energy(shape));
            close(stored, operator.stored(), stored, &format!("energy stored at corner {k}"));
            close(arm.dissipated[0], operator.dissipated(), operator.dissipated(), "energy dissipated");
            let set = arm.hub.set(0, &arm.memory).expect("it slips");
            close((set - axis * operator.clone().let_go()).norm(), 0.0, LARGEST, &format!("set at corner {k}"));
        }
        assert!(operator.dissipated() > 1e-4, "nothing slipped");
    }
}

/// Masing's rules: after a reversal at φ_r the moment is the virgin curve f at twice the scale,
/// `m_r ∓ 2 f(|φ − φ_r|/2)`; and once a loop has come back to where it left the virgin curve, that goes on as if there
/// had been no loop.
#[test]
fn masing_s_rules_hold_for_an_arm() {
    let virgin = |turn: f64| Turned::new().moment(Vector::x() * turn).x;
    for reversal in [0.05, 0.2, 0.5, 0.9].map(|share| share * LARGEST) {
        let mut arm = Turned::new();
        let at_reversal = arm.turn(Vector::x() * reversal).x;
        for turn in [0.9, 0.5, 0.0, -0.5, -1.0].map(|share| share * reversal) {
            let want = at_reversal - 2.0 * virgin(0.5 * (reversal - turn));
            close(arm.moment(Vector::x() * turn).x, want, virgin(LARGEST), &format!("from {reversal} to {turn}"));
        }
        arm.turn(Vector::x() * (-0.7 * reversal));
        arm.turn(Vector::x() * reversal);
        let beyond = 1.1 * reversal;
        close(arm.moment(Vector::x() * beyond).x, virgin(beyond), virgin(LARGEST), &format!("beyond {reversal}"));
    }
}

/// A path in one direction gives the same in one increment and in twenty, up to round-off, also by large turns.
#[test]
fn the_number_of_increments_of_a_monotone_turn_does_not_matter() {
    let axis = Vector::new(0.6, -0.8, 0.5);
    let (mut once, mut often) = (Turned::new(), Turned::new());
    let mut from = 0.0;
    for to in [0.8, -0.4, 0.2, 0.04] {
        let moment = once.turn(axis * to);
        for k in 1..=20 {
            let there = often.turn(axis * (from + (to - from) * f64::from(k) / 20.0));
            if k == 20 {
                assert!((there - moment).norm() <= 1e-12 * moment.norm(), "{there:?} instead of {moment:?}");
            }
        }
        let apart = once.memory.iter().zip(&often.memory).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart <= 1e-13, "slips {apart:e} rad apart at {to}");
        assert!((once.dissipated[0] - often.dissipated[0]).abs() <= 1e-12 * once.dissipated[0]);
        from = to;
    }
}

/// An arm that is let go where nothing holds it has no moment at its set, however large that is.
#[test]
fn at_its_set_an_arm_has_no_moment() {
    let mut arm = Turned::new();
    for k in 0..50 {
        arm.turn(Vector::from_fn(|i, _| 1.2 * scattered(3 * k + i as u32)));
        let set = arm.hub.set(0, &arm.memory).expect("it slips");
        let moment = arm.moment(set);
        assert!(moment.norm() <= 1e-12, "{moment:?} N m at a set of {set:?} rad");
        assert_eq!(arm.hub.set(1, &arm.memory), Some(Vector::zeros()), "the other arm was not turned");
    }
}

/// What is dissipated along a random path never falls.
#[test]
fn random_turns_gain_nothing() {
    let mut arm = Turned::new();
    let mut last = 0.0;
    for k in 0..1000 {
        arm.turn(Vector::from_fn(|i, _| 0.05 * scattered(3 * k + i as u32)));
        assert!(arm.dissipated[0] >= last, "{:?}", arm.dissipated);
        last = arm.dissipated[0];
    }
    assert!(last > 0.1, "{last} J");
}
