//! The wires of a harness one by one, for its formboard.

use super::document::Document;
use super::harness::Harness;
use super::options::WireRun;

/// Every wire with the ends of its way and its length, in the order of the file. A wire that ends at more or fewer than
/// two vertices, because it has branches or its way has gaps, names all of its ends.
pub(super) fn runs(document: &Document, harness: &Harness) -> Vec<WireRun> {
    let mut segments: Vec<Vec<usize>> = vec![Vec::new(); document.wires.len()];
    for (k, segment) in document.segments.iter().enumerate() {
        segment.wires.iter().for_each(|&wire| segments[wire].push(k));
    }
    let run = |(wire, segments): (&super::document::Wire, Vec<usize>)| {
        let mut ends: Vec<usize> = segments.iter().flat_map(|&k| document.segments[k].ends).collect();
        ends.sort_unstable();
        // Where a wire runs on, two of its segments meet.
        let ends = ends.chunk_by(|a, b| a == b).filter(|times| times.len() % 2 == 1).map(|times| times[0]);
        WireRun {
            name: wire.id.clone(),
            copper_area: wire.copper_area,
            diameter: wire.outside_diameter,
            ends: ends.map(|vertex| harness.vertices[vertex].name.clone()).collect(),
            length: segments.iter().map(|&k| harness.branches[k].length).sum(),
        }
    };
    document.wires.iter().zip(segments).map(run).collect()
}
