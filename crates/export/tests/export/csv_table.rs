//! The table of a branch.

use crate::samples::{broken, y_harness};
use wireloom_core::Vector;
use wireloom_core::equilibrium::{ArmFriction, FrictionResult};
use wireloom_export::csv::{ARMS_HEADER, HEADER, SET_HEADER, write, write_arms};

fn table(branch: &wireloom_core::equilibrium::BranchResult) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut bytes = Vec::new();
    write(branch, &mut bytes).unwrap();
    let mut reader = csv::Reader::from_reader(bytes.as_slice());
    let header = reader.headers().unwrap().iter().map(String::from).collect();
    let rows = reader.records().map(|row| row.unwrap().iter().map(|x| x.parse().unwrap()).collect()).collect();
    (header, rows)
}

#[test]
fn comes_back_bit_for_bit() {
    for branch in &y_harness().branches {
        let (header, rows) = table(branch);
        assert_eq!(header, HEADER);
        assert_eq!(rows.len(), branch.s.len());
        for (i, row) in rows.iter().enumerate() {
            assert_eq!(row[0], branch.s[i]);
            assert_eq!(row[1..4], *branch.position[i].as_slice());
            assert_eq!(row[10..13], *branch.force[i].as_slice());
            assert_eq!(row[13..16], *branch.moment[i].as_slice());
            assert_eq!(row[20], branch.bend_radius[i]);
            // The parts along and across the tangent are those of the whole.
            let (n, m) = (branch.force[i].norm(), branch.moment[i].norm());
            assert!((row[16].hypot(row[17]) - n).abs() < 1e-14 * (1.0 + n));
            assert!((row[18].hypot(row[19]) - m).abs() < 1e-14 * (1.0 + m));
            let d3 = &row[7..10];
            let tension: f64 = d3.iter().zip(&row[10..13]).map(|(d, n)| d * n).sum();
            assert!((row[16] - tension).abs() < 1e-14);
        }
    }
}

#[test]
fn a_branch_with_friction_has_its_set() {
    let mut branch = y_harness().branches.remove(0);
    let set: Vec<Vector> = branch.s.iter().map(|s| Vector::new(s / 3.0, -s, 0.1)).collect();
    branch.friction = Some(FrictionResult { set: set.clone(), dissipated: 0.1, dissipated_in_all: 0.3 });
    let (header, rows) = table(&branch);
    assert_eq!(header, [&HEADER[..], &SET_HEADER].concat());
    for (row, set) in rows.iter().zip(&set) {
        assert_eq!(row[21..], *set.as_slice());
    }
    branch.friction.as_mut().expect("it has some").set.pop();
    assert!(write(&branch, &mut Vec::new()).is_err(), "a set of another length");
}

#[test]
fn arms_that_slip_have_a_row_each() {
    let mut joints = y_harness().joints;
    let set = Vector::new(0.1, -1.0 / 3.0, 0.0);
    let arm = ArmFriction { branch: "left".into(), starts_here: true, set, dissipated: 0.1, dissipated_in_all: 0.3 };
    joints[0].friction = vec![arm];
    let mut bytes = Vec::new();
    write_arms(&joints, &mut bytes).unwrap();
    let wanted = format!("{}\n{},left,0.1,-0.3333333333333333,0.0,0.1,0.3\n", ARMS_HEADER.join(","), joints[0].name);
    assert_eq!(String::from_utf8(bytes).unwrap(), wanted);
}

#[test]
fn not_finite_numbers_have_words() {
    let mut branch = broken().branches.remove(0);
    branch.bend_radius[0] = f64::INFINITY;
    let (_, rows) = table(&branch);
    assert!(rows[10][1].is_nan());
    assert_eq!(rows[0][20], f64::INFINITY);
}

#[test]
fn vectors_of_different_length_are_refused() {
    let mut branch = y_harness().branches.remove(0);
    branch.force.pop();
    let error = write(&branch, &mut Vec::new()).unwrap_err();
    assert_eq!(error.kind(), std::io::ErrorKind::InvalidInput);
    assert_eq!(
        error.to_string(),
        "branch \"trunk\": vectors differ in length: s 61, position 61, frame 61, force 60, moment 61, bend_radius 61"
    );
}

#[test]
fn an_empty_branch_is_a_header() {
    let mut branch = y_harness().branches.remove(0);
    branch.s.clear();
    branch.position.clear();
    branch.frame.clear();
    branch.force.clear();
    branch.moment.clear();
    branch.bend_radius.clear();
    let (header, rows) = table(&branch);
    assert_eq!((header.len(), rows.len()), (HEADER.len(), 0));
}

/// The sheet has the numbers of the result, in SI, and a name may hold what separates columns.
#[test]
fn the_sheet_is_a_table() {
    let mut run = crate::samples::failing();
    run.requirements[0].name = "plug, \"A\"".into();
    let mut bytes = Vec::new();
    wireloom_export::csv::write_sheet(&run.requirements, &mut bytes).unwrap();
    let mut table = csv::Reader::from_reader(bytes.as_slice());
    let header = table.headers().unwrap().clone();
    assert_eq!(header.iter().collect::<Vec<_>>(), wireloom_export::csv::SHEET_HEADER);
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    let cell = |row: usize, name: &str| rows[row][header.iter().position(|head| head == name).unwrap()].to_owned();
    let verdicts: Vec<String> = (0..rows.len()).map(|row| cell(row, "verdict")).collect();
    assert_eq!(verdicts, ["fail", "fail", "unresolved", "not checked", "fail", "pass"]);
    let bend = run.steps[0].min_bend_radius.as_ref().unwrap();
    assert_eq!(cell(0, "worst").parse(), Ok(bend.value));
    assert_eq!(
        (cell(0, "limit"), cell(0, "unit"), cell(0, "branch")),
        ("0.045".into(), "m".into(), bend.branch.clone())
    );
    assert_eq!(
        (cell(3, "worst"), cell(3, "step"), cell(5, "requirement")),
        ("".into(), "".into(), "plug, \"A\"".into())
    );
}
