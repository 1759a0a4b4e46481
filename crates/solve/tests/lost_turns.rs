//! Prescribed turns of twist: held by the mesh, or reported as lost.

use wireloom_core::constraint::ConstraintSpec;
use wireloom_core::equilibrium::StepResult;
use wireloom_core::minimiser::Stop;
use wireloom_core::status::Status;
use wireloom_core::steps::{Move, Schedule, Step, Track};
use wireloom_core::{Event, EventKind, Network, Parameters, Registry, Run, Value, Vector};
use wireloom_solve::minimisers::newton::Newton;
use wireloom_solve::steps::checkpoint::IncrementObserver;
use wireloom_solve::{Control, carry_out};
use wireloom_testkit::conformance::networks::{cable, cut_cable};

fn registry() -> Registry {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    registry
}

/// Moves the last constraint to a place, then turns it by a number of turns in a number of increments.
fn turn(network: &Network, to: Vector, gravity: f64, turns: f64, increments: usize) -> Run {
    let last = network.constraints.len() - 1;
    let track = Track { positions: vec![(1.0, to)], ..Track::default() };
    let steps = [("pull", track, 4), ("turn", Track { spin: turns, ..Track::default() }, increments)];
    let step = |(name, track, increments): (&str, Track, usize)| Step {
        name: name.into(),
        increments,
        moves: vec![Move::of(last, track)],
        ..Step::default()
    };
    let schedule = Schedule {
        scenario: "twisted".into(),
        gravity: Vector::new(0.0, 0.0, -gravity),
        rotation: Default::default(),
        initial: None,
        steps: steps.map(step).into(),
        increments: true,
        clearances: false,
        identities: Default::default(),
    };
    let mut observer = |_: &_, _: &_| Control::Continue;
    carry_out(
        network,
        None,
        &mut Newton::new(),
        &Stop::default(),
        &schedule,
        None,
        &mut IncrementObserver(&mut observer),
    )
}

/// Half a percent of strain: the tension keeps the cable straight at any twist.
const TAUT: Vector = Vector::new(1.005, 0.0, 0.0);

/// Increments of the step that turns, with the prescribed turns of each.
fn turning(run: &Run, turns: f64) -> impl Iterator<Item = (&StepResult, f64)> {
    let all = run.steps.iter().filter(|end| end.name == "turn");
    all.map(move |end| (end, turns * end.increment as f64 / end.increments as f64))
}

fn twist(end: &StepResult) -> f64 {
    end.branches.iter().map(|branch| branch.twist_turns).sum()
}

/// Checks that converged increments have the prescribed twist (this fraction of it in the branches, with this error),
/// and that others report lost turns with their place.
#[track_caller]
fn held_or_reported(what: &str, run: &Run, turns: f64, (fraction, error): (f64, f64), held: bool) {
    for (end, asked) in turning(run, turns).filter(|(end, _)| end.status == Status::Converged) {
        assert!(
            (twist(end) - fraction * asked).abs() <= error * asked.abs(),
            "{what}: {} turns of {asked}",
            twist(end)
        );
    }
    let lost = lost(run);
    if held {
        assert_eq!((run.status(), lost.len()), (Status::Converged, 0), "{what}: {lost:?}");
        return;
    }
    assert_eq!(run.status(), Status::Failed, "{what}: {:?}", run.events);
    assert!(!lost.is_empty(), "{what}: {:?}", run.events);
    for event in lost {
        assert!(event.place.branch.is_some() && event.place.s.is_some(), "{what}: {event:?}");
        assert!(event.value.is_some_and(|turns| turns >= 1.0), "{what}: {event:?}");
    }
}

fn lost(run: &Run) -> Vec<&Event> {
    run.events.iter().filter(|event| event.kind == EventKind::TwistLost).collect()
}

/// All of it in the branches, to round-off.
const EXACTLY: (f64, f64) = (1.0, 1e-9);

#[test]
fn eight_turns_on_twenty_segments_end_converged_with_five() {
    for (segments, turns, held) in [(20, 5.0, true), (20, 8.0, false), (40, 8.0, true), (40, 50.0, false)] {
        let sample = cable(&registry(), segments);
        for increments in [1, 16] {
            let run = turn(&sample.network, TAUT, 0.0, turns, increments);
            held_or_reported(&format!("{turns} turns on {segments}, in {increments}"), &run, turns, EXACTLY, held);
        }
    }
}

/// The run ends where the first turn would be lost, before all its parts are computed.
#[test]
fn ten_million_turns_end_where_the_mesh_holds_no_more() {
    let sample = cable(&registry(), 20);
    for turns in [1e7, -1e7] {
        let run = turn(&sample.network, TAUT, 0.0, turns, 1);
        held_or_reported(&format!("{turns} turns"), &run, turns, EXACTLY, false);
    }
}

#[test]
fn turns_are_not_lost_at_a_joint_in_between() {
    for model in ["cosserat", "fused", "rigid-body", "compliant-hub"] {
        let sample = cut_cable(&registry(), model, 20);
        // The twist between the two segments at a joint without a frame belongs to no branch.
        let fraction = match model {
            "cosserat" => (0.95, 0.05),
            // L/GJ in series with two springs of 0.2 N m/rad, whose moment is at its largest before nine turns; beyond
            // 60° it is less than k φ.
            "compliant-hub" => ((1.0 / 0.009) / (1.0 / 0.009 + 2.0 / 0.2), 0.02),
            _ => EXACTLY,
        };
        for (turns, held) in [(4.0, true), (9.0, false)] {
            let run = turn(&sample.network, TAUT, 0.0, turns, 18);
            held_or_reported(&format!("{turns} turns through {model}"), &run, turns, fraction, held);
        }
    }
}

/// The end of a hanging loop is turned by five turns: the loop sheds pairs of turns around its end, as in the belt
/// trick. It is in balance, with events.
#[test]
fn turns_shed_by_a_loop_are_reported() {
    for segments in [20, 40] {
        let sample = cable(&registry(), segments);
        let run = turn(&sample.network, Vector::new(0.5, 0.0, 0.0), 9.81, 5.0, 20);
        assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
        let lost = lost(&run);
        let shed: f64 = lost.iter().filter_map(|event| event.value).sum();
        assert_eq!((lost.len(), shed), (2, 4.0), "{lost:?}");
        assert!(
            lost.iter().all(|event| event.place.branch.is_some() && event.message.contains("passed through itself"))
        );
        let left = turning(&run, 5.0).last().map(|(end, _)| twist(end));
        assert!(left.is_some_and(|left| left < 1.0), "{left:?}");
    }
}

/// A handle whose rotational spring is weaker than the twisted cable: the spring snaps round, and the cable loses
/// turns.
#[test]
fn turns_are_not_lost_in_a_rotational_spring() {
    let registry = registry();
    let spring = |stiffness: f64| {
        let mut sample = cable(&registry, 20);
        let spec = ConstraintSpec { tangent_given: true, up_given: true, ..ConstraintSpec::default() };
        let springs = [("stiffness", 1e5), ("angular_stiffness", stiffness)];
        let parameters = Parameters(springs.map(|(name, value)| (name.into(), Value::Number(value))).into());
        let handle = registry.constraint("handle").expect("built in");
        sample.network.constraints[1].model = (handle.build)(&spec, &parameters).expect("a handle with a spring");
        turn(&sample.network, TAUT, 0.0, 3.0, 6)
    };
    let strong = spring(10.0);
    assert_eq!((strong.status(), lost(&strong).len()), (Status::Converged, 0), "{:?}", strong.events);
    let weak = spring(0.02);
    assert_eq!(weak.status(), Status::Failed, "{:?}", weak.events);
    assert!(matches!(lost(&weak)[..], [event] if event.place.constraint.is_some()), "{:?}", weak.events);
}
