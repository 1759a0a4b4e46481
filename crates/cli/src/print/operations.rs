//! The table of operations: grasp, carry, mate, clip.

use crate::print::table::Columns;
use std::io::{self, Write};
use wireloom::Run;

/// Rows that are shown.
const ROWS: usize = 40;

/// Prints the operations of a run, each with its result at the end of its step.
pub fn print(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let mut table = Columns::new(["operation", "of", "in step", "result"]);
    let mut rows = 0;
    for (k, end) in run.steps.iter().enumerate() {
        if run.steps.get(k + 1).is_some_and(|next| next.name == end.name && next.increment > end.increment) {
            continue;
        }
        for operation in &end.operations {
            rows += 1;
            if rows <= ROWS {
                let of = operation.of().join(", ");
                table.row([operation.word().to_owned(), of, end.name.clone(), operation.to_string()]);
            }
        }
    }
    table.print(out)?;
    if rows > ROWS { writeln!(out, "({} more operations: see result.json)\n", rows - ROWS) } else { Ok(()) }
}
