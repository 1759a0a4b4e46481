//! `wireloom verify`, and the verdict in the summary of `run`: what a user reads, and the exit code a script reads.

use serde_json::Value;
use std::fmt::Write;
use wireloom_tests::cables::{branch, connector, hanging, section};
use wireloom_tests::place::{Ended, Place};
use wireloom_tests::root;

/// The right plug goes to 0.4 m, then to `end`, in metres; `more` are requirements.
fn there_and_back(end: f64, more: &str) -> String {
    let step = |name: &str, x: f64| {
        format!(
            "[[steps]]\nname = \"{name}\"\nincrements = 8\n\
             move = [{{ constraint = \"plug-B\", position = [{x:?}, 0, 0] }}]\n"
        )
    };
    hanging("there and back", 40, &[&*step("in", 0.4), &*step("out", end), more].concat())
}

/// A requirement on the bend radius of the cable, which is 80 mm at the end of the first step and more otherwise.
fn bend(min: &str, more: &str) -> String {
    format!(
        "[[requirements]]\nname = \"loop\"\nquantity = \"bend_radius\"\nof = {{ branch = \"cable\" }}\n\
         min = \"{min}\"\n{more}"
    )
}

fn verify(text: &str, arguments: &[&str]) -> (Place, Ended) {
    let place = Place::new(text);
    let ended = place.run(&[&["verify", "s.toml"], arguments].concat());
    (place, ended)
}

/// The line of the sheet that has these words.
#[track_caller]
fn line<'e>(ended: &'e Ended, words: &[&str]) -> &'e str {
    let has = |line: &&str| words.iter().all(|word| line.contains(word));
    ended.out.lines().find(has).unwrap_or_else(|| panic!("no line with {words:?} in {ended:#?}"))
}

#[test]
fn a_harness_that_keeps_its_requirements_ends_with_0() {
    let (place, ended) = verify(&there_and_back(0.6, &bend("20 mm", "because = \"sheet 12\"\n")), &[]);
    ended.says(0, &[]);
    let kept = line(&ended, &["loop", "bend radius"]);
    for words in ["pass", "min 20 mm", "branch `cable` at s = ", "in (8)", "sheet 12"] {
        assert!(kept.contains(words), "{words}: {ended:#?}");
    }
    assert!(line(&ended, &["verdict: PASS: "]).ends_with("kept, 1 not checked"), "{ended:#?}");
    line(&ended, &["status:  converged"]);
    line(&ended, &["wrote out/s: picture.svg, result.json"]);
    // The files are those of `run`.
    let verified = place.result("out/s");
    place.run(&["run", "s.toml", "--out", "again"]).says(0, &[]);
    assert_eq!(verified, place.result("again"));
}

/// The same run is "converged", and fails: in its first step, though it ends as it began.
#[test]
fn a_harness_that_fails_in_a_middle_step_ends_with_4_and_its_run_with_0() {
    let text = there_and_back(0.6, &bend("85 mm", ""));
    let (place, ended) = verify(&text, &[]);
    ended.says(4, &[]);
    // The worst comes first.
    let first = ended.out.lines().nth(2).unwrap_or_default();
    for words in ["FAIL", "loop", "bend radius", "mm", "min 85 mm", "-", "%", "branch `cable` at s = ", "in (8)"] {
        assert!(first.contains(words), "{words}: {ended:#?}");
    }
    assert!(line(&ended, &["verdict: FAIL: 1 of "]).contains("requirements fails"), "{ended:#?}");
    line(&ended, &["status:  converged"]);
    let run = place.run(&["run", "s.toml"]);
    run.says(0, &[]);
    let lines: Vec<&str> = run.out.lines().collect();
    assert!(lines[0].starts_with("verdict: FAIL: 1 of "), "{run:#?}");
    assert!(lines[1].starts_with("not checked: `straight spans do not buckle`: "), "{run:#?}");
    assert!(lines[5].starts_with("FAIL") && lines[5].contains("min 85 mm"), "{run:#?}");
    assert!(lines[7].starts_with("status:  converged (there and back: "), "{run:#?}");
}

/// A cable that is pulled to twice its length converges, and is no harness that anybody could sign.
#[test]
fn a_plug_out_of_reach_fails_without_any_requirement_in_the_file() {
    let (_, ended) = verify(&there_and_back(2.0, ""), &[]);
    ended.says(4, &[]);
    let reach = line(&ended, &["spans are long enough"]);
    for words in ["FAIL", "reach", "200 %", "max 100 %", "-100 %", "out (8)"] {
        assert!(reach.contains(words), "{words}: {ended:#?}");
    }
}

/// A trunk of 0.3 m and an arm of 0.4 m run straight through the joint from plug to plug, which are `apart` (m);
/// `middle` is a branch beside them.
fn through_a_joint(apart: f64, middle: &str) -> String {
    let arms = |more: &str| {
        format!(
            "[[joints]]\nname = \"J\"\nmodel = \"fused\"\narms = [\
             {{ branch = \"trunk\", direction = [-1, 0, 0], up = [0, 0, 1] }}, \
             {{ branch = \"arm\", direction = [1, 0, 0], up = [0, 0, 1] }}{more}]\n"
        )
    };
    let beside = ", { branch = \"middle\", direction = [0, 1, 0], up = [0, 0, 1] }";
    [
        "schema = 1\nname = \"through a joint\"\ngravity = [0, 0, 0]\n",
        &section("cable"),
        &branch("trunk", ["A", "J"], "cable", 0.3, 30),
        &branch("arm", ["J", "B"], "cable", 0.4, 40),
        middle,
        &arms(if middle.is_empty() { "" } else { beside }),
        &connector("plug-A", "A", [0.0; 3]),
        &connector("plug-B", "B", [apart, 0.0, 0.0]),
    ]
    .concat()
}

/// Each branch is stretched by less than what any cable may be; the two of them are too short all the same.
#[test]
fn plugs_farther_apart_than_the_cable_through_a_joint_fail() {
    for middle in [String::new(), branch("middle", ["J", "C"], "cable", 0.2, 20)] {
        let (place, ended) = verify(&through_a_joint(0.7021, &middle), &["--out", "o"]);
        ended.says(4, &[]);
        let reach = line(&ended, &["spans are long enough"]);
        for words in ["FAIL", "100.3 %", "max 100 %", "-0.30 %"] {
            assert!(reach.contains(words), "{words}: {ended:#?}");
        }
        let event = "between s = 0.0000 m of `trunk` and s = 0.4000 m of `arm`, 0.7000 m of cable bridge 0.7021 m";
        let result = place.result("o");
        let events = result["events"].as_array().expect("events");
        assert!(events.iter().any(|own| own["message"] == event), "{events:#?}");
        let (_, ended) = verify(&through_a_joint(0.7, &middle), &[]);
        ended.says(0, &[]);
    }
}

/// Two branches that a joint joins to a straight cable are one column.
#[test]
fn a_joint_within_a_cable_does_not_raise_its_buckling_limit() {
    let whole = [
        "schema = 1\nname = \"whole\"\ngravity = [0, 0, 0]\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 0.7, 70),
        &connector("plug-A", "A", [0.0; 3]),
        &connector("plug-B", "B", [0.69995, 0.0, 0.0]),
    ];
    let [whole, joined] = [whole.concat(), through_a_joint(0.69995, "")].map(|text| {
        let (place, _) = verify(&text, &["--out", "o"]);
        let result = place.result("o");
        let all = result["requirements"].as_array().expect("requirements");
        let own = all.iter().find(|own| own["quantity"] == "buckling").expect("the check of straight spans");
        ["worst", "limit"].map(|key| own[key].as_f64().expect("a number"))
    });
    // 1.1 · 4 π² EI/L², and EA times the compression as far as the cable has not bowed out.
    let euler = 1.1 * 4.0 * std::f64::consts::PI.powi(2) * 0.01 / 0.49;
    assert!((whole[1] - euler).abs() < 1e-9 * euler, "{whole:?} {euler}");
    for (a, b) in whole.into_iter().zip(joined) {
        assert!((a - b).abs() < 1e-6 * a.abs(), "{whole:?} {joined:?}");
    }
}

#[test]
fn what_should_be_kept_decides_nothing() {
    let (_, ended) = verify(&there_and_back(0.6, &bend("85 mm", "severity = \"should\"\n")), &[]);
    ended.says(0, &[]);
    assert!(line(&ended, &["loop"]).starts_with("FAIL (should)"), "{ended:#?}");
    assert!(line(&ended, &["verdict: PASS"]).ends_with("1 that should be kept fails"), "{ended:#?}");
}

/// In the second step the plug stays where it is.
#[test]
fn a_requirement_that_nothing_was_checked_on_is_no_pass() {
    let moving = bend("20 mm", "motion = \"moving\"\nsteps = [\"out\"]\n");
    let (place, ended) = verify(&there_and_back(0.4, &moving), &[]);
    ended.says(4, &[]);
    let never = line(&ended, &["loop"]);
    assert!(never.starts_with("not checked") && never.contains("it did not move"), "{ended:#?}");
    line(&ended, &["verdict: UNRESOLVED: "]);
    // The summary of a run, which leaves out what is kept, names it beside its verdict.
    let ended = place.run(&["run", "s.toml"]);
    line(&ended, &["verdict: UNRESOLVED: "]);
    line(&ended, &["not checked: `loop`: it did not move in these steps"]);
}

/// Whether the run converged comes first: its sheet is not that of the whole assembly.
#[test]
fn a_run_that_does_not_converge_ends_with_2_whatever_its_sheet_says() {
    for (end, iterations, verdict) in [(0.6, 1, "UNRESOLVED"), (2.0, 5, "FAIL")] {
        let minimiser = format!("[minimiser]\nkind = \"newton\"\nmax_iterations = {iterations}\n");
        let (_, ended) = verify(&there_and_back(end, &minimiser), &[]);
        ended.says(2, &[]);
        line(&ended, &["verdict: ", verdict]);
        line(&ended, &["status:  iteration limit"]);
    }
}

#[test]
fn the_sheet_as_json_is_that_of_the_result() {
    let (place, ended) = verify(&there_and_back(0.6, &bend("85 mm", "")), &["--json", "--out", "o"]);
    ended.says(4, &[]);
    let sheet: Value = serde_json::from_str(&ended.out).expect("JSON and nothing else");
    let result = place.result("o");
    let keys: Vec<&String> = sheet.as_object().expect("an object").keys().collect();
    assert_eq!(keys.len(), 5, "{keys:?}");
    for key in keys {
        assert_eq!(sheet[key], result[key], "{key}");
    }
    assert_eq!((&sheet["verdict"], &sheet["status"]), (&Value::from("fail"), &Value::from("converged")));
}

#[test]
fn values_of_the_command_line_are_verified_and_quiet_says_nothing() {
    let text = there_and_back(
        0.6,
        &bend(
            "85 mm",
            "[sweep]\nmethod = \"grid\"\n[sweep.vary]\n\"requirements.loop.min\" = { values = [0.085, 0.02] }\n",
        ),
    );
    let (place, ended) = verify(&text, &["--quiet", "--set", "requirements.loop.min=\"20 mm\""]);
    ended.says(0, &[]);
    assert!(ended.out.is_empty() && ended.err.is_empty(), "{ended:#?}");
    for (point, code) in [("0", 4), ("1", 0)] {
        place.run(&["verify", "s.toml", "--point", point, "-q"]).says(code, &[]);
    }
}

/// 78 notes on joints once hid what a user has to know.
#[test]
fn many_notes_are_counted_and_go_to_the_result() {
    let mut text = "schema = 1\nname = \"notes\"\n".to_owned();
    for k in 0..5 {
        let (name, ends) = (format!("c{k}"), [format!("A{k}"), format!("B{k}")]);
        write!(text, "[sections.{name}]\nwires = [{{ type = \"FLRY-B 0.5\", count = {} }}]\n", k + 2).expect("text");
        text += &branch(&name, [&ends[0], &ends[1]], &name, 0.2, 4);
        text += &connector(&format!("plug-{k}"), &ends[0], [0.0, 0.1 * f64::from(k), 0.0]);
    }
    let place = Place::new(&text);
    let ended = place.run(&["run", "s.toml"]);
    ended.says(0, &[]);
    let notes = place.result("out/s")["notes"].as_array().map_or(0, Vec::len);
    assert!(notes >= 5, "{notes}");
    line(&ended, &[&format!("{notes} notes on the scenario: see result.json")]);
    assert!(!ended.out.contains("note: "), "{ended:#?}");
}

/// A plug that needs 20 N itself and 10 N for its cable: where its own force is not given, the sheet does not show 10 N
/// as if that were all.
#[test]
fn an_insertion_force_has_the_connectors_own_part_or_says_that_it_has_not() {
    let path = root().join("scenarios/assembly/mate_straight.toml");
    let text = std::fs::read_to_string(path).expect("the scenario");
    let remark = "force of the cable alone: the `insertion_force` of `plug-B` itself is not given";
    let (place, ended) = verify(&text, &[]);
    let push = line(&ended, &["plug-B", "insertion force"]);
    assert!(push.contains("30.0 N") && push.contains("max 45 N") && !ended.out.contains("cable alone"), "{ended:#?}");
    assert_eq!(place.result("out/s")["steps"][0]["operations"][0]["own"], 20.0);
    let without = text.replace("\ninsertion_force = \"20 N\"", "");
    assert_ne!(without, text, "another scenario by now");
    let (place, ended) = verify(&without, &[]);
    let push = line(&ended, &["plug-B", "insertion force"]);
    assert!(push.contains("10.0 N") && push.contains(remark), "{ended:#?}");
    let run = place.run(&["run", "s.toml"]);
    line(&run, &["insertion force 10.00 N (cable alone: that of the connector is not given), allowed 45 N"]);
}

/// Without a plug off the middle the loop is tightest at its middle, which lies between two of an odd number of
/// segments: at the nodes beside it the cable bends less. Errors of nodes alone were 80 times too small.
#[test]
fn a_bend_that_is_tightest_between_nodes_is_covered_by_its_error() {
    let sheet = |segments: usize| -> (f64, f64) {
        let text = there_and_back(0.4, &bend("20 mm", "")).replace("segments = 40", &format!("segments = {segments}"));
        let (place, ended) = verify(&text, &[]);
        ended.says(0, &[]);
        let result = place.result("out/s");
        let own = result["requirements"].as_array().expect("a sheet").iter().find(|own| own["name"] == "loop");
        let number = |key: &str| own.expect("the requirement")[key].as_f64().expect("a number");
        (number("worst"), number("error"))
    };
    let (fine, _) = sheet(320);
    for segments in [21, 27, 33] {
        let (worst, error) = sheet(segments);
        let off = worst - fine;
        assert!(off > 0.0 && off <= error && error < 4.0 * off, "{segments}: {worst} ± {error}, {fine}");
    }
}
