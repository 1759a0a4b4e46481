//! Mechanisms in whole runs: what is mounted on their bodies goes with them, in every kind of step.

use std::f64::consts::PI;
use wireloom::geometry::Vector;
use wireloom::result::{OperationResult, Verdict};
use wireloom::{Control, Run, Status, StepResult};
use wireloom_tests::cables::{branch, built, connector, connector_along, section};
use wireloom_tests::place::Place;
use wireloom_tests::root;

/// A cable from a pillar to a door that is drawn shut; its hinge, at x = 0.1 m, is along z.
fn door(more: &str) -> String {
    [
        "schema = 1\nname = \"door\"\n",
        &section("cable"),
        &branch("loop", ["pillar", "lock"], "cable", 0.6, 30),
        "[[mechanisms]]\nname = \"door\"\n[[mechanisms.joints]]\nname = \"hinge\"\nkind = \"revolute\"\n\
         between = [\"ground\", \"door\"]\norigin = [0.1, 0, 0]\naxis = [0, 0, 1]\n",
        &connector_along("pillar plug", "pillar", [0.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]),
        more,
    ]
    .concat()
}

fn door_plug() -> String {
    connector_along("door plug", "lock", LOCK, [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]) + "mount = \"door\"\n"
}

const LOCK: [f64; 3] = [0.35, -0.05, 0.02];

/// A step that drives the hinge.
fn drive(name: &str, increments: usize, value: &str) -> String {
    format!("[[steps]]\nname = \"{name}\"\nincrements = {increments}\ndrive = [{{ joint = \"hinge\", {value} }}]\n")
}

fn converged(text: &str) -> Run {
    let built = built(text);
    let run = wireloom::run(built, &mut |_, _| Control::Continue);
    assert_eq!(run.status(), Status::Converged, "{:?} {:?}", run.notes, run.steps.last().map(|step| &step.name));
    run
}

/// A point of the door that is drawn at x, with the door open by an angle.
fn on_door(x: [f64; 3], angle: f64) -> Vector {
    let (s, c) = angle.sin_cos();
    let (u, v) = (x[0] - 0.1, x[1]);
    Vector::new(0.1 + c * u - s * v, s * u + c * v, x[2])
}

fn lock(step: &StepResult) -> Vector {
    *step.branches[0].position.last().expect("nodes")
}

fn value(step: &StepResult) -> f64 {
    step.mechanisms[0].joints[0].1[0]
}

fn apart(a: &StepResult, b: &StepResult) -> f64 {
    let nodes = a.branches[0].position.iter().zip(&b.branches[0].position);
    nodes.map(|(x, y)| (x - y).norm()).fold(0.0, f64::max)
}

#[test]
fn every_increment_is_on_the_arc_and_each_value_of_at_has_a_result() {
    let text = door(&(door_plug() + &drive("open", 4, "at = [\"15 deg\", \"30 deg\", \"70 deg\"]")));
    let run = converged(&text);
    let degrees = |step: &StepResult| value(step).to_degrees();
    let at: Vec<(usize, f64)> = run.steps.iter().map(|step| (step.increment, degrees(step))).collect();
    for (k, (increment, expected)) in [(4, 15.0), (8, 30.0), (12, 70.0)].into_iter().enumerate() {
        assert_eq!(at[k].0, increment);
        assert!((at[k].1 - expected).abs() < 1e-12);
    }
    assert_eq!(run.steps.len(), 3);
    let all = converged(&text.replacen("schema = 1", "schema = 1\noutput = { increments = true }", 1));
    assert_eq!(all.steps.len(), 12);
    for step in &all.steps {
        let error = (lock(step) - on_door(LOCK, value(step))).norm();
        assert!(error < 1e-12, "{error:e} at {}", degrees(step));
    }
    // The third of them is no chord from the second to the end.
    assert!((degrees(&all.steps[2]) - 11.25).abs() < 1e-9);
}

#[test]
fn a_door_that_opens_and_shuts_two_hundred_times_comes_back() {
    let cycles: String =
        (0..200).map(|k| drive(&format!("open {k}"), 2, "to = 1.2") + &drive("shut", 2, "to = 0")).collect();
    // Names of steps must differ.
    let cycles = (0..200).fold(cycles, |text, k| text.replacen("\"shut\"", &format!("\"shut {k}\""), 1));
    let run = converged(&door(&(door_plug() + &cycles)));
    let shut: Vec<&StepResult> = run.steps.iter().filter(|step| step.name.starts_with("shut")).collect();
    assert_eq!(shut.len(), 200);
    assert!(shut.iter().all(|step| value(step) == 0.0));
    let drift = shut.iter().map(|step| apart(step, shut[0])).fold(0.0, f64::max);
    assert!(drift < 1e-9, "{drift:e}");
}

/// A cable that rubs in a grommet does not come back at once: it shakes down.
#[test]
fn with_friction_the_first_cycles_leave_a_drift_that_results_show() {
    let text = std::fs::read_to_string(root().join("scenarios/mechanisms/door.toml")).expect("a text");
    let (harness, _) = text.split_once("[[steps]]").expect("steps");
    let grommet = "[[obstacles]]\nname = \"grommet\"\nshape = \"torus\"\nring_radius = 0.014\nradius = 0.006\n\
                   position = [0, -0.05, 0]\ntangent = [0, 1, 0]\nfriction = 0.4\n";
    let cycle = |k: usize| drive(&format!("open {k}"), 3, "to = 1.2") + &drive(&format!("shut {k}"), 3, "to = 0");
    let run = converged(&[harness, grommet, &cycle(0), &cycle(1), &cycle(2), &cycle(3)].concat());
    let shut: Vec<&StepResult> = run.steps.iter().filter(|step| step.name.starts_with("shut")).collect();
    let [first, second] = [apart(shut[0], shut[1]), apart(shut[1], shut[2])];
    assert!(first > 1e-8 && second < 0.5 * first, "{first:e}, {second:e}");
}

/// A clip and a plug that begin on the open door are given as the door is drawn; the same harness with their places in
/// the world takes the same shapes and forces.
#[test]
fn what_begins_on_an_open_door_is_where_it_is_drawn_when_the_door_shuts() {
    let seat = [0.3, -0.12, 0.0];
    let installed = |plug: [f64; 3], clip: [f64; 3], along: [f64; 3], mount: &str| {
        format!(
            "[[steps]]\nname = \"install\"\nincrements = 6\n[[steps.mate]]\nname = \"door plug\"\n\
             at = {{ end = \"lock\" }}\nposition = {plug:?}\ntangent = {along:?}\nup = [0, 0, -1]\n\
             insertion_force = 5\n{mount}\
             [[steps]]\nname = \"clip\"\nincrements = 4\n[[steps.clip]]\nname = \"clip\"\n\
             at = {{ branch = \"loop\" }}\nposition = {clip:?}\ntangent = {along:?}\n{mount}"
        )
    };
    let on_body = installed(LOCK, seat, [0.0, 1.0, 0.0], "mount = \"door\"\n");
    let run = converged(&door(&(drive("open", 4, "to = 1.2") + &on_body + &drive("shut", 4, "to = 0"))));
    let clip = |step: &StepResult| {
        step.constraints.iter().find(|constraint| constraint.name == "clip").expect("it acts").position
    };
    let [open, install, clipped, shut] = &run.steps[..] else { panic!() };
    assert_eq!([open, install, clipped, shut].map(value), [1.2, 1.2, 1.2, 0.0]);
    assert!((lock(install) - on_door(LOCK, 1.2)).norm() < 1e-12);
    assert!((lock(shut) - Vector::from(LOCK)).norm() < 1e-12);
    assert!((clip(clipped) - on_door(seat, 1.2)).norm() < 1e-12);
    assert!((clip(shut) - Vector::from(seat)).norm() < 1e-12);
    let along = on_door([0.1, 1.0, 0.0], 1.2) - on_door([0.1, 0.0, 0.0], 1.2);
    let [plug, at] = [LOCK, seat].map(|x| on_door(x, 1.2).into());
    let reference = converged(&door(&installed(plug, at, along.into(), "")));
    // Their meshes differ, as the clip has another provisional place, and 30 segments are coarse beside it.
    for (step, reference, limit) in [(install, &reference.steps[0], 2e-3), (clipped, &reference.steps[1], 0.2)] {
        for (own, other) in step.constraints.iter().zip(&reference.constraints) {
            let difference = (own.force - other.force).norm();
            assert!(difference < limit * other.force.norm(), "{}: {difference:e} N of {}", own.name, other.force);
        }
    }
    match [clipped, &reference.steps[1]].map(|step| &step.operations[0]) {
        [
            OperationResult::Clip { place: Some((_, s)), reach, .. },
            OperationResult::Clip { place: Some((_, other)), reach: far, .. },
        ] => assert!((s - other).abs() < 1e-4 && (reach - far).abs() < 1e-3, "{s}, {reach} and {other}, {far}"),
        other => panic!("{other:?}"),
    }
    match [install, &reference.steps[0]].map(|step| &step.operations[0]) {
        [
            OperationResult::Mate { insertion_force: Some(force), .. },
            OperationResult::Mate { insertion_force: Some(other), .. },
        ] => assert!((force - other).abs() < 2e-3 * other, "{force} and {other}"),
        other => panic!("{other:?}"),
    }
}

/// Moves of what is mounted are relative to its body, also while that moves.
#[test]
fn a_mounted_handle_moves_against_its_body_while_the_body_turns() {
    let step = "[[steps]]\nname = \"both\"\nincrements = 5\ndrive = [{ joint = \"hinge\", to = 1.0 }]\n\
                move = [{ constraint = \"door plug\", position = [0.45, -0.05, 0.02] }]\n";
    let text = door(&(door_plug() + step)).replacen("schema = 1", "schema = 1\noutput = { increments = true }", 1);
    let run = converged(&text);
    for (k, step) in run.steps.iter().enumerate() {
        let t = (k + 1) as f64 / 5.0;
        assert!((lock(step) - on_door([0.35 + 0.1 * t, -0.05, 0.02], t)).norm() < 1e-12);
    }
}

/// A hand in the world and a plug on the door hold the same end: the door would tear it off.
#[test]
fn a_hand_that_holds_what_the_door_carries_away_is_refused() {
    let hand = "[[constraints]]\nname = \"hand\"\nkind = \"handle\"\n\
                at = { end = \"lock\" }\nposition = [0.35, -0.05, 0.02]\n";
    let stands = door(&(door_plug() + hand));
    converged(&stands);
    let text = stands + &drive("open", 4, "to = 1.2");
    let faults = wireloom::load(&text, &wireloom::registry()).err().expect("it is refused");
    let words = wireloom::scenario::render(&text, &faults);
    assert!(words.contains("\"door plug\" and \"hand\" hold the position at s = 0.6 m"), "{words}");
}

/// The door's panel pushes a cable that hangs beside it: the obstacle goes along its arc, too.
#[test]
fn an_obstacle_on_a_body_pushes_the_cable_along_its_arc() {
    let bar = "[[obstacles]]\nname = \"bar\"\nshape = \"cylinder\"\nradius = 0.01\nlength = 0.4\n\
               position = [0.1, 0.2, 0]\nmount = \"door\"\n";
    let free = connector("door plug", "lock", [0.2, 0.3, 0.0]);
    let text = door(&(free + bar + &drive("swing", 12, "to = -1.0")));
    let run = converged(&text);
    let end = run.steps.last().expect("a step");
    let center = end.obstacles[0].pose.position;
    assert!((center - on_door([0.1, 0.2, 0.0], -1.0)).norm() < 1e-12);
    // It has met the cable, and the cable has not passed through it.
    assert!(end.obstacles[0].contact_force > 0.0, "{:?}", end.obstacles[0]);
    assert!(end.obstacles[0].depth < 1e-5);
}

/// The same drive from a table: there and back again in one step.
#[test]
fn a_table_drives_a_joint_over_time() {
    let place = Place::new(&door(&(door_plug() + &drive("swing", 8, "path = \"hinge.csv\""))));
    place.file("hinge.csv", "t [s], value [deg]\n0, 0\n1, 40\n2, 60\n4, 20\n");
    let ended = place.run(&["run", "s.toml", "--out", "o", "--set", "output.increments=true"]);
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let result = place.result("o");
    let steps = result["steps"].as_array().expect("steps");
    let angle = |k: usize| steps[k]["mechanisms"]["door"]["hinge"][0].as_f64().expect("a number") * 180.0 / PI;
    for (k, degrees) in [20.0, 40.0, 50.0, 60.0, 50.0, 40.0, 30.0, 20.0].into_iter().enumerate() {
        assert!((angle(k) - degrees).abs() < 1e-12, "{k}");
    }
    place.file("hinge.csv", "t, value [deg]\n0, 10\n1, 40\n");
    place.run(&["check", "s.toml"]).says(1, &["begins at 10.000 deg, and the joint stands at 0.000 deg"]);
    place.file("hinge.csv", "t, value [mm]\n0, 0\n0, 40\n1, none\n");
    place.run(&["check", "s.toml"]).says(1, &["`value [mm]` has a unit that does not fit"]);
}

/// Robots whose files are broken in every way that the format allows are refused with their line.
#[test]
fn a_urdf_file_is_refused_with_its_line() {
    let robot =
        |inside: &str| format!("<robot name=\"r\">\n<link name=\"a\"/>\n<link name=\"b\"/>\n{inside}\n</robot>");
    let joint = |kind: &str, more: &str| {
        format!("<joint name=\"j\" type=\"{kind}\"><parent link=\"a\"/><child link=\"b\"/>{more}</joint>")
    };
    let text = door(&(door_plug() + "[[mechanisms]]\nname = \"robot\"\nurdf = \"r.urdf\"\n"));
    let place = Place::new(&text);
    for (file, words) in [
        ("no xml".to_owned(), "r.urdf:1: "),
        ("<sdf/>".to_owned(), "r.urdf:1: <sdf> is not <robot>"),
        (robot(""), "r.urdf:1: there are no joints"),
        (robot(&joint("ball", "")), "r.urdf:4: joint \"j\" has the type \"ball\""),
        (robot(&joint("revolute", "<axis xyz=\"0 0\"/>")), "r.urdf:4: xyz=\"0 0\" is not three numbers"),
        (robot(&joint("revolute", "<axis xyz=\"0 0 0\"/>")), "r.urdf:4: the axis is zero"),
        (
            robot(&joint("revolute", "<limit lower=\"1\" upper=\"x\"/>")),
            "r.urdf:4: upper=\"x\" has what is not a number",
        ),
        (robot(&joint("revolute", "<origin xyz=\"0 0 1e300\"/>")), "r.urdf:4: xyz=\"0 0 1e300\" is out of range"),
        (robot(&joint("revolute", "<mimic joint=\"j\" multiplier=\"1e99\"/>")), "multiplier=\"1e99\" is out of range"),
        (robot(&joint("revolute", "<mimic joint=\"k\"/>")), "r.urdf:4: joint \"j\" mimics in a way"),
        (robot(&joint("revolute", "").replace("link=\"b\"", "link=\"c\"")), "r.urdf:4: there is no link \"c\""),
        (robot(&joint("fixed", "<mimic joint=\"j\"/>")), "r.urdf:4: joint \"j\" mimics in a way"),
        (robot(&(joint("fixed", "") + &joint("fixed", ""))), "r.urdf:4: there are two joints \"j\""),
    ] {
        place.file("r.urdf", &file);
        place.run(&["check", "s.toml"]).says(1, &[words]);
    }
    place.file("r.urdf", robot(&joint("revolute", "<axis xyz=\"0 0 2\"/>")));
    assert_eq!(place.run(&["check", "s.toml"]).code, Some(0));
}

/// A robot that is drawn with its joints bent, one of which another one follows with an offset: its links stand as
/// those of a chain of turns, and the hand goes on from there.
#[test]
fn a_robot_drawn_bent_stands_and_moves_as_its_joints_say() {
    let joint = |name: &str, links: [&str; 2], inside: &str| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><origin xyz=\"0.2 0 0\"/><axis xyz=\"0 0 1\"/>\
             <parent link=\"{}\"/><child link=\"{}\"/>{inside}</joint>",
            links[0], links[1]
        )
    };
    let robot = [
        "<robot name=\"r\"><link name=\"base\"/><link name=\"arm\"/><link name=\"hand\"><visual><origin \
         xyz=\"0.1 0 0\"/><geometry><sphere radius=\"0.01\"/></geometry></visual></link>",
        &joint("elbow", ["arm", "hand"], "<mimic joint=\"turn\" multiplier=\"-2\" offset=\"0.1\"/>"),
        &joint("turn", ["base", "arm"], "<limit lower=\"-1\" upper=\"1\"/>"),
        "</robot>",
    ]
    .concat();
    let text = door(
        "[[constraints]]\nname = \"lock plug\"\nkind = \"connector\"\nat = { end = \"lock\" }\n\
         position = [0.35, -0.05, 0.02]\ntangent = [0, 1, 0]\nup = [0, 0, 1]\n\
         [[mechanisms]]\nname = \"robot\"\nurdf = \"pack/urdf/r.urdf\"\nposition = [5, 0, 0]\n\
         obstacles = \"visual\"\ndrawn = [{ joint = \"turn\", value = \"30 deg\" }]\n\
         [[steps]]\nname = \"on\"\nincrements = 2\ndrive = [{ joint = \"turn\", to = 0.8 }]\n",
    );
    let place = Place::new(&text);
    place.file("pack/urdf/r.urdf", &robot);
    let tip = |turn: f64| {
        let elbow = 0.1 - 2.0 * turn;
        let along = |length: f64, angle: f64| Vector::new(length * angle.cos(), length * angle.sin(), 0.0);
        Vector::new(5.2, 0.0, 0.0) + along(0.2, turn) + along(0.1, turn + elbow)
    };
    place.run(&["run", "s.toml", "--out", "out"]).says(0, &[]);
    let result = place.result("out");
    let [x, y, z] = [0, 1, 2].map(|k| result["steps"][0]["obstacles"]["robot/hand"]["position"][k].as_f64().unwrap());
    let error = (Vector::new(x, y, z) - tip(0.8)).norm();
    assert!(error < 1e-12, "{error:e}: {x} {y} {z}");
    let values = &result["steps"][0]["mechanisms"]["robot"];
    assert!(values.to_string().contains("0.8"), "{values}");
    // The joint that follows it would stand at −0.95 rad.
    let stiff = robot.replace("<mimic", "<limit lower=\"-0.9\" upper=\"0.9\"/><mimic");
    place.file("pack/urdf/r.urdf", &stiff);
    place.run(&["check", "s.toml"]).says(1, &["joint \"elbow\" is drawn at -54.270 deg"]);
    // A mesh in its package, and what is refused.
    let mesh = robot.replace("<sphere radius=\"0.01\"/>", "<mesh filename=\"package://pack/m/tip.stl\"/>");
    for (file, words) in [
        (mesh.clone(), "cannot read \"pack/m/tip.stl\""),
        (mesh.replace("package", "model"), "filename=\"model://pack/m/tip.stl\" begins with model://"),
        (mesh.replace("tip.stl\"", "tip.stl\" scale=\"1 1 2\""), "the scale differs along the axes"),
        (robot.replace("sphere radius=\"0.01\"", "cone"), "<cone> is not a known shape"),
        (robot.replace("radius=\"0.01\"", "radius=\"0\""), "radius=\"0\" is not greater than 0"),
    ] {
        place.file("pack/urdf/r.urdf", &file);
        place.run(&["check", "s.toml"]).says(1, &[words]);
    }
    place.file("pack/urdf/r.urdf", &robot);
    for (drawn, words) in [
        ("joint = \"turn\", value = 1.2", "is drawn at 68.755 deg, and its limits are -57.296 deg and 57.296 deg"),
        ("joint = \"elbow\", value = 0.1", "joint \"elbow\" follows another one"),
        ("joint = \"trun\", value = 0.1", "did you mean `turn`?"),
        ("joint = \"turn\", value = [1, 2]", "gives 2 values"),
        ("joint = \"turn\", value = 0.1 }, { joint = \"turn\", value = 0.2", "has two values as drawn"),
    ] {
        place.file("s.toml", text.replace("joint = \"turn\", value = \"30 deg\"", drawn));
        place.run(&["check", "s.toml"]).says(1, &[words]);
    }
}

/// A marker on the open door against the derivative of its arc, by the angle and by the hinge's place.
#[test]
fn derivatives_by_an_angle_are_those_of_the_arc() {
    let marker = "[[markers]]\nname = \"m\"\nat = { branch = \"loop\", s = 0.6 }\n";
    let place = Place::new(&door(&(door_plug() + marker + &drive("open", 4, "to = 0.8"))));
    let by = ["steps.open.drive.0.to", "mechanisms.door.joints.hinge.origin.0"];
    let of = ["position_x.m", "position_y.m"];
    let ended = place.run(&["sensitivities", "s.toml", "--of", of[0], of[1], "--by", by[0], by[1], "--json"]);
    let found: serde_json::Value = serde_json::from_str(&ended.out).expect("JSON");
    let (s, c) = 0.8_f64.sin_cos();
    let (u, v) = (LOCK[0] - 0.1, LOCK[1]);
    for (output, exact) in [[-s * u - c * v, 1.0 - c], [c * u - s * v, -s]].into_iter().enumerate() {
        for (key, exact) in exact.into_iter().enumerate() {
            let value = found["outputs"][output]["by"][key]["value"].as_f64().expect("a number");
            assert!((value - exact).abs() < 1e-7 * exact.abs(), "{} by {}: {value} and {exact}", of[output], by[key]);
        }
    }
}

/// A post beside the arc of the plug of a door: the plug, turned outward, comes 35 mm near to its middle, whatever the
/// increments. A required clearance above that is broken in all of them, and one below in none.
#[test]
fn a_post_beside_the_arc_of_a_door_is_not_missed_between_increments() {
    let arc = Vector::from(LOCK) - Vector::new(0.1, 0.0, LOCK[2]);
    let post = on_door((Vector::from(LOCK) + arc.normalize() * 0.035).into(), 0.7);
    // Less the radii of the post and the cable.
    let least = 0.035 - 0.02 - 0.003;
    let worst = |increments: usize, min: f64| {
        let surroundings = format!(
            "[[obstacles]]\nname = \"post\"\nshape = \"sphere\"\nradius = 0.02\nposition = [{}, {}, {}]\n\
             [[requirements]]\nname = \"free\"\nquantity = \"clearance\"\n\
             between = [{{ branch = \"loop\" }}, {{ obstacle = \"post\" }}]\nmin = {min}\n",
            post.x, post.y, post.z
        );
        let plug = connector_along("door plug", "lock", LOCK, arc.into(), [0.0, 0.0, 1.0]) + "mount = \"door\"\n";
        let run = converged(&door(&(plug + &surroundings + &drive("open", increments, "to = \"85 deg\""))));
        let line = run.requirements.iter().find(|line| line.name == "free").expect("it is there");
        (line.verdict, line.worst.expect("it was checked"))
    };
    for increments in [1, 2, 3, 4, 9] {
        let (verdict, value) = worst(increments, 1.5 * least);
        assert_eq!(verdict, Verdict::Fail, "{increments}: {value}");
        let (verdict, value) = worst(increments, 0.7 * least);
        assert_eq!(verdict, Verdict::Pass, "{increments}: {value}");
        assert!(value > least - 1e-6, "{increments}: {value}");
    }
}

/// A door that turns by 50° against a slack cable in its way takes the cable along, whatever the increments: with few
/// of them it once went through.
#[test]
fn a_door_pushes_a_cable_and_does_not_go_through_it_in_few_increments() {
    let down =
        |name: &str, end: &str, z: f64| connector_along(name, end, [0.3, 0.05, z], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]);
    for increments in [1, 2, 3, 7] {
        let text = [
            "schema = 1\nname = \"push\"\n",
            &section("cable"),
            &branch("cable", ["A", "B"], "cable", 0.8, 60),
            &down("plug A", "A", 0.3),
            &down("plug B", "B", -0.35),
            "[[mechanisms]]\nname = \"door\"\n[[mechanisms.joints]]\nname = \"hinge\"\nkind = \"revolute\"\n\
             between = [\"ground\", \"door\"]\norigin = [0, 0, 0]\naxis = [0, 0, 1]\n\
             [[obstacles]]\nname = \"leaf\"\nshape = \"box\"\nsize = [0.6, 0.02, 0.2]\nposition = [0.3, 0, 0]\n\
             mount = \"door\"\n",
            &drive("push", increments, "to = \"50 deg\""),
        ]
        .concat();
        let run = converged(&text);
        let middle = run.steps[0].branches[0].position.iter().min_by(|a, b| a.z.abs().total_cmp(&b.z.abs()));
        let angle = middle.map(|x| x.y.atan2(x.x).to_degrees()).expect("nodes");
        assert!(angle > 50.0, "with {increments} increments the door is at 50°, the cable at {angle:.1}°");
    }
}
