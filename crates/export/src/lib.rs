//! Results as JSON, CSV, VTK, glTF, pictures and reports.
//!
//! Every writer takes a result of `wireloom-core` and any [`std::io::Write`]; none touches the file system,
//! prints, or depends on the clock: equal input gives equal bytes. SI units throughout; where a format has
//! headers, they carry the units.
//!
//! | module | written | for |
//! | --- | --- | --- |
//! | [`json`] | `result.json`: the whole run | programs; this is the contract |
//! | [`fields`] | `fields.arrow`: fields of all nodes, beside a `result.json` without them (feature `arrow`) | tables |
//! | [`csv`] | one branch, or the sheet, as a table | spreadsheets |
//! | [`gltf`] | the ends of steps, or a surface, as GLB | viewers, digital mock-ups |
//! | [`vtk`] | one step as `.vtp`, and a `.pvd` over many | ParaView |
//! | [`picture`] | one step as SVG: three views | people and reports |
//! | [`report`] | the whole run as one HTML page | people, and their files |
//! | [`sheet`] | the sheet of requirements in words | terminals, reports, pictures |
//! | [`table`] | the points of a sweep as Parquet (feature `parquet`) | DuckDB, pandas, Polars |
//!
//! A run's files are those of the formats in the [`catalogue`], each a [`format::Format`]: it has a key in the
//! scenario's `[output]`, names of files, a media type and a writer.
//!
//! [`json::read`] reads a `result.json` back as an [`ending::Ending`]; [`comparison`] finds the differences between
//! several of them.
//!
//! Errors are [`std::io::Error`]: those of the writer, and `InvalidInput` where the vectors of a branch
//! differ in length.

pub mod catalogue;
pub mod comparison;
pub mod csv;
pub mod curve;
pub mod ending;
pub mod fields;
pub mod format;
pub mod gltf;
pub mod json;
mod local;
pub mod names;
pub mod picture;
pub mod report;
pub mod sheet;
pub mod table;
pub mod vtk;
mod xml;
