//! A part: some points as a Parquet file that says of which sweep it is, and whose rows are checked by their hash.

use crate::error::Error;
use crate::store::Object;
use crate::{Dataset, Part};
use std::collections::BTreeMap;
use std::io;
use std::ops::Range;
use std::panic::catch_unwind;
use wireloom::Status;
use wireloom::export::sha256;
use wireloom::export::table::{
    Column, Grouped, Head, Header, Kind, Layout, OF_REQUIREMENT, Row, Table, Tail, head, read, statistics,
};

/// Metadata: program, hash of the manifest, points, hash of the rows, points without a result by reason; and a hash of
/// columns and metadata.
const PROGRAM: &str = "wireloom.program";
const SWEEP: &str = "wireloom.sweep";
const POINTS: &str = "wireloom.points";
const ROWS: &str = "wireloom.rows";
const FAILED: &str = "wireloom.failed";
const HEAD: &str = "wireloom.head";

/// Reasons that a part tells of each status.
const REASONS: usize = 5;
/// Characters of a reason.
const REASON: usize = 200;
/// Bytes at the end of a part that are read to learn what is in it: enough for some hundred columns.
const TAIL: u64 = 1 << 16;

/// A part that was written, or that was there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// Its bytes.
    pub bytes: usize,
    /// Points that did not converge.
    pub failed: usize,
    /// Whether it was there already, written by another worker.
    pub known: bool,
}

impl Dataset {
    /// Writes the part with these points, unless it is there already. `chains` are the rows of its chains, in order.
    ///
    /// # Errors
    /// The store cannot be used.
    pub fn write(&self, points: &Range<usize>, header: &Header, chains: &[Vec<Row>]) -> Result<Written, Error> {
        let name = self.manifest.part(points);
        let (bytes, failed) = self.encode(points, header, chains).map_err(|source| Error::System {
            place: self.place().to_owned(),
            what: format!("encode {name}"),
            source,
        })?;
        let size = bytes.len();
        let known = !self.store.create(&name, bytes)?;
        Ok(Written { bytes: size, failed, known })
    }

    /// The part as a file, and the number of its points that did not converge.
    fn encode(&self, points: &Range<usize>, header: &Header, chains: &[Vec<Row>]) -> io::Result<(Vec<u8>, usize)> {
        let mut layout = Layout::new(header);
        chains.iter().for_each(|rows| layout.add(rows));
        let columns = self.manifest.columns.as_ref().map(|names| self.columns(names, &layout));
        let mut first = points.start;
        let tables = chains.iter().map(|rows| {
            let table = layout.table(first, rows);
            first += rows.len();
            if let Some(columns) = &columns { table.conformed(columns) } else { table }
        });
        let tables: Vec<Table> = tables.collect();
        let mut whole = Table::default();
        tables.iter().for_each(|table| whole.append(table.clone()));
        let failures = Failures::of(&whole);
        let notes = [
            (PROGRAM, self.manifest.program.clone()),
            (SWEEP, self.manifest.hash.clone()),
            (POINTS, format!("{}..{}", points.start, points.end)),
            (ROWS, digest(&whole)),
            (FAILED, failures.text()),
            (statistics::REQUIREMENTS, statistics::requirement_lines(layout.requirements())),
        ];
        whole.notes = notes.map(|(key, text)| (key.to_owned(), text)).to_vec();
        whole.notes.push((HEAD.to_owned(), digest_of_head(&whole)));
        let mut bytes = Vec::new();
        let mut file = Grouped::begin(&whole, &mut bytes)?;
        for table in tables {
            file.add(table)?;
        }
        file.finish()?;
        Ok((bytes, failures.points()))
    }

    /// Chosen columns with their types.
    fn columns(&self, names: &[String], layout: &Layout<'_>) -> Vec<(String, Kind)> {
        let known = layout.table(0, &[]).columns;
        let kind = |name: &String| {
            let there = known.iter().find(|(other, _)| other == name).map(|(_, column)| column.kind());
            // A requirement that no point of this part has.
            let of_requirement =
                || OF_REQUIREMENT.iter().find(|(what, _)| name.starts_with(&format!("{what}."))).map(|(_, kind)| *kind);
            (name.clone(), there.or_else(of_requirement).unwrap_or(Kind::Numbers))
        };
        names.iter().map(kind).collect()
    }

    /// Columns and metadata of a part.
    pub(crate) fn head(&self, part: &Part) -> Result<Head, Error> {
        let head = self.head_of(&part.object, &part.range)?;
        let Range { start, end } = part.range;
        let note = |name: &str| head.table.note(name).unwrap_or_default();
        let reason = if note(HEAD) != digest_of_head(&head.table) {
            Some("its columns or its metadata are not those that were written".to_owned())
        } else if note(SWEEP) != self.manifest.hash {
            let program = note(PROGRAM);
            Some(format!("it is a part of another sweep (of {program}, this one is of {})", self.manifest.program))
        } else if note(POINTS) != format!("{start}..{end}") || head.rows != end - start {
            Some(format!("it has {} rows and the points {}", head.rows, note(POINTS)))
        } else {
            None
        };
        match reason {
            Some(reason) => Err(damaged(part, reason)),
            None => Ok(head),
        }
    }

    /// Columns and metadata of an object with these points.
    pub(crate) fn head_of(&self, object: &Object, range: &Range<usize>) -> Result<Head, Error> {
        let mut wanted = TAIL;
        loop {
            let tail = self.store.tail(object, wanted)?;
            let (read, size) = (tail.len() as u64, object.size);
            let parsed = caught(move || head(tail, size));
            match parsed {
                Ok(Tail::Head(head)) => return Ok(head),
                Ok(Tail::Short(more)) if more > read && more <= size => wanted = more,
                other => {
                    let reason = other.err().unwrap_or_else(|| "it is too short".to_owned());
                    return Err(Error::Damaged { name: object.name.clone(), reason, range: range.clone() });
                }
            }
        }
    }

    /// The rows of a part, which are as they were written.
    pub(crate) fn read(&self, part: &Part) -> Result<Table, Error> {
        let bytes = self.store.read(&part.object.name)?.ok_or_else(|| damaged(part, "it has vanished".to_owned()))?;
        let table = caught(move || read(bytes)).map_err(|reason| damaged(part, reason))?;
        let numbers = match table.column("point") {
            Some(Column::Counts(numbers)) => numbers.as_slice(),
            _ => &[],
        };
        let right = numbers.iter().copied().eq(part.range.clone().map(|k| Some(k as i64)));
        if !right || table.note(ROWS) != Some(digest(&table).as_str()) {
            return Err(damaged(part, "its rows are not those that were written".to_owned()));
        }
        Ok(table)
    }
}

fn damaged(part: &Part, reason: String) -> Error {
    Error::Damaged { name: part.object.name.clone(), reason, range: part.range.clone() }
}

/// What is read from bytes that may be damaged, or the reason why nothing is: the reader may panic.
fn caught<T>(read: impl FnOnce() -> io::Result<T> + std::panic::UnwindSafe) -> Result<T, String> {
    match catch_unwind(read) {
        Ok(read) => read.map_err(|error| error.to_string()),
        Err(_) => Err("it is no Parquet file of this program".to_owned()),
    }
}

/// Hash of the columns of a table and of its metadata.
fn digest_of_head(table: &Table) -> String {
    let columns: Vec<String> =
        table.columns.iter().map(|(name, column)| format!("{name} {:?}", column.kind())).collect();
    let notes: Vec<_> = table.notes.iter().filter(|(key, _)| key != HEAD).collect();
    sha256(format!("{columns:?}{notes:?}").as_bytes())
}

/// Hash of the rows of a table.
fn digest(table: &Table) -> String {
    let mut bytes = Vec::new();
    let mut entry = |entry: Option<&[u8]>| {
        // The length of null is that of no entry.
        bytes.extend(entry.map_or(u64::MAX, |entry| entry.len() as u64).to_le_bytes());
        bytes.extend(entry.unwrap_or_default());
    };
    for (name, column) in &table.columns {
        entry(Some(name.as_bytes()));
        match column {
            Column::Counts(all) => all.iter().for_each(|n| entry(n.map(i64::to_le_bytes).as_ref().map(|n| &n[..]))),
            Column::Numbers(all) => all.iter().for_each(|x| entry(x.map(f64::to_le_bytes).as_ref().map(|x| &x[..]))),
            Column::Words(all) => all.iter().for_each(|word| entry(word.as_ref().map(|word| word.as_bytes()))),
            Column::Flags(all) => {
                all.iter().for_each(|flag| entry(flag.map(|flag| [u8::from(flag)]).as_ref().map(|f| &f[..])))
            }
        }
    }
    sha256(&bytes)
}

/// Points that did not converge: number by status and reason; of further reasons of a status only their number.
#[derive(Default)]
pub(crate) struct Failures(pub BTreeMap<String, BTreeMap<String, usize>>);

impl Failures {
    fn of(table: &Table) -> Self {
        let mut failures = Self::default();
        let messages = table.words("message");
        for (k, status) in table.words("status").iter().enumerate() {
            let status = status.as_deref().unwrap_or_default();
            if status == Status::Converged.word() {
                continue;
            }
            let message = messages.get(k).and_then(Option::as_deref).unwrap_or_default();
            let reason: String = message.chars().map(|c| if c.is_control() { ' ' } else { c }).take(REASON).collect();
            failures.add(status, &reason, 1);
        }
        failures
    }

    /// Counts further points.
    pub fn add(&mut self, status: &str, reason: &str, points: usize) {
        let reasons = self.0.entry(status.to_owned()).or_default();
        let reason = if reasons.len() < REASONS || reasons.contains_key(reason) { reason } else { "" };
        *reasons.entry(reason.to_owned()).or_default() += points;
    }

    fn points(&self) -> usize {
        self.0.values().flat_map(BTreeMap::values).sum()
    }

    /// A line for each status and reason.
    fn text(&self) -> String {
        let line = |status: &str, reason: &str, points: &usize| format!("{points}\t{status}\t{reason}");
        let lines: Vec<String> =
            self.0.iter().flat_map(|(status, all)| all.iter().map(move |(why, n)| line(status, why, n))).collect();
        lines.join("\n")
    }

    /// Counts those that a part tells of.
    pub fn add_part(&mut self, head: &Head) {
        for line in head.table.note(FAILED).unwrap_or_default().lines() {
            let mut words = line.splitn(3, '\t');
            if let (Some(Ok(points)), Some(status)) = (words.next().map(str::parse), words.next()) {
                self.add(status, words.next().unwrap_or_default(), points);
            }
        }
    }
}
