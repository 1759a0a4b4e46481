//! One table of all parts, sorted by the numbers of its points. Every point is in it once, and every row is as it was
//! written. Its bytes are those of the table that one process writes.

use crate::error::Error;
use crate::manifest::BEFORE_REQUIREMENTS;
use crate::status::Status;
use crate::store::Object;
use crate::{Dataset, Part};
use std::io;
use wireloom::export::table::{Column, FILE, Grouped, Head, Kind, OF_REQUIREMENT, Table, statistics};

/// The table of all points.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Compacted {
    /// Its name: the place and `points.parquet`.
    pub name: String,
    /// Number of its rows.
    pub rows: usize,
    /// Number of its columns.
    pub columns: usize,
    /// Its bytes.
    pub bytes: u64,
}

impl Dataset {
    /// Writes the table of all points beside the parts, which stay. `done` is called with the number of points so far.
    ///
    /// # Errors
    /// Points are missing, a part is damaged, or the store cannot be used; a table that was there stays.
    pub fn compact(&self, done: &dyn Fn(usize)) -> Result<Compacted, Error> {
        let listing = self.listing()?;
        let place = || self.place().to_owned();
        if !listing.foreign.is_empty() {
            return Err(Error::Foreign { place: place(), names: listing.foreign });
        }
        let missing = listing.missing(self.manifest.points);
        if !missing.is_empty() {
            return Err(Error::Missing { place: place(), ranges: missing });
        }
        let cover = listing.cover();
        let mut union = Union { chosen: self.manifest.columns.is_some(), ..Union::default() };
        for (part, _) in &cover {
            union.add(part, &self.head(part)?)?;
        }
        let columns = union.columns();
        let empty = Table {
            columns: columns.iter().map(|(name, kind)| (name.clone(), Column::nulls(*kind, 0))).collect(),
            notes: self.notes(&union.requirements),
        };
        let failed = |source: io::Error| Error::System { place: place(), what: format!("write {FILE}"), source };
        self.store.write(FILE, |out| {
            let mut file = Grouped::begin(&empty, out).map_err(failed)?;
            for (part, first) in &cover {
                let table = self.read(part)?.conformed(&columns);
                for chain in self.chains(table, part, *first) {
                    file.add(chain).map_err(failed)?;
                }
                done(part.range.end);
            }
            file.finish().map_err(failed)
        })?;
        self.written(columns.len())
    }

    /// The rows of a part from a point on, chain by chain.
    fn chains(&self, mut table: Table, part: &Part, first: usize) -> Vec<Table> {
        let mut rest = table.split_off(first - part.range.start);
        let mut chains = Vec::new();
        while rest.rows() > 0 {
            let after = rest.split_off(self.manifest.chain.min(rest.rows()));
            chains.push(std::mem::replace(&mut rest, after));
        }
        chains
    }

    /// Metadata of the table: that of the sweep, with the requirements that its points have.
    fn notes(&self, requirements: &[String]) -> Vec<(String, String)> {
        let note = |(key, text): &(String, String)| {
            let requirements = (key == statistics::REQUIREMENTS).then(|| requirements.join("\n"));
            (key.clone(), requirements.unwrap_or_else(|| text.clone()))
        };
        self.manifest.notes.iter().map(note).collect()
    }

    /// The table as it is there now.
    fn written(&self, columns: usize) -> Result<Compacted, Error> {
        let whole = 0..self.manifest.points;
        let lost = |reason: String| Error::Damaged { name: FILE.to_owned(), reason, range: whole.clone() };
        let object: Option<Object> = self.store.list()?.into_iter().find(|object| object.name == FILE);
        let object = object.ok_or_else(|| lost("it has vanished".to_owned()))?;
        let head = self.head_of(&object, &whole)?;
        if head.rows != self.manifest.points {
            return Err(lost(format!("it has {} of {} rows", head.rows, self.manifest.points)));
        }
        let name = format!("{}/{FILE}", self.place().trim_end_matches('/'));
        Ok(Compacted { name, rows: head.rows, columns, bytes: object.size })
    }
}

impl Status {
    /// Whether the table of all points can be written.
    pub fn is_complete(&self) -> bool {
        self.missing.is_empty()
    }
}

/// Columns of several parts: a part has the columns of those requirements that its points have.
#[derive(Default)]
struct Union {
    /// Whether columns were chosen: then all parts have them.
    chosen: bool,
    columns: Vec<(String, Kind)>,
    /// Lines of the note on requirements.
    requirements: Vec<String>,
}

impl Union {
    fn add(&mut self, part: &Part, head: &Head) -> Result<(), Error> {
        let lines: Vec<&str> = head.table.note(statistics::REQUIREMENTS).unwrap_or_default().lines().collect();
        let names = lines.iter().filter_map(|line| line.split_once('\t')).map(|(_, name)| name);
        let own: Vec<String> =
            names.flat_map(|name| OF_REQUIREMENT.map(|(what, _)| format!("{what}.{name}"))).collect();
        let kinds = head.table.columns.iter().map(|(name, column)| (name.clone(), column.kind()));
        let columns: Vec<(String, Kind)> = kinds.filter(|(name, _)| self.chosen || !own.contains(name)).collect();
        if self.columns.is_empty() {
            self.columns = columns;
        } else if self.columns != columns {
            let reason = "its columns are not those of the other parts".to_owned();
            return Err(Error::Damaged { name: part.object.name.clone(), reason, range: part.range.clone() });
        }
        for line in lines {
            if !self.requirements.iter().any(|known| known == line) {
                self.requirements.push(line.to_owned());
            }
        }
        Ok(())
    }

    /// All columns in the order in which a table has them.
    fn columns(&self) -> Vec<(String, Kind)> {
        if self.chosen {
            return self.columns.clone();
        }
        let names = self.requirements.iter().filter_map(|line| line.split_once('\t')).map(|(_, name)| name);
        let of_requirements =
            names.flat_map(|name| OF_REQUIREMENT.map(|(what, kind)| (format!("{what}.{name}"), kind)));
        let at =
            self.columns.iter().position(|(name, _)| name == BEFORE_REQUIREMENTS).map_or(self.columns.len(), |k| k + 1);
        let mut columns = self.columns.clone();
        columns.splice(at..at, of_requirements);
        columns
    }
}
