//! The form of `result.json`.

use crate::samples::{among_obstacles, broken, run, step, v, y_harness};
use serde_json::Value;
use wireloom_core::equilibrium::Violation;
use wireloom_core::equilibrium::{
    ArmFriction, OperationResult, Outcome, PartFamily, PartFault, Run, SlideMotion, SlideResult, SpanResult,
    StationResult, TightestBend,
};
use wireloom_core::requirement::{Bound, Measure, Severity};
use wireloom_core::rotation::columns;
use wireloom_core::{EventPlace, Parameters, Stop};
use wireloom_export::json::{Provenance, options};

fn parsed(run: &Run) -> Value {
    let mut bytes = Vec::new();
    wireloom_export::json::write(run, &provenance(), &mut bytes).unwrap();
    assert_eq!(bytes.last(), Some(&b'\n'));
    serde_json::from_slice(&bytes).unwrap()
}

fn provenance() -> Provenance {
    Provenance {
        program: "wireloom 1".into(),
        files: [("y.toml".into(), "e3b0".into())].into(),
        set: vec!["branches.left.length = 1".into()],
        seed: Some(7),
        rods: vec!["cosserat".into()],
        joints: vec!["fused".into()],
        constraints: vec!["connector".into()],
        minimiser: options(
            "newton",
            &Stop { force_tolerance: 1e-7, max_iterations: 50 },
            &Parameters([("memory".to_owned(), wireloom_core::Value::Count(9))].into()),
        ),
    }
}

#[test]
fn what_made_it_stands_in_it() {
    let expected = serde_json::json!({
        "program": "wireloom 1",
        "files": { "y.toml": "e3b0" },
        "set": ["branches.left.length = 1"],
        "seed": 7,
        "rods": ["cosserat"],
        "joints": ["fused"],
        "constraints": ["connector"],
        "minimiser": { "kind": "newton", "force_tolerance": 1e-7, "max_iterations": 50, "memory": 9 }
    });
    assert_eq!(parsed(&run("y", vec![]))["provenance"], expected);
}

/// Whether all of `b` is as in `a`, directors to the last digits but a few.
fn same(a: &Value, b: &Value, key: &str) -> bool {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|((k, a), (l, b))| k == l && same(a, b, k))
        }
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b, key)),
        (Value::Number(a), Value::Number(b)) if ["d1", "d3"].contains(&key) => {
            (a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 1e-14
        }
        _ => a == b,
    }
}

/// What slips at an arm.
fn slipped() -> ArmFriction {
    let set = v(0.1, -1.0 / 3.0, 0.0);
    ArmFriction { branch: "left".into(), starts_here: true, set, dissipated: 0.1, dissipated_in_all: 1.0 / 3.0 }
}

#[test]
fn what_is_written_is_read_back() {
    let mut rich = y_harness();
    rich.joints[0].friction = vec![slipped()];
    let station = StationResult { position: v(0.0, 0.0, 1.0), force: v(1.0, 0.0, 0.0), moment: v(0.0, 1.0, 0.0) };
    rich.constraints[0].stations = vec![station.clone(), station];
    rich.constraints[1].slide = Some(SlideResult {
        branch: "trunk".into(),
        arc_length: 0.125,
        axial_force: -0.1 / 3.0,
        motion: SlideMotion::Slip,
    });
    rich.operations = vec![
        OperationResult::Grasp { constraint: "hand".into(), place: Some(("left".into(), 0.1)) },
        OperationResult::Carry { constraints: vec!["hand".into(), "plug-B".into()], force: 3.5 },
        OperationResult::Mate {
            constraint: "plug-B".into(),
            insertion_force: None,
            own: Some(15.0),
            limit: Some(45.0),
        },
        OperationResult::Clip { constraint: "clip-1".into(), place: None, reach: 0.002 },
    ];
    let place =
        EventPlace { other_branch: Some("left".into()), other_s: Some(0.2), ..EventPlace::branch("trunk", 0.1) };
    rich.violations = vec![Violation {
        name: "bend".into(),
        measure: Measure::BendRadius,
        severity: Severity::Should,
        value: 0.1 / 3.0,
        limit: 0.05,
        bound: Bound::Min,
        place,
    }];
    let failed = Run { steps: vec![rich, broken()], ..faulty() };
    for run in [run("y", vec![y_harness()]), among_obstacles(), failed] {
        let written = parsed(&run);
        let again = wireloom_export::json::read_run(written.to_string().as_bytes()).expect("a result");
        assert!(same(&written, &parsed(&again), ""), "{}", run.scenario);
        assert_eq!(again.steps[0].violations, run.steps[0].violations);
        assert_eq!(again.steps[0].joints, run.steps[0].joints);
        assert_eq!((&again.events, again.status()), (&run.events, run.status()));
    }
}

/// Why a document is refused, by both readers.
fn refusal(value: &Value) -> String {
    let text = value.to_string();
    let error = wireloom_export::json::read_run(text.as_bytes()).expect_err("no result");
    assert_eq!(error.kind(), std::io::ErrorKind::InvalidData, "{error}");
    error.to_string()
}

#[test]
fn what_is_no_result_is_refused() {
    let mut written = parsed(&run("y", vec![y_harness()]));
    written["steps"][0]["branches"]["left"]["d1"].as_array_mut().unwrap().pop();
    assert_eq!(refusal(&written), "steps[0]: the lists of branch \"left\" differ in length");
    written["status"] = "fine".into();
    assert_eq!(refusal(&written), "status: invalid value: string \"fine\", expected a status");
    written["schema"] = 7.into();
    assert_eq!(refusal(&written), "schema: version 7 is not known to this program, which reads version 1");
}

#[test]
fn converged_beside_a_fault_is_refused() {
    let mut written = parsed(&run("y", vec![y_harness()]));
    written["fault"] = parsed(&faulty())["fault"].clone();
    assert_eq!(refusal(&written), "its status is converged, beside a fault: expected failed");
}

/// A run that a joint ended.
fn faulty() -> Run {
    let outcome = Outcome::Fault(PartFault {
        family: PartFamily::Joint,
        name: "J".into(),
        kind: "fused".into(),
        step: "pull".into(),
        increment: 0,
        message: "it broke".into(),
    });
    Run { outcome, ..run("broken", vec![]) }
}

/// Every field that is always written must be there, also where it may be null, and there may be no other one.
#[test]
fn missing_and_unknown_fields_are_named_with_their_path() {
    fn each(value: &mut Value, path: &str, whole: &dyn Fn(&Value) -> Option<String>, root: &Value, at: &str) -> usize {
        let mut tried = 0;
        let Value::Object(map) = value else { return 0 };
        let named = ["files", "minimiser"].iter().any(|key| path == format!("provenance.{key}"));
        let by_name = ["branches", "joints", "constraints", "obstacles", "markers", "sliding"]
            .iter()
            .any(|key| path.ends_with(key));
        for key in map.keys().cloned().collect::<Vec<_>>() {
            let pointer = format!("{at}/{key}");
            let inner = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            if !named && !by_name {
                let mut changed = root.clone();
                let parent = changed.pointer_mut(at).and_then(Value::as_object_mut).expect("an object");
                parent.remove(&key);
                match whole(&changed) {
                    Some(said) => {
                        assert!(said.contains(&format!("missing field `{key}`")), "{inner}: {said}");
                        assert!(path.is_empty() || said.starts_with(&format!("{path}: ")), "{inner}: {said}");
                        tried += 1;
                    }
                    None => assert!(OPTIONAL.contains(&key.as_str()), "{inner} may be missing"),
                }
            }
            tried += each(map.get_mut(&key).expect("a key"), &inner, whole, root, &pointer);
        }
        tried
    }
    let written = full();
    let all = |value: &Value| {
        wireloom_export::json::read_run(value.to_string().as_bytes()).err().map(|error| error.to_string())
    };
    let step = written["steps"][0].clone();
    let mut flat = written.clone();
    assert!(all(&written).is_none(), "{:?}", all(&written));
    let tried = each(&mut flat, "", &all, &written, "");
    let mut inner = step;
    let tried = tried + each(&mut inner, "steps[0]", &all, &written, "/steps/0");
    assert!(tried > 60, "{tried}");
    let mut new = written.clone();
    new["grade"] = "A".into();
    let newer = ", which another version of this program may have written";
    assert_eq!(refusal(&new), format!("grade: unknown field `grade`{newer}"));
    let mut new = written.clone();
    new["steps"][0]["branches"]["left"]["colour"] = "red".into();
    let said = refusal(&new);
    assert_eq!(said, format!("steps[0].branches.left.colour: unknown field `colour`{newer}"));
    let ending = wireloom_export::json::read(new.to_string().as_bytes()).expect_err("an unknown field").to_string();
    assert_eq!(ending, said);
    let mut new = written.clone();
    new["steps"][0]["operations"][0]["speed"] = 1.into();
    assert_eq!(refusal(&new), format!("steps[0].operations[0]: unknown field `speed`{newer}"));
}

/// Fields that are left out where there is nothing to say.
const OPTIONAL: [&str; 7] = ["plugins", "obstacles", "sliding", "operations", "clearance", "fault", "shape_error"];

/// A run with everything that a result may have.
fn full() -> Value {
    let mut step = y_harness();
    step.operations = vec![OperationResult::Grasp { constraint: "hand".into(), place: Some(("left".into(), 0.1)) }];
    step.constraints[1].slide =
        Some(SlideResult { branch: "trunk".into(), arc_length: 0.125, axial_force: 0.5, motion: SlideMotion::Slip });
    parsed(&run("full", vec![step]))
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn constraints_of_several_stations_have_each_of_them() {
    let mut step = y_harness();
    let station = |z: f64| StationResult { position: v(0.0, 0.0, z), force: v(z, 0.0, 0.0), moment: v(0.0, z, 0.0) };
    step.constraints[0].stations = vec![station(1.0), station(2.0)];
    step.constraints[1].span = Some(SpanResult {
        branch: "trunk".into(),
        range: (0.1, 0.3),
        force: v(0.0, 0.0, 2.0),
        largest: v(0.0, 0.0, 1.5),
        largest_at: 0.2,
    });
    step.minimiser.constraint_residual = Some(1e-10);
    let mut run = run("ties", vec![step]);
    run.outcome = Outcome::Fault(PartFault {
        family: PartFamily::Constraint,
        name: "tie".into(),
        kind: "cable-tie".into(),
        step: "pull".into(),
        increment: 3,
        message: "it broke".into(),
    });
    let value = parsed(&run);
    let constraints = &value["steps"][0]["constraints"];
    let second =
        serde_json::json!({ "position": [0.0, 0.0, 2.0], "force": [2.0, 0.0, 0.0], "moment": [0.0, 2.0, 0.0] });
    assert_eq!(constraints["plug-A"]["stations"][1], second);
    let span = serde_json::json!({ "branch": "trunk", "from": 0.1, "to": 0.3, "force": [0.0, 0.0, 2.0],
        "largest": [0.0, 0.0, 1.5], "largest_at": 0.2 });
    assert_eq!(constraints["clip-1"]["span"], span);
    assert_eq!(keys(&constraints["hand"]), ["kind", "position", "orientation", "force", "moment"]);
    assert_eq!(value["steps"][0]["minimiser"]["constraint_residual"], 1e-10);
    let fault = serde_json::json!({ "constraint": "tie", "kind": "cable-tie", "step": "pull", "increment": 3,
        "message": "it broke" });
    assert_eq!(value["fault"], fault);
}

/// The rename of fixings to constraints changed this key for a while.
#[test]
fn an_event_at_a_constraint_keeps_its_key() {
    let mut run = run("y-harness", vec![y_harness()]);
    run.events[0].place = EventPlace { s: Some(0.25), ..EventPlace::constraint("plug-A") };
    assert_eq!(parsed(&run)["events"][0]["place"], serde_json::json!({ "fixing": "plug-A", "s": 0.25 }));
}

#[test]
fn has_the_keys_of_the_contract_in_order() {
    let step = y_harness();
    let value = parsed(&run("y-harness", vec![step]));
    assert_eq!(
        keys(&value),
        [
            "schema",
            "scenario",
            "status",
            "verdict",
            "requirements",
            "provenance",
            "notes",
            "plugins",
            "events",
            "steps"
        ]
    );
    assert_eq!(value["schema"], 1);
    assert_eq!(value["scenario"], "y-harness");
    assert_eq!(value["status"], "converged");
    assert_eq!(value["notes"][0], "a remark");
    let expected = serde_json::json!({
        "kind": "bend-radius", "place": { "branch": "trunk", "s": 0.25 },
        "first": { "step": "pull", "step_index": 1, "increment": 2 },
        "worst": { "step": "pull", "step_index": 1, "increment": 3 },
        "last": { "step": "pull", "step_index": 1, "increment": 4 },
        "increments": 3, "value": 0.04, "limit": 0.05, "message": "bend radius 40.0 mm, allowed 50.0 mm"
    });
    assert_eq!(value["events"][0], expected);
    let step = &value["steps"][0];
    assert_eq!(
        keys(step),
        [
            "name",
            "increment",
            "increments",
            "status",
            "branches",
            "joints",
            "constraints",
            "energy",
            "min_bend_radius",
            "stable",
            "minimiser"
        ]
    );
    assert_eq!(keys(&step["branches"]), ["trunk", "left", "right", "spare"]);
    assert_eq!(
        keys(&step["branches"]["trunk"]),
        [
            "diameter",
            "bend_radius_limit",
            "axial_stiffness",
            "s",
            "position",
            "d3",
            "d1",
            "force",
            "moment",
            "bend_radius",
            "twist_turns"
        ]
    );
    assert_eq!(step["branches"]["trunk"]["bend_radius_limit"], 0.048);
    assert_eq!(keys(&step["joints"]["J"]), ["position", "orientation"]);
    assert_eq!(keys(&step["constraints"]), ["plug-A", "clip-1", "plug-B", "hand", "magnet <north> & \"south\""]);
    assert_eq!(keys(&step["constraints"]["hand"]), ["kind", "position", "orientation", "force", "moment"]);
    assert_eq!(
        keys(&step["energy"]),
        ["total", "stretch", "shear", "bend", "twist", "gravity", "load", "joint", "constraint"]
    );
    assert_eq!(keys(&step["min_bend_radius"]), ["branch", "s", "value", "limit"]);
    assert_eq!(step["stable"], true);
    assert_eq!(
        keys(&step["minimiser"]),
        ["kind", "iterations", "factorisations", "seconds", "force_residual", "shape_error"]
    );
}

#[test]
fn a_branch_with_friction_has_its_set_and_its_losses() {
    let mut step = y_harness();
    let set: Vec<_> = step.branches[0].s.iter().map(|s| wireloom_core::Vector::new(s / 3.0, -s, 0.1)).collect();
    let friction = wireloom_core::equilibrium::FrictionResult { set, dissipated: 0.1, dissipated_in_all: 1.0 / 3.0 };
    step.branches[0].friction = Some(friction.clone());
    let value = parsed(&run("y", vec![step]));
    let branches = &value["steps"][0]["branches"];
    let own = &branches["trunk"]["friction"];
    assert_eq!(keys(own), ["set", "dissipated", "dissipated_in_all"]);
    assert_eq!(own["dissipated_in_all"].as_f64(), Some(friction.dissipated_in_all));
    assert_eq!(own["set"][3][1].as_f64(), Some(friction.set[3].y));
    assert!(branches["left"].get("friction").is_none());
}

#[test]
fn arms_that_slip_have_their_set_and_their_losses() {
    let mut step = y_harness();
    let arm = slipped();
    step.joints[0].friction = vec![arm.clone()];
    let name = step.joints[0].name.clone();
    let value = parsed(&run("y", vec![step]));
    let own = &value["steps"][0]["joints"][&name]["friction"]["left"];
    assert_eq!(keys(own), ["starts_here", "set", "dissipated", "dissipated_in_all"]);
    assert_eq!(floats(&own["set"]), arm.set.as_slice());
}

#[test]
fn numbers_come_back_bit_for_bit() {
    let step = y_harness();
    let value = parsed(&run("y", vec![step.clone()]));
    let back = &value["steps"][0];
    for branch in &step.branches {
        let b = &back["branches"][&branch.name];
        assert_eq!(floats(&b["s"]), branch.s);
        assert_eq!(b["twist_turns"].as_f64(), Some(branch.twist_turns));
        for i in 0..branch.s.len() {
            let [d1, _, d3] = columns(&branch.frame[i]);
            for (key, expected) in [
                ("position", branch.position[i]),
                ("force", branch.force[i]),
                ("moment", branch.moment[i]),
                ("d1", d1),
                ("d3", d3),
            ] {
                assert_eq!(floats(&b[key][i]), expected.as_slice(), "{key}");
            }
            let radius = branch.bend_radius[i];
            assert_eq!(b["bend_radius"][i].as_f64(), radius.is_finite().then_some(radius));
        }
    }
    assert_eq!(floats(&back["joints"]["J"]["orientation"]), [1.0, 0.0, 0.0, 0.0]);
    assert_eq!(floats(&back["constraints"]["hand"]["force"]), [0.0, 0.0, 7.25]);
    assert_eq!(back["energy"]["total"].as_f64(), Some(step.energy.total()));
    assert_eq!(back["energy"]["twist"].as_f64(), Some(1e-17));
    assert_eq!(back["minimiser"]["force_residual"].as_f64(), Some(1.25e-9));
    assert_eq!(back["minimiser"]["shape_error"].as_f64(), Some(3.5e-10));
    assert_eq!(back["min_bend_radius"]["value"].as_f64(), step.min_bend_radius.map(|bend| bend.value));
}

#[test]
fn what_is_not_finite_is_null() {
    let value = parsed(&run("broken", vec![broken()]));
    let step = &value["steps"][0];
    assert_eq!(step["status"], "failed");
    assert_eq!(step["stable"], Value::Null);
    assert_eq!(step["branches"]["trunk"]["position"][10], serde_json::json!([null, 0.0, 0.0]));
    assert_eq!(step["branches"]["left"]["force"][0], serde_json::json!([null, 0.0, 0.0]));
    assert_eq!(step["energy"]["bend"], Value::Null);
    assert_eq!(step["energy"]["total"], Value::Null);
    assert_eq!(step["minimiser"]["force_residual"], Value::Null);
}

#[test]
fn absent_things_are_null_or_empty() {
    assert_eq!(parsed(&run("", vec![]))["steps"], serde_json::json!([]));
    let mut empty = step(vec![], vec![], vec![]);
    let value = parsed(&run("", vec![empty.clone()]));
    assert_eq!(value["steps"][0]["branches"], serde_json::json!({}));
    assert_eq!(value["steps"][0]["min_bend_radius"], Value::Null);
    empty.min_bend_radius = Some(TightestBend { branch: "b".into(), s: 0.5, value: 0.1, limit: None });
    empty.constraints.push(crate::samples::constraint("c", "collar", v(0.0, 0.0, 0.0), v(0.0, 0.0, 0.0)));
    let value = parsed(&run("", vec![empty]));
    assert_eq!(
        value["steps"][0]["min_bend_radius"],
        serde_json::json!({"branch": "b", "s": 0.5, "value": 0.1, "limit": null})
    );
}

#[test]
fn operations_say_what_they_came_to() {
    let mut step = y_harness();
    let at = Some(("trunk".to_owned(), 0.25));
    step.operations = vec![
        OperationResult::Grasp { constraint: "hand".into(), place: at.clone() },
        OperationResult::Carry { constraints: vec!["hand".into(), "plug-B".into()], force: 1.5 },
        OperationResult::Mate {
            constraint: "plug-B".into(),
            insertion_force: Some(31.5),
            own: Some(15.0),
            limit: Some(45.0),
        },
        OperationResult::Mate { constraint: "plug-A".into(), insertion_force: None, own: None, limit: None },
        OperationResult::Clip { constraint: "clip-1".into(), place: at, reach: 0.125 },
        OperationResult::Clip { constraint: "clip-J".into(), place: None, reach: 0.5 },
    ];
    let expected = serde_json::json!([
        { "operation": "grasp", "constraint": "hand", "branch": "trunk", "s": 0.25 },
        { "operation": "carry", "constraints": ["hand", "plug-B"], "force": 1.5 },
        { "operation": "mate", "constraint": "plug-B", "insertion_force": 31.5, "own": 15.0, "limit": 45.0 },
        { "operation": "mate", "constraint": "plug-A", "insertion_force": null, "limit": null },
        { "operation": "clip", "constraint": "clip-1", "branch": "trunk", "s": 0.25, "reach": 0.125 },
        { "operation": "clip", "constraint": "clip-J", "reach": 0.5 },
    ]);
    assert_eq!(parsed(&run("y-harness", vec![step]))["steps"][0]["operations"], expected);
}

#[test]
fn obstacles_say_what_they_exert_and_clearances_where_they_are() {
    let value = parsed(&among_obstacles());
    let floor = &value["steps"][0]["obstacles"]["floor"];
    assert_eq!(keys(floor), ["position", "orientation", "force", "moment", "contact_force", "contacts", "depth"]);
    assert_eq!((floats(&floor["force"]), &floor["contacts"]), (vec![0.0, 0.25, 1.5], &serde_json::json!(7)));
    let [to_post, to_left] = value["clearance"].as_array().unwrap().as_slice() else {
        panic!("{}", value["clearance"])
    };
    assert_eq!(keys(to_post), ["branch", "s", "position", "obstacle", "distance", "required", "at"]);
    assert_eq!((&to_post["obstacle"], &to_post["required"]), (&"post".into(), &0.006.into()));
    assert_eq!(to_post["at"], serde_json::json!({ "step": "equilibrium", "step_index": 0, "increment": 1 }));
    assert_eq!(keys(to_left), ["branch", "s", "position", "other", "other_s", "distance", "required", "at"]);
    assert_eq!((&to_left["other"], &to_left["other_s"]), (&"left".into(), &0.125.into()));
    let without = parsed(&run("alone", vec![y_harness()]));
    assert!(without.get("clearance").is_none() && without["steps"][0].get("obstacles").is_none());
}
