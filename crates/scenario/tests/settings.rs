//! Values set from outside the file.

mod common;

use wireloom_scenario::settings::{apart, lines};
use wireloom_scenario::{Division, NoFiles, Scenario, Setting, parse_with_settings, render};

const HARNESS: &str = include_str!("../../../scenarios/branches/y_cosserat.toml");

fn set(settings: &[(&str, &str)]) -> Result<Scenario, String> {
    let settings: Vec<Setting> = settings.iter().map(|(key, value)| Setting::new(*key, *value)).collect();
    parse_with_settings(HARNESS, &settings, &NoFiles, &common::registry()).map_err(|faults| {
        let (own, set) = apart(HARNESS, faults);
        render(HARNESS, &own) + &render(&lines(&settings), &set)
    })
}

#[test]
fn values_take_the_place_of_those_of_the_file() {
    let scenario = set(&[
        ("branches.left.length", "500 mm"),
        ("branches.*.segments", "7"),
        ("branches.right.segments", "9"),
        ("gravity", "[0, 0, -1.62]"),
        ("gravity.0", "0.5"),
        ("constraints.plug-A.position.0", "\"10 mm\""),
        ("joints.J.model", "fused"),
        ("joints.J.arms.left.direction", "[0.8, 0.6, 0]"),
        ("minimiser.max_iterations", "77"),
        ("sections.arm.diameter", "6 mm"),
        ("name", "other"),
    ])
    .unwrap_or_else(|faults| panic!("{faults}"));
    assert_eq!(scenario.branches[1].length, 0.5);
    let divisions: Vec<Division> = scenario.branches.iter().map(|branch| branch.division).collect();
    assert_eq!(divisions, [Division::Segments(7), Division::Segments(7), Division::Segments(9)]);
    assert_eq!((scenario.gravity.x, scenario.gravity.z), (0.5, -1.62));
    assert_eq!(scenario.constraints[0].position.unwrap().x, 0.01);
    assert_eq!((scenario.joints[0].model.as_str(), scenario.minimiser.stop.max_iterations), ("fused", 77));
    assert_eq!((scenario.sections[1].diameter, scenario.name.as_str()), (0.006, "other"));
}

#[test]
fn what_is_set_is_refused_where_it_stands() {
    let cases = [
        ("branches.left.length", "-1", "1:24: `length` = -1 is too small"),
        ("branches.left.length", "500 N", "1:24: `length` = 500 N is a force, not a length"),
        ("branches.left.lenght", "1", "1:15: unknown key `lenght` in branch \"left\"\n  help: did you mean `length`?"),
        (
            "branches.lefd.length",
            "1",
            "1:10: there is no entry `lefd` in `branches` of the scenario\n  help: did you mean `left`?",
        ),
        ("branch.left.length", "1", "1:1: there is no key `branch` in the scenario\n  help: did you mean `branches`?"),
        ("branches.left.length.x", "1", "1:22: `length` of `left` of `branches` of the scenario has no parts"),
        ("branches.left.", "1", "1:15: `branches.left.` names no key: a part of it is empty"),
        ("branches.\"left.length", "1", "1:10: `branches.\"left.length` names no key: a quote is not closed"),
        ("constraints.plug-A.position", "[0, 0", "1:31: `[0, 0` is not a value"),
        ("joints.J.model", "welded", "1:18: unknown joint model \"welded\""),
        ("loads.*.factor", "2", "1:1: the scenario has no `loads`, so it has no parts"),
        ("minimiser.kind", "", "1:18: `` is not a value"),
    ];
    for (key, value, expected) in cases {
        let faults = set(&[(key, value)]).expect_err(key);
        assert!(faults.starts_with(expected), "{key} = {value}: {faults}");
    }
}

#[test]
fn a_fault_of_a_later_setting_has_its_line() {
    let faults = set(&[("name", "ü"), ("branches.left.length", "0")]).unwrap_err();
    assert!(faults.starts_with("2:24: `length` = 0 is too small"), "{faults}");
}
