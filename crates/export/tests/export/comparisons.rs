//! What differs between results, and how they are read back.

use crate::samples::{branch, constraint, requirement, run, step, v, y_harness};
use wireloom_core::equilibrium::{OperationResult, Outcome, RequirementResult, Run, SlideMotion, SlideResult};
use wireloom_core::requirement::{Bound, Measure, Origin, Verdict, Violation};
use wireloom_core::{EventPlace, Status, StepResult};
use wireloom_export::comparison::{Case, Comparison, Reason};
use wireloom_export::ending::Ending;
use wireloom_export::table::{Computed, Header, Layout};
use wireloom_export::{json, sheet};

fn ending(step: StepResult) -> Ending {
    Ending::of(&run("y", vec![step])).unwrap()
}

fn cases(endings: Vec<Ending>) -> Vec<Case> {
    endings.into_iter().enumerate().map(|(k, ending)| Case { name: format!("seed{k}"), ending }).collect()
}

/// Three cables in a row (a and b meet), each of which bulges to one side: +1 or −1.
fn cables(bulges: [f64; 3]) -> StepResult {
    let cable = |name: &str, start: f64, bulge: f64| {
        branch(name, 0.01, None, 20, move |t| v(start + t, 0.1 * bulge * (std::f64::consts::PI * t).sin(), 0.0))
    };
    let branches = vec![cable("a", 0.0, bulges[0]), cable("b", 1.0, bulges[1]), cable("c", 5.0, bulges[2])];
    step(branches, vec![], vec![constraint("clip", "collar", v(0.0, 0.0, 0.0), v(0.0, 0.0, 1.0))])
}

fn read(run: &Run) -> Option<Ending> {
    let mut bytes = Vec::new();
    json::write(run, &json::Provenance::default(), &mut bytes).unwrap();
    json::read(bytes.as_slice()).unwrap()
}

/// JSON has no infinite numbers: the bend radius of a straight cable is null there, and so is its margin.
#[test]
fn a_straight_cable_that_fails_a_greatest_bend_radius_comes_back_as_that() {
    let mut run = run("y", vec![y_harness()]);
    let place = EventPlace::branch("left", 0.2);
    let failing = RequirementResult {
        bound: Bound::Max,
        verdict: Verdict::Fail,
        ..requirement("tight", Measure::BendRadius, [f64::INFINITY, 0.5], place.clone())
    };
    let violation = Violation {
        name: "tight".into(),
        measure: Measure::BendRadius,
        severity: failing.severity,
        value: f64::INFINITY,
        limit: 0.5,
        bound: Bound::Max,
        place,
    };
    run.steps[0].violations = vec![violation];
    run.requirements = vec![failing];
    let mut bytes = Vec::new();
    json::write(&run, &json::Provenance::default(), &mut bytes).unwrap();
    let again = json::read_run(bytes.as_slice()).expect("a result");
    assert_eq!((&again.requirements, &again.steps[0].violations), (&run.requirements, &run.steps[0].violations));
    assert_eq!(again.requirements[0].margin(), Some(f64::NEG_INFINITY));
    assert_eq!(sheet::brief(&again.requirements[0]), "FAIL straight (< -1000 %), branch `left` at s = 200.0 mm");
    let sheets = read(&run).expect("an ending").requirements;
    assert_eq!(sheet::open_in_any(&[&sheets]), ["tight"]);
}

/// The limits of a section have its name: the second one, which fails, was compared under the name of the first.
#[test]
fn limits_of_the_same_name_are_told_apart() {
    let mut run = run("y", vec![y_harness()]);
    let of = |measure, values| RequirementResult {
        origin: Origin::Section,
        ..requirement("wire", measure, values, EventPlace::branch("left", 0.2))
    };
    run.requirements = vec![of(Measure::BendRadius, [0.06, 0.05]), of(Measure::Tension, [30.0, 20.0])];
    let names = |lines: &[RequirementResult]| lines.iter().map(|line| line.name.clone()).collect::<Vec<_>>();
    let (fresh, read) = (Ending::of(&run).expect("an ending"), read(&run).expect("an ending"));
    assert_eq!(names(&fresh.requirements), ["wire (bend radius)", "wire (tension)"]);
    assert_eq!(fresh.requirements, read.requirements);
    assert_eq!(sheet::open_in_any(&[&fresh.requirements]), ["wire (tension)"]);
    // In the table of a sweep, too: it had one column for both.
    let header = Header { keys: vec![], branches: vec![], constraints: vec![], outputs: vec![] };
    let verdict = Some((Verdict::Fail, &run.requirements[..]));
    let rows = [header.row(vec![], &fresh, Computed { verdict, ..Computed::default() })];
    let mut layout = Layout::new(&header);
    layout.add(&rows);
    let table = layout.table(0, &rows);
    assert_eq!(table.words("verdict.wire (bend radius)"), [Some("pass".to_owned())]);
    assert_eq!(table.words("verdict.wire (tension)"), [Some("fail".to_owned())]);
    assert_eq!(table.numbers("worst.wire (tension)"), [Some(30.0)]);
}

#[test]
fn a_result_comes_back_from_its_file() {
    let mut sliding = constraint("ring", "collar", v(0.0, 0.1, 0.0), v(0.0, 0.0, 3.0));
    let slide = SlideResult { branch: "trunk".into(), arc_length: 0.25, axial_force: 0.5, motion: SlideMotion::Slip };
    sliding.slide = Some(slide);
    let clip = |s| OperationResult::Clip { constraint: "clip".into(), place: Some(("trunk".into(), s)), reach: 0.01 };
    let (mut first, mut second, mut third) = (y_harness(), y_harness(), y_harness());
    (first.increment, first.increments, second.increment, second.increments) = (1, 2, 2, 2);
    first.operations = vec![clip(0.1)];
    second.operations = vec![clip(0.2), OperationResult::Carry { constraints: vec!["hand".into()], force: 1.0 }];
    second.minimiser.iterations = 11;
    third.name = "last".into();
    third.constraints.push(sliding);
    third.branches[0].position[1].x = f64::NAN;
    let mut run = run("y", vec![first, second, third]);
    run.outcome = Outcome::Graded(Status::Stalled);
    let (mut read, expected) = (read(&run).unwrap(), Ending::of(&run).unwrap());
    assert_eq!((read.iterations, read.closed.len(), read.events[0].1), (11 + 6, 1, 1));
    assert_eq!(read.closed[0].place, Some(("trunk".into(), 0.2)));
    assert_eq!(read.constraints.last().unwrap().slide, Some(("trunk".into(), 0.25)));
    let lost = &mut read.branches[0].position[1].x;
    assert!(lost.is_nan());
    let mut expected = expected;
    (*lost, expected.branches[0].position[1].x) = (0.0, 0.0);
    // Directors are columns of a rotation matrix on one side, and numbers in a text on the other.
    assert_eq!(read, expected);
}

#[test]
fn what_is_no_result_is_refused_with_its_place() {
    for text in ["", "{}", "[1]", r#"{"schema": 2, "scenario": "", "status": "", "steps": []}"#, r#"{"schema": 1"#] {
        let refused = json::read(text.as_bytes()).unwrap_err();
        assert!(!refused.to_string().is_empty(), "{text}");
    }
    assert_eq!(read(&run("nothing", vec![])), None);
}

#[test]
fn the_same_equilibrium_is_the_same_on_any_mesh() {
    let cable = |n| step(vec![branch("a", 0.01, None, n, |t| v(t, 0.1 * (3.0 * t).sin(), 0.0))], vec![], vec![]);
    let cases = cases(vec![ending(cable(20)), ending(cable(33))]);
    let comparison = Comparison::of(&cases, None, 1e-3);
    assert_eq!(comparison.groups.len(), 1);
    assert!(comparison.parts.is_empty() && comparison.groups[0].reasons.is_empty());
    let apart = comparison.differences[1].farthest().unwrap().largest;
    assert!(apart > 0.0 && apart < 1e-3, "{apart}");
}

/// A whole turn more leaves a straight cable where it is.
#[test]
fn another_twist_or_load_in_the_same_shape_is_another_equilibrium() {
    let reasons = |other: Ending| {
        let comparison = Comparison::of(&cases(vec![ending(cables([1.0; 3])), other]), None, 1e-3);
        assert_eq!(comparison.groups.len(), 2);
        comparison.groups[1].reasons.clone()
    };
    let mut turned = ending(cables([1.0; 3]));
    turned.branches[1].twist_turns += 1.0;
    assert!(matches!(&reasons(turned)[..], [Reason::Twist { branch, .. }] if branch == "b"));
    let mut pulled = ending(cables([1.0; 3]));
    pulled.constraints[0].force.x += 1.0;
    assert!(matches!(&reasons(pulled)[..], [Reason::Bears { constraint, unit: "N", .. }] if constraint == "clip"));
    let mut strained = ending(cables([1.0; 3]));
    strained.energy.twist += 1.0 + strained.energy.total().abs();
    assert!(matches!(&reasons(strained)[..], [Reason::Energy { difference }] if *difference >= 1.0));
}

#[test]
fn runs_that_did_not_converge_are_no_equilibrium_together() {
    let mut torn = ending(cables([1.0; 3]));
    (torn.converged, torn.status) = (false, "stalled".into());
    let why = Reason::NotConverged { reference: false, status: "stalled".into() };
    let comparison = Comparison::of(&cases(vec![torn.clone(), torn.clone()]), None, 1e-3);
    assert_eq!((comparison.groups.len(), &comparison.groups[0].reasons), (2, &vec![why.clone()]));
    // One that converged is the reference.
    let comparison = Comparison::of(&cases(vec![torn.clone(), torn, ending(cables([1.0; 3]))]), None, 1e-3);
    assert_eq!((comparison.reference, comparison.groups.len()), (2, 3));
    assert_eq!(comparison.groups[1].reasons, [why]);
}

#[test]
fn independent_parts_that_lie_on_either_side_are_found() {
    let mut lower = cables([-1.0, -1.0, 1.0]);
    lower.energy.bend -= 0.002;
    let ends = [cables([1.0; 3]), cables([1.0; 3]), lower, cables([1.0, 1.0, -1.0]), cables([-1.0; 3])];
    let cases = cases(ends.map(ending).to_vec());
    let comparison = Comparison::of(&cases, None, 1e-3);
    let groups: Vec<&[usize]> = comparison.groups.iter().map(|group| &group.cases[..]).collect();
    assert_eq!(groups, [&[0, 1][..], &[2], &[3], &[4]], "the largest first, then by energy");
    assert_eq!(comparison.groups[1].reasons, [Reason::Multistable { stable: true }]);
    assert!((comparison.differences[2].energy + 0.002).abs() < 1e-12);
    // a and b change sides together and meet; c does for itself.
    let parts: Vec<Vec<&str>> =
        comparison.parts.iter().map(|part| part.branches.iter().map(String::as_str).collect()).collect();
    assert_eq!(parts.len(), 2);
    assert!(parts.contains(&vec!["a", "b"]) && parts.contains(&vec!["c"]), "{parts:?}");
    for part in &comparison.parts {
        let expected = if part.branches[0] == "c" { [vec![0, 1, 2], vec![3, 4]] } else { [vec![0, 1, 3], vec![2, 4]] };
        assert_eq!(part.ways.iter().map(|way| way.cases.clone()).collect::<Vec<_>>(), expected);
        let (_, s, distance) = part.ways[1].farthest.clone().unwrap();
        assert!((distance - 0.2).abs() < 1e-9 && (s - 0.52).abs() < 0.03, "{distance} at {s}");
    }
}

#[test]
fn what_may_be_the_reason_is_told() {
    let base = || cables([1.0; 3]);
    let other = || cables([1.0, 1.0, -1.0]);
    let reasons = |ends: [Ending; 2]| {
        let comparison = Comparison::of(&cases(ends.to_vec()), Some(0), 1e-3);
        comparison.groups[1].reasons.clone()
    };
    let mut unstable = ending(other());
    unstable.stable = Some(false);
    assert_eq!(reasons([ending(base()), unstable]), [Reason::Unstable { reference: false }]);
    let mut torn = ending(other());
    (torn.converged, torn.status) = (false, "stalled".into());
    let expected = Reason::NotConverged { reference: true, status: "stalled".into() };
    assert_eq!(reasons([torn, ending(base())]), [expected]);
    let mut twisted = other();
    twisted.branches[2].twist_turns = 1.25;
    let expected = Reason::Twist { branch: "c".into(), turns: [0.25, 1.25] };
    assert_eq!(reasons([ending(base()), ending(twisted)]), [expected]);
    let mut moved = other();
    moved.constraints[0].position.x = 0.5;
    let expected = Reason::HeldElsewhere { constraint: "clip".into(), distance: 0.5 };
    assert_eq!(reasons([ending(base()), ending(moved)]), [expected]);
    let clipped = |mut step: StepResult, s| {
        let place = Some(("c".into(), s));
        step.operations = vec![OperationResult::Clip { constraint: "clip".into(), place, reach: 0.0 }];
        ending(step)
    };
    let [Reason::OtherPlace { constraint, .. }] = &reasons([clipped(base(), 0.1), clipped(other(), 0.2)])[..] else {
        panic!("the clip closed elsewhere")
    };
    assert_eq!(constraint, "clip");
    let mut fewer = other();
    fewer.branches.pop();
    let [Reason::OtherHarness { unmatched }] = &reasons([ending(base()), ending(fewer)])[..] else {
        panic!("a branch is missing")
    };
    assert_eq!(unmatched, &["c"]);
}
