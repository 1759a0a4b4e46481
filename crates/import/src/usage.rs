//! What an import does with each element of a file.

use std::collections::BTreeMap;

/// Use of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// The computation depends on it.
    Used,
    /// The scenario names it; the computation does not depend on it.
    Kept,
    /// It belongs to other modules than the chosen ones, or to what only these need.
    LeftOut,
    /// It is not read.
    NotRead,
}

/// An element directly in the container or a harness.
pub(super) struct Element {
    /// Its name.
    pub kind: String,
    /// Its XML id; may be empty.
    pub id: String,
    pub usage: Use,
}

/// What an import does with the elements of one kind: their numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Usage {
    /// Class of the element in the file.
    pub kind: String,
    /// In the file.
    pub total: usize,
    /// The computation depends on them.
    pub used: usize,
    /// The scenario names them; the computation does not depend on them.
    pub kept: usize,
    /// They belong to other modules than the chosen ones, or to what only these need.
    pub left_out: usize,
    /// They are not read.
    pub not_read: usize,
}

/// The elements by kind, in alphabetical order.
pub(super) fn count(elements: &[Element]) -> Vec<Usage> {
    let mut kinds: BTreeMap<&str, Usage> = BTreeMap::new();
    for Element { kind, usage, .. } in elements {
        let own = kinds.entry(kind).or_insert_with(|| Usage { kind: kind.clone(), ..Usage::default() });
        own.total += 1;
        *match usage {
            Use::Used => &mut own.used,
            Use::Kept => &mut own.kept,
            Use::LeftOut => &mut own.left_out,
            Use::NotRead => &mut own.not_read,
        } += 1;
    }
    kinds.into_values().collect()
}
