//! Modules of a harness and its variants: which parts a car with some of them has.

use super::super::options::{Contents, Module, Selection, Variant};
use super::{Chosen, ImportError, Read, Reader, Xml, child, child_text, children, position, words, xml};
use std::collections::{HashMap, HashSet};

/// Modules and variants in the file, with their elements.
struct Known<'a, 'i> {
    modules: Vec<(Module, Xml<'a, 'i>)>,
    /// Configurations of each module: within it, or beside it with a reference to it.
    configurations: Vec<Vec<Xml<'a, 'i>>>,
    variants: Vec<(Variant, Xml<'a, 'i>)>,
}

/// The texts by which an element may be called, the best ones first.
fn names<'a>(node: Xml<'a, '_>) -> Vec<&'a str> {
    let of = |name| child_text(node, name);
    let texts = [
        of("Part_number"),
        of("Abbreviation"),
        of("Car_classification_level_4"),
        of("Car_classification_level_3"),
        of("Description"),
        node.attribute("id"),
    ];
    // Some exporters write this where there is no number.
    texts.into_iter().flatten().filter(|text| *text != "/OVMM").collect()
}

/// A name for each element: the first of its texts that no other one has.
fn distinct(nodes: &[Xml<'_, '_>]) -> Vec<String> {
    let mut count: HashMap<&str, usize> = HashMap::new();
    let all: Vec<Vec<&str>> = nodes.iter().map(|node| names(*node)).collect();
    all.iter().flatten().for_each(|text| *count.entry(text).or_default() += 1);
    all.iter().map(|texts| (*texts.iter().find(|text| count[*text] == 1).unwrap_or(&"")).to_owned()).collect()
}

/// Ids of the parts that some configurations control.
fn controlled<'a, 'i>(configurations: &[Xml<'a, 'i>]) -> impl Iterator<Item = &'a str> {
    configurations.iter().flat_map(|configuration| words(*configuration, "Controlled_components"))
}

impl<'a, 'i> Known<'a, 'i> {
    fn of(root: Xml<'a, 'i>) -> Self {
        let all = |name| children(root, "Harness").flat_map(move |harness| children(harness, name)).collect::<Vec<_>>();
        let modules = all("Module");
        let module_names = distinct(&modules);
        let by_id: HashMap<&str, &String> =
            modules.iter().zip(&module_names).filter_map(|(node, name)| Some((node.attribute("id")?, name))).collect();
        let mut beside: HashMap<&str, Vec<Xml>> = HashMap::new();
        for configuration in all("Module_configuration") {
            beside.entry(child_text(configuration, "Modules").unwrap_or_default()).or_default().push(configuration);
        }
        let configurations = modules.iter().map(|node| {
            let beside = node.attribute("id").and_then(|id| beside.remove(id));
            children(*node, "Module_configuration").chain(beside.into_iter().flatten()).collect()
        });
        let configurations: Vec<Vec<Xml>> = configurations.collect();
        let variants = all("Harness_configuration");
        let variant = |(node, name): (&Xml<'a, 'i>, String)| {
            let modules =
                words(*node, "Modules").map(|id| by_id.get(id).map_or(id, |name| name.as_str()).to_owned()).collect();
            (Variant { name, modules }, *node)
        };
        let variants = variants.iter().zip(distinct(&variants)).map(variant).collect();
        let module = |((node, name), configurations): ((Xml<'a, 'i>, String), &Vec<Xml<'a, 'i>>)| {
            let configuration = child(node, "Module_configuration");
            let option_code = configuration.and_then(|own| child_text(own, "Logistic_control_information"));
            let description = child_text(node, "Description").map(str::to_owned);
            let parts = controlled(configurations).count();
            (Module { name, description, option_code: option_code.map(str::to_owned), parts }, node)
        };
        let modules = modules.into_iter().zip(module_names).zip(&configurations).map(module).collect();
        Self { modules, configurations, variants }
    }

    /// The elements of the chosen modules.
    fn chosen(&self, selection: &Selection) -> Result<Vec<Xml<'a, 'i>>, ImportError> {
        let names: Vec<&str> = match selection {
            Selection::All => return Ok(self.modules.iter().map(|(_, node)| *node).collect()),
            Selection::Modules(names) => names.iter().map(String::as_str).collect(),
            Selection::Variant(name) => {
                let known = || self.variants.iter().map(|(variant, _)| variant.name.as_str());
                let found = self.variants.iter().find(|(variant, _)| variant.name == *name);
                let (variant, node) = found.ok_or_else(|| ImportError::choice("variant", name, known()))?;
                if variant.modules.is_empty() {
                    let (line, column) = position(*node);
                    return Err(ImportError::EmptyVariant { line, column, name: name.clone() });
                }
                variant.modules.iter().map(String::as_str).collect()
            }
        };
        let module = |name: &str| {
            let found = self.modules.iter().find(|(module, _)| module.name == name);
            let known = self.modules.iter().map(|(module, _)| module.name.as_str());
            found.map(|(_, node)| *node).ok_or_else(|| ImportError::choice("module", name, known))
        };
        names.into_iter().map(module).collect()
    }
}

/// The modules and variants of a KBL text.
pub fn contents(text: &str) -> Result<Contents, ImportError> {
    let file = xml(text)?;
    let read = Read::nothing_of(&file);
    let Known { modules, variants, .. } = Known::of(Xml::root(&file, &read));
    Ok(Contents {
        modules: modules.into_iter().map(|(module, _)| module).collect(),
        variants: variants.into_iter().map(|(variant, _)| variant).collect(),
    })
}

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// Chooses modules, and reports what that means.
    pub(super) fn choose(&mut self, root: Xml<'a, 'i>, selection: &Selection) -> Result<(), ImportError> {
        let known = Known::of(root);
        let chosen = known.chosen(selection)?;
        let taken: HashSet<roxmltree::NodeId> = chosen.iter().map(|node| node.id()).collect();
        let (all, count) = (known.modules.len(), taken.len());
        if *selection == Selection::All {
            if all > 1 {
                self.findings.add(format!(
                    "the harness has {all} modules; the wires of all of them are taken together, as in a car with \
                     every option (other choices: --list)"
                ));
            }
        } else {
            self.findings.add(format!("of the {all} modules of the harness {count} are taken"));
        }
        let (mut present, mut left_out) = (HashSet::new(), HashSet::new());
        for ((_, node), configurations) in known.modules.iter().zip(&known.configurations) {
            let is_taken = taken.contains(&node.id());
            let parts = if is_taken { &mut present } else { &mut left_out };
            for id in controlled(configurations) {
                if !self.ids.contains_key(id) {
                    self.findings.add_to("modules name parts that are not in the file", id);
                }
                parts.insert(id);
            }
            let elements = if is_taken { self.used.get_mut() } else { &mut self.left_out };
            elements.extend(configurations.iter().chain([node]).map(|own| own.id()));
        }
        if let Selection::Variant(name) = selection {
            for (variant, node) in &known.variants {
                let elements = if variant.name == *name { self.used.get_mut() } else { &mut self.left_out };
                elements.insert(node.id());
            }
        }
        self.chosen = Chosen { present, left_out };
        let harnesses = children(root, "Harness").count();
        if harnesses > 1 {
            self.findings.add(format!("the file has {harnesses} harnesses; all are taken together"));
        }
        Ok(())
    }
}
