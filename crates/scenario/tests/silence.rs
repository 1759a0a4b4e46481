//! What was once read in silence and had no effect, or another one than was meant.

mod common;

use wireloom_scenario::{Fault, Files, Scenario, parse_with_files, render};

const HARNESS: &str = concat!(include_str!("section.toml"), include_str!("branch.toml"));

/// A robot with one joint, whose limits do not have 0 between them, and a mesh of 0.2 mm.
struct Beside;

impl Files for Beside {
    fn read(&self, path: &str) -> Result<String, String> {
        match path {
            "robot.urdf" => Ok("<robot name=\"r\"><link name=\"a\"/>\n<link name=\"b\"><collision><geometry>\
                <sphere radius=\"0.1\"/></geometry></collision></link>\n<joint name=\"j\" type=\"revolute\">\
                <parent link=\"a\"/><child link=\"b\"/><limit lower=\"0.2\" upper=\"1\"/></joint></robot>"
                .into()),
            "tiny.obj" => {
                Ok("v 0 0 0\nv 2e-4 0 0\nv 0 2e-4 0\nv 0 0 2e-4\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n".into())
            }
            _ => Err("no such file".into()),
        }
    }
}

fn parse(more: &str) -> Result<Scenario, (String, Vec<Fault>)> {
    let text = format!("{HARNESS}{more}");
    parse_with_files(&text, &Beside, &common::registry()).map_err(|faults| (text, faults))
}

/// The faults, as lines without their place, and what stands at each place.
#[track_caller]
fn refused(more: &str) -> Vec<(String, String)> {
    let (text, faults) = parse(more).err().unwrap_or_else(|| panic!("{more} is not refused"));
    let one = |fault: &Fault| (text[fault.span.clone()].to_owned(), format!("{}; {}", fault.message, fault.help));
    faults.iter().map(one).collect()
}

#[track_caller]
fn notes(more: &str) -> Vec<String> {
    let scenario = parse(more).unwrap_or_else(|(text, faults)| panic!("{}", render(&text, &faults)));
    scenario.build(&common::registry()).unwrap_or_else(|faults| panic!("{faults:?}")).notes
}

const HINGE: &str = "[[mechanisms.joints]]\nname = \"hinge\"\nkind = \"revolute\"\nbetween = [\"ground\", \"door\"]\n\
                     axis = [0, 0, 1]\n";

#[test]
fn what_belongs_to_a_urdf_file_is_refused_beside_joints_not_ignored() {
    let drawn = "drawn = [{ joint = \"hinge\", value = \"30 deg\" }]\nobstacles = \"collision\"\n";
    let found = refused(&format!("[[mechanisms]]\nname = \"door\"\n{drawn}{HINGE}"));
    let [(place, words), (other, more)] = &found[..] else { panic!("{found:#?}") };
    assert!(place.starts_with("[{ joint") && other == "\"collision\"", "{found:#?}");
    assert_eq!(
        words,
        "mechanism \"door\" has `drawn` but no `urdf`; leave it out, and give each joint its own `drawn`"
    );
    assert!(
        more.contains("has `obstacles` but no `urdf`; leave it out, and give each shape as [[obstacles]]"),
        "{more}"
    );
}

#[test]
fn a_joint_does_not_stand_outside_its_limits_because_nothing_says_how_it_is_drawn() {
    let found = refused(&format!("[[mechanisms]]\nname = \"door\"\n{HINGE}limits = [\"10 deg\", \"75 deg\"]\n"));
    let [(_, words)] = &found[..] else { panic!("{found:#?}") };
    assert_eq!(
        words,
        "joint \"hinge\" is drawn at 0.000 deg, and its limits are 10.000 deg and 75.000 deg; \
         add `drawn`, with a value within its limits: the default is 0"
    );
    let robot = "[[mechanisms]]\nname = \"arm\"\nurdf = \"robot.urdf\"\n";
    let found = refused(robot);
    let [(_, words)] = &found[..] else { panic!("{found:#?}") };
    assert!(words.contains("joint \"j\" is drawn at 0.000 deg, and its limits are 11.459 deg and"), "{words}");
    assert!(words.contains("give it a value within its limits in `drawn`: the default is 0"), "{words}");
    assert!(parse(&format!("{robot}drawn = [{{ joint = \"j\", value = 0.5 }}]\n")).is_ok());
}

#[test]
fn a_robot_without_shapes_of_the_kind_asked_for_is_told() {
    let robot = "[[mechanisms]]\nname = \"arm\"\nurdf = \"robot.urdf\"\ndrawn = [{ joint = \"j\", value = 0.5 }]\n";
    let found = notes(&format!("{robot}obstacles = \"visual\"\n"));
    let what = "mechanism \"arm\": no link of robot.urdf has a <visual> shape, so none is an obstacle; if the links \
                have <collision> shapes, write obstacles = \"collision\"";
    assert!(found.iter().any(|note| note == what), "{found:#?}");
    let found = notes(&format!("{robot}obstacles = \"collision\"\n"));
    assert!(!found.iter().any(|note| note.contains("shape")), "{found:#?}");
}

#[test]
fn a_mesh_that_is_smaller_than_a_cable_by_its_unit_is_told() {
    let mesh = "[[obstacles]]\nname = \"panel\"\nmesh = \"tiny.obj\"\n";
    let found = notes(&format!("{mesh}scale = 0.001\n"));
    let what = "obstacle \"panel\": it is 0.00 mm large, less than the radius of the thinnest cable";
    assert!(found.iter().any(|note| note.starts_with(what)), "{found:#?}");
    let found = notes(&format!("{mesh}scale = 1000\n"));
    assert!(!found.iter().any(|note| note.contains("large")), "{found:#?}");
}

#[test]
fn directions_and_orientations_are_numbers_without_units() {
    let ball = "[[obstacles]]\nname = \"box\"\nshape = \"box\"\nsize = [0.1, 0.1, 0.1]\n";
    for key in ["tangent = [\"0 %\", 0, 1]", "orientation = [1, 0, 0, \"0\"]"] {
        let found = refused(&format!("{ball}{key}\n"));
        let [(place, words)] = &found[..] else { panic!("{found:#?}") };
        assert!(place.starts_with('"') && words.contains("not a number; write a number without quotes"), "{words}");
    }
}

#[test]
fn a_step_that_only_waits_says_so_with_true_or_false() {
    for value in ["\"x\"", "1", "[]"] {
        let found = refused(&format!("[[steps]]\nname = \"night\"\nwait = {value}\nduration = 60\n"));
        assert!(found.iter().any(|(place, words)| place == value && words.contains("not true or false")), "{found:#?}");
    }
}

#[test]
fn control_characters_in_names_are_refused() {
    let [(place, words)] = &refused("[[steps]]\nname = \"a\\u0000b\"\n")[..] else { panic!() };
    assert_eq!(place, "\"a\\u0000b\"");
    assert_eq!(words, "`name` has the control character U+0000; leave it out");
    let [(_, words)] = &refused("[wires.\"a\\nb\"]\nlike = \"FLRY-B 0.5\"\n")[..] else { panic!() };
    assert!(words.contains("a name in `wires` has the control character U+000A"), "{words}");
    // A text may have several lines.
    let text = "[[requirements]]\nname = \"r\"\nquantity = \"tension\"\nbecause = \"one\\ntwo\"\n";
    let faults = refused(text);
    assert!(faults.iter().all(|(_, words)| !words.contains("control character")), "{faults:?}");
}

#[test]
fn a_byte_order_mark_is_no_column() {
    let text = "\u{feff}schema = 7\n";
    let faults = parse_with_files(text, &Beside, &common::registry()).err().unwrap_or_default();
    let said = render(text, &faults);
    assert!(said.contains("\n1:10: `schema` = 7"), "{said}");
}
