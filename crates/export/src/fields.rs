//! Node fields beside `result.json`: with `[output] fields = "arrow"` they are in `fields.arrow`, and `result.json` has
//! everything else.
//!
//! `fields.arrow` is an Arrow IPC file (Feather version 2). It is not compressed, so programs map it into memory. It
//! has a row for each node, and a record batch for each equilibrium of `result.json`, in the same order:
//!
//! | column | type | unit |
//! | --- | --- | --- |
//! | `step` | dictionary of names | |
//! | `increment` | `uint32`, from 1 | |
//! | `branch` | dictionary of names, in the order of `result.json` | |
//! | `s` | `float64`: arc length | m |
//! | `position` | three `float64` | m |
//! | `d3`, `d1` | three `float64` each: directors | 1 |
//! | `force`, `moment` | three `float64` each: internal force and moment | N, N m |
//! | `bend_radius` | `float64`; infinite where the branch is straight | m |
//! | `set` | three `float64`; null for branches without friction; left out where no branch has friction | 1/m |
//! | `strain` | `float64`; null for branches whose axial law is linear; left out where all are | 1 |
//!
//! They have the meaning of the lists of the same name in `result.json`, and the same bits. In `result.json`, `fields`
//! names the file, `nodes` of a branch is the number of its rows, and `fields_sha256` of an equilibrium is the SHA-256
//! of the bytes from the end of the record batch before (or the start of the file) to the end of its own: a file of
//! another run, or a damaged one, is refused.
//!
//! Compression saves little, since most digits of computed numbers look random: of the main harness's assembly, 230
//! increments of 3,333 nodes, LZ4 leaves 92 % and Zstandard 86 %, and a compressed file cannot be mapped.

#[cfg(feature = "arrow")]
mod read;
#[cfg(feature = "arrow")]
mod write;

#[cfg(feature = "arrow")]
pub(crate) use read::Reader;
#[cfg(feature = "arrow")]
pub(crate) use write::hashes;
#[cfg(feature = "arrow")]
pub use write::{Fields, write};

use wireloom_core::Vector;

/// The node fields of a branch, as in `result.json`.
pub(crate) struct BranchFields {
    pub s: Vec<f64>,
    pub position: Vec<Vector>,
    pub d3: Vec<Vector>,
    pub d1: Vec<Vector>,
    pub force: Vec<Vector>,
    pub moment: Vec<Vector>,
    pub bend_radius: Vec<f64>,
    /// None where no branch of the file has friction.
    pub set: Option<Vec<Vector>>,
    /// None for a branch whose axial law is linear.
    pub strain: Option<Vec<f64>>,
}

/// Its file.
pub const FILE: &str = "fields.arrow";

/// Names of the columns that are numbers of one node, and how many each has.
#[cfg(feature = "arrow")]
const COLUMNS: [(&str, usize, &str); 9] = [
    ("s", 1, "m"),
    ("position", 3, "m"),
    ("d3", 3, "1"),
    ("d1", 3, "1"),
    ("force", 3, "N"),
    ("moment", 3, "N m"),
    ("bend_radius", 1, "m"),
    ("set", 3, "1/m"),
    ("strain", 1, "1"),
];
/// Number of columns that every file has, of [`COLUMNS`]; the others are there where a branch has them.
#[cfg(feature = "arrow")]
const ALWAYS: usize = 7;
/// Names of the columns before them.
#[cfg(feature = "arrow")]
const NAMES: [&str; 3] = ["step", "increment", "branch"];

/// The schema of the file; `optional`: whether it has each of the columns behind the first [`ALWAYS`].
#[cfg(feature = "arrow")]
fn schema(scenario: &str, optional: [bool; COLUMNS.len() - ALWAYS]) -> arrow_schema::Schema {
    use arrow_schema::{DataType, Field, Schema};
    use std::collections::HashMap;
    let names = || DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8));
    let named = NAMES.map(|name| {
        let kind = if name == "increment" { DataType::UInt32 } else { names() };
        Field::new(name, kind, false)
    });
    let there = |k: usize| k < ALWAYS || optional[k - ALWAYS];
    let columns = COLUMNS.iter().enumerate().filter(|(k, _)| there(*k));
    let numbers = columns.map(|(k, (name, count, unit))| {
        let kind = if *count == 1 { DataType::Float64 } else { DataType::FixedSizeList(item(), 3) };
        let unit = HashMap::from([("unit".to_owned(), (*unit).to_owned())]);
        Field::new(*name, kind, k >= ALWAYS).with_metadata(unit)
    });
    let fields: Vec<Field> = named.into_iter().chain(numbers).collect();
    Schema::new_with_metadata(fields, HashMap::from([("wireloom.scenario".to_owned(), scenario.to_owned())]))
}

/// The field of the numbers of a vector.
#[cfg(feature = "arrow")]
fn item() -> arrow_schema::FieldRef {
    std::sync::Arc::new(arrow_schema::Field::new("item", arrow_schema::DataType::Float64, false))
}

/// An error of Arrow.
#[cfg(feature = "arrow")]
fn failed(error: arrow_schema::ArrowError) -> std::io::Error {
    match error {
        arrow_schema::ArrowError::IoError(_, error) => error,
        other => std::io::Error::new(std::io::ErrorKind::InvalidData, format!("{FILE}: {other}")),
    }
}
