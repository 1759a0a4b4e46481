//! A motion given as a table in a file: poses `t, x, y, z` and, all or none, `qw, qx, qy, qz`; or values `t, value` of
//! a joint.
//!
//! The first line names the columns, in any order, and may give units: `x [mm]`; without, lengths are in m and angles
//! in rad. The times t increase; their unit does not matter, since the first is the beginning of the step and the last
//! is its end. Lines that begin with `#` are comments.

use super::entry::Entry;
use super::reader::Reader;
use crate::fault::did_you_mean;
use crate::format::limits::ANY;
use crate::format::units;
use crate::span::Span;
use csv::{ReaderBuilder, StringRecord, Trim};
use nalgebra::{Quaternion, Unit};
use wireloom_core::{Quantity, Rotation, Vector};

/// Units that a column may have.
#[derive(Clone, Copy)]
enum Units {
    /// Any: they make no difference.
    Any,
    /// Those of a quantity.
    Of(Quantity),
    /// None.
    No,
}

/// A column, by name, and the units that it may have.
type Title = (&'static str, Units);

/// The columns of poses. The last four are given together or not at all.
const POSE: [Title; 8] = [
    ("t", Units::Any),
    ("x", Units::Of(Quantity::Length)),
    ("y", Units::Of(Quantity::Length)),
    ("z", Units::Of(Quantity::Length)),
    ("qw", Units::No),
    ("qx", Units::No),
    ("qy", Units::No),
    ("qz", Units::No),
];
/// Number of columns of poses that must be given.
const POSITIONS: usize = 4;
/// Largest number of faults shown for a file: a wrong column is wrong in every line.
const FAULTS: usize = 10;

/// A line of the table.
pub(crate) struct TimedPose {
    /// Fraction of the step; 0 in the first line, 1 in the last.
    pub at: f64,
    /// Position, m.
    pub position: Vector,
    /// Orientation, if there are columns for it.
    pub orientation: Option<Rotation>,
}

/// The poses of the file that a key names; `None` if there are faults.
pub(crate) fn read(entry: &Entry<'_>, key: &str) -> Option<Vec<TimedPose>> {
    read_table(entry, key, &POSE, |table| table.poses())
}

/// Fractions of the step, from 0 to 1, and values of the file that a key names; `None` if there are faults.
pub(crate) fn read_values(entry: &Entry<'_>, key: &str, quantity: Quantity) -> Option<Vec<(f64, f64)>> {
    let titles = [("t", Units::Any), ("value", Units::Of(quantity))];
    read_table(entry, key, &titles, |table| table.values())
}

fn read_table<T>(
    entry: &Entry<'_>,
    key: &str,
    titles: &[Title],
    read: impl FnOnce(&mut Table<'_>) -> Option<T>,
) -> Option<T> {
    let path = entry.word(key)?;
    let text = entry.reader.file(path, entry.span_of(key))?;
    let mut table = Table { reader: entry.reader, path, text: &text, titles, span: entry.span_of(key), faults: 0 };
    let rows = read(&mut table);
    if table.faults > FAULTS {
        let message = format!("{path}: {} more faults", table.faults - FAULTS);
        entry.fault_at(key, message, "they may follow from the first ones");
    }
    rows.filter(|_| table.faults == 0)
}

struct Table<'t> {
    reader: &'t Reader<'t>,
    path: &'t str,
    text: &'t str,
    titles: &'t [Title],
    span: Span,
    faults: usize,
}

/// A line of a table: its number, time or fraction of the step, and the values of all columns.
type Row = (u64, f64, Vec<Option<f64>>);

/// Position of a column, and the factor of its numbers.
type Column = Option<(usize, f64)>;

impl Table<'_> {
    /// Notes a fault in a line.
    fn fault(&mut self, line: u64, message: &str, help: &str) {
        self.faults += 1;
        if self.faults <= FAULTS {
            self.reader.fault(self.span.clone(), format!("{}:{line}: {message}", self.path), help);
        }
    }

    /// The line of a record: its position is the end of the one before it.
    fn line_of(&self, record: &StringRecord) -> u64 {
        let Some(position) = record.position() else { return 1 };
        let rest = self.text.get(position.byte() as usize..).unwrap_or_default();
        let skipped = rest.lines().take_while(|line| line.is_empty() || line.starts_with('#'));
        position.line() + skipped.count() as u64
    }

    fn poses(&mut self) -> Option<Vec<TimedPose>> {
        let rows = self.rows(POSITIONS)?;
        let mut poses = Vec::new();
        for (line, at, values) in rows {
            let orientation = match values[POSITIONS..] {
                [Some(w), Some(x), Some(y), Some(z)] => {
                    let turn = Unit::try_new(Quaternion::new(w, x, y, z), 1e-9);
                    if turn.is_none() {
                        self.fault(line, "the quaternion is zero", "1, 0, 0, 0 leaves the axes as they are");
                    }
                    turn
                }
                _ => None,
            };
            let [Some(x), Some(y), Some(z)] = values[1..POSITIONS] else { continue };
            poses.push(TimedPose { at, position: Vector::new(x, y, z), orientation });
        }
        Some(poses)
    }

    fn values(&mut self) -> Option<Vec<(f64, f64)>> {
        let rows = self.rows(2)?;
        Some(rows.into_iter().filter_map(|(_, at, values)| Some((at, values[1]?))).collect())
    }

    /// Rows of the table: line, fraction of the step, and the values of all columns. The first `needed` columns must be
    /// given; the others together or not at all.
    fn rows(&mut self, needed: usize) -> Option<Vec<Row>> {
        let mut lines = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .comment(Some(b'#'))
            .from_reader(self.text.as_bytes());
        let mut records = lines.records().filter_map(Result::ok);
        let names: Vec<&str> = self.titles[..needed].iter().map(|title| title.0).collect();
        let Some(header) = records.next() else {
            let help = format!("begin with a line that names the columns: {}", names.join(", "));
            self.fault(1, "the file is empty", &help);
            return None;
        };
        let columns = self.header(&header, needed)?;
        let mut rows: Vec<Row> = Vec::new();
        for record in records {
            let line = self.line_of(&record);
            if record.len() != header.len() {
                let message = format!("{} values in {} columns", record.len(), header.len());
                self.fault(line, &message, "give one value for each column, separated by commas");
                continue;
            }
            let before = self.faults;
            let values: Vec<Option<f64>> =
                (0..columns.len()).map(|k| self.value(&record, self.titles[k], columns[k])).collect();
            let (true, Some(t)) = (self.faults == before, values[0]) else { continue };
            if let Some((_, last, _)) = rows.last().filter(|(_, last, _)| t <= *last) {
                let message = format!("`t` = {t} does not come after {last}");
                self.fault(line, &message, "give lines in the order of time");
            }
            rows.push((line, t, values));
        }
        let after = self.line_of(&header) + 1;
        let (Some(first), Some(last)) = (rows.first().map(|row| row.1), rows.last().map(|row| row.1)) else {
            self.fault(after, "no lines follow", "give at least two: the beginning and the end");
            return None;
        };
        if rows.len() == 1 {
            self.fault(after, "only one line", "give at least two: the beginning and the end");
        }
        let share = |t: f64| if t == last { 1.0 } else { (t - first) / (last - first) };
        Some(rows.into_iter().map(|(line, t, values)| (line, share(t), values)).collect())
    }

    /// The positions of the columns.
    fn header(&mut self, header: &StringRecord, needed: usize) -> Option<Vec<Column>> {
        let line = self.line_of(header);
        let before = self.faults;
        let names: Vec<&str> = self.titles.iter().map(|title| title.0).collect();
        let mut columns: Vec<Column> = vec![None; names.len()];
        for (place, title) in header.iter().enumerate() {
            let (name, unit) = match title.split_once('[') {
                Some((name, unit)) => (name.trim(), Some(unit.trim_end_matches(']').trim())),
                None => (title, None),
            };
            let Some(index) = names.iter().position(|column| *column == name) else {
                self.fault(line, &format!("unknown column `{title}`"), &did_you_mean(name, names.iter().copied()));
                continue;
            };
            let factor = match (self.titles[index].1, unit) {
                // The whole motion takes one step, in any unit of time.
                (_, None) | (Units::Any, Some(_)) => Some(1.0),
                (Units::Of(quantity), Some(unit)) => units::parse(&format!("1 {unit}"), quantity).ok(),
                (Units::No, Some(_)) => None,
            };
            if factor.is_none() {
                let help = match self.titles[index].1 {
                    Units::Of(Quantity::Length) => format!("give a unit of length, such as {name} [mm]"),
                    Units::Of(_) => format!("give a unit of angle, such as {name} [deg]"),
                    _ => format!("`{name}` has no unit"),
                };
                self.fault(line, &format!("`{title}` has a unit that does not fit"), &help);
            }
            if columns[index].is_some() {
                self.fault(line, &format!("there are two columns `{name}`"), "leave one of them out");
            }
            columns[index] = Some((place, factor.unwrap_or(1.0)));
        }
        let others = columns[needed..].iter().any(Option::is_some);
        let mut help = format!("the first line names the columns: {}", names[..needed].join(", "));
        if names.len() > needed {
            help += &format!(" and, all or none, {}", names[needed..].join(", "));
        }
        for (index, name) in names.iter().enumerate() {
            if columns[index].is_none() && (index < needed || others) {
                self.fault(line, &format!("there is no column `{name}`"), &help);
            }
        }
        (self.faults == before).then_some(columns)
    }

    /// The value of a column; `None` if there is no such column, or, with a fault, if it is no number or out of range.
    fn value(&mut self, record: &StringRecord, (name, units): Title, column: Column) -> Option<f64> {
        let (place, factor) = column?;
        let text = &record[place];
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => {
                let value = value * factor;
                if let Units::Of(quantity) = units
                    && let limits = ANY.of(quantity)
                    && !(limits.minimum..=limits.maximum).contains(&value)
                {
                    let line = self.line_of(record);
                    let help = format!("give a value {}", limits.words(quantity));
                    self.fault(line, &format!("`{name}` = {text} is out of range"), &help);
                    return None;
                }
                Some(value)
            }
            _ => {
                let message = format!("`{name}` is \"{text}\", not a finite number");
                let line = self.line_of(record);
                self.fault(line, &message, "write a number with a decimal point; give units in the first line");
                None
            }
        }
    }
}
