//! Reads dead loads.

use super::entry::Entry;
use super::names::{Names, register};
use super::places::attachment;
use crate::attachment::NOWHERE;
use crate::scenario::Load;

/// A dead load. `None` if it has no name of its own; marks the names as broken if it attaches to nothing.
pub(crate) fn load<'a>(entry: &Entry<'a>, names: &mut Names<'a>) -> Option<Load> {
    let index = names.loads.len();
    let name = entry.word("name").filter(|name| register(entry, entry.keys.what, &mut names.loads, name, index));
    let at = entry.entry("at").and_then(|at| attachment(&at, names, false)).map(|place| place.0);
    let force = entry.vector("force").unwrap_or_default();
    let moment = entry.vector("moment").unwrap_or_default();
    let factor = entry.number("factor").unwrap_or(1.0);
    if !entry.has("force") && !entry.has("moment") {
        let message = format!("{} has neither `force` nor `moment`", entry.label);
        entry.fault_here(message, "give one of them, such as force = [0, 0, -2] in N");
    }
    names.broken |= name.is_none() || at.is_none();
    let at = at.unwrap_or(NOWHERE);
    Some(Load { name: name?.to_owned(), at, force, moment, factor, spans: entry.spans() })
}
