//! A motion given as a table of poses in a file: `t, x, y, z` and, all or none, `qw, qx, qy, qz`.
//!
//! The first line names the columns, in any order, and may give units: `x [mm]`; without, lengths are in m. The times
//! t increase; their unit does not matter, since the first is the beginning of the step and the last is its end.
//! Lines that begin with `#` are comments.

use super::entry::Entry;
use super::reader::Reader;
use crate::fault::did_you_mean;
use crate::format::units;
use crate::span::Span;
use csv::{ReaderBuilder, StringRecord, Trim};
use nalgebra::{Quaternion, Unit};
use wireloom_core::{Quantity, Rotation, Vector};

/// The columns.
const COLUMNS: [&str; 8] = ["t", "x", "y", "z", "qw", "qx", "qy", "qz"];
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
    let path = entry.word(key)?;
    let text = entry.reader.file(path, entry.span_of(key))?;
    let mut table = Table { reader: entry.reader, path, text: &text, span: entry.span_of(key), faults: 0 };
    let poses = table.read();
    if table.faults > FAULTS {
        let message = format!("{path}: {} more faults", table.faults - FAULTS);
        entry.fault_at(key, message, "they may follow from the first ones");
    }
    poses.filter(|_| table.faults == 0)
}

struct Table<'t> {
    reader: &'t Reader<'t>,
    path: &'t str,
    text: &'t str,
    span: Span,
    faults: usize,
}

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

    fn read(&mut self) -> Option<Vec<TimedPose>> {
        let mut lines = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(Trim::All)
            .comment(Some(b'#'))
            .from_reader(self.text.as_bytes());
        let mut records = lines.records().filter_map(Result::ok);
        let Some(header) = records.next() else {
            self.fault(1, "the file is empty", "begin with a line that names the columns: t, x, y, z");
            return None;
        };
        let columns = self.header(&header)?;
        let mut rows: Vec<(f64, TimedPose)> = Vec::new();
        for record in records {
            let line = self.line_of(&record);
            if record.len() != header.len() {
                let message = format!("{} values in {} columns", record.len(), header.len());
                self.fault(line, &message, "give one value for each column, separated by commas");
                continue;
            }
            let values = COLUMNS.map(|name| self.value(&record, name, &columns));
            let [Ok(Some(t)), Ok(Some(x)), Ok(Some(y)), Ok(Some(z)), Ok(qw), Ok(qx), Ok(qy), Ok(qz)] = values else {
                continue;
            };
            if let Some((last, _)) = rows.last().filter(|(last, _)| t <= *last) {
                let message = format!("`t` = {t} does not come after {last}");
                self.fault(line, &message, "give poses in the order in which they are passed");
            }
            let orientation = match (qw, qx, qy, qz) {
                (Some(w), Some(x), Some(y), Some(z)) => {
                    let turn = Unit::try_new(Quaternion::new(w, x, y, z), 1e-9);
                    if turn.is_none() {
                        self.fault(line, "the quaternion is zero", "1, 0, 0, 0 leaves the axes as they are");
                    }
                    turn
                }
                _ => None,
            };
            rows.push((t, TimedPose { at: 0.0, position: Vector::new(x, y, z), orientation }));
        }
        let after = self.line_of(&header) + 1;
        let (Some(first), Some(last)) = (rows.first().map(|row| row.0), rows.last().map(|row| row.0)) else {
            self.fault(self.line_of(&header) + 1, "no poses follow", "give at least two: the first and the last pose");
            return None;
        };
        if rows.len() == 1 {
            self.fault(after, "only one pose", "give at least two: the first and the last pose");
        }
        let share = |t: f64| if t == last { 1.0 } else { (t - first) / (last - first) };
        Some(rows.into_iter().map(|(t, pose)| TimedPose { at: share(t), ..pose }).collect())
    }

    /// The positions of the columns.
    fn header(&mut self, header: &StringRecord) -> Option<[Column; 8]> {
        let line = self.line_of(header);
        let before = self.faults;
        let mut columns: [Column; 8] = [None; 8];
        for (place, title) in header.iter().enumerate() {
            let (name, unit) = match title.split_once('[') {
                Some((name, unit)) => (name.trim(), Some(unit.trim_end_matches(']').trim())),
                None => (title, None),
            };
            let Some(index) = COLUMNS.iter().position(|column| *column == name) else {
                self.fault(line, &format!("unknown column `{title}`"), &did_you_mean(name, COLUMNS));
                continue;
            };
            let factor = match (index, unit) {
                (_, None) => Some(1.0),
                // The whole motion takes one step, in any unit of time.
                (0, Some(_)) => Some(1.0),
                (1..=3, Some(unit)) => units::parse(&format!("1 {unit}"), Quantity::Length).ok(),
                (_, Some(_)) => None,
            };
            if factor.is_none() {
                let help = if index > 3 { "quaternions have no unit" } else { "give a unit of length, such as x [mm]" };
                self.fault(line, &format!("`{title}` has a unit that does not fit"), help);
            }
            if columns[index].is_some() {
                self.fault(line, &format!("there are two columns `{name}`"), "leave one of them out");
            }
            columns[index] = Some((place, factor.unwrap_or(1.0)));
        }
        for (index, name) in COLUMNS.iter().enumerate() {
            let turns = columns[4..].iter().any(Option::is_some);
            if columns[index].is_none() && (index < 4 || turns) {
                let help = "the first line names the columns: t, x, y, z and, all or none, qw, qx, qy, qz";
                self.fault(line, &format!("there is no column `{name}`"), help);
            }
        }
        (self.faults == before).then_some(columns)
    }

    /// The value of a column; `Ok(None)` if there is no such column.
    fn value(&mut self, record: &StringRecord, name: &str, columns: &[Column; 8]) -> Result<Option<f64>, ()> {
        let index = COLUMNS.iter().position(|column| *column == name).ok_or(())?;
        let Some((place, factor)) = columns[index] else { return Ok(None) };
        let text = &record[place];
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Some(value * factor)),
            _ => {
                let message = format!("`{name}` is \"{text}\", not a finite number");
                let line = self.line_of(record);
                self.fault(line, &message, "write a number with a decimal point; give units in the first line");
                Err(())
            }
        }
    }
}
