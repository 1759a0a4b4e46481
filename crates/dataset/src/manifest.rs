//! What is swept: a hash of everything that the points depend on, and the names of parts that follow from it.

use crate::error::Error;
use crate::store::Store;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use wireloom::export::sha256;
use wireloom::export::table::{Layout, OF_REQUIREMENT};
use wireloom::harness::Network;
use wireloom::result::Library;
use wireloom::scenario::fault::did_you_mean;
use wireloom::sweep::Points;

/// Name of its object.
pub const MANIFEST: &str = "sweep.json";
/// Where parts are.
pub const PARTS: &str = "parts/";
/// Version of datasets; changes with the meaning of their objects.
const FORMAT: u32 = 1;
/// Columns that every part has: they say which points are there, and why points failed.
const ALWAYS: [&str; 3] = ["point", "status", "message"];
/// Column after which those of the requirements come.
pub const BEFORE_REQUIREMENTS: &str = "stable";
/// Digits of the hash in the name of a part.
const DIGITS: usize = 32;

/// What is swept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    format: u32,
    /// Name and version of the program.
    pub program: String,
    /// Name of the scenario.
    pub scenario: String,
    /// Number of points.
    pub points: usize,
    /// Points of a chain.
    pub chain: usize,
    /// Chosen columns; `None`: all.
    pub columns: Option<Vec<String>>,
    /// SHA-256 of everything that parts depend on.
    pub hash: String,
    /// Metadata of the table of all points.
    pub notes: Vec<(String, String)>,
}

/// Everything that points depend on.
pub struct Origin<'o> {
    /// Name and version of the program.
    pub program: &'o str,
    /// Minimiser that replaces that of the scenario.
    pub minimiser: Option<&'o str>,
    /// Names and texts: of the scenario, then of the files it names.
    pub texts: &'o [(String, String)],
    /// Names and SHA-256 of other files.
    pub hashed: &'o [(String, String)],
    /// Plugins.
    pub plugins: &'o [Library],
    /// Metadata of the table of all points.
    pub notes: Vec<(String, String)>,
}

impl Manifest {
    /// The manifest of a sweep with some columns of its table, or all of them.
    ///
    /// # Errors
    /// There is no such column.
    pub fn of(
        origin: Origin<'_>,
        scenario: &str,
        points: &Points<'_>,
        network: &Network,
        columns: Option<&[String]>,
    ) -> Result<Self, Error> {
        let columns = columns.map(|columns| chosen(columns, points, network)).transpose()?;
        let Origin { program, minimiser, texts, hashed, plugins, notes } = origin;
        // The name of the scenario's file changes nothing, nor does the place of a plugin.
        let texts: Vec<(&str, &str)> =
            texts.iter().enumerate().map(|(k, (name, text))| (if k == 0 { "" } else { name }, text.as_str())).collect();
        let mut files = hashed.to_vec();
        files.sort_unstable();
        let plugins: Vec<_> = plugins.iter().map(|plugin| (&plugin.name, &plugin.version, &plugin.hash)).collect();
        let chain = points.chain_length();
        let all = (FORMAT, program, minimiser, texts, files, plugins, points.sweep.points, chain, &columns);
        // Texts and numbers are always valid JSON.
        let hash = sha256(&serde_json::to_vec(&all).unwrap_or_default());
        Ok(Self {
            format: FORMAT,
            program: program.to_owned(),
            scenario: scenario.to_owned(),
            points: points.sweep.points,
            chain,
            columns,
            hash,
            notes,
        })
    }

    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        serde_json::to_vec_pretty(self).unwrap_or_default()
    }

    /// The one of a store.
    pub(crate) fn read(store: &Store) -> Result<Self, Error> {
        let place = store.place().to_owned();
        let Some(bytes) = store.read(MANIFEST)? else { return Err(Error::NoSweep { place }) };
        let manifest = serde_json::from_slice::<Self>(&bytes).map_err(|error| error.to_string());
        manifest
            .and_then(|manifest| match manifest {
                Self { format: FORMAT, points: 1.., chain: 1.., .. } => Ok(manifest),
                Self { program, .. } => Err(format!("it is of another version ({program})")),
            })
            .map_err(|reason| Error::Other { place, difference: format!("its {MANIFEST} cannot be read, {reason}") })
    }

    /// Why a dataset is not that of `wanted`.
    pub(crate) fn differs(&self, wanted: &Self, place: &str) -> Error {
        let text = |manifest: &Self| {
            manifest.notes.iter().find(|(key, _)| key == "wireloom.text").map(|(_, text)| text.clone())
        };
        let (there, here) = (self, wanted);
        let difference = if there.program != here.program {
            format!("they are of {}, this is {}", there.program, here.program)
        } else if there.columns != here.columns {
            let words = |columns: &Option<Vec<String>>| columns.as_ref().map_or("all".to_owned(), |all| all.join(", "));
            format!("they have the columns {}, not {}", words(&there.columns), words(&here.columns))
        } else if text(there) != text(here) {
            "their scenario has another text".to_owned()
        } else {
            "another minimiser, or a file or plugin that the scenario names has changed".to_owned()
        };
        Error::Other { place: place.to_owned(), difference }
    }

    /// Name of the part with these points.
    pub(crate) fn part(&self, Range { start, end }: &Range<usize>) -> String {
        let hash = sha256(format!("{} {start} {end}", self.hash).as_bytes());
        format!("{PARTS}{start:010}-{end:010}-{}.parquet", &hash[..DIGITS])
    }

    /// The points of the part of this name; `None`: it is none of this sweep.
    pub(crate) fn range_of(&self, name: &str) -> Option<Range<usize>> {
        let mut numbers = name.strip_prefix(PARTS)?.split('-');
        let range = numbers.next()?.parse().ok()?..numbers.next()?.parse().ok()?;
        (self.part(&range) == name && range.start < range.end && range.end <= self.points).then_some(range)
    }
}

/// The columns of parts where some are chosen, in the order of the table.
fn chosen(columns: &[String], points: &Points<'_>, network: &Network) -> Result<Vec<String>, Error> {
    let mut known: Vec<String> = Layout::new(&points.header).table(0, &[]).columns.into_iter().map(|c| c.0).collect();
    let names = network.requirement_names();
    let of_requirements = names.iter().flat_map(|name| OF_REQUIREMENT.map(|(what, _)| format!("{what}.{name}")));
    let at = known.iter().position(|name| name == BEFORE_REQUIREMENTS).map_or(known.len(), |k| k + 1);
    known.splice(at..at, of_requirements);
    if let Some(name) = columns.iter().find(|name| !known.contains(name)) {
        return Err(Error::Column { name: name.clone(), help: did_you_mean(name, known.iter().map(String::as_str)) });
    }
    known.retain(|name| ALWAYS.contains(&name.as_str()) || columns.contains(name));
    Ok(known)
}
