//! Irregularities of a file, equal ones together.

use std::collections::{HashMap, HashSet};
use std::fmt::{self, Display, Formatter};

/// An irregularity of a file, and its treatment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// One sentence or two.
    pub what: String,
    /// The places, with ids of the file and faulty numbers; empty if `what` is complete.
    pub items: Vec<String>,
}

impl Display for Finding {
    /// `what`, or `what: item, item, …` with the number of items if there are several.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.items[..] {
            [] => f.write_str(&self.what),
            [item] => write!(f, "{}: {item}", self.what),
            items => write!(f, "{} ({} of them): {}", self.what, items.len(), items.join(", ")),
        }
    }
}

/// The findings of one import, in the order in which they were first made.
#[derive(Default)]
pub(super) struct Findings {
    pub list: Vec<Finding>,
    places: HashMap<String, usize>,
    /// Items that are listed, by the place of their finding.
    listed: HashSet<(usize, String)>,
}

impl Findings {
    /// A finding without items; added once.
    pub fn add(&mut self, what: impl Into<String>) {
        self.entry(what.into());
    }

    /// One more item of a finding; equal items are listed once.
    pub fn add_to(&mut self, what: impl Into<String>, item: impl Into<String>) {
        let (at, item) = (self.entry(what.into()), item.into());
        if self.listed.insert((at, item.clone())) {
            self.list[at].items.push(item);
        }
    }

    fn entry(&mut self, what: String) -> usize {
        let list = &mut self.list;
        *self.places.entry(what).or_insert_with_key(|what| {
            list.push(Finding { what: what.clone(), items: Vec::new() });
            list.len() - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_findings_stand_together_and_nothing_is_said_twice() {
        let mut findings = Findings::default();
        findings.add_to("stale", "a (1 mm)");
        findings.add("alone");
        findings.add_to("stale", "b (2 mm)");
        findings.add_to("stale", "a (1 mm)");
        findings.add("alone");
        let said: Vec<String> = findings.list.iter().map(ToString::to_string).collect();
        assert_eq!(said, ["stale (2 of them): a (1 mm), b (2 mm)", "alone"]);
    }
}
