//! A cable thrown from straight to its place in a single increment still finds it, and hot calls do not allocate.

use wireloom::bench::{cable, harness};
use wireloom::geometry::{Pose, Vector};
use wireloom::harness::{Conditions, Network, Problem, State};
use wireloom::parts::{Minimiser, Newton, Stop};
use wireloom::scenario::Built;
use wireloom::{Control, Status};
use wireloom_tests::cables::{self, branch, connector, connector_along, section};

fn thrown(segments: usize, increments: usize) -> wireloom::Run {
    let steps = format!(
        r#"
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
    let head = "schema = 1\nname = \"thrown\"\ngravity = [0, 0, 0]\n";
    cables::run(&[head, &section("cable"), &branch("cable", ["A", "B"], "cable", 1.0, segments), &steps].concat())
}

#[test]
fn a_throw_ends_where_small_steps_end() {
    for segments in [50, 100, 400] {
        let (far, near) = (thrown(segments, 1), thrown(segments, 20));
        assert_eq!((far.status(), near.status()), (Status::Converged, Status::Converged), "{segments} segments");
        let end = |run: &wireloom::Run| run.steps.last().map(|step| (step.stable, step.energy.total()));
        let ((stable, energy), (_, expected)) = (end(&far).expect("a step"), end(&near).expect("a step"));
        assert_eq!(stable, Some(true), "{segments} segments");
        assert!((energy - expected).abs() < 1e-8, "{segments} segments: {energy} J instead of {expected} J");
    }
}

/// Steps that would stretch the cable were cut to a tenth: the minimiser took 190 iterations, most for a hundredth of a
/// radian.
#[test]
fn a_cable_that_falls_over_between_two_clamps_is_not_held_back_by_its_stretch() {
    let text = [
        "schema = 1\nname = \"over\"\n",
        &section("cable").replace("1e4", "2e6"),
        &branch("cable", ["A", "B"], "cable", 0.65, 60),
        &connector("a", "A", [0.0; 3]),
        &connector("b", "B", [0.6, 0.0, 0.0]),
        "[[steps]]\nname = \"over\"\nincrements = 1\ngravity = [0, 0, 240]\n",
    ];
    let run = cables::run(&text.concat());
    let end = &run.steps[0];
    assert_eq!((run.status(), end.stable), (Status::Converged, Some(true)));
    assert!(end.branches[0].position.iter().any(|x| x.z > 0.1), "it hangs where it hung");
    // It falls at once, so the increment is followed again in halves: some 470 in all, and 1,500 with such steps.
    assert!(end.minimiser.iterations < 600, "{} iterations", end.minimiser.iterations);
}

/// A network hung from its constraints where its rest shape has them, and dragged once.
fn dragged(network: &Network, newton: &mut Newton) -> (Vec<bool>, Vec<Pose>, State) {
    let schedule = wireloom::bench::schedule();
    let mut state = wireloom::harness::place(network, &schedule);
    let targets: Vec<Pose> = network.constraints.iter().map(|f| state.pose(&f.site)).collect();
    let active = vec![true; network.constraints.len()];
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
    let mut conditions = Conditions::new(network, Vector::new(0.0, 0.0, -9.81), &State::origin(network));
    conditions.active = active.to_vec();
    let mut problem = Problem::new(network, conditions);
    targets.iter().enumerate().for_each(|(constraint, target)| problem.set_target(constraint, *target));
    problem
}

/// A Y of three arms that hang between plugs, with so many segments each.
fn hanging_y(segments: usize) -> Built {
    let section = section("arm").replace("50 g/m", "60 g/m");
    let mut text = format!("schema = 1\nname = \"hanging-y\"\n{section}");
    for (name, from, to) in [("trunk", "A", "J"), ("left", "J", "B"), ("right", "J", "C")] {
        text += &branch(name, [from, to], "arm", 0.5, segments);
    }
    text += r#"
        [[joints]]
        name = "J"
        model = "cosserat"
        arms = [
          { branch = "trunk", direction = [-1, 0, 0], up = [0, 0, 1] },
          { branch = "left",  direction = [0.8, 0.6, 0], up = [0, 0, 1] },
          { branch = "right", direction = [0.8, -0.6, 0], up = [0, 0, 1] },
        ]
        "#;
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    text += &connector_along("plug-A", "A", [0.0; 3], x, z);
    text += &connector_along("plug-B", "B", [0.6, 0.3, 0.1], y, x);
    text += &connector_along("plug-C", "C", [0.5, -0.4, 0.2], z, x);
    cables::built(&text)
}

#[test]
fn a_start_found_on_a_coarse_mesh_is_the_same_for_a_fraction_of_the_work() {
    assert!(hanging_y(200).coarse.is_none(), "not worth the while");
    let run = |coarse: bool| {
        let mut built = hanging_y(800);
        let nested = built.coarse.as_ref().expect("a coarse mesh");
        assert_eq!((nested.points, built.network.points), (3 * 201 + 1, 3 * 801 + 1));
        if !coarse {
            built.coarse = None;
        }
        wireloom::run(built, &mut |_, _| Control::Continue)
    };
    let (nested, direct) = (run(true), run(false));
    assert_eq!((nested.status(), direct.status()), (Status::Converged, Status::Converged));
    let (a, b) = (&nested.steps[0], &direct.steps[0]);
    for (a, b) in a.branches.iter().zip(&b.branches) {
        let apart = a.position.iter().zip(&b.position).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(apart < 1e-7, "{}: {apart} m", a.name);
    }
    // Iterations of both meshes count; those of the coarse one cost a quarter, and are as many as those of the fine one
    // alone.
    assert!(a.minimiser.iterations <= b.minimiser.iterations + 5, "few are left on the fine mesh");
}

#[test]
fn a_state_carried_over_to_a_finer_mesh_is_nearly_balanced() {
    let built = hanging_y(800);
    let coarse = built.coarse.as_ref().expect("a coarse mesh");
    let mut newton = Newton::new();
    let mut state = wireloom::harness::place(coarse, &built.schedule);
    let targets: Vec<Pose> = coarse.constraints.iter().map(|f| state.pose(&f.site)).collect();
    let active = vec![true; targets.len()];
    let stop = Stop { max_iterations: 5000, ..Stop::default() };
    let report = newton.minimise(&mut problem(coarse, &active, &targets), &mut state, &stop);
    assert_eq!(report.status, Status::Converged);
    let mut fine = wireloom::harness::prolonged(coarse, &state, &built.network);
    let report = newton.minimise(&mut problem(&built.network, &active, &targets), &mut fine, &stop);
    assert_eq!(report.status, Status::Converged);
    assert!(report.iterations <= 3, "{} iterations", report.iterations);
    // Nodes of the coarse mesh are nodes of the fine one.
    for (rough, smooth) in coarse.branches.iter().zip(&built.network.branches) {
        for node in 0..rough.points.len() {
            let gap = state.points[rough.points.start + node] - fine.points[smooth.points.start + 4 * node];
            assert!(gap.norm() < 1e-4, "{} of {}: {} m", node, rough.name, gap.norm());
        }
    }
}

#[test]
fn after_the_first_call_a_drag_step_does_not_allocate() {
    for network in [cable(200), harness()] {
        let mut newton = Newton::new();
        let (active, mut targets, mut state) = dragged(&network, &mut newton);
        let mut problem = problem(&network, &active, &targets);
        newton.minimise(&mut problem, &mut state, &Stop::default());
        let mut status = Status::Failed;
        // The counter sees one thread: that of a pool where a harness is so large that Newton shares its work.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        let count = pool.install(|| {
            allocation_counter::measure(|| {
                targets[1].position.x += 0.005;
                problem.set_target(1, targets[1]);
                status = newton.minimise(&mut problem, &mut state, &Stop::default()).status;
            })
        });
        assert_eq!((status, count.count_total), (Status::Converged, 0));
    }
}
