//! Checks of freedoms and of contradicting constraints.

mod common;

use wireloom_scenario::{parse, render};

const CABLE: &str = r#"
schema = 1
[sections.s]
diameter = 0.01
linear_density = 0.1
axial_stiffness = 1e4
bending_stiffness = 0.01
torsion_stiffness = 0.01
[[branches]]
name = "b"
from = "A"
to = "B"
section = "s"
length = 1
segments = 10
"#;

const NO_GRAVITY: &str = "gravity = [0, 0, 0]\n";

/// The messages for a cable with this before and behind it; empty where it is accepted.
fn refused(before: &str, behind: &str) -> String {
    let text = format!("{before}{CABLE}{behind}");
    parse(&text, &common::registry()).err().map(|faults| render(&text, &faults)).unwrap_or_default()
}

fn constraint(name: &str, kind: &str, at: &str, more: &str) -> String {
    format!("[[constraints]]\nname = \"{name}\"\nkind = \"{kind}\"\nat = {{ {at} }}\n{more}\n")
}

#[test]
fn one_pin_holds_what_has_weight() {
    let pin = constraint("pin", "handle", "end = \"A\"", "");
    assert_eq!(refused("", &pin), "");
    assert!(refused(NO_GRAVITY, &pin).contains("free to turn about x, y and z"));
}

#[test]
fn gravity_or_a_load_of_the_first_step_counts() {
    let pin = constraint("pin", "handle", "end = \"A\"", "");
    let load = "[[loads]]\nname = \"l\"\nat = { end = \"B\" }\nforce = [0, 0, -1]\nfactor = 0\n";
    let step = |what: &str| format!("{load}{pin}[[steps]]\n{what}\n");
    assert_eq!(refused(NO_GRAVITY, &step("gravity = [0, 0, -9.81]")), "");
    assert_eq!(refused(NO_GRAVITY, &step("load = [{ load = \"l\", factor = 1 }]")), "");
    assert!(refused(NO_GRAVITY, &step("name = \"nothing\"")).contains("free to turn"));
}

#[test]
fn a_connector_holds_everything_and_a_free_collar_all_but_the_twist() {
    assert_eq!(refused(NO_GRAVITY, &constraint("c", "connector", "end = \"A\"", "")), "");
    // At rest the cable lies along z of its start.
    let collar = |more: &str| constraint("c", "collar", "branch = \"b\", s = 0.5", more);
    assert!(refused(NO_GRAVITY, &collar("")).contains("free to turn about z"));
    assert!(refused(NO_GRAVITY, &collar("tangent = [1, 1, 0]")).contains("free to turn about [0.707, 0.707, 0.000]"));
    assert_eq!(refused(NO_GRAVITY, &collar("twist = \"held\"")), "");
    assert!(refused(NO_GRAVITY, &collar("free_axis = [0, 1, 0]")).contains("free to turn about y"));
}

#[test]
fn springs_hold_the_position() {
    let spring = constraint("hand", "handle", "end = \"A\"", "stiffness = \"0.5 N/mm\"");
    assert_eq!(refused("", &spring), "");
}

#[test]
fn a_rest_curvature_keeps_two_pins_from_the_axis_of_the_cable() {
    let curved = CABLE.replace("segments = 10", "segments = 10\ncurvature = [0, 1, 0]");
    let pins = ["branch = \"b\", s = 0", "branch = \"b\", s = 0.5", "branch = \"b\", s = 1"]
        .map(|at| constraint(&at.replace(['"', ' '], ""), "handle", at, ""))
        .concat();
    let text = format!("{NO_GRAVITY}{curved}{pins}");
    assert!(parse(&text, &common::registry()).is_ok());
    assert!(refused(NO_GRAVITY, &pins).contains("free to turn about z"));
}

#[test]
fn constraints_that_agree_or_share_no_freedom_are_accepted() {
    let plug =
        constraint("plug", "connector", "end = \"A\"", "position = [0, 0, 0]\ntangent = [1, 0, 0]\nup = [0, 0, 1]");
    let beside = |more: &str| plug.clone() + &constraint("clip", "collar", "branch = \"b\", s = 0", more);
    assert_eq!(refused("", &beside("")), "");
    assert_eq!(refused("", &beside("position = [0, 0, 0]\ntangent = [2, 0, 0]")), "");
    assert!(refused("", &beside("position = [0, 0, 1e-3]")).contains("hold the position"));
    assert!(refused("", &beside("tangent = [1, 1e-3, 0]")).contains("hold the tangent"));
    let rails = |a: &str, b: &str| {
        constraint("p", "handle", "end = \"A\"", &format!("position = [0, 0, 0]\nrail = {a}"))
            + &constraint("q", "handle", "end = \"A\"", &format!("position = [0, 0, 1]\nrail = {b}"))
            + &constraint("r", "connector", "end = \"B\"", "")
    };
    assert_eq!(refused("", &rails("[[0, 0, 1]]", "[[1, 0, 0], [0, 1, 0]]")), "");
    assert!(refused("", &rails("[[1, 0, 0]]", "[[0, 1, 0]]")).contains("hold the position"));
}

#[test]
fn a_hand_may_take_over_what_a_plug_lets_go() {
    let plug = constraint("plug", "connector", "end = \"A\"", "position = [0, 0, 0]");
    let take =
        "[[steps]]\nadd = [{ name = \"hand\", kind = \"handle\", at = { end = \"A\" }, position = [0, 0, 1] }]\n";
    assert_eq!(refused("", &format!("{plug}{take}release = [\"plug\"]\n")), "");
    assert!(
        refused("", &format!("{plug}{take}"))
            .contains("hold the position at s = 0 m of branch \"b\" differently in step")
    );
}

#[test]
fn every_connected_piece_is_judged_by_itself() {
    let other = "[[branches]]\nname = \"c\"\nfrom = \"C\"\nto = \"D\"\nsection = \"s\"\nlength = 1\nsegments = 1\n";
    let plug = constraint("plug", "connector", "end = \"A\"", "");
    assert!(refused("", &format!("{other}{plug}")).contains("branch \"c\" is not held at the start"));
}
