//! Values that take the place of what a file says: given on the command line, or by a sweep.
//!
//! A setting names its key by the way to it: `branches.left.length`. Entries of lists go by their name (or the branch,
//! constraint, load or vertex they are about), or by their number from 0, which also leads to the parts of a vector:
//! `constraints.clip-1.position.2`. `*` stands for every entry: `branches.*.segments`. A part with a dot in it stands in quotes:
//! `steps."plug B.1".increments`. What is set is read as if it stood in the file, and refused as it would be there.

use crate::fault::Fault;

/// A value for a key, as text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// The way to the key.
    pub key: String,
    /// Its value as TOML; what is no TOML, such as `500 mm`, is a string.
    pub value: String,
}

impl Setting {
    /// A value for a key.
    pub fn new(key: impl Into<String>, value: impl Into<String>) -> Self {
        Self { key: key.into(), value: value.into() }
    }

    /// The kind of the minimiser.
    pub fn minimiser(kind: &str) -> Self {
        Self::new("minimiser.kind", kind)
    }
}

/// The settings as lines, one each, in which faults have places that begin after the scenario's text and its last line feed.
pub fn lines(settings: &[Setting]) -> String {
    settings.iter().map(|setting| format!("{} = {}\n", setting.key, setting.value)).collect()
}

/// Faults of the text, and faults of the [`lines`] of the settings, each with places of its own.
pub fn apart(text: &str, faults: Vec<Fault>) -> (Vec<Fault>, Vec<Fault>) {
    let first = text.len() + 1;
    let (mut set, own): (Vec<Fault>, Vec<Fault>) = faults.into_iter().partition(|fault| fault.span.start >= first);
    for fault in &mut set {
        fault.span = fault.span.start - first..fault.span.end - first;
    }
    (own, set)
}
