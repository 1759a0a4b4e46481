//! From the contents of a file to its scenario.

use super::convert;
use super::document::Document;
use super::error::ImportError;
use super::findings::Findings;
use super::options::{Imported, Options};
use super::places;
use super::runs;
use super::usage::{self, Use};
use super::write;

/// Makes the scenario of what `read` reads.
pub(super) fn make(
    options: &Options,
    read: impl FnOnce(&mut Findings) -> Result<Document, ImportError>,
) -> Result<Imported, ImportError> {
    if !(options.max_segment.is_finite() && options.max_segment > 0.0) {
        return Err(ImportError::MaxSegment { found: options.max_segment });
    }
    let memory = options.memory_of_board();
    if !(0.0..=1.0).contains(&memory) {
        return Err(ImportError::Memory { found: memory });
    }
    let mut findings = Findings::default();
    let mut document = read(&mut findings)?;
    let (harness, acting) = convert::convert(&document, options, &mut findings)?;
    for element in document.elements.iter_mut().filter(|element| acting.contains(&element.id)) {
        element.usage = Use::Used;
    }
    let usage = usage::count(&document.elements);
    for own in usage.iter().filter(|own| own.not_read > 0) {
        findings.add_to("elements that are not read", format!("{} {}", own.not_read, own.kind));
    }
    let scenario = write::scenario(&harness, &document.format, options, &usage, &mut findings);
    let wires = runs::runs(&document, &harness);
    let places = places::places(&document, &harness);
    Ok(Imported { scenario, findings: findings.list, usage, wires, places })
}
