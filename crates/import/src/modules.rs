//! Modules of a harness and its variants: which parts a car with some of them has.

use super::elements::{Chosen, Elements};
use super::error::ImportError;
use super::options::{Contents, Module, Selection, Variant};
use super::xml::{Xml, position};
use roxmltree::NodeId;
use std::collections::{HashMap, HashSet};

/// Modules and variants in a file.
#[derive(Default)]
pub(super) struct Known<'a, 'i> {
    pub modules: Vec<KnownModule<'a, 'i>>,
    pub variants: Vec<KnownVariant<'a, 'i>>,
}

/// A module in a file.
pub(super) struct KnownModule<'a, 'i> {
    pub module: Module,
    pub node: Xml<'a, 'i>,
    /// Elements that say which parts it has.
    pub configurations: Vec<Xml<'a, 'i>>,
    /// Ids of its parts.
    pub controlled: Vec<&'a str>,
}

/// A variant in a file.
pub(super) struct KnownVariant<'a, 'i> {
    pub variant: Variant,
    pub node: Xml<'a, 'i>,
    /// Ids of the parts that it has beside its modules.
    pub controlled: Vec<&'a str>,
}

/// A name for each element: the first of its texts that no other one has.
pub(super) fn distinct(all: &[Vec<&str>]) -> Vec<String> {
    let mut count: HashMap<&str, usize> = HashMap::new();
    for texts in all {
        let own: HashSet<&&str> = texts.iter().collect();
        own.into_iter().for_each(|text| *count.entry(text).or_default() += 1);
    }
    all.iter().map(|texts| (*texts.iter().find(|text| count[*text] == 1).unwrap_or(&"")).to_owned()).collect()
}

impl<'a, 'i> Known<'a, 'i> {
    /// For a list.
    pub fn contents(self) -> Contents {
        Contents {
            modules: self.modules.into_iter().map(|own| own.module).collect(),
            variants: self.variants.into_iter().map(|own| own.variant).collect(),
        }
    }

    fn variant(&self, name: &str) -> Result<&KnownVariant<'a, 'i>, ImportError> {
        let known = || self.variants.iter().map(|own| own.variant.name.as_str());
        let found = self.variants.iter().find(|own| own.variant.name == name);
        found.ok_or_else(|| ImportError::choice("variant", name, known()))
    }

    /// The chosen modules.
    fn chosen(&self, selection: &Selection) -> Result<HashSet<NodeId>, ImportError> {
        let names: Vec<&str> = match selection {
            Selection::All => return Ok(self.modules.iter().map(|own| own.node.id()).collect()),
            Selection::Modules(names) => names.iter().map(String::as_str).collect(),
            Selection::Variant(name) => {
                let KnownVariant { variant, node, controlled } = self.variant(name)?;
                if variant.modules.is_empty() && controlled.is_empty() {
                    let (line, column) = position(*node);
                    return Err(ImportError::EmptyVariant { line, column, name: name.clone() });
                }
                variant.modules.iter().map(String::as_str).collect()
            }
        };
        let module = |name: &str| {
            let found = self.modules.iter().find(|own| own.module.name == name);
            let known = self.modules.iter().map(|own| own.module.name.as_str());
            found.map(|own| own.node.id()).ok_or_else(|| ImportError::choice("module", name, known))
        };
        names.into_iter().map(module).collect()
    }

    /// Chooses modules, and reports what that means.
    pub fn choose(&self, selection: &Selection, file: &mut Elements<'a, 'i, '_>) -> Result<Chosen<'a>, ImportError> {
        let taken = self.chosen(selection)?;
        let (all, count) = (self.modules.len(), taken.len());
        if *selection != Selection::All {
            file.findings.add(format!("of the {all} modules of the harness {count} are taken"));
        } else if all > 1 {
            file.findings.add(format!(
                "the harness has {all} modules; the wires of all of them are taken together, as in a car with every \
                 option (other choices: --list)"
            ));
        }
        let mut chosen = Chosen::default();
        for KnownModule { node, configurations, controlled, .. } in &self.modules {
            let is_taken = taken.contains(&node.id());
            let parts = if is_taken { &mut chosen.present } else { &mut chosen.left_out };
            for id in controlled {
                if !file.ids.contains_key(id) {
                    file.findings.add_to("modules name parts that are not in the file", *id);
                }
                parts.insert(id);
            }
            let elements = if is_taken { file.used.get_mut() } else { &mut file.left_out };
            elements.extend(configurations.iter().chain([node]).map(|own| own.id()));
        }
        if let Selection::Variant(name) = selection {
            for KnownVariant { variant, node, controlled } in &self.variants {
                let is_taken = variant.name == *name;
                let elements = if is_taken { file.used.get_mut() } else { &mut file.left_out };
                elements.insert(node.id());
                let parts = if is_taken { &mut chosen.present } else { &mut chosen.left_out };
                parts.extend(controlled);
            }
        }
        Ok(chosen)
    }
}
