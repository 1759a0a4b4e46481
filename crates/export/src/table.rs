//! The points of a sweep as a table, a row for each point: Parquet for DuckDB, pandas, Polars and the like, and CSV.
//!
//! | column | content |
//! | --- | --- |
//! | `point` | its number, from 0 |
//! | the keys that vary | values, in SI units where they are numbers; null: it does not vary at this point |
//! | `status` | status of the run; or `refused` (not a valid scenario), `time limit`, `crashed` (also a plugin) |
//! | `verdict` | verdict on the harness over the whole run; null where nothing was computed |
//! | `fails` | names of requirements that must be kept and fail; where none fails, of those unresolved |
//! | `requirement`, `margin`, `step`, `where` | first line of the sheet: name, margin, step and place of the worst |
//! | `message` | reason of a refusal or of an early end; null where there is none |
//! | `stable` | whether the last equilibrium is stable; null where it was not determined |
//! | `events` | kinds of events that need attention, and the number of each |
//! | `verdict.REQUIREMENT` | verdict of a line of the sheet; its measure follows its name where others have the name |
//! | `worst.REQUIREMENT` | its worst value over all increments (SI); with `margin.`, `step.` and `where.` |
//! | `iterations` | of the minimiser, over all steps |
//! | `polish` | iterations among them that `newton` made where `gpu` left a residual above the tolerance |
//! | `energy.total` ... | J, by effect, at the end |
//! | `min_bend_radius`, `max_force` | tightest bend (m; infinite: straight), largest constraint force (N) |
//! | `bend_radius`, `force` | the same at the end |
//! | `min_bend_radius.BRANCH`, `max_tension.BRANCH` | tightest bend (m), greatest tension (N) at any time |
//! | `bend_radius.BRANCH`, `twist_turns.BRANCH` | tightest bend (m) and twist (turns) at the end |
//! | `max_force.CONSTRAINT`, `max_moment.CONSTRAINT` | largest force (N) and moment (N m) at any time |
//! | `force.CONSTRAINT`, `force_x.CONSTRAINT` ... | force at the end: norm and components (N); null: released |
//! | `moment.CONSTRAINT`, `moment_x.CONSTRAINT` ... | likewise about the held point (N m) |
//! | `QUANTITY.OUTPUT`, `QUANTITY_x.OUTPUT` ... | an output of the sweep, in SI units |
//!
//! Least and greatest values (`min_`, `max_`, "at any time") are those at the ends of increments in equilibrium;
//! requirements are also checked in between.
//! There are no times in it: the same sweep gives the same bytes, unless points reach a time limit.

mod csv_file;
#[cfg(feature = "parquet")]
mod parquet_file;
pub mod statistics;

pub use csv_file::write_csv;
#[cfg(feature = "parquet")]
pub use parquet_file::{Grouped, Head, Tail, Writer, head, read};

use crate::ending::{ConstraintEnd, Ending};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wireloom_core::Vector;
use wireloom_core::equilibrium::StepResult;
use wireloom_core::requirement::{Measure, Origin, RequirementResult, Severity, Verdict, with_distinct_names};

/// Name of the file.
pub const FILE: &str = "points.parquet";

/// Status of a point whose values make no valid scenario.
pub const REFUSED: &str = "refused";
/// Status of a point that took longer than its time limit.
pub const TIME_LIMIT: &str = "time limit";
/// Status of a point at which the program failed.
pub const CRASHED: &str = "crashed";

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
    /// Verdict on the harness; `None` where nothing was computed.
    pub verdict: Option<Verdict>,
    /// The sheet, in the order of the requirements.
    pub sheet: Vec<Line>,
    /// Values of the columns of numbers, in the order of [`Header::numbers`].
    pub numbers: Vec<Option<f64>>,
}

/// A line of the sheet of a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Name of the requirement, distinct among those of its harness.
    pub name: String,
    /// What it limits.
    pub measure: Measure,
    /// Its importance.
    pub severity: Severity,
    /// Its verdict.
    pub verdict: Verdict,
    /// Its verdict as it counts for the whole: what was not checked is unresolved, or decides nothing.
    pub counted: Verdict,
    /// Its worst value.
    pub worst: Option<f64>,
    /// Distance of that from the limit, relative to the limit.
    pub margin: Option<f64>,
    /// Step of the worst value.
    pub step: Option<String>,
    /// Place of the worst value.
    pub place: Option<String>,
}

impl Line {
    fn of(line: &RequirementResult) -> Self {
        Self {
            name: line.name.clone(),
            measure: line.measure,
            severity: line.severity,
            verdict: line.verdict,
            counted: match (line.verdict, line.origin) {
                (Verdict::NotChecked, Origin::Scenario) => Verdict::Unresolved,
                (Verdict::NotChecked, _) => Verdict::Pass,
                (verdict, _) => verdict,
            },
            worst: line.worst,
            margin: line.margin(),
            step: line.moment.as_ref().map(|moment| moment.step.clone()),
            place: line.worst.map(|_| line.place.to_string()),
        }
    }
}

/// A value of a key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Cell {
    /// In SI units.
    Number(f64),
    /// Anything else.
    Word(String),
    /// The key does not vary at this point.
    Empty,
}

/// The names of the columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Keys that vary, and whether their values are numbers.
    pub keys: Vec<(String, bool)>,
    /// Branches.
    pub branches: Vec<String>,
    /// Constraints.
    pub constraints: Vec<String>,
    /// Columns of the outputs of the sweep.
    pub outputs: Vec<String>,
}

/// Extremes of the quantities of a run over all increments that ended in an equilibrium.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extremes {
    /// Least bend radius (m) and greatest tension (N) of each branch.
    branches: Vec<[f64; 2]>,
    /// Largest force (N) and moment (N m) of each constraint.
    constraints: BTreeMap<String, [f64; 2]>,
}

impl Extremes {
    /// Adds an increment.
    pub fn add(&mut self, end: &StepResult) {
        if !end.status.is_balanced() {
            return;
        }
        self.branches.resize(end.branches.len(), [f64::INFINITY, f64::NEG_INFINITY]);
        for ([radius, tension], branch) in self.branches.iter_mut().zip(&end.branches) {
            *radius = branch.bend_radius.iter().copied().fold(*radius, f64::min);
            *tension = branch.tensions().fold(*tension, f64::max);
        }
        for constraint in &end.constraints {
            let (force, moment) = (constraint.largest_force(), constraint.largest_moment());
            match self.constraints.get_mut(&constraint.name) {
                Some(known) => *known = [known[0].max(force), known[1].max(moment)],
                None => drop(self.constraints.insert(constraint.name.clone(), [force, moment])),
            }
        }
    }
}

/// What was computed at a point, besides its last equilibrium.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Computed<'a> {
    /// Extremes over its increments.
    pub extremes: Extremes,
    /// Values of the outputs of the sweep; NaN: there is none.
    pub outputs: Vec<f64>,
    /// Its verdict and its sheet.
    pub verdict: Option<(Verdict, &'a [RequirementResult])>,
}

impl Header {
    /// Names of the columns of numbers.
    pub fn numbers(&self) -> Vec<String> {
        let energies = ["total", "stretch", "shear", "bend", "twist", "gravity", "load", "joint", "constraint"];
        let mut names = ["iterations", "polish"].map(str::to_owned).to_vec();
        names.extend(energies.map(|effect| format!("energy.{effect}")));
        names.extend(["min_bend_radius", "max_force", "bend_radius", "force"].map(str::to_owned));
        for branch in &self.branches {
            let columns = ["min_bend_radius", "max_tension", "bend_radius", "twist_turns"];
            names.extend(columns.map(|what| format!("{what}.{branch}")));
        }
        for constraint in &self.constraints {
            names.extend(["max_force", "max_moment"].map(|what| format!("{what}.{constraint}")));
            for what in ["force", "moment"] {
                names.push(format!("{what}.{constraint}"));
                names.extend(["x", "y", "z"].map(|axis| format!("{what}_{axis}.{constraint}")));
            }
        }
        names.extend_from_slice(&self.outputs);
        names
    }

    /// The row of a point that was computed.
    pub fn row(&self, values: Vec<Cell>, ending: &Ending, computed: Computed<'_>) -> Row {
        let Computed { extremes, outputs, verdict } = computed;
        let e = &ending.energy;
        let energies = [e.total(), e.stretch, e.shear, e.bend, e.twist, e.gravity, e.load, e.joint, e.constraint];
        let mut numbers = vec![ending.iterations as f64, ending.polish as f64];
        numbers.extend(energies);
        let whole = |of: usize, worse: fn(f64, f64) -> f64| extremes.branches.iter().map(|b| b[of]).reduce(worse);
        numbers.push(whole(0, f64::min).unwrap_or(f64::NAN));
        let forces = extremes.constraints.values().map(|[force, _]| *force);
        numbers.push(if extremes.branches.is_empty() { f64::NAN } else { forces.fold(0.0, f64::max) });
        numbers.push(ending.tightest().map_or(f64::INFINITY, |(_, _, radius)| radius));
        numbers.push(ending.constraints.iter().fold(0.0, |force: f64, constraint| force.max(constraint.force.norm())));
        for name in &self.branches {
            let index = ending.branches.iter().position(|branch| branch.name == *name);
            let [radius, tension] =
                index.and_then(|k| extremes.branches.get(k)).copied().unwrap_or([f64::NAN, f64::NAN]);
            let branch = index.map(|k| &ending.branches[k]);
            let bend = branch.map_or(f64::NAN, |branch| branch.tightest().map_or(f64::INFINITY, |(_, radius)| radius));
            numbers.extend([radius, tension, bend, branch.map_or(f64::NAN, |branch| branch.twist_turns)]);
        }
        for name in &self.constraints {
            numbers.extend(extremes.constraints.get(name).copied().unwrap_or([f64::NAN, f64::NAN]));
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
            verdict: verdict.map(|(verdict, _)| verdict),
            sheet: verdict
                .map(|(_, sheet)| with_distinct_names(sheet).iter().map(Line::of).collect())
                .unwrap_or_default(),
            numbers: numbers.into_iter().map(|number| (!number.is_nan()).then_some(number)).collect(),
        }
    }

    /// The row of a point without a result, and the reason.
    pub fn without_result(&self, values: Vec<Cell>, status: &str, message: Option<String>) -> Row {
        Row {
            values,
            status: status.to_owned(),
            message,
            stable: None,
            events: String::new(),
            verdict: None,
            sheet: Vec::new(),
            numbers: vec![None; self.numbers().len()],
        }
    }
}

impl Row {
    /// The first line of the sheet: what fails most, or is nearest to its limit.
    pub fn first(&self) -> Option<&Line> {
        let margin = |line: &Line| line.margin.unwrap_or(0.0);
        let failed = |line: &Line| line.counted != Verdict::Pass;
        let checked = self.sheet.iter().filter(|line| line.worst.is_some() || failed(line));
        // In the order of the sheet.
        checked.min_by(|a, b| {
            let by_verdict = failed(b).cmp(&failed(a)).then(a.severity.cmp(&b.severity));
            by_verdict.then(a.counted.cmp(&b.counted)).then(margin(a).total_cmp(&margin(b)))
        })
    }

    /// Names of the requirements that must be kept and are not; where all are kept, of those that are unresolved.
    fn fails(&self) -> String {
        let names = |verdict: Verdict| {
            let must = |line: &&Line| line.counted == verdict && line.severity == Severity::Must;
            self.sheet.iter().filter(must).map(|line| line.name.as_str()).collect::<Vec<_>>().join(", ")
        };
        let fails = names(Verdict::Fail);
        if fails.is_empty() { names(Verdict::Unresolved) } else { fails }
    }
}

/// Columns for each requirement: `verdict.REQUIREMENT` and so on, with the type of their entries.
pub const OF_REQUIREMENT: [(&str, Kind); 5] = [
    ("verdict", Kind::Words),
    ("worst", Kind::Numbers),
    ("margin", Kind::Numbers),
    ("step", Kind::Words),
    ("where", Kind::Words),
];

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

/// Type of the entries of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Whole numbers.
    Counts,
    /// Numbers.
    Numbers,
    /// Texts.
    Words,
    /// Yes or no.
    Flags,
}

/// Columns of the table of a sweep: those of its header, and of the requirements that its points have.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout<'h> {
    header: &'h Header,
    numbers: Vec<String>,
    /// Names and measures of the requirements.
    requirements: Vec<(String, Measure)>,
}

impl<'h> Layout<'h> {
    /// Columns of this header, without requirements so far.
    pub fn new(header: &'h Header) -> Self {
        Self { header, numbers: header.numbers(), requirements: Vec::new() }
    }

    /// Adds the requirements of these rows.
    pub fn add(&mut self, rows: &[Row]) {
        for line in rows.iter().flat_map(|row| &row.sheet) {
            if !self.requirements.iter().any(|(name, _)| *name == line.name) {
                self.requirements.push((line.name.clone(), line.measure));
            }
        }
    }

    /// Names and measures of the requirements.
    pub fn requirements(&self) -> &[(String, Measure)] {
        &self.requirements
    }

    /// Some consecutive points as a table, the number of the first being `first`.
    pub fn table(&self, first: usize, rows: &[Row]) -> Table {
        let points = (first as i64..).take(rows.len());
        let mut columns = vec![("point".to_owned(), Column::Counts(points.map(Some).collect()))];
        for (k, (key, numeric)) in self.header.keys.iter().enumerate() {
            let column = if *numeric {
                Column::Numbers(rows.iter().map(|row| row.values[k].number()).collect())
            } else {
                Column::Words(rows.iter().map(|row| row.values[k].word()).collect())
            };
            columns.push((key.clone(), column));
        }
        let mut words = |name: &str, of: &dyn Fn(&Row) -> Option<String>| {
            columns.push((name.to_owned(), Column::Words(rows.iter().map(of).collect())));
        };
        words("status", &|row| Some(row.status.clone()));
        words("verdict", &|row| row.verdict.map(|verdict| verdict.word().to_owned()));
        words("fails", &|row| row.verdict.map(|_| row.fails()));
        words("requirement", &|row| row.first().map(|line| line.name.clone()));
        words("step", &|row| row.first().and_then(|line| line.step.clone()));
        words("where", &|row| row.first().and_then(|line| line.place.clone()));
        words("message", &|row| row.message.clone());
        words("events", &|row| Some(row.events.clone()));
        let margin = rows.iter().map(|row| row.first().and_then(|line| line.margin)).collect();
        columns.insert(columns.len() - 4, ("margin".to_owned(), Column::Numbers(margin)));
        columns.push(("stable".to_owned(), Column::Flags(rows.iter().map(|row| row.stable).collect())));
        for (k, (name, _)) in self.requirements.iter().enumerate() {
            // Mostly all points have the same requirements.
            let line = |row: &'_ Row| -> Option<usize> {
                let same = |line: &Line| line.name == *name;
                if row.sheet.get(k).is_some_and(same) { Some(k) } else { row.sheet.iter().position(same) }
            };
            let lines: Vec<Option<&Line>> = rows.iter().map(|row| line(row).map(|k| &row.sheet[k])).collect();
            let words = |of: &dyn Fn(&Line) -> Option<String>| {
                Column::Words(lines.iter().map(|line| line.and_then(of)).collect())
            };
            let numbers =
                |of: fn(&Line) -> Option<f64>| Column::Numbers(lines.iter().map(|line| line.and_then(of)).collect());
            let entries = [
                words(&|line| Some(line.verdict.word().to_owned())),
                numbers(|line| line.worst),
                numbers(|line| line.margin),
                words(&|line| line.step.clone()),
                words(&|line| line.place.clone()),
            ];
            let names = OF_REQUIREMENT.map(|(what, _)| format!("{what}.{name}"));
            columns.extend(names.into_iter().zip(entries));
        }
        for (k, name) in self.numbers.iter().enumerate() {
            columns.push((name.clone(), Column::Numbers(rows.iter().map(|row| row.numbers[k]).collect())));
        }
        Table { columns, notes: Vec::new() }
    }
}

impl Cell {
    fn number(&self) -> Option<f64> {
        if let Cell::Number(number) = self { Some(*number) } else { None }
    }

    fn word(&self) -> Option<String> {
        match self {
            Cell::Number(number) => Some(number.to_string()),
            Cell::Word(word) => Some(word.clone()),
            Cell::Empty => None,
        }
    }
}

impl Table {
    /// The column of this name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|(other, _)| other == name).map(|(_, column)| column)
    }

    /// The entries of a column of numbers; empty where there is none of this name.
    pub fn numbers(&self, name: &str) -> &[Option<f64>] {
        if let Some(Column::Numbers(entries)) = self.column(name) { entries } else { &[] }
    }

    /// The entries of a column of texts; empty where there is none of this name.
    pub fn words(&self, name: &str) -> &[Option<String>] {
        if let Some(Column::Words(entries)) = self.column(name) { entries } else { &[] }
    }

    /// The metadata of this name.
    pub fn note(&self, name: &str) -> Option<&str> {
        self.notes.iter().find(|(other, _)| other == name).map(|(_, text)| text.as_str())
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| column.len())
    }

    /// The same with some of the columns.
    #[must_use]
    pub fn with_columns(mut self, keep: impl Fn(&str) -> bool) -> Self {
        self.columns.retain(|(name, _)| keep(name));
        self
    }

    /// The same with these columns, in this order; null where there is none of that name.
    #[must_use]
    pub fn conformed(mut self, columns: &[(String, Kind)]) -> Self {
        let rows = self.rows();
        let mut taken = |(name, kind): &(String, Kind)| {
            let found = self.columns.iter_mut().find(|(other, column)| other == name && column.kind() == *kind);
            let none = Column::nulls(*kind, 0);
            let column = found.map(|(_, column)| std::mem::replace(column, none));
            (name.clone(), column.unwrap_or_else(|| Column::nulls(*kind, rows)))
        };
        let columns = columns.iter().map(&mut taken).collect();
        Self { columns, notes: self.notes }
    }

    /// Cuts off all rows from `row` on, and returns them.
    #[must_use]
    pub fn split_off(&mut self, row: usize) -> Self {
        let columns = self.columns.iter_mut().map(|(name, column)| (name.clone(), column.split_off(row))).collect();
        Self { columns, notes: self.notes.clone() }
    }

    /// Adds rows of the same columns; those of an empty table are taken over.
    pub fn append(&mut self, more: Table) {
        if self.columns.is_empty() {
            self.columns = more.columns;
            return;
        }
        for ((name, column), (_, more)) in self.columns.iter_mut().zip(more.columns) {
            let same = column.append(more);
            debug_assert!(same, "the column {name} changes its type");
        }
    }
}

impl Column {
    /// Entries that are all null.
    pub fn nulls(kind: Kind, rows: usize) -> Self {
        match kind {
            Kind::Counts => Self::Counts(vec![None; rows]),
            Kind::Numbers => Self::Numbers(vec![None; rows]),
            Kind::Words => Self::Words(vec![None; rows]),
            Kind::Flags => Self::Flags(vec![None; rows]),
        }
    }

    /// Type of its entries.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Counts(_) => Kind::Counts,
            Self::Numbers(_) => Kind::Numbers,
            Self::Words(_) => Kind::Words,
            Self::Flags(_) => Kind::Flags,
        }
    }

    fn split_off(&mut self, row: usize) -> Self {
        match self {
            Self::Counts(entries) => Self::Counts(entries.split_off(row)),
            Self::Numbers(entries) => Self::Numbers(entries.split_off(row)),
            Self::Words(entries) => Self::Words(entries.split_off(row)),
            Self::Flags(entries) => Self::Flags(entries.split_off(row)),
        }
    }

    fn len(&self) -> usize {
        match self {
            Column::Counts(entries) => entries.len(),
            Column::Numbers(entries) => entries.len(),
            Column::Words(entries) => entries.len(),
            Column::Flags(entries) => entries.len(),
        }
    }

    /// Adds entries; `false`: they are of another type.
    fn append(&mut self, more: Column) -> bool {
        match (self, more) {
            (Column::Counts(entries), Column::Counts(more)) => entries.extend(more),
            (Column::Numbers(entries), Column::Numbers(more)) => entries.extend(more),
            (Column::Words(entries), Column::Words(more)) => entries.extend(more),
            (Column::Flags(entries), Column::Flags(more)) => entries.extend(more),
            _ => return false,
        }
        true
    }
}
