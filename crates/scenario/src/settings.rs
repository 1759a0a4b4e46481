//! Settings: values that replace those of a file, given on the command line or by a sweep.
//!
//! A setting names its key by its path: `branches.left.length`. Entries of lists are selected by their name (or the
//! branch, constraint, load or vertex that they refer to), or by their number from 0, which also selects the components
//! of a vector: `constraints.clip-1.position.2`. `*` selects every entry: `branches.*.segments`. A part that contains a
//! dot is quoted: `steps."plug B.1".increments`. A set value is read and checked as if it stood in the file.

use crate::fault::Fault;

/// A value for a key, as text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Path to the key.
    pub key: String,
    /// Its value as TOML; text that is not TOML, such as `500 mm`, is a string.
    pub value: String,
}

impl Setting {
    /// A value for a key.
    pub fn new(key: impl Into<String>, value: impl Into<String>) -> Self {
        Self { key: key.into(), value: value.into() }
    }

    /// A number in SI units for a key.
    pub fn number(key: impl Into<String>, number: f64) -> Self {
        Self::new(key, format!("{number:?}"))
    }

    /// The kind of the minimiser.
    pub fn minimiser(kind: &str) -> Self {
        Self::new("minimiser.kind", kind)
    }
}

/// The settings as text, one line each. Faults in them have places that count from the beginning of the scenario's
/// text; the lines follow that text and one line feed.
pub fn lines(settings: &[Setting]) -> String {
    settings.iter().map(|setting| format!("{} = {}\n", setting.key, setting.value)).collect()
}

/// Separates faults of the text from faults of the [`lines`] of the settings; the places of the latter then count from
/// the beginning of these lines.
pub fn apart(text: &str, faults: Vec<Fault>) -> (Vec<Fault>, Vec<Fault>) {
    let first = text.len() + 1;
    let (mut set, own): (Vec<Fault>, Vec<Fault>) = faults.into_iter().partition(|fault| fault.span.start >= first);
    for fault in &mut set {
        fault.span = fault.span.start - first..fault.span.end - first;
    }
    (own, set)
}
