//! What is done with each element of a file.

use super::{Reader, Xml};
use crate::usage::Element;
use roxmltree::NodeId;
use std::collections::HashSet;

/// Specifications whose elements count one by one; others count as a whole.
const CONTAINERS: [&str; 26] = [
    "BuildingBlockSpecification2D",
    "BuildingBlockSpecification3D",
    "CompositionSpecification",
    "ConfigurationConstraintSpecification",
    "ConnectionSpecification",
    "ContactingSpecification",
    "CouplingSpecification",
    "DefaultDimensionSpecification",
    "HarnessDrawingSpecification2D",
    "HarnessGeometrySpecification3D",
    "MappingSpecification",
    "ModuleFamilySpecification",
    "ModuleListSpecification",
    "NetSpecification",
    "PartUsageSpecification",
    "PlacementSpecification",
    "RoutingSpecification",
    "SignalSpecification",
    "TopologyBendingRestrictionSpecification",
    "TopologyGroupSpecification",
    "TopologySpecification",
    "TopologyZoneSpecification",
    "UsageNodeSpecification",
    "VariantCodeSpecification",
    "VariantConfigurationSpecification",
    "WireGroupingSpecification",
];

/// Whether the elements in an element count one by one.
fn is_container(node: Xml) -> bool {
    ["DocumentVersion", "SheetOrChapter"].contains(&node.name()) || CONTAINERS.contains(&node.class())
}

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// Every element of the file and of its documents that has parts, and the use that is made of it; parts of elements
    /// that are not read are reported.
    pub(super) fn elements(&mut self, root: Xml<'a, 'i>) -> Vec<Element> {
        let mut nodes = Vec::new();
        gather(root, &mut nodes);
        let elsewhere = |node: &&Xml<'a, 'i>| node.descendants().any(|inner| self.chosen.leaves_out(inner, None));
        let left_out: HashSet<NodeId> = nodes.iter().filter(elsewhere).map(|node| node.id()).collect();
        let modules: HashSet<NodeId> = nodes.iter().filter(|own| self.is_module(**own)).map(|own| own.id()).collect();
        self.file.uses(&nodes, |node| left_out.contains(&node.id()), |node| !modules.contains(&node.id()))
    }
}

/// The elements that count, in the order of the file.
fn gather<'a, 'i>(around: Xml<'a, 'i>, nodes: &mut Vec<Xml<'a, 'i>>) {
    for node in around.elements() {
        if is_container(node) {
            gather(node, nodes);
        } else if node.elements().next().is_some() {
            nodes.push(node);
        }
    }
}
