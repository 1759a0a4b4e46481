//! Tables for spreadsheets and plotting: a branch, with a row for each node; the arms that slip on their hub, with a
//! row for each; the sheet, with a row for each requirement; the parts list.

mod parts;

pub use parts::{CONNECTIONS_HEADER, PARTS_HEADER, write_connections, write_parts};

use crate::format::{Ended, File, Format};
use crate::local::{Local, node_count};
use crate::names::file_name;
use crate::sheet::sorted;
use std::io::{self, Write};
use wireloom_core::equilibrium::{BranchResult, JointResult, RequirementResult};

/// The columns. Tension is `n·d3`, torque `m·d3`; shear force and bending moment are the lengths of the parts of `n`
/// and `m` normal to the tangent.
pub const HEADER: [&str; 21] = [
    "s [m]",
    "x [m]",
    "y [m]",
    "z [m]",
    "d1 x",
    "d1 y",
    "d1 z",
    "d3 x",
    "d3 y",
    "d3 z",
    "force x [N]",
    "force y [N]",
    "force z [N]",
    "moment x [N m]",
    "moment y [N m]",
    "moment z [N m]",
    "tension [N]",
    "shear force [N]",
    "bending moment [N m]",
    "torque [N m]",
    "bend radius [m]",
];

/// Further columns of a branch with friction within its section: the set about each director.
pub const SET_HEADER: [&str; 3] = ["set d1 [1/m]", "set d2 [1/m]", "set d3 [1/m]"];

/// Writes [`HEADER`] (with friction [`SET_HEADER`], too) and one row for each node, with all digits of the doubles. The
/// bend radius of a straight place is `inf`, which Rust, Python, R and C read as infinity.
///
/// # Errors
/// Those of `out`; `InvalidInput` where the branch's vectors differ in length.
pub fn write(branch: &BranchResult, out: &mut impl Write) -> io::Result<()> {
    let n = node_count(branch)?;
    let mut table = csv::Writer::from_writer(out);
    let set = branch.friction.as_ref().map(|friction| &friction.set);
    table.write_record(HEADER.iter().chain(set.iter().flat_map(|_| &SET_HEADER)))?;
    for i in 0..n {
        let mut row = row(branch, i).to_vec();
        row.extend(set.iter().flat_map(|set| set[i].iter()));
        table.serialize(row)?;
    }
    table.flush()
}

fn row(branch: &BranchResult, i: usize) -> [f64; HEADER.len()] {
    let local = Local::at(branch, i);
    let (x, d1, d3) = (branch.position[i], local.d1, local.d3);
    let (n, m) = (branch.force[i], branch.moment[i]);
    [
        branch.s[i],
        x.x,
        x.y,
        x.z,
        d1.x,
        d1.y,
        d1.z,
        d3.x,
        d3.y,
        d3.z,
        n.x,
        n.y,
        n.z,
        m.x,
        m.y,
        m.z,
        local.tension,
        local.shear,
        local.bending_moment,
        local.torque,
        branch.bend_radius[i],
    ]
}

/// The columns of the arms that slip on their hub: the set about each director of the branch, the energy dissipated in
/// the increment and since the start.
pub const ARMS_HEADER: [&str; 7] =
    ["joint", "branch", "set d1 [rad]", "set d2 [rad]", "set d3 [rad]", "dissipated [J]", "dissipated in all [J]"];

/// Writes [`ARMS_HEADER`] and one row for each arm that slips on its hub.
///
/// # Errors
/// Those of `out`.
pub fn write_arms(joints: &[JointResult], out: &mut impl Write) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    table.write_record(ARMS_HEADER)?;
    for (joint, arm) in joints.iter().flat_map(|joint| joint.friction.iter().map(move |arm| (joint, arm))) {
        let numbers = [arm.set.x, arm.set.y, arm.set.z, arm.dissipated, arm.dissipated_in_all];
        table.serialize((&joint.name, &arm.branch, numbers))?;
    }
    table.flush()
}

/// The columns of the sheet. Values are in the SI unit of their row; the margin is relative to the limit.
pub const SHEET_HEADER: [&str; 20] = [
    "verdict",
    "requirement",
    "quantity",
    "severity",
    "worst",
    "limit",
    "side",
    "unit",
    "margin",
    "error",
    "step",
    "increment",
    "constraint",
    "obstacle",
    "branch",
    "s [m]",
    "other branch",
    "other s [m]",
    "because",
    "reason",
];

/// Writes [`SHEET_HEADER`] and one row for each requirement, the most urgent first. What does not apply is empty.
///
/// # Errors
/// Those of `out`.
pub fn write_sheet(sheet: &[RequirementResult], out: &mut impl Write) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    table.write_record(SHEET_HEADER)?;
    for line in sorted(sheet) {
        table.write_record(sheet_row(line))?;
    }
    table.flush()
}

fn sheet_row(line: &RequirementResult) -> [String; SHEET_HEADER.len()] {
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:?}"));
    let word = |text: &Option<String>| text.clone().unwrap_or_default();
    let (place, moment) = (&line.place, line.moment.as_ref());
    [
        line.verdict.word().to_owned(),
        line.name.clone(),
        line.measure.word().to_owned(),
        line.severity.word().to_owned(),
        number(line.worst),
        number(Some(line.limit)),
        line.bound.word().to_owned(),
        line.measure.unit().to_owned(),
        number(line.margin()),
        number(line.error),
        moment.map_or_else(String::new, |moment| moment.step.clone()),
        moment.map_or_else(String::new, |moment| moment.increment.to_string()),
        word(&place.constraint),
        word(&place.obstacle),
        word(&place.branch),
        number(place.s),
        word(&place.other_branch),
        number(place.other_s),
        word(&line.because),
        word(&line.reason),
    ]
}

/// File of the sheet.
const SHEET: &str = "requirements.csv";
/// Files of the parts list, where there is one.
const PARTS: &str = "parts.csv";
const CONNECTIONS: &str = "connections.csv";

/// The formats `csv/STEP/BRANCH.csv`, `csv/STEP-joints.csv`, `requirements.csv`, `parts.csv` and `connections.csv`.
pub struct Csv;

impl Format for Csv {
    fn key(&self) -> Option<&'static str> {
        Some("csv")
    }

    fn files(&self) -> &'static [&'static str] {
        &["csv/STEP/BRANCH.csv", "csv/STEP-joints.csv", SHEET, PARTS, CONNECTIONS]
    }

    fn media_type(&self) -> &'static str {
        "text/csv; charset=utf-8"
    }

    fn at_end<'a>(&self, ended: &'a Ended<'a>) -> Vec<File<'a>> {
        let mut taken = vec![];
        let mut files = vec![File::new(SHEET, |mut out| write_sheet(&ended.run.requirements, &mut out))];
        let known = &ended.run.identities;
        if !known.parts.is_empty() || !known.components.is_empty() {
            files.push(File::new(PARTS, |mut out| write_parts(known, &mut out)));
        }
        if !known.connections.is_empty() {
            files.push(File::new(CONNECTIONS, |mut out| write_connections(&known.connections, &mut out)));
        }
        for end in ended.ends() {
            let step = file_name(&format!("{}-{}", taken.len() + 1, end.name), &mut taken);
            files.extend(tables(&format!("csv/{step}"), &end.branches));
            if end.joints.iter().any(|joint| !joint.friction.is_empty()) {
                files.push(File::new(format!("csv/{step}-joints.csv"), |mut out| write_arms(&end.joints, &mut out)));
            }
        }
        files
    }

    fn offered(&self, branches: &[&str], _: bool) -> Vec<String> {
        names("csv", branches.iter().copied())
    }

    fn at_hand<'a>(&self, ended: &'a Ended<'a>) -> Vec<File<'a>> {
        ended.run.steps.last().map_or_else(Vec::new, |end| tables("csv", &end.branches))
    }
}

/// The tables of branches in a folder.
fn tables<'a>(folder: &str, branches: &'a [BranchResult]) -> Vec<File<'a>> {
    let names = names(folder, branches.iter().map(|branch| branch.name.as_str()));
    let table = |(name, branch): (String, &'a BranchResult)| File::new(name, |mut out| write(branch, &mut out));
    names.into_iter().zip(branches).map(table).collect()
}

/// Names of the tables of branches in a folder.
fn names<'a>(folder: &str, branches: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut taken = vec![];
    branches.map(|branch| format!("{folder}/{}.csv", file_name(branch, &mut taken))).collect()
}
