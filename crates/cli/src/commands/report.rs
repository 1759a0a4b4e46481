//! `wireloom report`: the table of a sweep as one page.

use crate::failure::{Failure, Outcome};
use crate::files::{folder, load};
use crate::print::progress::Bar;
use crate::program::{PROGRAM, now};
use std::io::Write;
use std::path::Path;
use wireloom::export::table::statistics;
use wireloom::export::{report, table};

/// Reads the table, or that of a folder, and writes the page to `target`, or beside the table.
pub fn report(place: &Path, target: Option<&Path>, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let path = if place.is_dir() { place.join(table::FILE) } else { place.to_owned() };
    let bar = Bar::new(format!("reading {}", path.display()), true);
    let bytes = load::bytes(&path)?;
    let table = table::read(bytes)
        .map_err(|error| Failure::Input(format!("{} is no table of a sweep: {error}", path.display())))?;
    let name = table.note("wireloom.scenario").unwrap_or("sweep");
    let file = table.note(statistics::FILE).unwrap_or("SCENARIO.toml");
    let points = report::Points { title: name, table: &table, file, program: PROGRAM, written: &now() };
    let target = target.map_or_else(|| path.with_file_name(report::FILE), Path::to_owned);
    bar.say(format!("writing {}", target.display()));
    folder::write(&target, |out| report::write_points(&points, out))?;
    drop(bar);
    writeln!(out, "wrote {}", target.display()).map_err(Failure::standard_output)?;
    Ok(Outcome::Done)
}
