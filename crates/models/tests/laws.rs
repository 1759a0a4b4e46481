//! Curves and creep of sections: one coupling of a rod against closed forms.

use wireloom_core::curve::Curve;
use wireloom_core::rod::{BranchShape, Mesh, RodSegment, RodSpec};
use wireloom_core::section::{AxialLaw, CreepElement, FrictionElement, SectionCreep, SectionFriction, SectionLaws};
use wireloom_core::{Parameters, Registry, Rotation, Section, Vector};
use wireloom_models::coupling_law::CouplingLaw;
use wireloom_testkit::conformance::rod::section;

/// EI and GJ, N m².
const EI: f64 = 0.03;
const GJ: f64 = 0.02;
/// λ, m. As κ λ is 0.008 at most, `λ dκ/dφ = 1 − O(φ⁴)` is 1 to 4e-9.
const LAMBDA: f64 = 1e-3;

/// Two segments with one coupling in between, and what it remembers.
struct Coupling {
    rod: Box<dyn RodSegment>,
    memory: Vec<f64>,
    dissipated: f64,
}

impl Coupling {
    fn new(friction: SectionFriction, laws: SectionLaws) -> Self {
        let section = Section { bending_stiffness: [EI; 2], torsion_stiffness: GJ, friction, laws, ..section() };
        let mesh = Mesh::new(vec![LAMBDA; 2], vec![]);
        let spec = RodSpec { name: "branch".into(), sections: section.into(), mesh, curvature: Vector::zeros() };
        let mut registry = Registry::default();
        wireloom_models::register(&mut registry);
        let kind = registry.rod("cosserat").expect("built in");
        let rod = (kind.build)(&spec, &Parameters::default()).expect("accepted");
        Self { memory: rod.memory(), rod, dissipated: 0.0 }
    }

    /// What is read at this turn per length (1/m) and strain, at the end of an increment of this duration (s).
    fn at<T>(
        &self,
        (curvature, strain, duration): (Vector, f64, f64),
        read: impl Fn(&dyn RodSegment, &BranchShape<'_>) -> T,
    ) -> T {
        let frames = [Rotation::identity(), Rotation::from_scaled_axis(curvature * LAMBDA)];
        let edges = frames.map(|frame| frame * Vector::z() * (LAMBDA * (1.0 + strain)));
        let points = [Vector::zeros(), edges[0], edges[0] + edges[1]];
        let shape = BranchShape {
            points: &points,
            compensation: &[Vector::zeros(); 3],
            frames: &frames,
            rest_lengths: &[LAMBDA; 2],
            coupling_lengths: &[LAMBDA],
            free_strain: 0.0,
            extra_curvature: &[],
            memory: &self.memory,
            duration,
        };
        read(&*self.rod, &shape)
    }

    fn moment(&self, curvature: Vector, duration: f64) -> Vector {
        self.at((curvature, 0.0, duration), |rod, shape| {
            let mut moments = [Vector::zeros()];
            rod.moments(shape, &mut moments);
            moments[0]
        })
    }

    /// Ends an increment; returns the moment, N m.
    fn bend(&mut self, curvature: Vector, duration: f64) -> Vector {
        let moment = self.moment(curvature, duration);
        let (memory, dissipated) = self.at((curvature, 0.0, duration), |rod, shape| {
            let mut memory = self.memory.clone();
            let dissipated = rod.commit(shape, &mut memory);
            (memory, dissipated)
        });
        assert!(dissipated >= 0.0, "{dissipated} J");
        self.memory = memory;
        self.dissipated += dissipated;
        moment
    }

    /// Ends an increment under a moment (N m); returns the curvature, 1/m: a few steps of a secant, as creep is linear.
    fn load(&mut self, moment: Vector, duration: f64) -> Vector {
        let at_zero = self.moment(Vector::zeros(), duration);
        let mut curvature = Vector::zeros();
        for i in 0..3 {
            let unit = Vector::ith(i, 1.0);
            let stiffness = (self.moment(unit, duration) - at_zero)[i];
            curvature[i] = (moment - at_zero)[i] / stiffness;
        }
        for _ in 0..3 {
            let off = moment - self.moment(curvature, duration);
            curvature += off.component_div(&Vector::new(EI, EI, GJ));
        }
        self.bend(curvature, duration);
        curvature
    }
}

fn close(got: f64, want: f64, tolerance: f64, what: &str) {
    assert!((got - want).abs() <= tolerance, "{what}: {got:e} instead of {want:e}");
}

const K: [[f64; 2]; 2] = [[0.05, 60.0], [0.02, 3600.0]];

fn creeping() -> SectionLaws {
    let elements = |all: &[[f64; 2]]| -> Vec<CreepElement> {
        all.iter().map(|&[stiffness, time]| CreepElement { stiffness, time }).collect()
    };
    let creep = SectionCreep { bending: elements(&K), torsion: elements(&K[..1]) };
    SectionLaws { creep, ..SectionLaws::default() }
}

/// A bend that is held relaxes as `EI + Σ k exp(−t/τ)`, in increments of any number and duration; so does a twist.
#[test]
fn a_held_bend_relaxes_exactly() {
    let bent = (Vector::new(0.6, -0.8, 0.0), 5.0, EI, &K[..]);
    for (axis, size, lasting, elements) in [bent, (Vector::z(), 2.0, GJ, &K[..1])] {
        for increments in [1, 7, 100] {
            let mut coupling = Coupling::new(SectionFriction::default(), creeping());
            coupling.bend(axis * size, 0.0);
            for k in 1..=increments {
                let t = 5000.0 * f64::from(k) / f64::from(increments);
                let moment = coupling.bend(axis * size, 5000.0 / f64::from(increments));
                let relaxed = elements.iter().map(|[k, tau]| k * (-t / tau).exp()).sum::<f64>();
                let want = size * (lasting + relaxed);
                assert!((moment - axis * want).norm() <= 1e-8 * want, "{moment:?} after {t} s, not {want}");
            }
            // All that the elements had stored, less what is left.
            let lost = |[k, tau]: &[f64; 2]| 0.5 * k * size * size * (1.0 - (-1e4 / tau).exp());
            let lost = elements.iter().map(lost).sum::<f64>() * LAMBDA;
            close(coupling.dissipated, lost, 1e-8 * lost, "energy dissipated");
        }
    }
}

/// One element beside EI under a moment that is applied at once creeps as the standard linear solid,
/// `κ = m/EI (1 − k/(EI + k) exp(−t EI/((EI + k) τ)))`, to second order in the increments; taken away, the springback
/// is that of EI + k, and the rest recovers.
#[test]
fn a_held_moment_creeps_and_recovers() {
    let [k, tau] = K[0];
    let element = CreepElement { stiffness: k, time: tau };
    let creep = SectionCreep { bending: vec![element], torsion: vec![] };
    let laws = SectionLaws { creep, ..SectionLaws::default() };
    let moment = Vector::new(0.1, 0.0, 0.0);
    let (time, slow) = (90.0, EI / ((EI + k) * tau));
    let crept = |t: f64| 0.1 / EI * (1.0 - k / (EI + k) * (-t * slow).exp());
    let errors = [10, 20, 40].map(|increments| {
        let mut coupling = Coupling::new(SectionFriction::default(), laws.clone());
        close(coupling.load(moment, 0.0).x, crept(0.0), 1e-8, "at once");
        let mut end = 0.0;
        for _ in 0..increments {
            end = coupling.load(moment, time / f64::from(increments)).x;
        }
        let sprung = coupling.load(Vector::zeros(), 0.0).x;
        close(sprung, end - 0.1 / (EI + k), 1e-8, "after the moment is taken away");
        let set = coupling.rod.curvature_under(&Vector::zeros(), &coupling.memory, 0.0).expect("it creeps").x;
        close(set, sprung, 1e-8, "set");
        let mut left = 0.0;
        for _ in 0..increments {
            left = coupling.load(Vector::zeros(), time / f64::from(increments)).x;
        }
        close(left, sprung * (-time * slow).exp(), 2e-4 * sprung, "recovered");
        end - crept(time)
    });
    assert!(errors[0].abs() < 1e-3 * crept(time), "{errors:?}");
    for pair in errors.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((3.8..4.2).contains(&ratio), "second order: {errors:?}");
    }
}

/// Without a duration nothing creeps: the section has the stiffness of all springs. Work is stored, none dissipated.
#[test]
fn at_once_it_is_elastic() {
    let mut coupling = Coupling::new(SectionFriction::default(), creeping());
    for kappa in [2.0, -5.0, 1.0, 0.0] {
        let moment = coupling.bend(Vector::y() * kappa, 0.0);
        close(moment.y, kappa * (EI + 0.07), 1e-8, "moment");
    }
    assert_eq!(coupling.dissipated, 0.0);
}

/// A bend that grows evenly is exact in one increment, energy included: work is stored or dissipated.
#[test]
fn an_even_ramp_is_exact_in_one_increment() {
    for duration in [1e-3, 0.5, 30.0, 1e3, 1e6] {
        let of = |increments: i32| {
            let mut coupling = Coupling::new(SectionFriction::default(), creeping());
            let (mut moment, mut work) = (0.0, 0.0);
            for k in 1..=increments {
                let before = moment;
                moment = coupling
                    .bend(Vector::x() * (4.0 * f64::from(k) / f64::from(increments)), duration / f64::from(increments))
                    .x;
                work += 0.5 * (before + moment) * 4.0 / f64::from(increments);
            }
            let stored = coupling.at((Vector::x() * 4.0, 0.0, 0.0), |rod, shape| rod.energy(shape).total());
            (moment, work * LAMBDA, stored + coupling.dissipated, coupling.dissipated)
        };
        let ((once, ..), (often, work, spent, lost)) = (of(1), of(4000));
        close(once, often, 1e-8 * often, &format!("moment after {duration} s"));
        // The trapezoidal rule of the work, of increments far below the times or far above them.
        close(spent, work, 2e-6 * work, &format!("energy after {duration} s"));
        close(of(1).3, lost, 1e-7 * lost.max(1e-12), &format!("dissipated in {duration} s"));
    }
}

const TABLE: [[f64; 2]; 5] = [[0.5, 0.04], [1.0, 0.06], [2.0, 0.08], [4.0, 0.11], [8.0, 0.15]];

/// Pure bending has the moment of the table, in any direction, and the curvature under it is that of the table; beyond
/// its end the last slope goes on.
#[test]
fn a_curve_has_the_moments_of_its_table() {
    let laws = SectionLaws { bending: Some(Curve::new(&TABLE, None)), ..SectionLaws::default() };
    let coupling = Coupling::new(SectionFriction::default(), laws);
    for angle in [0.0_f64, 0.8, 2.0, 4.5] {
        let axis = Vector::new(angle.cos(), angle.sin(), 0.0);
        for [kappa, want] in TABLE.into_iter().chain([[10.0, 0.17]]) {
            let moment = coupling.moment(axis * kappa, 0.0);
            assert!((moment - axis * want).norm() <= 1e-8 * want, "{moment:?} at {kappa} about {axis:?}");
            let found = coupling.rod.curvature_under(&(axis * want), &[], 0.0).expect("it has a curve");
            assert!((found - axis * kappa).norm() <= 1e-12 * kappa, "{found:?} instead of {kappa}");
        }
    }
    // Twist has GJ alone.
    assert!((coupling.moment(Vector::z() * 3.0, 0.0).z - 3.0 * GJ).abs() <= 1e-9);
}

/// A curve, friction and creep act in parallel: their moments add up, and the curvature under their sum is found.
#[test]
fn all_laws_act_in_parallel() {
    let slips = FrictionElement { stiffness: 0.04, moment: 0.02 };
    let friction = SectionFriction { bending: vec![slips], torsion: vec![slips] };
    let curve = SectionLaws { bending: Some(Curve::new(&TABLE, None)), ..SectionLaws::default() };
    let all = SectionLaws { creep: creeping().creep, ..curve.clone() };
    let way =
        [(Vector::new(1.0, 2.0, 0.5), 10.0), (Vector::new(-3.0, 0.2, 1.0), 50.0), (Vector::new(0.3, 0.1, 0.0), 0.0)];
    let mut together = Coupling::new(friction.clone(), all.clone());
    let parts =
        [(friction.clone(), SectionLaws::default()), (Default::default(), curve), (Default::default(), creeping())];
    let mut parts = parts.map(|(friction, laws)| Coupling::new(friction, laws));
    let linear = Coupling::new(SectionFriction::default(), SectionLaws::default());
    for (curvature, duration) in way {
        let moment = together.bend(curvature, duration);
        let sum: Vector = parts.iter_mut().map(|own| own.bend(curvature, duration)).sum();
        // Two parts have EI, and three GJ; together it is GJ alone.
        let want = sum - linear.moment(curvature, 0.0) * 2.0;
        assert!((moment - want).norm() <= 1e-12 * sum.norm(), "{moment:?} instead of {want:?}");
        let section = Section { friction: friction.clone(), laws: all.clone(), ..section() };
        let law = CouplingLaw::of(&section);
        let exact = law.at(curvature, &together.memory, 0.0).moment() + Vector::z() * (GJ * curvature.z);
        let found = together.rod.curvature_under(&exact, &together.memory, 0.0).expect("it is not linear");
        assert!((found - curvature).norm() <= 1e-9 * curvature.norm(), "{found:?} instead of {curvature:?}");
    }
}

/// Axial force and energy are those of the law, in tension and compression.
#[test]
fn axial_laws_have_their_forces() {
    let points = [[-0.02, -1.0], [-0.01, -0.8], [0.01, 2.0], [0.02, 5.0], [0.04, 20.0]];
    let strap = AxialLaw::of_two(1e4, 10.0);
    for law in [AxialLaw::through(&points, None), AxialLaw::through(&points[2..], Some(40.0)), strap.clone()] {
        let laws = SectionLaws { axial: Some(law.clone()), ..SectionLaws::default() };
        let coupling = Coupling::new(SectionFriction::default(), laws);
        for strain in [-0.5, -0.015, -1e-3, 1e-5, 5e-5, 1e-4, 0.003, 0.01, 0.03, 0.3] {
            let (force, energy) = coupling.at((Vector::zeros(), strain, 0.0), |rod, shape| {
                let mut forces = [Vector::zeros(); 2];
                rod.forces(shape, &mut forces);
                (forces[0], rod.energy(shape).stretch)
            });
            let want = law.force(strain);
            // Strains are exact to some 1e-13 on segments of 1 mm.
            assert!((force - Vector::z() * want).norm() <= 1e-8 * want.abs() + 1e-9, "{force:?} at {strain}, {want}");
            let work = 2.0 * LAMBDA * simpson(|e| law.force(e), strain);
            close(energy, work, 1e-6 * work + 1e-15, &format!("energy at {strain}"));
            close(law.strain(law.force(strain)), strain, 1e-13, "inverse");
        }
    }
    // From TAUT on a strap has EA, and is as if it were longer by half of that.
    let beyond = strap.force(2e-4) - strap.force(1e-4);
    close(beyond, 1.0, 1e-12, "force of 1e-4");
    close(strap.force(1e-4), 0.5 * (1e4 + 10.0) * 1e-4, 1e-12, "force where it is taut");
    close(strap.force(-1e-4), -1e-3, 1e-15, "compression");
}

/// Integral from 0.
fn simpson(f: impl Fn(f64) -> f64, to: f64) -> f64 {
    let n = 20_000;
    let h = to / f64::from(n);
    let at = |k: i32| f(h * (f64::from(k) + 0.5));
    (0..n).map(|k| h / 6.0 * (f(h * f64::from(k)) + 4.0 * at(k) + f(h * f64::from(k + 1)))).sum()
}
