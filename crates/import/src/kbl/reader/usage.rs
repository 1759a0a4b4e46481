//! What is done with each element of a file.

use super::{Reader, Xml, children};
use crate::usage::Element;
use roxmltree::NodeId;
use std::collections::HashSet;

/// Elements that say which modules others belong to: what they refer to, they do not need.
const MODULES: [&str; 3] = ["Harness_configuration", "Module", "Module_configuration"];

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// Every element directly in the container or a harness, and the use that is made of it; parts of elements that are
    /// not read are reported.
    pub(super) fn elements(&mut self, root: Xml<'a, 'i>) -> Vec<Element> {
        let within = root.elements().chain(children(root, "Harness").flat_map(Xml::elements));
        let nodes: Vec<Xml> =
            within.filter(|node| node.name() != "Harness" && node.elements().next().is_some()).collect();
        let elsewhere = |node: Xml<'a, 'i>| {
            node.descendants().any(|inner| self.chosen.leaves_out(inner, None)) || self.all_left_out(node)
        };
        let left_out: HashSet<NodeId> = nodes.iter().filter(|node| elsewhere(**node)).map(|node| node.id()).collect();
        self.file.uses(&nodes, |node| left_out.contains(&node.id()), |node| !MODULES.contains(&node.name()))
    }

    /// Whether a part, or what stands in it, has occurrences, of which none is left.
    fn all_left_out(&self, part: Xml<'a, 'i>) -> bool {
        let ids = part.descendants().filter_map(|inner| inner.attribute("id"));
        let mut occurrences = ids.filter_map(|id| self.occurrences.get(id)).flatten().peekable();
        occurrences.peek().is_some() && occurrences.all(|own| self.leaves_out(*own))
    }
}
