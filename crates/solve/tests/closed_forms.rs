//! Critical loads by the stability flag alone, and the sag of a stiff beam, against closed forms.
//!
//! The scenarios of `scenarios/analytic` test the flag of a rod just above its critical load with the whole program,
//! and accept that the minimiser has left the straight state. Here the straight state is constructed, certified as an
//! equilibrium and inspected; the load at which the flag changes is found by bisection, so that only the flag is
//! tested.

use wireloom_core::constraint::{ConstraintSpec, HoldWord};
use wireloom_core::minimiser::{Minimiser, Stop};
use wireloom_core::rod::RodSpec;
use wireloom_core::status::Status;
use wireloom_core::{Parameters, Problem, Registry, Rotation, Section, State, Tangent, Vector};
use wireloom_solve::minimisers::newton::Newton;
use wireloom_solve::steps::certificate::Certifier;
use wireloom_solve::steps::stability::Stability;
use wireloom_testkit::closed_forms::{clamped_beam_sag, euler_clamped, euler_pinned, greenhill_critical_angle};
use wireloom_testkit::conformance::networks::{Sample, cable, section};

/// Segments of the meshes.
const MESHES: [usize; 3] = [20, 40, 80];

fn registry() -> Registry {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    registry
}

/// The straight cable of 1 m between two constraints that hold these freedoms, without gravity.
fn weightless(segments: usize, holds: [&[HoldWord]; 2]) -> Sample {
    let registry = registry();
    let mut sample = cable(&registry, segments);
    let connector = registry.constraint("connector").unwrap();
    for (constraint, words) in sample.network.constraints.iter_mut().zip(holds) {
        let spec = ConstraintSpec { hold: Some(words.to_vec()), ..ConstraintSpec::default() };
        constraint.model = (connector.build)(&spec, &Parameters::default()).unwrap();
    }
    sample.conditions.gravity = Vector::zeros();
    sample
}

const CLAMPED: &[HoldWord] = &[HoldWord::Position, HoldWord::Tangent, HoldWord::Twist];

/// Stability flag of a state, which must be certified as an equilibrium to the default tolerance: positions without
/// compensation leave residual forces of `EA/ℓ · ε`, about 1e-8 of the force scale.
fn stable(problem: &mut Problem<'_>, state: &State) -> bool {
    let mut certifier = Certifier::new(problem.network);
    let certificate = certifier.certify(problem, state, &Stop::default(), Status::IterationLimit);
    assert_eq!(certificate.grade, Status::Converged, "{certificate:?}");
    certifier.inspect(problem, state).stability == Stability::Stable
}

/// Load at which the flag changes from stable to unstable, by bisection to 1e-7 of the closed form.
fn critical(exact: f64, mut stable: impl FnMut(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.5 * exact, 1.5 * exact);
    assert!(stable(low), "unstable at half the critical load");
    assert!(!stable(high), "stable at 1.5 times the critical load");
    while high - low > 1e-7 * exact {
        let middle = 0.5 * (low + high);
        if stable(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Checks the relative errors on [`MESHES`]: the coarsest within 1 %, each at most a third of the one before (a quarter
/// at second order), down to `floor`, the error of the closed form.
#[track_caller]
fn second_order(errors: [f64; 3], floor: f64) {
    assert!(errors[0].abs() < 0.01, "{errors:?}");
    for pair in errors.windows(2) {
        assert!(pair[1].abs() <= pair[0].abs() / 3.0 + floor, "{errors:?}");
    }
}

/// Equilibrium of the straight cable with its far end turned by `angle` (rad): the frames turn about the axis alone,
/// and are brought into balance by steps with the springs between neighbours, which leave a third of what is out of
/// balance.
fn twisted(sample: &Sample, problem: &mut Problem<'_>, angle: f64) -> State {
    let mesh = sample.network.branches[0].rod.mesh();
    let mut state = sample.state.clone();
    let base = sample.conditions.targets[0].orientation;
    let places = mesh.frame_places(&mesh.arc_lengths());
    let last = places.len() - 1;
    let mut angles: Vec<f64> = places.iter().map(|s| angle * s / mesh.length()).collect();
    let mut target = sample.conditions.targets[1];
    target.orientation = base * Rotation::from_axis_angle(&Vector::z_axis(), angle);
    problem.set_target(1, target);
    let mut gradient = Tangent::zeros(&sample.network);
    for _ in 0..40 {
        for (frame, angle) in state.frames.iter_mut().zip(&angles) {
            *frame = base * Rotation::from_axis_angle(&Vector::z_axis(), *angle);
        }
        problem.gradient(&state, &mut gradient);
        // Of a chain of springs GJ/λ between fixed ends: torques t from the start on, turned by Σ t λ/GJ.
        let compliance = |c: usize| mesh.coupling_lengths[c] / section(false).torsion_stiffness;
        let (mut torque, mut turned, mut moves) = (0.0, 0.0, vec![0.0; last + 1]);
        for c in 0..last {
            turned += torque * compliance(c);
            moves[c + 1] = turned;
            torque += gradient.frames[c + 1].z;
        }
        for (k, angle) in angles.iter_mut().enumerate() {
            *angle += moves[k] - turned * places[k] / mesh.length();
        }
    }
    state
}

/// The closed form neglects shear, of the order of `M²/(EI GA)` = 1e-4 of the load.
#[test]
fn the_flag_changes_at_greenhills_twist() {
    let section = section(false);
    let exact = greenhill_critical_angle(section.bending_stiffness[0], section.torsion_stiffness);
    let errors = MESHES.map(|n| {
        let sample = weightless(n, [CLAMPED; 2]);
        let mut problem = sample.problem();
        let found = critical(exact, |angle| {
            let state = twisted(&sample, &mut problem, angle);
            stable(&mut problem, &state)
        });
        found / exact - 1.0
    });
    second_order(errors, 1e-4);
}

/// The straight cable under a uniform compressive force (N): `ε = P/EA`.
fn compressed(sample: &Sample, problem: &mut Problem<'_>, force: f64) -> State {
    let mut state = sample.state.clone();
    let stretch = 1.0 - force / section(false).axial_stiffness;
    for x in &mut state.points {
        *x *= stretch;
    }
    let mut target = sample.conditions.targets[1];
    target.position *= stretch;
    problem.set_target(1, target);
    state
}

/// Errors of the buckling load between constraints at a prescribed distance.
fn buckling(section: &Section, exact: f64, holds: [&[HoldWord]; 2]) -> [f64; 3] {
    MESHES.map(|n| {
        let mut sample = weightless(n, holds);
        let branch = &mut sample.network.branches[0];
        let (name, mesh) = (branch.name.clone(), branch.rod.mesh().clone());
        let spec = RodSpec { name, sections: section.clone().into(), mesh, curvature: Vector::zeros() };
        branch.rod = (registry().rod("cosserat").unwrap().build)(&spec, &Parameters::default()).unwrap();
        branch.sections = spec.sections;
        let mut problem = sample.problem();
        let found = critical(exact, |force| {
            let state = compressed(&sample, &mut problem, force);
            stable(&mut problem, &state)
        });
        found / exact - 1.0
    })
}

/// The closed form neglects shear, `P/GA` = 6e-5 of the load: the limit of the errors.
#[test]
fn the_flag_changes_at_eulers_load_of_a_clamped_column() {
    let section = section(false);
    second_order(buckling(&section, euler_clamped(section.bending_stiffness[0], 1.0), [CLAMPED; 2]), 6e-5);
}

/// One of the pins holds the twist. Shear is 1.5e-5 of the load.
#[test]
fn the_flag_changes_at_eulers_load_of_a_pinned_column() {
    let holds: [&[HoldWord]; 2] = [&[HoldWord::Position, HoldWord::Twist], &[HoldWord::Position]];
    let section = section(false);
    second_order(buckling(&section, euler_pinned(section.bending_stiffness[0], 1.0), holds), 2e-5);
}

/// A strip three times as stiff about one axis as about the other buckles about the weaker one, in either order of the
/// axes: in a single mode, while a round rod has two.
#[test]
fn a_flat_column_buckles_about_its_weaker_axis() {
    let round = section(false);
    let weak = round.bending_stiffness[0];
    for bending_stiffness in [[weak, 3.0 * weak], [3.0 * weak, weak]] {
        let flat = Section { bending_stiffness, ..round.clone() };
        second_order(buckling(&flat, euler_clamped(weak, 1.0), [CLAMPED; 2]), 6e-5);
    }
}

/// A sag of about 10 µm: its tension, `EA (π w/2L)²`, is 1e-5 of the buckling load and negligible.
#[test]
fn a_clamped_beam_sags_as_the_linear_theory_says() {
    let section = section(false);
    let gravity = 6e-4;
    let exact = clamped_beam_sag(
        section.linear_density * gravity,
        1.0,
        section.bending_stiffness[0],
        section.shear_stiffness[0],
    );
    let errors = MESHES.map(|n| {
        let mut sample = weightless(n, [CLAMPED; 2]);
        sample.conditions.gravity.z = -gravity;
        let mut state = sample.state.clone();
        let stop = Stop { force_tolerance: 1e-8, max_iterations: 50 };
        let report = Newton::new().minimise(&mut sample.problem(), &mut state, &stop);
        assert_eq!(report.status, Status::Converged, "{report:?}");
        -state.points[n / 2].z / exact - 1.0
    });
    second_order(errors, 2e-5);
}
