//! What the elements of all files have alike: occurrences and their roles, texts in several languages, colours.

use crate::xml::{Xml, child, child_text, children};

/// Texts that stand for no value.
pub(super) const NOTHING: [&str; 2] = ["-", "NotDefined"];

/// Whether an element is an occurrence of a part, or a usage of one that is not chosen yet.
pub(super) fn is_occurrence(node: &Xml) -> bool {
    ["Component", "PartUsage"].contains(&node.name())
}

/// The text of a child that may have several languages: in English, or else the first one.
pub(super) fn localized<'a>(node: Xml<'a, '_>, name: &'static str) -> Option<&'a str> {
    let english = |text: &Xml| child_text(*text, "LanguageCode").is_some_and(|code| code.eq_ignore_ascii_case("en"));
    let chosen = children(node, name).find(english).or_else(|| child(node, name))?;
    child_text(chosen, "Value").filter(|text| !NOTHING.contains(text))
}

/// The role of an occurrence that refers to a specification of this kind, by the name of the reference.
pub(super) fn role<'a, 'i>(occurrence: Xml<'a, 'i>, specification: &'static str) -> Option<Xml<'a, 'i>> {
    children(occurrence, "Role").find(|role| child(*role, specification).is_some())
}

/// Keys of colours.
pub(super) fn joined<'a, 'i: 'a>(colours: impl Iterator<Item = Xml<'a, 'i>>) -> Option<String> {
    let keys: Vec<&str> =
        colours.filter_map(|own| child_text(own, "Key")).filter(|key| !NOTHING.contains(key)).collect();
    (!keys.is_empty()).then(|| keys.join("/"))
}
