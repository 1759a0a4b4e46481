//! Places in the text of a scenario.

use std::collections::BTreeMap;
use std::ops::Range;

/// A place in a text, bytes.
pub type Span = Range<usize>;

/// Places of an entry and its values in the file, for faults that are found only when parts are built.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Spans {
    /// The entry, bytes.
    pub entry: Span,
    /// The values of its keys, bytes.
    pub keys: BTreeMap<String, Span>,
}

impl Spans {
    /// The value of a key, or the entry where the key is not given.
    pub fn of(&self, key: Option<&str>) -> Span {
        key.and_then(|key| self.keys.get(key)).unwrap_or(&self.entry).clone()
    }
}
