//! Reads the minimiser.

use super::entry::Entry;
use super::kinds;
use super::names::Names;
use crate::format::keys;
use crate::scenario::Minimiser;
use crate::span::Spans;
use wireloom_core::Stop;

/// The minimiser, with defaults if the file has none.
pub(crate) fn minimiser<'a>(root: &Entry<'a>, names: &mut Names<'a>) -> Minimiser {
    let empty = toml::de::DeTable::new();
    let given = root.entry("minimiser");
    let absent = given.is_none();
    let entry =
        given.unwrap_or_else(|| Entry::new(root.reader, &empty, 0..0, &keys::MINIMISER, "the minimiser".to_owned()));
    let kind = if absent && root.has("minimiser") { None } else { kinds::read(&entry) };
    names.broken |= kind.is_none();
    let (kind, parameters) = kind.map(|kind| (kind.name, kind.parameters)).unwrap_or_default();
    let default = Stop::default();
    let stop = Stop {
        force_tolerance: entry.number("force_tolerance").unwrap_or(default.force_tolerance),
        max_iterations: entry.count("max_iterations").unwrap_or(default.max_iterations),
    };
    Minimiser { kind, parameters, stop, spans: if absent { Spans::default() } else { entry.spans() } }
}
