//! What a scenario says of plugins. It is read before everything else: the kinds that a scenario may name depend on it.

use super::entry::Entry;
use super::files::NoFiles;
use super::reader::Reader;
use crate::format::keys;
use crate::span::Span;
use toml::de::DeTable;
use wireloom_core::Registry;

/// How long one call of a plugin may take where the scenario does not say, s.
const TIME_LIMIT: f64 = 10.0;

/// The plugins that a scenario wants.
#[derive(Clone, Debug, PartialEq)]
pub struct Plugins {
    /// Names of plugins, or paths of libraries from the scenario's folder, and where they stand.
    pub load: Vec<(String, Span)>,
    /// How long one call of a plugin may take, s.
    pub time_limit: f64,
}

impl Default for Plugins {
    fn default() -> Self {
        Self { load: vec![], time_limit: TIME_LIMIT }
    }
}

/// The plugins that a scenario's text wants; what is wrong with them is left for [`crate::parse`] to say.
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
