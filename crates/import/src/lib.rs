//! Harness files of other formats to scenarios, and results back into them.
//!
//! - [`kbl`]: KBL (*Kabelbaumliste*, VDA recommendation 4964), the list of parts, wires, topology and centre
//!   curves that harness design tools exchange.
//! - [`mod@vec`]: VEC (*Vehicle Electric Container*, VDA recommendation 4968), its successor.
//!
//! The flow of a file: the `reader` of its format (XML to plain values in SI, `document`; `xml`, `elements`: what both
//! readers do with elements) → `convert` (branches, joints; `segments`: centre lines from `curve`, make-up from
//! `section`; `anatomy`: wires through joints; `constraints`) → `harness` (the data) → `write` (TOML text; `tree`,
//! `board` and `assembly` for installation). And back into KBL: `kbl/export` changes the text of the file where a
//! result differs; `kbl/fit` makes the curves.

pub mod kbl;
pub mod vec;

mod anatomy;
mod assembly;
mod board;
mod constraints;
mod convert;
mod coverings;
mod curve;
mod document;
mod elements;
mod error;
mod findings;
mod harness;
mod identities;
mod modules;
mod names;
mod options;
mod places;
mod runs;
mod scenario;
mod section;
mod segments;
mod tree;
mod unit;
mod usage;
mod wires;
mod write;
mod xml;
