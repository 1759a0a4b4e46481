mod splits;

use super::*;
use serde_json::json;

const TEXT: &str = r#"# A harness.
schema = 1

[sections.cable] # of two wires
diameter = "8 mm" # measured

[[branches]] # the trunk
name = "trunk"
from = "A"
to = "J" # the joint
section = "cable"
length = "600 mm" # by the drawing
segments = 60

[[branches]]
name = "left"
from = "J"
to = "B"
section = "cable"
length = 0.4
segments = 40

[[branches]]
name = "right"
from = "J"
to = "C"
section = "cable"
length = 0.4
segments = 40

[[joints]]
name = "J"
arms = [
  { branch = "trunk", direction = [-1, 0, 0], up = [0, 0, 1] }, # from behind
  { branch = "left", direction = [0.866, 0.5, 0], up = [0, 0, 1] },
  { branch = "right", direction = [0.866, -0.5, 0], up = [0, 0, 1] },
]
wires = [{ between = ["trunk", "left"], share = 0.5 }, { between = ["trunk", "right"], share = 0.5 }]

[[constraints]]
name = "plug-A"
kind = "connector"
at = { end = "A" } # in the wall

[[constraints]]
name = "clip"
kind = "collar"
at = { branch = "trunk", s = "300 mm" }

[[requirements]]
name = "trunk bend"
quantity = "bend_radius"
of = { branch = "trunk" }
min = "30 mm"
steps = ["mate"]

[[steps]] # first
name = "mate"
increments = 2
release = ["clip"]
[[steps.add]]
name = "plug-B"
kind = "connector"
at = { end = "B" }

[[steps]]
name = "pull"
[[steps.move]]
constraint = "clip"
position = [0, 0, 1]

[sweep]
vary = { "branches.trunk.length" = { from = 0.5, to = 0.7 } }
"#;

/// The lines that are in one text and not in the other, as often as they are: `-` those that went, `+` those that came.
fn difference(before: &str, after: &str) -> Vec<String> {
    let mut came: Vec<&str> = after.lines().collect();
    let mut lines = Vec::new();
    for line in before.lines() {
        match came.iter().position(|other| *other == line) {
            Some(k) => {
                came.remove(k);
            }
            None => lines.push(format!("-{line}")),
        }
    }
    lines.extend(came.into_iter().map(|line| format!("+{line}")));
    lines.retain(|line| line.len() > 1);
    lines
}

/// The line with the wires of a joint, whose first arm is this one.
fn wires(sign: &str, arm: &str) -> &'static str {
    let to = |other: &str| format!("{{ between = [\"{arm}\", \"{other}\"], share = 0.5 }}");
    format!("{sign}wires = [{}, {}]", to("left"), to("right")).leak()
}

fn message(result: Result<String, Fault>) -> String {
    result.map(|text| format!("taken: {text}")).unwrap_or_else(|fault| format!("{} - {}", fault.message, fault.help))
}

/// A pattern lost the branch that failed, and the requirement passed.
#[test]
fn a_name_that_a_pattern_does_not_fit_any_more_is_refused() {
    let of = |pattern: &str| {
        let keys = format!("quantity = \"bend_radius\"\nof = {{ branches = \"{pattern}\" }}\nmin = 0.05");
        format!("{TEXT}\n[[requirements]]\nname = \"bends\"\n{keys}\n")
    };
    let said = |pattern: &str, to: &str| message(renamed(&of(pattern), Part::Branch, "trunk", to));
    let lost = "requirement \"bends\" is about branches like \"tr*\": \"trunk\", and not \"main\"";
    assert!(said("tr*", "main").contains(lost), "{}", said("tr*", "main"));
    assert!(said("ma*", "main").contains("like \"ma*\": \"main\", and not \"trunk\""), "{}", said("ma*", "main"));
    assert!(said("tr*", "trunk 2").starts_with("taken"), "{}", said("tr*", "trunk 2"));
    assert!(said("trunk", "main").contains("branches = \"main\""), "{}", said("trunk", "main"));
}

#[test]
fn a_part_is_renamed_wherever_it_is_meant_and_nowhere_else() {
    let text = renamed(TEXT, Part::Branch, "trunk", "main.1").expect("a branch");
    assert_eq!(
        difference(TEXT, &text),
        [
            "-name = \"trunk\"",
            "-  { branch = \"trunk\", direction = [-1, 0, 0], up = [0, 0, 1] }, # from behind",
            wires("-", "trunk"),
            "-at = { branch = \"trunk\", s = \"300 mm\" }",
            "-of = { branch = \"trunk\" }",
            "-vary = { \"branches.trunk.length\" = { from = 0.5, to = 0.7 } }",
            "+name = \"main.1\"",
            "+  { branch = \"main.1\", direction = [-1, 0, 0], up = [0, 0, 1] }, # from behind",
            wires("+", "main.1"),
            "+at = { branch = \"main.1\", s = \"300 mm\" }",
            "+of = { branch = \"main.1\" }",
            "+vary = { 'branches.\"main.1\".length' = { from = 0.5, to = 0.7 } }",
        ]
    );
    let text = renamed(TEXT, Part::Vertex, "J", "node").expect("a vertex");
    assert_eq!(
        difference(TEXT, &text),
        [
            "-to = \"J\" # the joint",
            "-from = \"J\"",
            "-from = \"J\"",
            "-name = \"J\"",
            "+to = \"node\" # the joint",
            "+from = \"node\"",
            "+from = \"node\"",
            "+name = \"node\"",
        ]
    );
    let text = renamed(TEXT, Part::Constraint, "clip", "clip-1").expect("a constraint");
    assert_eq!(
        difference(TEXT, &text),
        [
            "-name = \"clip\"",
            "-release = [\"clip\"]",
            "-constraint = \"clip\"",
            "+name = \"clip-1\"",
            "+release = [\"clip-1\"]",
            "+constraint = \"clip-1\"",
        ]
    );
    let text = renamed(TEXT, Part::Section, "cable", "wire").expect("a section");
    assert!(text.contains("[sections.wire] # of two wires\ndiameter") && !text.contains("cable"), "{text}");
    let text = renamed(TEXT, Part::Step, "mate", "plug in").expect("a step");
    assert!(text.contains("steps = [\"plug in\"]") && text.contains("name = \"plug in\""), "{text}");
    let said = |part, from, to| message(renamed(TEXT, part, from, to));
    assert_eq!(said(Part::Branch, "trnk", "x"), "there is no branch \"trnk\" in the text - did you mean `trunk`?");
    let taken = "there is already a constraint \"plug-B\" - choose another name";
    assert_eq!(said(Part::Constraint, "clip", "plug-B"), taken);
    assert!(said(Part::Branch, "left", " ").contains("must have a name"));
}

#[test]
fn a_part_is_deleted_with_all_that_is_of_no_use_without_it() {
    let text = without_part(TEXT, Part::Constraint, "clip").expect("a constraint");
    assert_eq!(
        difference(TEXT, &text),
        [
            "-[[constraints]]",
            "-name = \"clip\"",
            "-kind = \"collar\"",
            "-at = { branch = \"trunk\", s = \"300 mm\" }",
            "-release = [\"clip\"]",
            "-[[steps.move]]",
            "-constraint = \"clip\"",
            "-position = [0, 0, 1]",
            "+wait = true",
        ]
    );
    let text = without_part(TEXT, Part::Branch, "right").expect("a branch");
    let gone = difference(TEXT, &text);
    assert!(
        gone.contains(&"-to = \"C\"".to_owned())
            && gone.iter().all(|line| line.starts_with('-') || line.contains("wires"))
    );
    assert!(text.contains("wires = [{ between = [\"trunk\", \"left\"], share = 0.5 }]"), "{text}");
    // A joint with one branch is an end; what holds it holds that end.
    let held = text.replace("at = { end = \"A\" }", "at = { joint = \"J\" }");
    let text = without_part(&held, Part::Branch, "left").expect("a branch");
    assert!(!text.contains("[[joints]]") && !text.contains("plug-B"), "{text}");
    assert!(text.contains("at = { end = \"J\" }") && text.contains("# the joint"), "{text}");
    let text = without_part(TEXT, Part::Requirement, "trunk bend").expect("a requirement");
    assert!(!text.contains("requirements") && text.contains("[[steps]] # first"), "{text}");
    assert!(message(without_part(TEXT, Part::Obstacle, "wall")).contains("there is no obstacle \"wall\""));
}

#[test]
fn branches_are_added_at_joints_at_ends_and_inside_others() {
    let new =
        |from| NewBranch { name: "tap".into(), from, to: "D".into(), section: "cable".into(), length: json!("120 mm") };
    let entry = [
        "+[[branches]]",
        "+name = \"tap\"",
        "+to = \"D\"",
        "+section = \"cable\"",
        "+length = \"120 mm\"",
        "+max_segment = \"10 mm\"",
    ];
    let added = |from: Attachment, more: &[&str], text: &str| {
        let after = with_branch(text, &new(from)).expect("a place");
        let mut expected: Vec<&str> = entry.iter().chain(more).copied().collect();
        let mut found = difference(text, &after);
        expected.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, expected, "{after}");
        after
    };
    let arm = "+  { branch = \"tap\", direction = [-1, 0, 0], up = [0, 0, 1] },";
    added(Attachment::Joint("J".into()), &[arm, "+from = \"J\""], TEXT);
    let end = [
        "-at = { end = \"B\" }",
        "+at = { joint = \"B\" }",
        "+from = \"B\"",
        "+[[joints]]",
        "+name = \"B\"",
        "+arms = [",
        "+  { branch = \"left\", direction = [-1, 0, 0], up = [0, 0, 1] },",
        "+  { branch = \"tap\", direction = [1, 0, 0], up = [0, 0, 1] },",
        "+]",
    ];
    added(Attachment::End("B".into()), &end, TEXT);
    let text = with_branch(TEXT, &new(Attachment::Branch("left".into(), 0.1))).expect("a place");
    assert!(text.contains("  { branch = \"tap\", direction = [0, -1, 0], up = [0, 0, 1] },\n]"), "{text}");
    assert!(text.contains("name = \"left joint\"") && text.contains("name = \"left 2\""), "{text}");
    let said = |from| message(with_branch(TEXT, &new(from)));
    assert!(said(Attachment::Joint("K".into())).contains("there is no joint \"K\""));
    assert!(said(Attachment::End("J".into())).contains("\"J\" is no free end: 3 branches end there"));
    let at_end = || Attachment::End("B".into());
    let taken = NewBranch { name: "left".into(), ..new(at_end()) };
    assert!(message(with_branch(TEXT, &taken)).contains("there is already a branch \"left\""));
    let taken = NewBranch { to: "A".into(), ..new(at_end()) };
    assert!(message(with_branch(TEXT, &taken)).contains("there is already a vertex \"A\""));
    assert_eq!(unused_name(TEXT, Part::Branch, "left").as_deref(), Ok("left 2"));
    assert_eq!(unused_name(TEXT, Part::Vertex, "D").as_deref(), Ok("D"));
}

/// Arms given by `orientation` were not seen: a new arm lay on one of them.
#[test]
fn a_new_arm_points_away_from_arms_given_by_their_orientation() {
    // "left" begins at the joint along x: d3 is turned from z to x. "trunk" ends there, so its arm points against d3.
    let turned = |branch: &str| format!("{{ branch = \"{branch}\", orientation = [1, 0, 1, 0] }}");
    let text = format!(
        "[[branches]]\nname = \"trunk\"\nfrom = \"A\"\nto = \"J\"\nlength = 1\n\n\
         [[branches]]\nname = \"left\"\nfrom = \"J\"\nto = \"B\"\nlength = 1\n\n\
         [[joints]]\nname = \"J\"\narms = [{}, {}]\n",
        turned("trunk"),
        turned("left")
    );
    let new = NewBranch {
        name: "tap".into(),
        from: Attachment::Joint("J".into()),
        to: "D".into(),
        section: "cable".into(),
        length: json!(0.1),
    };
    let added = with_branch(&text, &new).expect("a place");
    assert!(added.contains("{ branch = \"tap\", direction = [0, -1, 0], up = [0, 0, 1] }"), "{added}");
    let one = text.replace(&format!("[{}, ", turned("trunk")), "[");
    let added = with_branch(&one, &new).expect("a place");
    assert!(added.contains("{ branch = \"tap\", direction = [-1, 0, 0], up = [0, 0, 1] }"), "{added}");
    let said = message(with_branch(&text.replace("[1, 0, 1, 0]", "\"along\""), &new));
    assert!(said.contains("arm \"trunk\" of joint \"J\" has no direction that can be read"), "{said}");
}

/// A joint of a mechanism that has the name of a vertex became an end.
#[test]
fn a_joint_of_a_mechanism_is_no_vertex() {
    let door = "\n[[mechanisms]]\nname = \"door\"\nurdf = \"door.urdf\"\ndrawn = [{ joint = \"J\", value = 0 }]\n";
    let text = without_part(&format!("{TEXT}{door}"), Part::Branch, "left").expect("a branch");
    let text = without_part(&text, Part::Branch, "right").expect("a branch");
    assert!(!text.contains("[[joints]]") && text.contains(door), "{text}");
}

const IDENTITIES: &str = r#"
[[components]]
name = "tape"
branch = "right"
part = "4711"

[[components]]
name = "plug"
connector = "plug-B"
cavity = "2"

[[components]]
name = "seal"
connector = "plug"

[[components]]
name = "splice"
vertex = "B"

[[connections]]
name = "W1"
branches = ["trunk", "left"]
ends = [{ connector = "plug-B", cavity = "1", terminal = "77" }, { connector = "splice" }]

[[connections]]
name = "W2"
branches = ["right"]
"#;

/// Components and connections kept the old name, and the text was refused.
#[test]
fn a_part_is_renamed_in_components_and_connections() {
    let given = format!("{TEXT}{IDENTITIES}");
    let lines = |part, from: &str, to: &str| {
        let text = renamed(&given, part, from, to).expect("a part");
        let lines = difference(&given, &text);
        lines.into_iter().filter(|line| line.starts_with('+')).collect::<Vec<_>>()
    };
    let left = lines(Part::Branch, "left", "arm");
    assert!(left.contains(&"+branches = [\"trunk\", \"arm\"]".to_owned()), "{left:?}");
    assert!(lines(Part::Branch, "right", "arm").contains(&"+branch = \"arm\"".to_owned()));
    assert!(lines(Part::Vertex, "B", "end").contains(&"+vertex = \"end\"".to_owned()));
    let plug = lines(Part::Constraint, "plug-B", "XB");
    let ends = "+ends = [{ connector = \"XB\", cavity = \"1\", terminal = \"77\" }, { connector = \"splice\" }]";
    assert!(plug.contains(&"+connector = \"XB\"".to_owned()) && plug.contains(&ends.to_owned()), "{plug:?}");
}

/// Components and connections still named what was gone, and the text was refused.
#[test]
fn a_part_is_deleted_in_components_and_connections() {
    let given = format!("{TEXT}{IDENTITIES}");
    let text = without_part(&given, Part::Branch, "right").expect("a branch");
    assert!(!text.contains("tape") && text.ends_with("name = \"W2\"\n"), "{text}");
    let text = without_part(&given, Part::Constraint, "plug-B").expect("a constraint");
    assert!(!text.contains("\"plug\"") && !text.contains("seal") && text.contains("splice"), "{text}");
    assert!(text.contains("ends = [{ terminal = \"77\" }, { connector = \"splice\" }]"), "{text}");
    let text = without_part(&given, Part::Branch, "left").expect("a branch");
    assert!(!text.contains("splice") && text.contains("branches = [\"trunk\"]"), "{text}");
}

/// An empty list of branches was left, which is no temperature of anything.
#[test]
fn a_temperature_of_a_deleted_branch_goes_with_it() {
    let heated = "\n[[steps]]\nname = \"heat\"\n[[steps.temperature]]\nchange = 60\nbranches = [\"right\"]\n";
    let text = without_part(&format!("{TEXT}{heated}"), Part::Branch, "right").expect("a branch");
    assert!(text.ends_with("[[steps]]\nname = \"heat\"\nwait = true\n"), "{text}");
    let two = heated.replace("[\"right\"]", "[\"trunk\", \"right\"]");
    let text = without_part(&format!("{TEXT}{two}"), Part::Branch, "right").expect("a branch");
    assert!(text.ends_with("change = 60\nbranches = [\"trunk\"]\n"), "{text}");
}

#[test]
fn an_obstacle_is_moved_in_the_units_of_its_entry_and_turned_instead_of_its_directions() {
    let post = "\n[[obstacles]]\nname = \"post\"\nshape = \"cylinder\"\nradius = \"30 mm\"\nlength = 1\n\
                position = [\"100 mm\", 0.2, \"1 cm\"] # measured\ntangent = [1, 0, 0]\nup = [0, 0, 1]\n";
    let text = format!("{TEXT}{post}");
    let moved = with_pose(&text, "post", Some(&Vector::new(0.15, 0.25, 0.02)), None).expect("an obstacle");
    assert_eq!(
        difference(&text, &moved),
        ["-position = [\"100 mm\", 0.2, \"1 cm\"] # measured", "+position = [\"150 mm\", 0.25, \"2 cm\"] # measured"]
    );
    let turn = Rotation::from_euler_angles(0.0, 0.0, -std::f64::consts::FRAC_PI_2);
    let turned = with_pose(&text, "post", None, Some(&turn)).expect("an obstacle");
    let lines = ["-tangent = [1, 0, 0]", "-up = [0, 0, 1]", "+orientation = [0.7071068, 0, 0, -0.7071068]"];
    assert_eq!(difference(&text, &turned), lines);
    assert!(message(with_pose(&text, "pole", None, None)).contains("pole"));
}

#[test]
fn entries_and_keys_come_and_go_and_comments_stay() {
    let ball = json!({ "name": "ball", "shape": "sphere", "radius": "30 mm", "position": [0.1, 0, 0] });
    let text = with_entry(TEXT, "obstacles", &ball).expect("an entry");
    let lines = "[[obstacles]]\nname = \"ball\"\nshape = \"sphere\"\nradius = \"30 mm\"\nposition = [0.1, 0, 0]\n";
    assert!(text.contains(lines), "{text}");
    assert_eq!(without_part(&text, Part::Obstacle, "ball").as_deref(), Ok(TEXT));
    assert_eq!(without_key(&text, "obstacles.ball").as_deref(), Ok(TEXT));
    let text = without_key(TEXT, "requirements.trunk bend.steps").expect("a key");
    assert_eq!(difference(TEXT, &text), ["-steps = [\"mate\"]"]);
    assert!(message(without_key(TEXT, "branches.x.length")).contains("names no key"));
    assert!(message(with_entry(TEXT, "obstacles", &json!(3))).contains("3 is no entry"));
    assert!(message(with_entry(TEXT, "schema", &ball)).contains("`schema` is no list"));
    let inline = "loads = [\n  { name = \"a\" },\n]\n";
    let text = with_entry(inline, "loads", &json!({ "name": "b" })).expect("an entry");
    assert_eq!(text, "loads = [\n  { name = \"a\" },\n  { name = \"b\" },\n]\n");
}
