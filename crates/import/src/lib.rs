//! Harness files of other formats to scenarios, and results back into them.
//!
//! - [`kbl`]: KBL (*Kabelbaumliste*, VDA recommendation 4964), the list of parts, wires, topology and centre
//!   curves that harness design tools exchange.
//!
//! The flow of a KBL file through the files of `kbl/`: `document` (XML to plain values in SI) → `convert`
//! (branches, joints; `segments`: centre lines from `curve`, make-up from `section`; `anatomy`: wires through joints;
//! `constraints`) → `harness` (the data) → `write` (TOML text; `tree`, `board` and `assembly` for installation).
//! And back: `export` changes the text of the file where a result differs; `fit` makes the curves.

pub mod kbl;
