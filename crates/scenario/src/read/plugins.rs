//! The plugins that a scenario names. They are read before everything else, because the kinds depend on them.

use super::entry::Entry;
use super::files::NoFiles;
use super::reader::Reader;
use crate::format::keys;
use crate::span::Span;
use toml::de::DeTable;
use wireloom_core::Registry;

/// Default time limit of one call of a plugin, s.
const TIME_LIMIT: f64 = 10.0;

/// The plugins that a scenario loads.
#[derive(Clone, Debug, PartialEq)]
pub struct Plugins {
    /// Names of plugins, or paths of libraries from the scenario's folder, with their places in the text.
    pub load: Vec<(String, Span)>,
    /// Time limit of one call of a plugin, s.
    pub time_limit: f64,
}

impl Default for Plugins {
    fn default() -> Self {
        Self { load: vec![], time_limit: TIME_LIMIT }
    }
}

/// The plugins that a scenario's text loads; their faults are reported by [`crate::parse`].
pub fn plugins(text: &str) -> Plugins {
    let (table, _) = DeTable::parse_recoverable(text);
    let registry = Registry::default();
    let reader = Reader::new(text, &NoFiles, &registry);
    let root = Entry::new(&reader, table.get_ref(), 0..0, &keys::SCENARIO, "the scenario".to_owned());
    root.entry("plugins").map(|entry| read(&entry)).unwrap_or_default()
}

/// Reads the table `plugins`.
pub(crate) fn read(entry: &Entry<'_>) -> Plugins {
    Plugins {
        load: entry.names("load").into_iter().map(|(name, span)| (name.to_owned(), span)).collect(),
        time_limit: entry.number("time_limit").unwrap_or(TIME_LIMIT),
    }
}
