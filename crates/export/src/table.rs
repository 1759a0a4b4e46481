//! The points of a sweep as a table, in Parquet: a row for each point, for DuckDB, pandas, Polars and the like.
//!
//! | column | content |
//! | --- | --- |
//! | `point` | its number, from 0 |
//! | the keys that vary | their values, in SI units where they are numbers |
//! | `status` | status of the run; `refused` where these values make no valid scenario |
//! | `message` | reason of the refusal or of an early end; null where there is none |
//! | `stable` | whether the equilibrium is stable; null where it was not determined |
//! | `events` | kinds of events that need attention, and the number of each |
//! | `iterations` | of the minimiser, over all steps |
//! | `polish` | iterations among them that `newton` made where `gpu` left a residual above the tolerance |
//! | `energy.total` ... | J, by effect |
//! | `bend_radius`, `force` | tightest bend of all branches (m; infinite: straight), largest force of constraints (N) |
//! | `bend_radius.BRANCH`, `twist_turns.BRANCH` | tightest bend of a branch (m), its twist (turns) |
//! | `force.CONSTRAINT`, `force_x.CONSTRAINT` ... | its force at the end: norm and components (N); null: released |
//! | `moment.CONSTRAINT`, `moment_x.CONSTRAINT` ... | likewise about the held point (N m) |
//! | `position_x.OUTPUT` ... | position that is an output of the sweep (m) |
//! | `force.OUTPUT`, `force_x.OUTPUT`, `tension.OUTPUT` ... | internal force and tension (N) at an output |
//! | `moment.OUTPUT`, `moment_x.OUTPUT` ... | internal moment (N m) at an output |
//! | `bend_radius.OUTPUT` | tightest bend of a part of a branch that is an output (m) |
//! | `slack.OUTPUT` | its unstressed length minus the distance of its ends (m) |
//!
//! There are no times in it: the same sweep gives the same bytes.

#[cfg(feature = "parquet")]
mod parquet_file;

#[cfg(feature = "parquet")]
pub use parquet_file::{read, write};

use crate::ending::{ConstraintEnd, Ending};
use serde::{Deserialize, Serialize};
use wireloom_core::Vector;

/// Name of the file.
pub const FILE: &str = "points.parquet";

/// Status of a point whose values make no valid scenario.
pub const REFUSED: &str = "refused";

/// A point of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Values of the keys that vary.
    pub values: Vec<Cell>,
    /// Status of the run.
    pub status: String,
    /// Reason of the refusal or of an early end.
    pub message: Option<String>,
    /// Whether the equilibrium is stable.
    pub stable: Option<bool>,
    /// Kinds of events, and the number of each.
    pub events: String,
    /// Values of the columns of numbers, in the order of [`Header::numbers`].
    pub numbers: Vec<Option<f64>>,
}

/// A value of a key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Cell {
    /// In SI units.
    Number(f64),
    /// Anything else.
    Word(String),
}

/// The names of the columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Keys that vary.
    pub keys: Vec<String>,
    /// Branches.
    pub branches: Vec<String>,
    /// Constraints.
    pub constraints: Vec<String>,
    /// Columns of the outputs of the sweep.
    pub outputs: Vec<String>,
}

impl Header {
    /// Names of the columns of numbers.
    pub fn numbers(&self) -> Vec<String> {
        let energies = ["total", "stretch", "shear", "bend", "twist", "gravity", "load", "joint", "constraint"];
        let mut names = ["iterations", "polish"].map(str::to_owned).to_vec();
        names.extend(energies.map(|effect| format!("energy.{effect}")));
        names.extend(["bend_radius", "force"].map(str::to_owned));
        for branch in &self.branches {
            names.extend(["bend_radius", "twist_turns"].map(|what| format!("{what}.{branch}")));
        }
        for constraint in &self.constraints {
            for what in ["force", "moment"] {
                names.push(format!("{what}.{constraint}"));
                names.extend(["x", "y", "z"].map(|axis| format!("{what}_{axis}.{constraint}")));
            }
        }
        names.extend_from_slice(&self.outputs);
        names
    }

    /// The row of a point that was computed; `outputs`: values of the outputs of the sweep.
    pub fn row(&self, values: Vec<Cell>, ending: &Ending, outputs: Vec<f64>) -> Row {
        let e = &ending.energy;
        let energies = [e.total(), e.stretch, e.shear, e.bend, e.twist, e.gravity, e.load, e.joint, e.constraint];
        let mut numbers = vec![ending.iterations as f64, ending.polish as f64];
        numbers.extend(energies);
        numbers.push(ending.tightest().map_or(f64::INFINITY, |(_, _, radius)| radius));
        numbers.push(ending.constraints.iter().fold(0.0, |force: f64, constraint| force.max(constraint.force.norm())));
        for name in &self.branches {
            let branch = ending.branches.iter().find(|branch| branch.name == *name);
            let radius = branch.map(|branch| branch.tightest().map_or(f64::INFINITY, |(_, radius)| radius));
            numbers.extend([radius, branch.map(|branch| branch.twist_turns)].map(|number| number.unwrap_or(f64::NAN)));
        }
        for name in &self.constraints {
            let constraint = ending.constraints.iter().find(|constraint| constraint.name == *name);
            let parts: [fn(&ConstraintEnd) -> Vector; 2] =
                [|constraint| constraint.force, |constraint| constraint.moment];
            for part in parts {
                let v = constraint.map_or(Vector::repeat(f64::NAN), part);
                numbers.extend([v.norm(), v.x, v.y, v.z]);
            }
        }
        numbers.extend(outputs);
        let trouble = ending.events.iter().filter(|(kind, _)| kind.is_trouble());
        let events: Vec<String> = trouble.map(|(kind, n)| format!("{n} {}", kind.word())).collect();
        Row {
            values,
            status: ending.status.clone(),
            message: None,
            stable: ending.stable,
            events: events.join(", "),
            numbers: numbers.into_iter().map(|number| (!number.is_nan()).then_some(number)).collect(),
        }
    }

    /// The row of a point whose values make no valid scenario.
    pub fn refused(&self, values: Vec<Cell>, message: String) -> Row {
        Row {
            values,
            status: REFUSED.to_owned(),
            message: Some(message),
            stable: None,
            events: String::new(),
            numbers: vec![None; self.numbers().len()],
        }
    }
}

/// A table by columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Names and entries, as many in each.
    pub columns: Vec<(String, Column)>,
    /// Metadata of the file: names and texts.
    pub notes: Vec<(String, String)>,
}

/// The entries of a column; `None`: null.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Whole numbers.
    Counts(Vec<Option<i64>>),
    /// Numbers.
    Numbers(Vec<Option<f64>>),
    /// Texts.
    Words(Vec<Option<String>>),
    /// Yes or no.
    Flags(Vec<Option<bool>>),
}

impl Table {
    /// The points of a sweep, in order.
    pub fn of(header: &Header, rows: &[Row], notes: Vec<(String, String)>) -> Self {
        let mut columns = vec![("point".to_owned(), Column::Counts((0..rows.len() as i64).map(Some).collect()))];
        for (k, key) in header.keys.iter().enumerate() {
            let number = |row: &Row| if let Cell::Number(number) = &row.values[k] { Some(*number) } else { None };
            let word = |row: &Row| match &row.values[k] {
                Cell::Number(number) => number.to_string(),
                Cell::Word(word) => word.clone(),
            };
            let column = if rows.iter().all(|row| number(row).is_some()) {
                Column::Numbers(rows.iter().map(number).collect())
            } else {
                Column::Words(rows.iter().map(|row| Some(word(row))).collect())
            };
            columns.push((key.clone(), column));
        }
        let words = |of: fn(&Row) -> Option<String>| Column::Words(rows.iter().map(of).collect());
        columns.push(("status".to_owned(), words(|row| Some(row.status.clone()))));
        columns.push(("message".to_owned(), words(|row| row.message.clone())));
        columns.push(("stable".to_owned(), Column::Flags(rows.iter().map(|row| row.stable).collect())));
        columns.push(("events".to_owned(), words(|row| Some(row.events.clone()))));
        for (k, name) in header.numbers().into_iter().enumerate() {
            columns.push((name, Column::Numbers(rows.iter().map(|row| row.numbers[k]).collect())));
        }
        Self { columns, notes }
    }

    /// The column of this name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|(other, _)| other == name).map(|(_, column)| column)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| column.len())
    }
}

impl Column {
    fn len(&self) -> usize {
        match self {
            Column::Counts(entries) => entries.len(),
            Column::Numbers(entries) => entries.len(),
            Column::Words(entries) => entries.len(),
            Column::Flags(entries) => entries.len(),
        }
    }
}
