//! `wireloom sweep FILE --into URL`: the points of a sweep in parts.

use super::job::Job;
use super::pool;
use crate::arguments::SweepArguments;
use crate::failure::{Failure, Outcome};
use crate::interrupt;
use crate::print::progress::Bar;
use crate::print::text::counted;
use std::collections::BTreeMap;
use std::io::Write;
use std::ops::Range;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use wireloom::sweep::Row;
use wireloom_dataset::words;

/// Computes the points that no part has, or those that are asked for, and writes their parts.
pub fn into(arguments: &SweepArguments, file: &Path, place: &str, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let bar = Bar::new(format!("reading {}", file.display()), !arguments.quiet);
    let job = Job::read(file, arguments.minimiser.as_deref(), &arguments.allowed)?;
    let points = job.points();
    if job.sweep().swept.is_some() {
        return Err(Failure::Input(format!(
            "{}: a sweep in parts has no swept space: leave out `swept` of its [sweep], or --into",
            file.display()
        )));
    }
    // Before anything is written.
    let chains = |range: &Range<usize>| points.chains_of(range.clone());
    if let Some(asked) = &arguments.points {
        chains(asked).map_err(|fault| Failure::Input(fault.to_string()))?;
    }
    let dataset = job.dataset(&points, place, arguments.columns.as_deref())?;
    let ranges = match &arguments.points {
        Some(asked) if dataset.has(asked).map_err(Failure::Dataset)? => vec![],
        Some(asked) => vec![asked.clone()],
        None => dataset.pieces(&dataset.missing().map_err(Failure::Dataset)?, arguments.each),
    };
    let left: usize = ranges.iter().map(Range::len).sum();
    let whole = arguments.points.as_ref().map_or(points.sweep.points, Range::len);
    bar.count(&job.loaded.scenario.name, "points", whole, whole - left);
    interrupt::listen();
    let (mut bytes, mut failed) = (0, 0);
    for range in &ranges {
        let chains: Vec<usize> = chains(range).map_err(|fault| Failure::Input(fault.to_string()))?.collect();
        let done: Mutex<BTreeMap<usize, Vec<Row>>> = Mutex::default();
        pool::compute((&job, &points), arguments, &chains, &|| bar.one(), |k, chain| {
            done.lock().unwrap_or_else(PoisonError::into_inner).insert(k, chain.rows);
            Ok(())
        })?;
        if interrupt::asked() {
            drop(bar);
            let words = format!("interrupted; the parts that are done are in {place}, and the same command goes on");
            writeln!(out, "{words}").map_err(Failure::standard_output)?;
            return Ok(Outcome::NotConverged);
        }
        let rows: Vec<Vec<Row>> = done.into_inner().unwrap_or_else(PoisonError::into_inner).into_values().collect();
        let written = dataset.write(range, &points.header, &rows).map_err(Failure::Dataset)?;
        (bytes, failed) = (bytes + written.bytes, failed + written.failed);
    }
    drop(bar);
    if !arguments.quiet {
        let said = if ranges.is_empty() {
            format!("all points are in {place} already")
        } else {
            let (all, parts) = (counted(left, "point", "points"), counted(ranges.len(), "part", "parts"));
            let size = bytes as f64 / left as f64;
            let range = words(&ranges[..1]);
            let first = if ranges.len() == 1 { format!(", {range}") } else { String::new() };
            format!("wrote {parts} into {place}: {all}{first}; {failed} did not converge; {size:.0} bytes a point")
        };
        writeln!(out, "{said}").map_err(Failure::standard_output)?;
    }
    Ok(Outcome::Done)
}
