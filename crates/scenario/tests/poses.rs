//! Ways given by a CSV file of poses.

mod common;

use wireloom_core::steps::Turn;
use wireloom_core::{Rotation, Vector};
use wireloom_scenario::{Files, Scenario, parse_with_files, render};

const HARNESS: &str = concat!(
    include_str!("section.toml"),
    include_str!("branch.toml"),
    r#"[[steps]]
[[steps.carry]]
what = ["plug"]
path = "way.csv"
"#
);

struct One<'t>(&'t str);

impl Files for One<'_> {
    fn read(&self, path: &str) -> Result<String, String> {
        if path == "way.csv" { Ok(self.0.to_owned()) } else { Err("no such file".into()) }
    }
}

fn read(csv: &str) -> Scenario {
    let scenario = parse_with_files(HARNESS, &One(csv), &common::registry());
    scenario.unwrap_or_else(|faults| panic!("{}", render(HARNESS, &faults)))
}

#[track_caller]
fn refused(csv: &str, expected: &[&str]) {
    let faults = parse_with_files(HARNESS, &One(csv), &common::registry()).err().unwrap_or_default();
    let said: Vec<&str> = faults.iter().map(|fault| fault.message.as_str()).collect();
    assert_eq!(said, expected);
    assert!(faults.iter().all(|fault| &HARNESS[fault.span.clone()] == "\"way.csv\""));
}

#[test]
fn times_are_shares_of_the_step_and_lengths_have_units() {
    let scenario = read("# from the robot\nt [ms], x [mm], z, y\n1000, 1, 5, 0\n1500,100, 5,-1\n3000, 200,6,0\n");
    let [carry] = scenario.steps[0].moves.as_slice() else { panic!() };
    assert_eq!(carry.origin, (Some(Vector::new(0.001, 0.0, 5.0)), None));
    let expected = [(0.25, Vector::new(0.1, -1.0, 5.0)), (1.0, Vector::new(0.2, 0.0, 6.0))];
    assert_eq!((carry.track.positions.as_slice(), carry.track.turns.len()), (expected.as_slice(), 0));
}

#[test]
fn quaternions_are_orientations() {
    let scenario = read("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n2,0,0,1,0,0,0,-3\n");
    let [carry] = scenario.steps[0].moves.as_slice() else { panic!() };
    assert_eq!(carry.origin, (Some(Vector::zeros()), Some(Rotation::identity())));
    let [(at, Turn::Orientation(half))] = carry.track.turns.as_slice() else { panic!() };
    assert!(*at == 1.0 && (half.angle() - std::f64::consts::PI).abs() < 1e-12);
}

#[test]
fn every_fault_has_its_line() {
    refused("", &["way.csv:1: the file is empty"]);
    refused(
        "0,0,0,0\n1,0,0,0\n",
        &[
            "way.csv:1: unknown column `0`",
            "way.csv:1: unknown column `0`",
            "way.csv:1: unknown column `0`",
            "way.csv:1: unknown column `0`",
            "way.csv:1: there is no column `t`",
            "way.csv:1: there is no column `x`",
            "way.csv:1: there is no column `y`",
            "way.csv:1: there is no column `z`",
        ],
    );
    refused(
        "t,x [kg],y,z,qw,qz,z\n",
        &[
            "way.csv:1: `x [kg]` has a unit that does not fit",
            "way.csv:1: there are two columns `z`",
            "way.csv:1: there is no column `qx`",
            "way.csv:1: there is no column `qy`",
        ],
    );
    refused("t,x,y,z\n", &["way.csv:2: no lines follow"]);
    refused("t,x,y,z\n1,0,0,0\n", &["way.csv:2: only one line"]);
    refused(
        "t,x,y,z\n0,0,0,0\n1,\"0,5\",inf,\n1,2,3\n\n0,0,0,0\n",
        &[
            "way.csv:3: `x` is \"0,5\", not a finite number",
            "way.csv:3: `y` is \"inf\", not a finite number",
            "way.csv:3: `z` is \"\", not a finite number",
            "way.csv:4: 3 values in 4 columns",
            "way.csv:6: `t` = 0 does not come after 0",
        ],
    );
    refused("t,x,y,z,qw,qx,qy,qz\n0,0,0,0,0,0,0,0\n1,0,0,0,1,0,0,0\n", &["way.csv:2: the quaternion is zero"]);
    let many = format!("t,x,y,z\n{}", "a,0,0,0\n".repeat(12));
    let faults = parse_with_files(HARNESS, &One(&many), &common::registry()).unwrap_err();
    assert_eq!((faults.len(), faults[10].message.as_str()), (11, "way.csv: 3 more faults"));
}

#[test]
fn a_path_stands_alone() {
    let text = HARNESS
        .replace("path =", "keyframes = [{ at = 1, position = [0, 0, 1] }]\nabout = { position = [0, 0, 0] }\npath =");
    let faults = parse_with_files(&text, &One("t,x,y,z\n0,0,0,0\n1,0,0,1\n"), &common::registry()).unwrap_err();
    assert_eq!(faults.len(), 2, "{}", render(&text, &faults));
    let text = HARNESS.replace("way.csv", "away.csv");
    let faults = parse_with_files(&text, &One(""), &common::registry()).unwrap_err();
    assert_eq!(faults[0].message, "cannot read \"away.csv\": no such file");
}
