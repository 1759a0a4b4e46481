//! Modules of a harness and its variants in VEC: occurrences of part structures with this content.

use super::{ImportError, Reader, Xml, child_text, children, classes, element};
use crate::modules::{Known, KnownModule, KnownVariant, distinct};
use crate::options::{Contents, Module, Selection, Variant};
use crate::xml::{Read, VEC, words, xml};
use std::collections::HashMap;

/// Reference of the role of a structure to its specification.
const STRUCTURE: &str = "PartStructureSpecification";

/// The texts by which an occurrence may be called, the best ones first.
fn names<'a>(occurrence: Xml<'a, '_>, part: Option<Xml<'a, '_>>) -> Vec<&'a str> {
    let texts = [
        part.and_then(|part| child_text(part, "PartNumber")),
        child_text(occurrence, "Identification"),
        part.and_then(|part| element::localized(part, "Description")),
        occurrence.attribute("id"),
    ];
    texts.into_iter().flatten().collect()
}

/// Modules and variants in the file.
fn known<'a, 'i>(occurrences: &[Xml<'a, 'i>], ids: &HashMap<&'a str, Xml<'a, 'i>>) -> Known<'a, 'i> {
    let target = |node: Xml<'a, 'i>, name| child_text(node, name).and_then(|id| ids.get(id).copied());
    let content = |node: &Xml<'a, 'i>, wanted: &str| {
        let structure = element::role(*node, STRUCTURE).and_then(|role| target(role, STRUCTURE));
        structure.is_some_and(|own| child_text(own, "Content") == Some(wanted))
    };
    let of = |wanted: &str| occurrences.iter().copied().filter(|node| content(node, wanted)).collect::<Vec<_>>();
    let part = |node: Xml<'a, 'i>| target(node, "Part");
    let called =
        |nodes: &[Xml<'a, 'i>]| distinct(&nodes.iter().map(|node| names(*node, part(*node))).collect::<Vec<_>>());
    let components = |node: Xml<'a, 'i>| -> Vec<&'a str> {
        let role = element::role(node, STRUCTURE);
        role.into_iter().flat_map(|role| words(role, "SubComponent")).collect()
    };
    let (modules, variants) = (of("Module"), of("Variant"));
    let module_names = called(&modules);
    // Some refer to the role of a module.
    let mut by_id: HashMap<&str, String> = HashMap::new();
    for (node, name) in modules.iter().zip(&module_names) {
        let own = std::iter::once(*node).chain(children(*node, "Role"));
        by_id.extend(own.filter_map(|own| Some((own.attribute("id")?, name.clone()))));
    }
    let variant_names = called(&variants);
    let modules = modules.into_iter().zip(module_names).map(|(node, name)| {
        let controlled = components(node);
        let description = part(node).and_then(|part| element::localized(part, "Description"));
        let description = description.or_else(|| element::localized(node, "Description")).map(str::to_owned);
        let module = Module { name, description, option_code: None, parts: controlled.len() };
        KnownModule { module, node, configurations: Vec::new(), controlled }
    });
    let modules = modules.collect();
    let variants = variants.into_iter().zip(variant_names).map(|(node, name)| {
        let (of_modules, controlled): (Vec<&str>, Vec<&str>) =
            components(node).into_iter().partition(|id| by_id.contains_key(id));
        let modules = of_modules.iter().filter_map(|id| by_id.get(id).cloned()).collect();
        KnownVariant { variant: Variant { name, modules }, node, controlled }
    });
    Known { modules, variants: variants.collect() }
}

/// The modules and variants of a VEC text.
pub fn contents(text: &str) -> Result<Contents, ImportError> {
    let file = xml(text, &VEC)?;
    let read = Read::with_classes(&file);
    let root = Xml::root(&file, &read);
    let classes = classes(root);
    let ids: HashMap<&str, Xml> =
        classes.values().flatten().filter_map(|node| Some((node.attribute("id")?, *node))).collect();
    Ok(known(classes.get("Component").map_or(&[], Vec::as_slice), &ids).contents())
}

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// Chooses modules, and reports what that means.
    pub(super) fn choose(&mut self, selection: &Selection) -> Result<(), ImportError> {
        let known = known(&self.all("Component"), &self.file.ids);
        self.chosen = known.choose(selection, &mut self.file)?;
        let configurations = self.all("VariantConfiguration").len();
        if configurations > 0 {
            self.file.findings.add(format!(
                "the file has {configurations} VariantConfigurations; their expressions are not evaluated, and all \
                 that they control is taken"
            ));
        }
        Ok(())
    }

    /// Whether an occurrence is a structure of others: a module, a variant, or the harness.
    pub(super) fn is_module(&self, occurrence: Xml<'a, 'i>) -> bool {
        let structure = element::role(occurrence, STRUCTURE).and_then(|role| self.file.target(role, STRUCTURE));
        let content = structure.and_then(|own| child_text(own, "Content"));
        content.is_some_and(|content| ["Module", "Variant", "Harness"].contains(&content))
    }
}
