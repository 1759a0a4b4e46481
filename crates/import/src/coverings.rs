//! What the readers of all formats do with coverings.

use super::document::{self, Segment};
use super::findings::Findings;
use std::collections::BTreeMap;

/// Inner and outer diameter of a tube that its description gives, m, which is told.
pub(super) fn diameters(description: &str, findings: &mut Findings) -> (Option<f64>, Option<f64>) {
    let (inner, outer) = document::diameters(description);
    let read: Vec<String> = [inner, outer].iter().flatten().map(|d| format!("{:.1} mm", d * 1e3)).collect();
    if !read.is_empty() {
        let item = format!("`{description}` ({})", read.join(", "));
        findings.add_to("diameters of tubes are read from descriptions", item);
    }
    (inner, outer)
}

/// Reports coverings that cover nothing, and those whose length is not that of the places that they cover; `stated`:
/// ids and lengths, m, of coverings whose places are all in these segments.
pub(super) fn note_lengths(segments: &[Segment], stated: &[(&str, Option<f64>)], findings: &mut Findings) {
    // None where a segment has no length of its own.
    let mut covered: BTreeMap<&str, Option<f64>> = BTreeMap::new();
    for segment in segments {
        let length = segment.physical_length.or(segment.virtual_length);
        for covering in &segment.coverings {
            let span = |length| (covering.to.fraction(length) - covering.from.fraction(length)).abs() * length;
            let sum = covered.entry(&covering.id).or_insert(Some(0.0));
            *sum = sum.zip(length).map(|(sum, length)| sum + span(length));
        }
    }
    for (id, stated) in stated {
        match (covered.get(id), stated) {
            (None, _) => findings.add_to("coverings cover no segment; not counted", *id),
            (Some(Some(covered)), Some(stated)) if (covered - stated).abs() > 0.01 * stated + 1e-3 => {
                findings.add_to(
                    "coverings do not have the length of the places that they cover; the places count",
                    format!("{id} ({:.1} mm, places {:.1} mm)", stated * 1e3, covered * 1e3),
                );
            }
            _ => {}
        }
    }
}
