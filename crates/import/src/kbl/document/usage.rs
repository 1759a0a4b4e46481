//! What is done with each element of a file.

use super::{Reader, Xml, children, text};
use crate::kbl::usage::{Element, Use};
use roxmltree::NodeId;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Elements that say which modules others belong to: what they refer to, they do not need.
const MODULES: [&str; 3] = ["Harness_configuration", "Module", "Module_configuration"];

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// Every element directly in the container or a harness, and the use that is made of it; parts of elements that are
    /// not read are reported.
    pub(super) fn elements(&mut self, root: Xml<'a, 'i>) -> Vec<Element> {
        let within = root.elements().chain(children(root, "Harness").flat_map(Xml::elements));
        let nodes: Vec<Xml> =
            within.filter(|node| node.name() != "Harness" && node.elements().next().is_some()).collect();
        let mut uses: Vec<Use> = nodes.iter().map(|node| self.usage(*node)).collect();
        self.spread(&nodes, &mut uses);
        self.note_unread(&nodes, &uses);
        let element = |(node, usage): (&Xml, Use)| {
            let id = node.attribute("id").unwrap_or_default().to_owned();
            Element { kind: node.name().to_owned(), id, usage }
        };
        nodes.iter().zip(uses).map(element).collect()
    }

    fn usage(&self, node: Xml<'a, 'i>) -> Use {
        let used = self.used.borrow();
        let any = |set: &HashSet<NodeId>| node.descendants().any(|inner| set.contains(&inner.id()));
        match () {
            () if any(&used) => Use::Used,
            () if any(&self.kept) => Use::Kept,
            () if self.left_out.contains(&node.id()) => Use::LeftOut,
            () if node.descendants().any(|inner| self.chosen.leaves_out(inner, None)) => Use::LeftOut,
            () if self.all_left_out(node) => Use::LeftOut,
            () => Use::NotRead,
        }
    }

    /// Whether a part, or what stands in it, has occurrences, of which none is left.
    fn all_left_out(&self, part: Xml<'a, 'i>) -> bool {
        let ids = part.descendants().filter_map(|inner| inner.attribute("id"));
        let mut occurrences = ids.filter_map(|id| self.occurrences.get(id)).flatten().peekable();
        occurrences.peek().is_some() && occurrences.all(|own| self.leaves_out(*own))
    }

    /// What only elements that are left out refer to is left out with them: nodes, points, part numbers.
    fn spread(&self, nodes: &[Xml<'a, 'i>], uses: &mut [Use]) {
        let index: HashMap<NodeId, usize> = nodes.iter().enumerate().map(|(k, node)| (node.id(), k)).collect();
        let element_of = |node: &Xml| node.ancestors().find_map(|around| index.get(&around.id()).copied());
        let mut references: Vec<HashSet<usize>> = vec![HashSet::new(); nodes.len()];
        let mut referring = vec![0_usize; nodes.len()];
        for (k, node) in nodes.iter().enumerate().filter(|(_, node)| !MODULES.contains(&node.name())) {
            let leaves = node.descendants().filter_map(text);
            let targets = leaves.flat_map(str::split_whitespace).filter_map(|word| self.ids.get(word));
            for target in targets.filter_map(element_of) {
                if target != k && uses[target] == Use::NotRead && references[k].insert(target) {
                    referring[target] += 1;
                }
            }
        }
        let mut open: Vec<usize> = (0..nodes.len()).filter(|k| uses[*k] == Use::LeftOut).collect();
        while let Some(k) = open.pop() {
            for &target in &references[k] {
                referring[target] -= 1;
                if referring[target] == 0 {
                    uses[target] = Use::LeftOut;
                    open.push(target);
                }
            }
        }
    }

    /// Reports the parts of elements in use that nothing has read, and nothing within them either.
    fn note_unread(&mut self, nodes: &[Xml<'a, 'i>], uses: &[Use]) {
        let mut unread: BTreeMap<&str, usize> = BTreeMap::new();
        let in_use = |usage: &Use| matches!(usage, Use::Used | Use::Kept);
        for (element, _) in nodes.iter().zip(uses).filter(|(_, usage)| in_use(usage)) {
            let mut reached: HashSet<NodeId> = HashSet::from([element.id()]);
            for inner in element.descendants() {
                let id = inner.id();
                if inner.is_read() || self.kept.contains(&id) || self.used.borrow().contains(&id) {
                    for around in inner.ancestors() {
                        if !reached.insert(around.id()) {
                            break;
                        }
                    }
                }
            }
            for inner in element.descendants().filter(|inner| !reached.contains(&inner.id())) {
                // What stands in a part that is not read is told with it.
                if inner.parent().is_some_and(|around| reached.contains(&around.id())) {
                    *unread.entry(inner.name()).or_default() += 1;
                }
            }
        }
        for (name, count) in unread {
            self.findings.add_to("parts of elements that are not read", format!("{count} {name}"));
        }
    }
}
