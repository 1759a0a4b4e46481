//! Modules of a harness and its variants in KBL.

use super::{ImportError, KBL, Read, Reader, Xml, child, child_text, children, words, xml};
use crate::modules::{Known, KnownModule, KnownVariant, distinct};
use crate::options::{Contents, Module, Selection, Variant};
use std::collections::HashMap;

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

/// Modules and variants in the file.
fn known<'a, 'i>(root: Xml<'a, 'i>) -> Known<'a, 'i> {
    let all = |name| children(root, "Harness").flat_map(move |harness| children(harness, name)).collect::<Vec<_>>();
    let distinct = |nodes: &[Xml<'a, 'i>]| distinct(&nodes.iter().map(|node| names(*node)).collect::<Vec<_>>());
    let modules = all("Module");
    let module_names = distinct(&modules);
    let by_id: HashMap<&str, String> = modules
        .iter()
        .zip(&module_names)
        .filter_map(|(node, name)| Some((node.attribute("id")?, name.clone())))
        .collect();
    let mut beside: HashMap<&str, Vec<Xml>> = HashMap::new();
    for configuration in all("Module_configuration") {
        beside.entry(child_text(configuration, "Modules").unwrap_or_default()).or_default().push(configuration);
    }
    let module = |(node, name): (Xml<'a, 'i>, String)| {
        let beside = node.attribute("id").and_then(|id| beside.remove(id));
        let configurations: Vec<Xml> =
            children(node, "Module_configuration").chain(beside.into_iter().flatten()).collect();
        let controlled: Vec<&str> =
            configurations.iter().flat_map(|configuration| words(*configuration, "Controlled_components")).collect();
        let configuration = child(node, "Module_configuration");
        let option_code = configuration.and_then(|own| child_text(own, "Logistic_control_information"));
        let module = Module {
            name,
            description: child_text(node, "Description").map(str::to_owned),
            option_code: option_code.map(str::to_owned),
            parts: controlled.len(),
        };
        KnownModule { module, node, configurations, controlled }
    };
    let modules = modules.into_iter().zip(module_names).map(module).collect();
    let variants = all("Harness_configuration");
    let variant = |(node, name): (&Xml<'a, 'i>, String)| {
        let modules = words(*node, "Modules").map(|id| by_id.get(id).map_or(id, String::as_str).to_owned()).collect();
        KnownVariant { variant: Variant { name, modules }, node: *node, controlled: Vec::new() }
    };
    let variants = variants.iter().zip(distinct(&variants)).map(variant).collect();
    Known { modules, variants }
}

/// The modules and variants of a KBL text.
pub fn contents(text: &str) -> Result<Contents, ImportError> {
    let file = xml(text, &KBL)?;
    let read = Read::nothing_of(&file);
    Ok(known(Xml::root(&file, &read)).contents())
}

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// Chooses modules, and reports what that means.
    pub(super) fn choose(&mut self, root: Xml<'a, 'i>, selection: &Selection) -> Result<(), ImportError> {
        self.chosen = known(root).choose(selection, &mut self.file)?;
        let harnesses = children(root, "Harness").count();
        if harnesses > 1 {
            self.file.findings.add(format!("the file has {harnesses} harnesses; all are taken together"));
        }
        Ok(())
    }
}
