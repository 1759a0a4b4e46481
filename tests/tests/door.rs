//! The harness of a car door: its sheet names requirement, step and place, alone and at every point of its sweep.

use std::fs;
use wireloom::result::{Measure, RequirementResult, Verdict};
use wireloom::scenario::{NoFiles, Setting};
use wireloom::{Control, Run, Status};
use wireloom_tests::root;

fn text() -> String {
    let path = root().join("scenarios/assembly/door.toml");
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A single run, as `wireloom run --point` carries it out.
fn run(text: &str, settings: &[Setting]) -> Run {
    let loaded = wireloom::load_with_settings(text, settings, &NoFiles, &wireloom::registry());
    let (_, built) = loaded.unwrap_or_else(|faults| panic!("{faults:?}"));
    wireloom::run(built, &mut |_, _| Control::Continue)
}

fn line<'r>(run: &'r Run, name: &str, measure: Measure) -> &'r RequirementResult {
    let found = run.requirements.iter().find(|line| line.name == name && line.measure == measure);
    found.unwrap_or_else(|| panic!("no line {name} in {:?}", run.requirements))
}

/// The end state keeps every limit. On the way to it the tube is bent too tightly, most just before its loop snaps in
/// the last step, and touches the trim.
#[test]
fn the_sheet_of_the_door_fails_in_middle_steps_though_its_end_is_fine() {
    let run = run(&text(), &[]);
    assert_eq!((run.status(), run.verdict()), (Status::Converged, Verdict::Fail));
    let at = |line: &RequirementResult| {
        let moment = line.moment.as_ref().expect("an increment");
        (line.verdict, moment.step.clone(), line.place.branch.clone(), line.place.obstacle.clone())
    };
    let (bend, trim) =
        (line(&run, "tube", Measure::BendRadius), line(&run, "loop clear of the trim", Measure::Clearance));
    assert_eq!(at(bend), (Verdict::Fail, "open 70".into(), Some("loop".into()), None));
    // It lies against the trim in several steps: which one is the worst is decided by the tolerance of contact.
    let (verdict, _, branch, obstacle) = at(trim);
    assert_eq!((verdict, branch, obstacle), (Verdict::Fail, Some("loop".into()), Some("kick panel".into())));
    let end = run.steps.last().expect("steps");
    let least = end.branches[0].bend_radius.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(end.name == "open 70" && least > 1.5 * bend.limit && bend.worst < Some(bend.limit), "{least}");
    assert!(end.obstacles.iter().all(|obstacle| obstacle.contacts == 0), "{:?}", end.obstacles);
    let failed: Vec<&str> =
        run.requirements.iter().filter(|line| line.verdict != Verdict::Pass).map(|line| line.name.as_str()).collect();
    assert_eq!(failed, ["loop clear of the trim", "tube"]);
}

#[test]
fn every_point_of_the_doors_sweep_says_what_a_single_run_says() {
    // A quarter of its points, spread over the same ranges.
    let text = text().replace("samples = 200", "samples = 50");
    let (_, rows) = wireloom::sweep::run(&text, &NoFiles, &wireloom::registry()).unwrap_or_else(|f| panic!("{f:?}"));
    assert_eq!(rows.len(), 50);
    assert!(rows.iter().all(|row| row.status == "converged" && row.verdict == Some(Verdict::Fail)));
    let (scenario, built) = wireloom::load(&text, &wireloom::registry()).unwrap_or_else(|faults| panic!("{faults:?}"));
    let sweep = scenario.sweep.expect("a sweep");
    // The section of the tube has two limits, and the sweep a column for each.
    let names = built.network.requirement_names();
    for k in [0, 17, 32, 49] {
        let (row, single) = (&rows[k], run(&text, &sweep.settings(k)));
        assert_eq!((row.verdict, row.sheet.len()), (Some(single.verdict()), single.requirements.len()), "{k}");
        for ((swept, own), name) in row.sheet.iter().zip(&single.requirements).zip(&names) {
            let step = own.moment.as_ref().map(|moment| moment.step.clone());
            assert_eq!((&swept.name, swept.verdict), (name, own.verdict), "{k}");
            // The start may be a warm one, which ends within the tolerance of forces.
            let close = match (swept.worst, own.worst) {
                (Some(a), Some(b)) => (a - b).abs() <= 1e-4 * own.limit.abs().max(b.abs()),
                (a, b) => a == b,
            };
            assert!(close, "{k}: {swept:?} and {own:?}");
            if own.verdict == Verdict::Fail {
                assert_eq!(swept.step, step, "{k}: {}", own.name);
                assert_eq!(swept.place.as_ref(), Some(&own.place.to_string()), "{k}: {}", own.name);
            }
        }
    }
}
