//! Tables on standard output.

use crate::print::text::printable;
use comfy_table::{CellAlignment, LineStyle, Table, TableStyle};
use std::io::{self, Write};

/// Rows of a table that are shown; a harness may have hundreds of branches.
pub const ROWS: usize = 20;

/// A table with a line under its header; a heading that begins with `>` aligns its column right.
pub struct Columns(Table);

impl Columns {
    /// A table without rows.
    pub fn new<S: AsRef<str>>(headings: impl IntoIterator<Item = S>) -> Self {
        let headings: Vec<String> = headings.into_iter().map(|heading| printable(heading.as_ref())).collect();
        let mut table = Table::new();
        table.load_style(TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─')));
        table.set_header(headings.iter().map(|heading| heading.trim_start_matches('>')));
        for (column, heading) in table.column_iter_mut().zip(headings) {
            column.set_padding((0, 2));
            if heading.starts_with('>') {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        Self(table)
    }

    /// One more row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.0.add_row(cells.into_iter().map(|cell| printable(&cell)));
    }

    /// Prints it, and an empty line; nothing where there are no rows.
    pub fn print(&self, out: &mut dyn Write) -> io::Result<()> {
        if self.0.row_count() == 0 {
            return Ok(());
        }
        for line in self.0.lines() {
            writeln!(out, "{}", line.trim_end())?;
        }
        writeln!(out)
    }
}
