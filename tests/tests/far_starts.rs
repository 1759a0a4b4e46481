//! A cable thrown from straight to its place in a single increment still finds it, and hot calls do not allocate.

use wireloom::bench::{cable, harness};
use wireloom::core::{Conditions, Minimiser, Network, Pose, Problem, State, Status, Stop, Vector};
use wireloom::solve::Control;
use wireloom::solve::newton::Newton;

fn thrown(segments: usize, increments: usize) -> wireloom::core::Run {
    let text = format!(
        r#"
        schema = 1
        name = "thrown"
        gravity = [0, 0, 0]
        [sections.cable]
        diameter = "6 mm"
        linear_density = 0.05
        axial_stiffness = 1e4
        bending_stiffness = 0.01
        torsion_stiffness = 0.008
        [[branches]]
        name = "cable"
        from = "A"
        to = "B"
        section = "cable"
        length = 1
        segments = {segments}
        [[constraints]]
        name = "a"
        kind = "connector"
        at = {{ end = "A" }}
        [[constraints]]
        name = "b"
        kind = "connector"
        at = {{ end = "B" }}
        [initial]
        branch = "cable"
        position = [0, 0, 0]
        tangent = [1, 0, 0]
        up = [0, 0, 1]
        [[steps]]
        name = "weight"
        gravity = [0, 0, -9.81]
        [[steps]]
        name = "throw"
        increments = {increments}
        [[steps.move]]
        constraint = "b"
        position = [0.6, 0, 0]
        "#
    );
    let (_, built) = wireloom::load(&text, &wireloom::registry()).expect("no faults");
    wireloom::run(built, &mut |_, _| Control::Continue)
}

#[test]
fn a_throw_ends_where_small_steps_end() {
    for segments in [50, 100, 400] {
        let (far, near) = (thrown(segments, 1), thrown(segments, 20));
        assert_eq!((far.status, near.status), (Status::Converged, Status::Converged), "{segments} segments");
        let end = |run: &wireloom::core::Run| run.steps.last().map(|step| (step.stable, step.energy.total()));
        let ((stable, energy), (_, expected)) = (end(&far).expect("a step"), end(&near).expect("a step"));
        assert_eq!(stable, Some(true), "{segments} segments");
        assert!((energy - expected).abs() < 1e-8, "{segments} segments: {energy} J instead of {expected} J");
    }
}

/// A network hung from its fixings where its rest shape has them, and dragged once.
fn dragged(network: &Network, newton: &mut Newton) -> (Vec<bool>, Vec<Pose>, State) {
    let schedule = wireloom::bench::schedule();
    let mut state = wireloom::solve::start::place(network, &schedule);
    let targets: Vec<Pose> = network.fixings.iter().map(|f| state.pose(&f.site)).collect();
    let active = vec![true; network.fixings.len()];
    let mut problem = problem(network, &active, &targets);
    for k in 1..=30 {
        let mut target = targets[1];
        target.position.x -= 0.01 * f64::from(k);
        problem.set_target(1, target);
        // The first one falls from the straight rest shape.
        let stop = Stop { max_iterations: 5000, ..Stop::default() };
        let report = newton.minimise(&mut problem, &mut state, &stop);
        assert_eq!(report.status, Status::Converged, "increment {k}");
    }
    (active, problem.conditions().targets.clone(), state)
}

fn problem<'n>(network: &'n Network, active: &[bool], targets: &[Pose]) -> Problem<'n> {
    let conditions = Conditions {
        gravity: Vector::new(0.0, 0.0, -9.81),
        load_factors: vec![],
        active: active.to_vec(),
        targets: targets.to_vec(),
        sliding: vec![],
    };
    Problem::new(network, conditions)
}

#[test]
fn after_the_first_call_a_drag_step_does_not_allocate() {
    for network in [cable(200), harness()] {
        let mut newton = Newton::new();
        let (active, mut targets, mut state) = dragged(&network, &mut newton);
        let mut problem = problem(&network, &active, &targets);
        newton.minimise(&mut problem, &mut state, &Stop::default());
        let mut status = Status::Failed;
        let count = allocation_counter::measure(|| {
            targets[1].position.x += 0.005;
            problem.set_target(1, targets[1]);
            status = newton.minimise(&mut problem, &mut state, &Stop::default()).status;
        });
        assert_eq!((status, count.count_total), (Status::Converged, 0));
    }
}

#[test]
fn work_of_a_drag_step_is_pinned() {
    let case = wireloom::bench::drag("drag", &cable(1000), Vector::new(-0.4, 0.0, 0.0), Vector::x(), 1, 10);
    assert_eq!(case.failures, 0);
    assert_eq!((case.iterations_per_step, case.factorisations_per_step), (2.4, 1.4));
    assert!(case.residual < 1e-8);
}
