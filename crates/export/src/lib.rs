//! Results as JSON, CSV, VTK, glTF, pictures and reports.
//!
//! Every writer takes a result of `wireloom-core` and any [`std::io::Write`]; none touches the file system,
//! prints, or depends on the clock: equal input gives equal bytes. SI units throughout; where a format has
//! headers, they carry the units.
//!
//! | module | what it writes | for whom |
//! | --- | --- | --- |
//! | [`json`] | `result.json`: the whole run | programs; this is the contract |
//! | [`csv`] | one branch as a table | spreadsheets |
//! | [`gltf`] | the ends of steps, or a surface, as GLB | viewers, digital mock-ups |
//! | [`vtk`] | one step as `.vtp`, and a `.pvd` over many | ParaView |
//! | [`picture`] | one step as SVG: three views | people and reports |
//! | [`report`] | the whole run as one HTML page | people, and their files |
//! | [`table`] | the points of a sweep as Parquet | DuckDB, pandas, Polars |
//!
//! [`json::read`] reads a `result.json` back as an [`ending::Ending`]; [`comparison`] says what differs between several of them.
//!
//! Errors are [`std::io::Error`]: those of the writer, and `InvalidInput` where the vectors of a branch
//! differ in length.

pub mod comparison;
pub mod csv;
mod curve;
pub mod ending;
pub mod gltf;
pub mod json;
mod local;
pub mod names;
pub mod picture;
pub mod report;
pub mod table;
pub mod vtk;
mod xml;
