//! Dead moments: loads about axes that are fixed in space, which have no potential.

use std::f64::consts::TAU;
use wireloom_core::minimiser::{Minimiser, Report, Stop};
use wireloom_core::network::{Load, Place};
use wireloom_core::problem::Hessian;
use wireloom_core::rod::RodSpec;
use wireloom_core::status::Status;
use wireloom_core::{Parameters, Problem, Registry, Section, State, Tangent, Vector};
use wireloom_solve::linear::assembly::System;
use wireloom_solve::linear::border::Border;
use wireloom_solve::linear::dead_moments::DeadMoments;
use wireloom_solve::minimisers::newton::Newton;
use wireloom_solve::steps::certificate::Certifier;
use wireloom_testkit::conformance::networks::{Sample, Sketch, section, sized_y_harness};
use wireloom_testkit::conformance::numeric::{random_turn, random_vector};

/// Largest number of iterations of an increment.
const MOST: usize = 20;

fn registry() -> Registry {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    registry
}

/// Adds a dead moment (N m) at a place.
fn load(sample: &mut Sample, place: Place, moment: Vector) {
    let site = sample.network.site(place);
    let load = Load { name: "tool".into(), site, point: site.point, force: Vector::zeros(), moment, factor: 1.0 };
    sample.network.loads.push(load);
    sample.conditions.load_factors.push(1.0);
}

/// A weightless cantilever of 1 m along x with this moment (N m) at its end.
fn cantilever(segments: usize, moment: Vector) -> Sample {
    let mut sketch = Sketch::default();
    let b = sketch.branch(Vector::zeros(), Vector::x(), segments, [None, None], false);
    sketch.clamp(b, true);
    let mut sample = sketch.build(&registry());
    sample.conditions.gravity = Vector::zeros();
    load(&mut sample, Place::Node { branch: 0, node: segments }, moment);
    sample
}

fn solve(problem: &mut Problem<'_>, state: &mut State) -> Report {
    Newton::new().minimise(problem, state, &Stop { force_tolerance: 1e-9, max_iterations: 200 })
}

/// Position and tangent at arc length s of a weightless cantilever along x under a moment M. Without forces M is
/// constant, and the tangent turns about it at the rate |M|/EI: a helix, for any GJ.
fn helix(moment: &Vector, s: f64) -> (Vector, Vector) {
    let (axis, rate) = (moment.normalize(), moment.norm() / section(false).bending_stiffness[0]);
    let along = axis * axis.x;
    let across = Vector::x() - along;
    let turned = axis.cross(&across);
    let (sin, cos) = (rate * s).sin_cos();
    (along * s + (across * sin + turned * (1.0 - cos)) / rate, along + across * cos + turned * sin)
}

/// Applies the moment in one increment on three meshes; checks the convergence of the ends to their exact positions.
#[track_caller]
fn second_order(what: &str, harness: impl Fn(usize) -> Sample, ends: &[(usize, Vector)]) {
    let errors = [40, 80, 160].map(|segments| {
        let sample = harness(segments);
        let mut state = sample.state.clone();
        let report = solve(&mut sample.problem(), &mut state);
        assert_eq!(report.status, Status::Converged, "{what}, {segments} segments: {report:?}");
        assert!(report.iterations <= MOST, "{what}, {segments} segments: {report:?}");
        let end = |branch: usize| state.points[sample.network.branches[branch].points.end - 1];
        ends.iter().map(|(branch, exact)| (end(*branch) - exact).norm()).fold(0.0, f64::max)
    });
    // The ratio is a quarter at second order; errors of different signs may cancel on the coarsest mesh.
    assert!(errors[0] < 1e-3 && errors[1] < 0.5 * errors[0] && errors[2] < 0.3 * errors[1], "{what}: {errors:?}");
}

/// Half, one and two full circles, about an axis across the cable.
#[test]
fn a_cantilever_rolled_up_by_an_end_moment_ends_at_the_iteration_limit() {
    for circles in [0.5, 1.0, 2.0] {
        let moment = -Vector::y() * (TAU * circles * section(false).bending_stiffness[0]);
        let exact = helix(&moment, 1.0).0;
        second_order(&format!("{circles} circles"), |segments| cantilever(segments, moment), &[(0, exact)]);
    }
}

/// The cable becomes a helix of up to one and a half turns.
#[test]
fn a_moment_about_an_oblique_axis_makes_a_helix() {
    for (direction, turns) in
        [(Vector::new(0.5, -1.0, 0.3), 0.4), (Vector::new(1.0, 0.2, -0.7), 1.0), (Vector::new(-0.6, 0.5, 0.6), 1.5)]
    {
        let moment = direction.normalize() * (TAU * turns * section(false).bending_stiffness[0]);
        let exact = helix(&moment, 1.0).0;
        second_order(&format!("{direction:?}"), |segments| cantilever(segments, moment), &[(0, exact)]);
    }
}

/// A moment on a joint in the middle bends the first half to a helix; the second half stays straight.
#[test]
fn a_moment_at_a_joint_bends_the_half_before_it() {
    let moment = Vector::new(0.4, -1.0, 0.5).normalize() * (TAU * section(false).bending_stiffness[0]);
    let (middle, tangent) = helix(&moment, 0.5);
    for model in ["fused", "rigid-body"] {
        let harness = |segments: usize| {
            let mut sketch = Sketch::default();
            let at = Vector::x() * 0.5;
            let joint = sketch.joint(model, at);
            let first = sketch.branch(Vector::zeros(), at, segments / 2, [None, Some(joint)], false);
            sketch.branch(at, Vector::x(), segments / 2, [Some(joint), None], false);
            sketch.clamp(first, true);
            let mut sample = sketch.build(&registry());
            sample.conditions.gravity = Vector::zeros();
            load(&mut sample, Place::Joint(joint), moment);
            sample
        };
        second_order(model, harness, &[(0, middle), (1, middle + tangent * 0.5)]);
    }
}

/// Random states and moments on a hub, on the end of a branch tied to it with an offset, and on the ends: the residual
/// must vanish to first order at the step `u` of the solve. With r the gradient in body frames, its change along u is
/// `K u + ½ r × u` in each frame, as K is the derivative of r pulled back to θ.
#[test]
fn the_corrected_matrix_is_the_derivative_of_the_residual() {
    let mut rng = fastrand::Rng::with_seed(17);
    for model in ["fused", "rigid-body"] {
        let radius = if model == "rigid-body" { 0.02 } else { 0.0 };
        let mut sample = sized_y_harness(&registry(), model, 6, radius);
        load(&mut sample, Place::Joint(0), random_vector(&mut rng, 100.0));
        load(&mut sample, Place::Node { branch: 1, node: 0 }, random_vector(&mut rng, 100.0));
        load(&mut sample, Place::Node { branch: 2, node: 0 }, random_vector(&mut rng, 100.0));
        let network = &sample.network;
        let mut state = sample.state.clone();
        for x in &mut state.points {
            *x += random_vector(&mut rng, 1e-3);
        }
        for q in &mut state.frames {
            *q *= random_turn(&mut rng, 0.2);
        }
        network.follow_ties(&mut state);
        let mut problem = sample.problem();
        problem.update_held(&state);
        let (mut residual, mut step) = (Tangent::zeros(network), Tangent::zeros(network));
        problem.gradient(&state, &mut residual);
        let mut system = System::new(&problem);
        let mut hessian = Hessian::new(network);
        problem.hessian(&state, None, &mut hessian);
        system.fill(&problem, &state, &hessian);
        let System { matrix, rhs, .. } = &mut system;
        matrix.eliminate_prescribed(&problem);
        matrix.factorise();
        matrix.right_hand_side(&problem, &residual, None, rhs);
        matrix.solve(rhs);
        matrix.step(&problem, &state, rhs, None, &mut step);
        let mut moments = DeadMoments::default();
        moments.prepare(matrix, &Border::default(), &problem, &state, rhs);
        let symmetric = step.clone();
        moments.complete(&mut step);
        problem.free_part(&mut residual);
        let before = residual.dot(&residual).sqrt();
        let mut left = |step: &Tangent| {
            let mut at = |h: f64| {
                let (mut there, mut gradient) = (state.clone(), Tangent::zeros(network));
                network.retract(&state, step, h, &mut there);
                problem.gradient(&there, &mut gradient);
                gradient
            };
            let h = 1e-5;
            let (mut left, ahead, behind) = (at(0.0), at(h), at(-h));
            for ((left, r), u) in left.frames.iter_mut().zip(&at(0.0).frames).zip(&step.frames) {
                *left -= r.cross(u) * 0.5;
            }
            left.add_scaled(0.5 / h, &ahead);
            left.add_scaled(-0.5 / h, &behind);
            problem.free_part(&mut left);
            left.dot(&left).sqrt() / before
        };
        let (left, without) = (left(&step), left(&symmetric));
        assert!(left < 1e-7, "{model}: {left:e} of {before:e} N is left");
        assert!(without > 1e-4, "{model}: the moments hardly matter, {without:e}");
    }
}

/// A cable rolled up to one and a half circles is moved at its clamp. Turned about the axis of the moment it keeps its
/// shape; turned about another axis it becomes a helix.
#[test]
fn a_rolled_up_cable_follows_its_clamp() {
    let moment = -Vector::y() * (1.5 * TAU * section(false).bending_stiffness[0]);
    let sample = cantilever(80, moment);
    let mut problem = sample.problem();
    let mut state = sample.state.clone();
    let mut newton = Newton::new();
    let stop = Stop { force_tolerance: 1e-9, max_iterations: 200 };
    assert_eq!(newton.minimise(&mut problem, &mut state, &stop).status, Status::Converged);
    let away = Vector::new(0.3, -0.2, 0.1);
    for turn in [Vector::y() * 0.7, Vector::new(0.0, 0.5, 0.6), Vector::new(0.0, 0.5, 1.0)] {
        let q = wireloom_core::Rotation::from_scaled_axis(turn);
        let mut target = sample.conditions.targets[0];
        (target.position, target.orientation) = (target.position + away, q * target.orientation);
        problem.set_target(0, target);
        let report = newton.minimise(&mut problem, &mut state, &stop);
        assert_eq!(report.status, Status::Converged, "{turn:?}: {report:?}");
        assert!(report.iterations <= MOST, "{turn:?}: {report:?}");
        // In the frame of the clamp the moment turns backward.
        let exact = away + q * helix(&(q.inverse() * moment), 1.0).0;
        assert!((state.points[80] - exact).norm() < 2e-4, "{turn:?}: {} m off", (state.points[80] - exact).norm());
    }
}

/// An upright strip, too heavy for its softer direction, under a moment about the vertical: the straight shape is an
/// equilibrium with one unstable direction. A round rod has two, which the determinant cannot detect.
#[test]
fn a_strip_that_cannot_stand_diverges_under_a_moment() {
    let run = |stiffness: [f64; 2], gravity: f64| {
        let mut sketch = Sketch::default();
        let b = sketch.branch(Vector::zeros(), Vector::z(), 40, [None, None], false);
        sketch.clamp(b, true);
        let mut sample = sketch.build(&registry());
        let branch = &mut sample.network.branches[0];
        let section = Section { bending_stiffness: stiffness, ..section(false) };
        let spec = RodSpec { section: section.clone(), mesh: branch.rod.mesh().clone(), curvature: Vector::zeros() };
        branch.rod = (registry().rod("cosserat").unwrap().build)(&spec, &Parameters::default()).unwrap();
        branch.section = section;
        sample.conditions.gravity = Vector::z() * -gravity;
        load(&mut sample, Place::Node { branch: 0, node: 40 }, Vector::z() * 1e-3);
        let mut problem = sample.problem();
        let mut state = sample.state.clone();
        let stop = Stop { force_tolerance: 1e-9, max_iterations: 50 };
        Newton::new().minimise(&mut problem, &mut state, &stop);
        let mut certifier = Certifier::new(&sample.network);
        let status = certifier.certify(&mut problem, &state, &stop, Status::Failed).grade;
        assert_eq!(status, Status::Converged);
        assert!(state.points[40].xy().norm() < 1e-9, "it is upright: {}", state.points[40]);
        certifier.diverges(&mut problem, &state)
    };
    // Greenhill: ρ g L³/EI = 7.84.
    let (soft, stiff) = (0.012, 1.2);
    let critical = 7.84 * soft / 0.08;
    assert!(!run([soft, stiff], 0.8 * critical));
    assert!(run([soft, stiff], 1.5 * critical));
    assert!(!run([soft, soft], 1.5 * critical));
}
