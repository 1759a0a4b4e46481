//! Friction within a section: one coupling of a rod against the analytic Prandtl–Ishlinskii operator.

use wireloom_core::rod::{BranchShape, Mesh, RodSegment, RodSpec};
use wireloom_core::section::{FrictionElement, SectionFriction};
use wireloom_core::{Parameters, Registry, Rotation, Section, Vector};
use wireloom_models::friction::Friction;
use wireloom_testkit::closed_forms::FrictionOperator;
use wireloom_testkit::conformance::rod::section;

/// k (N m²) and M (N m): limits of 0.4, 1.5 and 4 1/m.
const BENDING: [[f64; 2]; 3] = [[0.05, 0.02], [0.02, 0.03], [0.01, 0.04]];
const TORSION: [[f64; 2]; 2] = [[0.02, 0.01], [0.01, 0.02]];
/// EI about both axes, N m²; GJ of [`section`] is 0.03.
const EI: f64 = 0.03;
const GJ: f64 = 0.03;
/// λ, m. The moment is `m dκ/dφ · λ`, and with the angle φ = κ λ `λ dκ/dφ = 1 − O(φ⁴)`: at κ = 8 1/m φ is 0.008.
const LAMBDA: f64 = 1e-3;
/// What is asked for: the fourth power of the angle is 4e-9.
const TOLERANCE: f64 = 1e-8;

fn section_friction() -> SectionFriction {
    let elements = |all: &[[f64; 2]]| -> Vec<FrictionElement> {
        all.iter().map(|&[stiffness, moment]| FrictionElement { stiffness, moment }).collect()
    };
    SectionFriction { bending: elements(&BENDING), torsion: elements(&TORSION) }
}

/// Two segments with one coupling in between, and what it remembers.
struct Coupling {
    rod: Box<dyn RodSegment>,
    memory: Vec<f64>,
    dissipated: f64,
}

impl Coupling {
    fn new() -> Self {
        let friction = section_friction();
        let section = Section { bending_stiffness: [EI; 2], torsion_stiffness: GJ, friction, ..section() };
        let mesh = Mesh::new(vec![LAMBDA; 2], vec![]);
        let spec = RodSpec { name: "branch".into(), sections: section.into(), mesh, curvature: Vector::zeros() };
        let mut registry = Registry::default();
        wireloom_models::register(&mut registry);
        let kind = registry.rod("cosserat").expect("built in");
        let rod = (kind.build)(&spec, &Parameters::default()).expect("accepted");
        Self { memory: rod.memory(), rod, dissipated: 0.0 }
    }

    /// Moment (N m) and energy (J) of an increment that ends with this turn per length, 1/m.
    fn at<T>(&self, curvature: Vector, read: impl Fn(&dyn RodSegment, &BranchShape<'_>) -> T) -> T {
        let frames = [Rotation::identity(), Rotation::from_scaled_axis(curvature * LAMBDA)];
        let points = [0.0, LAMBDA, 2.0 * LAMBDA].map(|z| Vector::z() * z);
        let shape = BranchShape {
            points: &points,
            compensation: &[Vector::zeros(); 3],
            frames: &frames,
            rest_lengths: &[LAMBDA; 2],
            coupling_lengths: &[LAMBDA],
            free_strain: 0.0,
            extra_curvature: &[],
            memory: &self.memory,
            duration: 0.0,
        };
        read(&*self.rod, &shape)
    }

    fn moment(&self, curvature: Vector) -> Vector {
        self.at(curvature, |rod, shape| {
            let mut moments = [Vector::zeros()];
            rod.moments(shape, &mut moments);
            moments[0]
        })
    }

    /// Ends an increment; returns the moment, N m.
    fn bend(&mut self, curvature: Vector) -> Vector {
        let moment = self.moment(curvature);
        let (memory, dissipated) = self.at(curvature, |rod, shape| {
            let mut memory = self.memory.clone();
            let dissipated = rod.commit(shape, &mut memory);
            (memory, dissipated)
        });
        assert!(dissipated >= 0.0, "{dissipated} J");
        self.memory = memory;
        self.dissipated += dissipated;
        moment
    }
}

/// Numbers between −1 and 1 without an order: the Weyl sequence of the golden ratio.
fn scattered(k: u32) -> f64 {
    2.0 * (f64::from(k + 1) * 0.618_033_988_749_894_9).fract() - 1.0
}

/// Corners of a path of curvatures: a large loop, smaller ones within it, and a random walk, 1/m.
fn path() -> Vec<f64> {
    let mut all = vec![3.0, -3.0, 3.0, 1.0, 2.5, 0.0, 6.0, -8.0, 8.0];
    all.extend((0..200).map(|k| 8.0 * scattered(k)));
    all
}

fn close(got: f64, want: f64, scale: f64, what: &str) {
    assert!((got - want).abs() <= TOLERANCE * scale, "{what}: {got:e} instead of {want:e}");
}

/// Along any path in any direction of bending, and in torsion, moment, stored and dissipated energy are those of the
/// operator.
#[test]
fn loops_are_those_of_the_operator() {
    let bending = [0.0, 0.7, std::f64::consts::FRAC_PI_2, 4.0]
        .map(|a: f64| (Vector::new(a.cos(), a.sin(), 0.0), EI, &BENDING[..]));
    for (axis, elastic, elements) in bending.into_iter().chain([(Vector::z(), GJ, &TORSION[..])]) {
        let (mut coupling, mut operator) = (Coupling::new(), FrictionOperator::new(elastic, elements));
        let mut largest = 0.0_f64;
        for (k, kappa) in path().into_iter().enumerate() {
            let (moment, want) = (coupling.bend(axis * kappa), operator.bend(kappa));
            largest = largest.max(want.abs());
            close(moment.dot(&axis), want, largest, &format!("moment at corner {k} about {axis:?}"));
            assert!((moment - axis * moment.dot(&axis)).norm() <= TOLERANCE * largest, "corner {k}: across the path");
            let energy = coupling.at(axis * kappa, |rod, shape| rod.energy(shape));
            let stored = (energy.bend + energy.twist) / LAMBDA;
            close(stored, operator.stored(), stored, &format!("energy stored at corner {k}"));
            close(coupling.dissipated / LAMBDA, operator.dissipated(), operator.dissipated(), "energy dissipated");
        }
        assert!(operator.dissipated() > 1.0, "nothing slipped");
    }
}

/// Masing's rules: after a reversal at κ_r the moment is the virgin curve f at twice the scale,
/// `m_r ∓ 2 f(|κ − κ_r|/2)`; and once a loop has come back to where it left the virgin curve, that goes on as if there
/// had been no loop.
#[test]
fn masing_s_rules_hold() {
    let virgin = |kappa: f64| Coupling::new().moment(Vector::x() * kappa).x;
    for reversal in [0.3, 1.0, 3.0, 7.0] {
        let mut coupling = Coupling::new();
        let at_reversal = coupling.bend(Vector::x() * reversal).x;
        for kappa in [0.9, 0.5, 0.0, -0.5, -1.0].map(|share| share * reversal) {
            let want = at_reversal - 2.0 * virgin(0.5 * (reversal - kappa));
            close(coupling.moment(Vector::x() * kappa).x, want, virgin(7.0), &format!("from {reversal} to {kappa}"));
        }
        coupling.bend(Vector::x() * (-0.7 * reversal));
        coupling.bend(Vector::x() * reversal);
        let beyond = 1.1 * reversal;
        close(coupling.moment(Vector::x() * beyond).x, virgin(beyond), virgin(7.0), &format!("beyond {reversal}"));
    }
}

/// A path in one direction gives the same in one increment and in a thousand, up to round-off.
#[test]
fn the_number_of_increments_of_a_monotone_path_does_not_matter() {
    let axis = Vector::new(0.6, -0.8, 0.5);
    let (mut once, mut often) = (Coupling::new(), Coupling::new());
    let mut from = 0.0;
    for to in [4.0, -2.0, 1.0, 0.2] {
        let moment = once.bend(axis * to);
        for k in 1..=1000 {
            let there = often.bend(axis * (from + (to - from) * f64::from(k) / 1000.0));
            if k == 1000 {
                assert!((there - moment).norm() <= 1e-12 * moment.norm(), "{there:?} instead of {moment:?}");
            }
        }
        let apart = once.memory.iter().zip(&often.memory).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart <= 1e-11, "slips {apart:e} 1/m apart at {to}");
        assert!((once.dissipated - often.dissipated).abs() <= 1e-11 * once.dissipated);
        from = to;
    }
}

/// A closed cycle dissipates the area of its loop: `Σ 4 M (a − M/k)` over the elements that slip at the amplitude a.
#[test]
fn a_cycle_dissipates_the_area_of_its_loop() {
    for amplitude in [0.3, 1.0, 2.0, 6.0] {
        let mut coupling = Coupling::new();
        for end in [amplitude, -amplitude, amplitude] {
            coupling.bend(Vector::y() * end);
        }
        let before = coupling.dissipated;
        coupling.bend(Vector::y() * -amplitude);
        coupling.bend(Vector::y() * amplitude);
        let area: f64 = BENDING.iter().map(|[k, m]| 4.0 * m * (amplitude - m / k).max(0.0)).sum();
        close((coupling.dissipated - before) / LAMBDA, area, area.max(1e-9), &format!("amplitude {amplitude}"));
    }
}

/// The curvature under a moment is that at which the moment is found.
#[test]
fn the_curvature_under_a_moment_has_that_moment() {
    let (mut coupling, law) = (Coupling::new(), section_friction());
    let random = |k: u32, size: f64| Vector::from_fn(|i, _| size * scattered(3 * k + i as u32));
    for k in 0..300 {
        coupling.bend(random(2 * k, 6.0));
        let curvature = random(2 * k + 1, 8.0);
        let friction = Friction::new(&law, curvature, &coupling.memory).moment();
        let moment = Vector::new(EI, EI, GJ).component_mul(&curvature) + friction;
        let found = coupling.rod.curvature_under(&moment, &coupling.memory, 0.0).expect("it has friction");
        assert!((found - curvature).norm() <= 1e-9 * curvature.norm(), "{found:?} instead of {curvature:?}");
    }
}
