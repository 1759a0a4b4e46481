//! Checks of [`Minimiser`], on harnesses small enough to be solved in every build.

use super::networks::{Sample, cable, ring, y_harness};
use super::numeric::{random_turn, random_vector};
use fastrand::Rng;
use wireloom_core::minimiser::Report;
use wireloom_core::{Minimiser, Registry, State, Status, Stop, Tangent, Vector};

/// Makes the minimiser under test.
pub type Factory<'f> = dyn Fn() -> Box<dyn Minimiser> + 'f;
/// Makes the registry whose rods, joints and constraints it is tested on.
pub type Registries<'f> = dyn Fn() -> Registry + 'f;

/// Enough iterations for methods that use gradients alone.
const STOP: Stop = Stop { force_tolerance: 1e-6, max_iterations: 100_000 };

/// Positions of the end of the cable, step by step, m.
const ENDS: [[f64; 3]; 4] = [[0.95, 0.0, 0.0], [0.85, 0.02, 0.0], [0.75, 0.05, 0.05], [0.8, 0.0, 0.1]];

/// Recomputes what the report claims.
fn check(name: &str, sample: &Sample, targets: &Moved, state: &State, report: &Report) {
    assert_eq!(report.status, Status::Converged, "{name}: {report:?}");
    let mut problem = sample.problem();
    problem.change(|c| c.targets = targets.0.clone());
    problem.update_held(state);
    let mut gradient = Tangent::zeros(&sample.network);
    problem.gradient(state, &mut gradient);
    problem.free_part(&mut gradient);
    let residual = problem.residual(&gradient);
    assert!(residual <= STOP.force_tolerance * (1.0 + 1e-9), "{name}: recomputed {residual:e}, reported {report:?}");
    for (constraint, target) in sample.network.constraints.iter().zip(&targets.0) {
        let at = state.pose(&constraint.site);
        assert_eq!(at.position, target.position, "{name}: {}", constraint.name);
        let turn = at.orientation.angle_to(&target.orientation);
        assert!(turn <= 1e-15, "{name}: {} is turned by {turn:e}", constraint.name);
    }
    let mut tied = state.clone();
    sample.network.follow_ties(&mut tied);
    assert!(&tied == state, "{name}: what is tied to a joint is not where the joint carries it");
}

/// Targets of the constraints.
struct Moved(Vec<wireloom_core::Pose>);

/// The cable, its end moved along [`ENDS`]; the last state.
fn follow(minimiser: &mut dyn Minimiser, sample: &Sample) -> State {
    let mut problem = sample.problem();
    let mut state = sample.state.clone();
    let mut targets = Moved(sample.conditions.targets.clone());
    for end in ENDS {
        targets.0[1].position = Vector::from(end);
        problem.set_target(1, targets.0[1]);
        let report = minimiser.minimise(&mut problem, &mut state, &STOP);
        check(&format!("end at {end:?}"), sample, &targets, &state, &report);
    }
    state
}

/// A harness from its rest shape under gravity.
fn balanced(minimiser: &mut dyn Minimiser, name: &str, sample: &Sample) -> State {
    let mut state = sample.state.clone();
    let report = minimiser.minimise(&mut sample.problem(), &mut state, &STOP);
    check(name, sample, &Moved(sample.conditions.targets.clone()), &state, &report);
    state
}

fn bits(state: &State) -> Vec<u64> {
    let points = state.points.iter().chain(&state.compensation).flatten();
    points.chain(state.frames.iter().flat_map(|q| q.coords.iter())).map(|x| x.to_bits()).collect()
}

/// # Panics
/// If the end's moves do not end in equilibria that hold what is prescribed.
pub fn carries_a_clamped_cable_whose_end_is_moved(factory: &Factory<'_>, registry: &Registries<'_>) {
    follow(factory().as_mut(), &cable(&registry(), 20));
}

/// # Panics
/// If a harness of three branches does not converge, whatever its joint.
pub fn carries_every_joint_of_the_registry(factory: &Factory<'_>, registry: &Registries<'_>) {
    let registry = registry();
    for kind in registry.joints() {
        balanced(factory().as_mut(), &kind.name, &y_harness(&registry, &kind.name, 10));
    }
}

/// # Panics
/// If a ring of three branches on a tail does not converge.
pub fn carries_a_closed_ring(factory: &Factory<'_>, registry: &Registries<'_>) {
    let registry = registry();
    for kind in registry.joints() {
        balanced(factory().as_mut(), &kind.name, &ring(&registry, &kind.name, 6, 1));
    }
}

/// # Panics
/// If the energy at the end is above that of the start with its held freedoms in place.
pub fn never_raises_the_energy(factory: &Factory<'_>, registry: &Registries<'_>) {
    let sample = cable(&registry(), 20);
    for iterations in [1, 2, 3, 5, 8, 100] {
        let mut problem = sample.problem();
        let mut state = sample.state.clone();
        let mut target = sample.conditions.targets[1];
        target.position = Vector::new(0.7, 0.1, 0.0);
        problem.set_target(1, target);
        problem.place_held(&mut state);
        let before = problem.energy(&state).total();
        factory().minimise(&mut problem, &mut state, &Stop { max_iterations: iterations, ..STOP });
        let after = problem.energy(&state).total();
        assert!(after <= before, "{iterations} iterations: from {before:e} J to {after:e} J");
    }
}

/// A cable with every frame between its ends turned at random and every node shaken by so many segment lengths:
/// full steps of Newton's method go uphill from there.
fn crumple(sample: &Sample, turn: f64, shake: f64, rng: &mut Rng) -> State {
    let mut state = sample.state.clone();
    let (nodes, frames) = (state.points.len(), state.frames.len());
    let length = (state.points[1] - state.points[0]).norm();
    for x in &mut state.points[1..nodes - 1] {
        *x += random_vector(rng, shake * length);
    }
    for q in &mut state.frames[1..frames - 1] {
        *q *= random_turn(rng, turn);
    }
    state
}

/// # Panics
/// If, from a crumpled start, the energy after some iterations is above that of the start or of fewer iterations.
pub fn comes_down_from_a_crumpled_start(factory: &Factory<'_>, registry: &Registries<'_>) {
    let sample = cable(&registry(), 20);
    let mut rng = Rng::with_seed(31);
    for (turn, shake) in [(0.5, 0.1), (1.5, 0.5), (3.0, 2.0)] {
        for _ in 0..5 {
            let start = crumple(&sample, turn, shake, &mut rng);
            let mut before = sample.problem().energy(&start).total();
            for iterations in [1, 2, 3, 4, 6, 8, 12, 16, 24, 40] {
                let mut problem = sample.problem();
                let mut state = start.clone();
                let report = factory().minimise(&mut problem, &mut state, &Stop { max_iterations: iterations, ..STOP });
                let after = problem.energy(&state).total();
                let noise = 1e-12 * (1.0 + before.abs());
                assert!(
                    after <= before + noise,
                    "turns of {turn}, shaken by {shake}, {iterations} iterations: from {before:e} J to {after:e} J, \
                     {report:?}"
                );
                before = after;
            }
        }
    }
}

/// # Panics
/// If two runs differ in a bit.
pub fn repeats_to_the_last_bit(factory: &Factory<'_>, registry: &Registries<'_>) {
    let sample = cable(&registry(), 20);
    let [one, other] = [(); 2].map(|()| bits(&follow(factory().as_mut(), &sample)));
    assert!(one == other);
}

/// # Panics
/// If one iteration is allowed for a far move and the status is another than the iteration limit.
pub fn stops_at_the_iteration_limit(factory: &Factory<'_>, registry: &Registries<'_>) {
    let sample = cable(&registry(), 20);
    let mut problem = sample.problem();
    let mut state = sample.state.clone();
    let mut target = sample.conditions.targets[1];
    target.position = Vector::new(0.5, 0.2, 0.1);
    problem.set_target(1, target);
    let stop = Stop { max_iterations: 1, ..STOP };
    let report = factory().minimise(&mut problem, &mut state, &stop);
    assert_eq!((report.status, report.iterations), (Status::IterationLimit, 1), "{report:?}");
    assert!(report.residual > stop.force_tolerance, "{report:?}");
}

/// # Panics
/// If a minimiser that was stopped goes on, returns another status, or gives other bits when it is started again from
/// the same state.
pub fn is_interrupted_when_stopped(factory: &Factory<'_>, registry: &Registries<'_>) {
    let sample = cable(&registry(), 20);
    let target = wireloom_core::Pose { position: Vector::new(0.5, 0.2, 0.1), ..sample.conditions.targets[1] };
    for moves in [false, true] {
        let target = if moves { target } else { sample.conditions.targets[1] };
        let mut stopped = factory();
        let mut problem = sample_at(&sample, target);
        problem.monitor.stop();
        let report = stopped.minimise(&mut problem, &mut sample.state.clone(), &STOP);
        assert_eq!(report.status, Status::Interrupted, "moves: {moves}; {report:?}");
        problem.monitor.go_on();
        stopped.forget();
        let ends = [stopped, factory()].map(|mut minimiser| {
            let mut state = sample.state.clone();
            let report = minimiser.minimise(&mut sample_at(&sample, target), &mut state, &STOP);
            assert_eq!(report.status, Status::Converged, "moves: {moves}; {report:?}");
            bits(&state)
        });
        assert!(ends[0] == ends[1], "moves: {moves}");
    }
}

/// # Panics
/// If a start with NaN in it (free or held, with something to move or without) is called anything but failed.
pub fn fails_on_a_start_that_is_not_finite(factory: &Factory<'_>, registry: &Registries<'_>) {
    let sample = cable(&registry(), 20);
    for moves in [false, true] {
        for spoil in [
            (|state: &mut State| state.points[7].y = f64::NAN) as fn(&mut State),
            |state| state.points[3].x = f64::INFINITY,
            |state| state.frames[9].as_mut_unchecked().coords.x = f64::NAN,
        ] {
            let mut problem = sample.problem();
            if moves {
                let mut target = sample.conditions.targets[1];
                target.position.x -= 0.1;
                problem.set_target(1, target);
            }
            let mut state = sample.state.clone();
            spoil(&mut state);
            let report = factory().minimise(&mut problem, &mut state, &STOP);
            assert_eq!(report.status, Status::Failed, "moves: {moves}; {report:?}");
        }
    }
}

/// # Panics
/// If a minimiser that has served another network gives other bits than a fresh one.
pub fn goes_from_network_to_network(factory: &Factory<'_>, registry: &Registries<'_>) {
    let registry = registry();
    let kind = &registry.joints().next().expect("a joint").name;
    let mut used = factory();
    follow(used.as_mut(), &cable(&registry, 20));
    let y = y_harness(&registry, kind, 10);
    let got = bits(&balanced(used.as_mut(), "after the cable", &y));
    assert!(got == bits(&balanced(factory().as_mut(), "fresh", &y)), "the Y after the cable");
    let again = cable(&registry, 24);
    assert!(bits(&follow(used.as_mut(), &again)) == bits(&follow(factory().as_mut(), &again)), "a cable after the Y");
}

/// # Panics
/// If a minimiser that was told to forget gives other bits than a fresh one.
pub fn forgets_when_told(factory: &Factory<'_>, registry: &Registries<'_>) {
    let sample = cable(&registry(), 20);
    let mut problem = sample.problem();
    let mut used = factory();
    let mut state = sample.state.clone();
    let mut target = sample.conditions.targets[1];
    for end in ENDS {
        target.position = Vector::from(end);
        problem.set_target(1, target);
        let mut other = state.clone();
        used.minimise(&mut problem, &mut state, &STOP);
        factory().minimise(&mut sample_at(&sample, target), &mut other, &STOP);
        used.forget();
        assert!(bits(&state) == bits(&other), "end at {end:?}");
    }
}

/// The problem of a sample with the end at `target`.
fn sample_at(sample: &Sample, target: wireloom_core::Pose) -> wireloom_core::Problem<'_> {
    let mut problem = sample.problem();
    problem.set_target(1, target);
    problem
}
