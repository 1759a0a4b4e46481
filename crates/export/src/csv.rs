//! One branch as a table: a row for each node, for spreadsheets and plotting.

use crate::format::{Ended, File, Format};
use crate::local::{Local, node_count};
use crate::names::file_name;
use std::io::{self, Write};
use wireloom_core::equilibrium::BranchResult;

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

/// Writes [`HEADER`] and one row for each node, with all digits of the doubles. The bend radius of a straight place
/// is `inf`, which Rust, Python, R and C read as infinity.
///
/// # Errors
/// Those of `out`; `InvalidInput` where the branch's vectors differ in length.
pub fn write(branch: &BranchResult, out: &mut impl Write) -> io::Result<()> {
    let n = node_count(branch)?;
    let mut table = csv::Writer::from_writer(out);
    table.write_record(HEADER)?;
    for i in 0..n {
        table.serialize(&row(branch, i)[..])?;
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

/// The format `csv/STEP/BRANCH.csv`.
pub struct Csv;

impl Format for Csv {
    fn key(&self) -> Option<&'static str> {
        Some("csv")
    }

    fn files(&self) -> &'static [&'static str] {
        &["csv/STEP/BRANCH.csv"]
    }

    fn media_type(&self) -> &'static str {
        "text/csv; charset=utf-8"
    }

    fn at_end<'a>(&self, ended: &'a Ended<'a>) -> Vec<File<'a>> {
        let mut taken = vec![];
        let mut files = vec![];
        for end in ended.ends() {
            let step = file_name(&format!("{}-{}", taken.len() + 1, end.name), &mut taken);
            files.extend(tables(&format!("csv/{step}"), &end.branches));
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
