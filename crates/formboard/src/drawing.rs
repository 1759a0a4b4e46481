//! Drawings of a board at 1:1, in mm: SVG for the screen, DXF for CAD, PDF for the workshop.
//!
//! `scene` says what is drawn; the writers know nothing of harnesses. Layers have the same names in all of them.

mod dxf;
mod pdf;
mod scene;
mod svg;
mod table;

pub use dxf::{DxfError, dxf};
pub use pdf::{Paper, not_printable, pdf};
pub use svg::svg;
pub use table::{Table, branches, parts};

use crate::{Board, Harness};

/// A board with what is written about it.
#[derive(Clone, Copy, Debug)]
pub struct Drawing<'a> {
    /// The headline.
    pub title: &'a str,
    /// The harness.
    pub harness: &'a Harness,
    /// Its board.
    pub board: &'a Board,
    /// Tables of the PDF.
    pub tables: &'a [Table],
}
