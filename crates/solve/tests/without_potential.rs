//! Loads without a potential: dead moments (about axes that are fixed in space), followers (which turn with the cable)
//! and the drag of flows.

use std::f64::consts::TAU;
use std::sync::Arc;
use wireloom_core::constraint::{ConstraintSpec, Limits};
use wireloom_core::load::{Axes, Dead, DeadLine, Flow, Follower, FollowerLine, LineLoad, LoadAction, PointLoad};
use wireloom_core::minimiser::{Minimiser, Report, Stop};
use wireloom_core::network::{ConstraintPlan, Load, LoadSite, NodeRange, Place};
use wireloom_core::problem::Hessian;
use wireloom_core::rod::RodSpec;
use wireloom_core::rotation::{columns, skew};
use wireloom_core::status::Status;
use wireloom_core::{
    Conditions, Constraint, HoldWord, Matrix, Parameters, Problem, Registry, Rotation, Section, State, Tangent, Vector,
};
use wireloom_solve::linear::assembly::System;
use wireloom_solve::linear::border::Border;
use wireloom_solve::linear::without_potential::WithoutPotential;
use wireloom_solve::minimisers::newton::Newton;
use wireloom_solve::steps::certificate::Certifier;
use wireloom_testkit::conformance::networks::{Sample, Sketch, cable, section, sized_y_harness};
use wireloom_testkit::conformance::numeric::{random_turn, random_vector};

/// Largest number of iterations of an increment.
const MOST: usize = 20;

fn registry() -> Registry {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    registry
}

/// Adds a load.
fn add(sample: &mut Sample, action: LoadAction<LoadSite, NodeRange>) {
    sample.network.loads.push(Load { name: "tool".into(), action, factor: 1.0 });
    sample.conditions.load_factors.push(1.0);
}

/// Adds a force (N) and a moment (N m) at a place.
fn at_place(sample: &mut Sample, place: Place, [force, moment]: [Vector; 2], follows: bool) {
    let load: Arc<dyn PointLoad> =
        if follows { Arc::new(Follower { force, moment }) } else { Arc::new(Dead { force, moment }) };
    own_at_place(sample, place, load);
}

/// Adds any load at a place.
fn own_at_place(sample: &mut Sample, place: Place, load: Arc<dyn PointLoad>) {
    let site = sample.network.site(place);
    add(sample, LoadAction::At { place: LoadSite { site, point: site.point }, load });
}

/// A load of another program: a force that grows with the height of d1, and the moment of a magnet along d3 in a field,
/// given in either axes.
#[derive(Debug)]
struct Magnet {
    axes: Axes,
    field: Vector,
}

impl Magnet {
    /// Vectors of the world in the axes of the load, and their derivatives.
    fn given(&self, frame: &Rotation, world: [Vector; 2], derivatives: [Matrix; 2]) -> ([Vector; 2], [Matrix; 2]) {
        if self.axes == Axes::World {
            return (world, derivatives);
        }
        let back = frame.to_rotation_matrix().inverse();
        let local = world.map(|v| back * v);
        (local, [0, 1].map(|k| skew(&local[k]) + back.matrix() * derivatives[k]))
    }

    fn all(&self, frame: &Rotation) -> ([Vector; 2], [Matrix; 2]) {
        let r = *frame.to_rotation_matrix().matrix();
        let [d1, _, d3] = columns(frame);
        let of_d1 = -(r * skew(&Vector::x()));
        let force = Vector::new(200.0, 100.0, -300.0);
        let derivatives = [force * of_d1.row(2), skew(&self.field) * r * skew(&Vector::z())];
        self.given(frame, [force * d1.z, d3.cross(&self.field)], derivatives)
    }
}

impl PointLoad for Magnet {
    fn without_potential(&self) -> Option<&str> {
        Some("is a magnet")
    }
    fn axes(&self) -> Axes {
        self.axes
    }
    fn on(&self, frame: &Rotation) -> [Vector; 2] {
        self.all(frame).0
    }
    fn derivative(&self, frame: &Rotation) -> [Matrix; 2] {
        self.all(frame).1
    }
    fn largest(&self) -> [f64; 2] {
        [400.0, self.field.norm()]
    }
}

/// Adds a dead moment (N m) at a place.
fn load(sample: &mut Sample, place: Place, moment: Vector) {
    at_place(sample, place, [Vector::zeros(), moment], false);
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

/// A constraint at one place, which holds what it holds at the start.
fn pinned(model: Box<dyn Constraint>, place: Place) -> ConstraintPlan {
    ConstraintPlan {
        name: "pin".into(),
        kind: "connector".into(),
        model,
        outputs: Vec::new(),
        stations: vec![place],
        span: None,
        position: None,
        tangent: None,
        orientation: None,
        mount: None,
        slide: None,
        limits: Limits::default(),
        nearest: false,
        from_start: true,
    }
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

/// A moment about d2 at the free end keeps the cable in its plane, where it is the dead moment about −y: half, one and
/// two circles in one increment each.
#[test]
fn a_moment_that_follows_rolls_a_cable_up() {
    for circles in [0.5, 1.0, 2.0] {
        let moment = TAU * circles * section(false).bending_stiffness[0];
        let harness = |segments: usize| {
            let mut sample = cantilever(segments, Vector::zeros());
            let end = Place::Node { branch: 0, node: segments };
            at_place(&mut sample, end, [Vector::zeros(), Vector::y() * moment], true);
            sample
        };
        let exact = helix(&(-Vector::y() * moment), 1.0).0;
        second_order(&format!("{circles} circles"), harness, &[(0, exact)]);
    }
}

/// Position of the end of a cantilever along x of stiffness EI under a force F (N) that stays across its end, towards
/// +z at rest. Seen from the end, where the force is fixed, the cable starts without bending and its turn φ obeys
/// `EI φ″ = −F cos φ` in the arc length σ from the end: an initial value problem. The classical Runge–Kutta method with
/// 4,000 steps errs by 1e-12.
fn end_under_follower(force: f64) -> Vector {
    let stiffness = section(false).bending_stiffness[0];
    let rate = |[phi, k, _, _]: [f64; 4]| [k, -force / stiffness * phi.cos(), -phi.cos(), -phi.sin()];
    let steps = 4000;
    let h = 1.0 / steps as f64;
    let mut y = [0.0; 4];
    let moved = |y: [f64; 4], k: [f64; 4], h: f64| -> [f64; 4] { std::array::from_fn(|i| y[i] + h * k[i]) };
    for _ in 0..steps {
        let k1 = rate(y);
        let k2 = rate(moved(y, k1, 0.5 * h));
        let k3 = rate(moved(y, k2, 0.5 * h));
        let k4 = rate(moved(y, k3, h));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    // At the clamp the tangent is along x: turn by −φ there, and look from the clamp to the end.
    let [phi, _, x, z] = y;
    let (sin, cos) = phi.sin_cos();
    -Vector::new(cos * x + sin * z, 0.0, cos * z - sin * x)
}

/// Forces that bend the cable to more than three quarters of a circle, each in one increment. The mesh errs by 1e-5 of
/// the length at most, and the cable stretches and shears, which the closed form leaves out, by F/GA.
#[test]
fn a_force_that_stays_across_the_end_bends_a_cantilever() {
    for load in [1.0, 5.0, 15.0] {
        let own = section(false);
        let force = load * own.bending_stiffness[0];
        let mut sample = cantilever(160, Vector::zeros());
        // d1 is z.
        at_place(&mut sample, Place::Node { branch: 0, node: 160 }, [Vector::x() * force, Vector::zeros()], true);
        let mut state = sample.state.clone();
        let report = solve(&mut sample.problem(), &mut state);
        assert_eq!(report.status, Status::Converged, "{load}: {report:?}");
        assert!(report.iterations <= MOST, "{load}: {report:?}");
        let off = (state.points[160] - end_under_follower(force)).norm();
        assert!(off < 1e-5 + 3.0 * force / own.shear_stiffness[0], "F L²/EI = {load}: {off} m off");
    }
}

/// Beck's column: a force that stays along the column presses its end. Straight it is in balance for every force, and
/// no other equilibrium is near: the tangent never becomes singular. Beyond 20.05 EI/L² (Beck 1952, Die Knicklast des
/// einseitig eingespannten, tangential gedrückten Stabes, ZAMP 3) it flutters. A determinant cannot see that, so the
/// column must never be called stable. Under a dead force it buckles at π²/4, which the determinant sees.
#[test]
fn becks_column_is_never_called_stable() {
    let stiffness = section(false).bending_stiffness[0];
    for load in [2.0, 15.0, 19.0, 21.0, 40.0] {
        let mut sample = cantilever(40, Vector::zeros());
        let end = Place::Node { branch: 0, node: 40 };
        at_place(&mut sample, end, [Vector::z() * (-load * stiffness), Vector::zeros()], true);
        let mut problem = sample.problem();
        let mut state = sample.state.clone();
        // Disturbed: it has to find its way back.
        for (i, x) in state.points.iter_mut().enumerate() {
            x.z += 1e-3 * (0.1 * i as f64).sin();
        }
        let report = solve(&mut problem, &mut state);
        assert_eq!(report.status, Status::Converged, "{load}: {report:?}");
        assert!(state.points[40].yz().norm() < 1e-8, "{load}: {}", state.points[40]);
        assert!(!problem.has_potential());
        let stop = Stop { force_tolerance: 1e-9, max_iterations: 50 };
        let mut certifier = Certifier::new(&sample.network);
        assert_eq!(certifier.certify(&mut problem, &state, &stop, Status::Failed).grade, Status::Converged);
        assert!(!certifier.diverges(&mut problem, &state), "{load}");
    }
}

/// A force per length is a weight: a weightless cable under ρ g per length has the same bits as the heavy one.
#[test]
fn a_force_per_length_acts_as_weight() {
    let heavy = cable(&registry(), 24);
    let mut light = cable(&registry(), 24);
    light.conditions.gravity = Vector::zeros();
    let weight = heavy.conditions.gravity * section(false).linear_density;
    let spans = vec![NodeRange { branch: 0, nodes: 0..25 }];
    add(&mut light, LoadAction::Along { spans, load: Arc::new(DeadLine(weight)) });
    let ends = [&heavy, &light].map(|sample| {
        let (mut problem, mut state) = (sample.problem(), sample.state.clone());
        assert!(problem.has_potential());
        assert_eq!(solve(&mut problem, &mut state).status, Status::Converged);
        (problem.energy(&state).total(), state)
    });
    let moved = ends[0].1.points.iter().zip(&ends[1].1.points).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    // Sums in another order: 1e-9 of the sag in balance of 1e-9.
    assert!(moved < 1e-9, "{moved}");
    assert!((ends[0].0 - ends[1].0).abs() < 1e-12 * ends[0].0.abs(), "{} J and {} J", ends[0].0, ends[1].0);
}

/// A cable hangs from a point in a flow along x. Where weight and drag across it cancel, `w sin φ = k U² cos² φ`, it is
/// straight, at the critical angle φ from the vertical (Glauert 1930, The form of a heavy flexible cable used for
/// towing), whatever its stiffness. From a gentle flow to one in which it flies at 65°, in 16 increments. (With
/// increments of twice the weight it may land upside down and against the flow, where all forces are in balance, too:
/// without a potential no minimum is preferred.)
#[test]
fn a_cable_in_a_flow_hangs_at_the_critical_angle() {
    let own = section(false);
    for ratio in [0.1, 1.0, 5.0] {
        let mut sketch = Sketch::default();
        let b = sketch.branch(Vector::zeros(), -Vector::z(), 30, [None, None], false);
        let mut sample = sketch.build(&registry());
        let pin = ConstraintSpec { hold: Some(vec![HoldWord::Position, HoldWord::Twist]), ..ConstraintSpec::default() };
        let kind = registry().constraint("connector").unwrap().build.as_ref()(&pin, &Parameters::default()).unwrap();
        sample.network.add_constraint(pinned(kind, Place::Node { branch: b, node: 0 }));
        sample.conditions = Conditions::new(&sample.network, Vector::new(0.0, 0.0, -9.81), &sample.state);
        let weight = 9.81 * own.linear_density;
        // k U² = ratio w with U = 20 m/s.
        let flow = Flow { velocity: Vector::x() * 20.0, drag: ratio * weight / (400.0 * own.diameter) };
        let spans = vec![NodeRange { branch: 0, nodes: 0..31 }];
        add(&mut sample, LoadAction::Along { spans, load: Arc::new(flow) });
        let (mut problem, mut state) = (sample.problem(), sample.state.clone());
        for k in 1..=16 {
            problem.change(|conditions| conditions.load_factors[0] = f64::from(k) / 16.0);
            let report = solve(&mut problem, &mut state);
            assert_eq!(report.status, Status::Converged, "{ratio}, {k}: {report:?}");
            assert!(report.iterations <= 2 * MOST, "{ratio}, {k}: {report:?}");
        }
        // sin φ from ratio (1 − sin² φ) = sin φ.
        let sine = ((1.0 + 4.0 * ratio * ratio).sqrt() - 1.0) / (2.0 * ratio);
        let direction = (state.points[30] - state.points[0]).normalize();
        let exact = Vector::new(sine, 0.0, -(1.0 - sine * sine).sqrt());
        // In balance to 1e-9; the pull stretches it evenly.
        assert!((direction - exact).norm() < 1e-7, "{ratio}: {direction}, not {exact}");
        for x in &state.points {
            assert!(x.cross(&exact).norm() < 1e-7, "{ratio}: {x} is off the line");
        }
    }
}

/// Random states and loads on a hub, on the end of a branch tied to it with an offset, on the ends and along the
/// branches: the residual must vanish to first order at the step `u` of the solve. With r the gradient in body frames,
/// its change along u is `K u + ½ r × u` in each frame, as K is the derivative of r pulled back to θ.
#[test]
fn the_corrected_matrix_is_the_derivative_of_the_residual() {
    let mut rng = fastrand::Rng::with_seed(17);
    for (what, model, along) in [
        ("dead moments", "fused", false),
        ("dead moments", "rigid-body", false),
        ("followers", "fused", false),
        ("followers", "rigid-body", false),
        ("own, in the world", "rigid-body", false),
        ("own, in the frame", "rigid-body", false),
        ("forces along", "fused", true),
        ("forces along", "rigid-body", true),
        ("all", "rigid-body", true),
        ("all", "compliant-hub", true),
    ] {
        let radius = if model == "fused" { 0.0 } else { 0.02 };
        let mut sample = sized_y_harness(&registry(), model, 6, radius);
        let places = [Place::Joint(0), Place::Node { branch: 1, node: 0 }, Place::Node { branch: 2, node: 0 }];
        for place in places {
            if what == "dead moments" || what == "all" {
                load(&mut sample, place, random_vector(&mut rng, 100.0));
            }
            // A point joint has no frame to follow.
            if what == "followers" && sample.network.site(place).frame.is_some() || what == "all" {
                let wrench = [random_vector(&mut rng, 1000.0), random_vector(&mut rng, 100.0)];
                at_place(&mut sample, place, wrench, true);
            }
            if what.starts_with("own") || what == "all" {
                let axes = if what.ends_with("world") { Axes::World } else { Axes::Frame };
                let field = random_vector(&mut rng, 100.0);
                own_at_place(&mut sample, place, Arc::new(Magnet { axes, field }));
            }
        }
        if along {
            let spans = (0..3).map(|branch| NodeRange { branch, nodes: 0..7 }).collect::<Vec<_>>();
            let flow = Flow { velocity: random_vector(&mut rng, 100.0), drag: 100.0 };
            let loads: [Arc<dyn LineLoad>; 2] =
                [Arc::new(FollowerLine(random_vector(&mut rng, 1000.0))), Arc::new(flow)];
            for load in loads {
                add(&mut sample, LoadAction::Along { spans: spans.clone(), load });
            }
        }
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
        system.matrix.eliminate_prescribed(&problem);
        system.matrix.factorise();
        system.step(&problem, &state, &residual, None, &mut step);
        let (mut without, border) = (WithoutPotential::default(), Border::default());
        without.prepare(&mut system, &border, &problem, &state);
        let symmetric = step.clone();
        without.complete(&mut system, &border, &problem, &state, &mut step);
        problem.free_part(&mut residual);
        let before = residual.dot(&residual).sqrt();
        let mut left = |step: &Tangent| {
            let mut at = |h: f64| {
                let (mut there, mut gradient) = (state.clone(), Tangent::zeros(network));
                network.retract(&state, step, h, &mut there);
                problem.gradient(&there, &mut gradient);
                gradient
            };
            let turn = step.frames.iter().map(Vector::norm).fold(1.0, f64::max);
            let h = 1e-5 / turn;
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
        // The loads turn frames by many radians in a step: differences over so small steps leave 2e-7.
        assert!(left < 1e-5, "{what}, {model}: {left:e} of {before:e} N is left");
        assert!(without > 1e-4, "{what}, {model}: the loads hardly matter, {without:e}");
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
        let q = Rotation::from_scaled_axis(turn);
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
        let (name, mesh) = (branch.name.clone(), branch.rod.mesh().clone());
        let spec = RodSpec { name, sections: section.clone().into(), mesh, curvature: Vector::zeros() };
        branch.rod = (registry().rod("cosserat").unwrap().build)(&spec, &Parameters::default()).unwrap();
        branch.sections = section.into();
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
