//! Where the elements of a file are in the scenario that was made of it.

use super::document::Document;
use super::harness::Harness;
use super::options::ElementPlace;
use std::collections::HashMap;

/// The places of nodes, of what sits at them, of segments, and of what runs along or lies on them, by XML ids.
pub(super) fn places(document: &Document, harness: &Harness) -> HashMap<String, ElementPlace> {
    let mut places = HashMap::new();
    for (segment, branch) in document.segments.iter().zip(&harness.branches) {
        let wires = segment.wires.iter().map(|wire| &document.wires[*wire].id);
        let fixings = segment.fixings.iter().flat_map(|fixing| std::iter::once(&fixing.id).chain(&fixing.of));
        let coverings = segment.coverings.iter().map(|covering| &covering.id);
        for id in std::iter::once(&segment.id).chain(coverings).chain(fixings).chain(wires) {
            // Of a wire or a covering on several segments, the first one.
            places.entry(id.clone()).or_insert_with(|| ElementPlace::Branch(branch.name.clone()));
        }
    }
    for (node, vertex) in document.nodes.iter().zip(&harness.vertices) {
        for id in std::iter::once(&node.id).chain(node.components.iter().map(|component| &component.id)) {
            places.insert(id.clone(), ElementPlace::Vertex(vertex.name.clone()));
        }
    }
    places
}
