//! `wireloom sweep status` and `wireloom sweep compact`: sweeps in parts.

use crate::failure::{Failure, Outcome};
use crate::print::progress::Bar;
use crate::print::text::{counted, printable};
use std::io::{self, Write};
use wireloom_dataset::{Dataset, Failed, Manifest, Status, words};

/// Reasons of a status that are shown.
const REASONS: usize = 3;
/// Names of damaged parts that are shown.
const NAMES: usize = 3;

/// Prints what is there, what is missing, and why points failed.
pub fn status(place: &str, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let dataset = Dataset::open(place).map_err(Failure::Dataset)?;
    let status = dataset.status().map_err(Failure::Dataset)?;
    print(dataset.manifest(), place, &status, out).map_err(Failure::standard_output)?;
    Ok(if status.is_complete() { Outcome::Done } else { Outcome::NotConverged })
}

fn print(manifest: &Manifest, place: &str, status: &Status, out: &mut dyn Write) -> io::Result<()> {
    let Manifest { scenario, points, chain, program, .. } = manifest;
    writeln!(out, "{}: {points} points in chains of {chain}, {}", printable(scenario), printable(program))?;
    let share = 100.0 * status.done as f64 / *points as f64;
    let size = status.bytes as f64 / status.done.max(1) as f64;
    let parts = counted(status.parts, "part", "parts");
    writeln!(out, "done        {} ({share:.1} %) in {parts}, {size:.1} bytes a point", status.done)?;
    if !status.missing.is_empty() {
        writeln!(out, "missing     {} ({})", points - status.done, words(&status.missing))?;
    }
    for Failed { status, points, reasons } in &status.failed {
        writeln!(out, "{:<11} {points}", printable(status))?;
        for (reason, points) in reasons.iter().filter(|(reason, _)| !reason.is_empty()).take(REASONS) {
            writeln!(out, "            {points}: {}", printable(reason))?;
        }
    }
    if let Some(throughput) = status.throughput {
        let left = (points - status.done) as f64 / throughput;
        let rest = if status.is_complete() { String::new() } else { format!(", {left:.0} s for what is missing") };
        writeln!(out, "throughput  {throughput:.1} points/s over the last ten minutes of work{rest}")?;
    }
    for (name, reason) in status.damaged.iter().take(NAMES) {
        writeln!(out, "damaged     {}: {}; remove it", printable(name), printable(reason))?;
    }
    if let Some(name) = status.foreign.first() {
        let n = status.foreign.len();
        writeln!(out, "foreign     {n} that are no parts of this sweep, such as {}; move them away", printable(name))?;
    }
    match (status.is_complete(), status.compacted) {
        (false, _) => writeln!(out, "go on with  wireloom sweep FILE --into {place}"),
        (true, false) => writeln!(out, "complete: wireloom sweep compact {place}"),
        (true, true) => writeln!(out, "complete, and points.parquet is written"),
    }
}

/// Writes one table of all parts.
pub fn compact(place: &str, quiet: bool, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let dataset = Dataset::open(place).map_err(Failure::Dataset)?;
    let points = dataset.manifest().points;
    let bar = Bar::new(format!("reading the parts in {place}"), !quiet);
    let told = |done| bar.say(format!("{done} of {points} points"));
    let compacted = dataset.compact(&told).map_err(Failure::Dataset)?;
    drop(bar);
    if !quiet {
        let size = compacted.bytes as f64 / compacted.rows as f64;
        let (rows, columns) = (compacted.rows, compacted.columns);
        writeln!(out, "wrote {}: {rows} points, {columns} columns, {size:.1} bytes a point", compacted.name)
            .map_err(Failure::standard_output)?;
    }
    Ok(Outcome::Done)
}
