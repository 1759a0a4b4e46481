//! Names, each given out once.

use std::collections::{HashMap, HashSet};

/// Longest label that serves as a name; a longer one gives way to the XML id.
const LONGEST_NAME: usize = 32;

/// Gives out names, each once.
#[derive(Default)]
pub(super) struct Names {
    taken: HashSet<String>,
    /// The number that the next one of a name that is taken is tried with.
    next: HashMap<String, usize>,
}

/// What has no name of its own is called.
const NAMELESS: &str = "unnamed";

impl Names {
    /// The label, or the id where the label is long or has control characters; numbered where it is taken.
    pub fn take(&mut self, label: &str, id: &str) -> String {
        let fits = !label.is_empty() && label.chars().count() <= LONGEST_NAME && !label.chars().any(char::is_control);
        self.unique(if fits { label } else { id })
    }

    /// The name itself, or numbered where it is taken.
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
