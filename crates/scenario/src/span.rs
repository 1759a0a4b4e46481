//! Places in the text of a scenario.

use std::collections::BTreeMap;
use std::ops::Range;

/// A place in a text, bytes.
pub type Span = Range<usize>;

/// Where an entry of the file is, for faults that only the building of parts can find.
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
