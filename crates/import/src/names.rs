//! Unique names.

use std::collections::{HashMap, HashSet};

/// Largest length of a label that serves as a name; a longer one is replaced by the XML id.
const LONGEST_NAME: usize = 32;

/// Makes names unique.
#[derive(Default)]
pub(super) struct Names {
    taken: HashSet<String>,
    /// The next number to try for a name that is taken.
    next: HashMap<String, usize>,
}

/// Name of entries without a name.
const NAMELESS: &str = "unnamed";

impl Names {
    /// The label, or the id if the label is long or has control characters; with a number if it is taken.
    pub fn take(&mut self, label: &str, id: &str) -> String {
        let fits = !label.is_empty() && label.chars().count() <= LONGEST_NAME && !label.chars().any(char::is_control);
        self.unique(if fits { label } else { id })
    }

    /// The name itself, with a number if it is taken.
    pub fn unique(&mut self, name: &str) -> String {
        let name = if name.trim().is_empty() { NAMELESS } else { name };
        let mut unique = name.to_owned();
        if self.taken.contains(name) {
            let next = self.next.entry(name.to_owned()).or_insert(2);
            while self.taken.contains(&unique) {
                unique = format!("{name}-{next}");
                *next += 1;
            }
        }
        self.taken.insert(unique.clone());
        unique
    }
}
