//! The names of a scenario, as they are read.

use super::entry::Entry;
use super::fixing_types::Types;
use crate::fault::did_you_mean;
use crate::span::Span;
use std::borrow::{Borrow, Cow};
use std::collections::{BTreeMap, BTreeSet};
use wireloom_core::identity::{Element, Identified, Part};
use wireloom_core::mechanism::{Mechanism, Mount};

/// A vertex.
pub(crate) struct Vertex {
    /// Branches that end here, and whether they start here.
    pub ends: Vec<(usize, bool)>,
    /// The place where it is first named.
    pub span: Span,
}

/// The names that have been read, with the data that later entries need.
#[derive(Default)]
pub(crate) struct Names<'a> {
    pub sections: BTreeMap<&'a str, usize>,
    pub branches: BTreeMap<&'a str, usize>,
    /// Name of each branch; empty if it has none of its own.
    pub branch_names: Vec<&'a str>,
    /// Length of each branch, m; `None` if it is faulty.
    pub lengths: Vec<Option<f64>>,
    pub vertices: BTreeMap<&'a str, Vertex>,
    pub joints: BTreeMap<&'a str, usize>,
    pub constraints: BTreeMap<&'a str, usize>,
    /// Outputs of the kind of each constraint; also of those that have been released.
    pub outputs: BTreeMap<&'a str, Vec<String>>,
    /// Types of constraints.
    pub types: Types,
    /// Number of constraints; several may have had the same name one after the other.
    pub constraint_count: usize,
    /// Released constraints, whose names may be used again.
    pub let_go: BTreeSet<&'a str>,
    pub loads: BTreeMap<&'a str, usize>,
    pub obstacles: BTreeMap<Cow<'a, str>, usize>,
    /// Obstacles that mechanisms carry.
    pub mounted_obstacles: BTreeSet<usize>,
    pub mechanism_names: BTreeMap<&'a str, usize>,
    pub mechanisms: Vec<Mechanism>,
    /// Bodies of mechanisms.
    pub bodies: Qualified<Mount>,
    /// Joints of mechanisms: index of the mechanism, and of the joint in it.
    pub mechanism_joints: Qualified<(usize, usize)>,
    /// Identities of the parts that have been read.
    pub parts: Vec<Part>,
    /// Elements of a KBL file that parts come from.
    pub elements: Vec<Element>,
    /// Notes on other files.
    pub file_notes: Vec<String>,
    /// Whether branches may leave their division to the accuracy of the mesh.
    pub by_accuracy: bool,
    /// Approximate number of segments.
    pub segments: f64,
    /// Whether a name refers to nothing, so that the harness cannot be built.
    pub broken: bool,
}

impl Names<'_> {
    /// The body of a mechanism that an entry is mounted on, if any.
    pub fn mount(&self, entry: &Entry<'_>) -> Option<Mount> {
        entry.keys.get("mount")?;
        let name = entry.word("mount")?;
        self.bodies.find(entry, "body", name, entry.span_of("mount"))
    }

    /// Notes the identity of a part and the element that it comes from, if its entry gives them. A constraint that
    /// begins again is the same part.
    pub fn identify(&mut self, entry: &Entry<'_>, of: Identified, name: Option<&str>) {
        if let (Some(name), Some(id)) = (name, entry.keys.get("kbl").and_then(|_| entry.word("kbl"))) {
            let element = Element { of, name: name.to_owned(), id: id.to_owned() };
            if of != Identified::Constraint || !self.elements.contains(&element) {
                self.elements.push(element);
            }
        }
        let identity = entry.identity();
        let Some(name) = name.filter(|_| !identity.is_empty()).map(str::to_owned) else { return };
        let part = Part { of, name, identity };
        if of != Identified::Constraint || !self.parts.contains(&part) {
            self.parts.push(part);
        }
    }
}

/// Gives a name of the family to an entry; false, with a fault, if it is taken.
#[must_use]
pub(crate) fn register<'a, N: Borrow<str> + Ord + From<&'a str>>(
    entry: &Entry<'a>,
    what: &str,
    family: &mut BTreeMap<N, usize>,
    name: &'a str,
    index: usize,
) -> bool {
    if family.contains_key(name) {
        let message = format!("there is another {what} of the name \"{name}\"");
        entry.fault_at("name", message, "give this one a name of its own");
        return false;
    }
    family.insert(name.into(), index);
    true
}

/// Looks a name up; notes a fault if it is unknown.
pub(crate) fn lookup<'m, N: Borrow<str> + Ord, T>(
    entry: &Entry<'_>,
    what: &str,
    family: &'m BTreeMap<N, T>,
    name: &str,
    span: Span,
) -> Option<&'m T> {
    let found = family.get(name);
    if found.is_none() {
        let help = did_you_mean(name, family.keys().map(Borrow::borrow));
        entry.reader.fault(span, format!("unknown {what} \"{name}\" in {}", entry.label), help);
    }
    found
}

/// Parts of mechanisms by name: `PART` where only one mechanism has a part of that name, and `MECHANISM/PART`.
pub(crate) struct Qualified<T> {
    parts: BTreeMap<String, T>,
    /// Names that several mechanisms give.
    shared: BTreeSet<String>,
    /// Whether a mechanism is faulty, so that names may be missing.
    pub incomplete: bool,
}

impl<T> Default for Qualified<T> {
    fn default() -> Self {
        Self { parts: BTreeMap::new(), shared: BTreeSet::new(), incomplete: false }
    }
}

impl<T: Copy> Qualified<T> {
    /// Gives a part of a mechanism its names.
    pub fn add(&mut self, mechanism: &str, name: &str, part: T) {
        self.parts.insert(format!("{mechanism}/{name}"), part);
        if self.parts.contains_key(name) {
            self.parts.remove(name);
            self.shared.insert(name.to_owned());
        } else if !self.shared.contains(name) {
            self.parts.insert(name.to_owned(), part);
        }
    }

    /// The part of a name; notes a fault if there is none, or if the name alone does not tell which.
    pub fn find(&self, entry: &Entry<'_>, what: &str, name: &str, span: Span) -> Option<T> {
        if self.shared.contains(name) {
            let message = format!("several mechanisms have a {what} \"{name}\"");
            entry.reader.fault(span, message, format!("write \"MECHANISM/{name}\""));
            return None;
        }
        match self.parts.get(name) {
            None if self.incomplete => None,
            _ => lookup(entry, what, &self.parts, name, span).copied(),
        }
    }
}
