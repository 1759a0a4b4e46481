//! What was written into a harness file.

use crate::print::table::Columns;
use crate::print::text::counted;
use serde_json::json;
use std::io::{self, Write};
use std::path::Path;
use wireloom::kbl::{Exported, Moved, Segment};

/// In words: the changed lengths, and how much of the rest.
pub fn print(written: &Exported, tolerance: f64, file: &Path, out: &mut dyn Write) -> io::Result<()> {
    let mut lengths = Columns::new(["segment", "branch", ">before [mm]", ">now [mm]", ">difference [mm]"]);
    for own in written.segments.iter().filter(|own| own.has_new_length()) {
        let [before, now, difference] = [own.before, own.length, own.length - own.before].map(|x| x * 1e3);
        let numbers = [format!("{before:.3}"), format!("{now:.3}"), format!("{difference:+.3}")];
        lengths.row([own.id.clone(), own.branches.join(", ")].into_iter().chain(numbers));
    }
    lengths.print(out)?;
    let changed = written.segments.iter().filter(|own| own.has_new_length()).count();
    writeln!(out, "lengths: {changed} of {} changed", counted(written.segments.len(), "segment", "segments"))?;
    let curves = written.segments.iter().filter_map(|own| own.curve);
    let points: usize = curves.clone().map(|curve| curve.control_points).sum();
    let count = curves.clone().count();
    let farthest = curves.map(|curve| curve.distance).fold(0.0, f64::max);
    let new = counted(count, "new centre curve", "new centre curves");
    let as_it_is = written.segments.len() - count;
    writeln!(
        out,
        "{new} ({points} control points, {:.4} mm or less from the computed lines); {as_it_is} within {} mm as before",
        farthest * 1e3,
        tolerance * 1e3
    )?;
    let moved = |all: &[Moved]| match all.iter().map(|own| own.distance).reduce(f64::max) {
        Some(most) => format!("{} moved, by up to {:.3} mm", all.len(), most * 1e3),
        None => "none moved".to_owned(),
    };
    writeln!(out, "nodes: {}; placements: {}", moved(&written.nodes), moved(&written.placements))?;
    writeln!(out, "places of fixings along their segments: {} changed", written.fixings.len())?;
    writeln!(out, "wrote {}", file.display())
}

/// As JSON: SI units, and all of it.
pub fn json(written: &Exported, tolerance: f64, file: &Path, out: &mut dyn Write) -> io::Result<()> {
    let moved =
        |all: &[Moved]| -> Vec<_> { all.iter().map(|own| json!({ "id": own.id, "distance": own.distance })).collect() };
    let segments: Vec<_> = written.segments.iter().map(segment).collect();
    let fixings: Vec<_> = (written.fixings.iter())
        .map(|own| {
            let [before, now] = own.fractions;
            json!({ "id": own.id, "constraint": own.constraint, "before": before, "now": now })
        })
        .collect();
    let notes: Vec<_> = written.notes.iter().map(|own| json!({ "what": own.what, "items": own.items })).collect();
    let document = json!({
        "file": file.display().to_string(),
        "tolerance": tolerance,
        "segments": segments,
        "nodes": moved(&written.nodes),
        "placements": moved(&written.placements),
        "fixings": fixings,
        "notes": notes,
    });
    serde_json::to_writer_pretty(&mut *out, &document)?;
    writeln!(out)
}

/// A segment; `curve` is null where that of the file was kept, `bend_radius` where it is straight.
fn segment(own: &Segment) -> serde_json::Value {
    let curve = own.curve.map(|curve| json!({ "control_points": curve.control_points, "distance": curve.distance }));
    json!({
        "id": own.id,
        "branches": own.branches,
        "length_before": own.before,
        "length": own.length,
        "length_changed": own.has_new_length(),
        "curve": curve,
        "bend_radius": own.bend_radius,
    })
}
