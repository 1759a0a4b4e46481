//! The path to a key: `steps."plug B.1".increments`.

use crate::fault::Fault;
use crate::format::form::{Form, Keys};
use crate::format::kinds;
use crate::span::Span;
use wireloom_core::Registry;

/// Keys that name an entry of a list: its own name, or that of the part that it refers to.
pub(crate) const NAMES: [&str; 6] = ["name", "branch", "constraint", "load", "joint", "of"];
/// Keys that exclude each other: setting the first removes the second.
const EITHER: [[&str; 2]; 2] = [["segments", "max_segment"], ["max_segment", "segments"]];

/// One part of the path to a key.
pub(crate) struct Part {
    pub name: String,
    /// `*`, without quotes.
    pub every: bool,
    pub span: Span,
}

pub(crate) fn parts(key: &str, start: usize) -> Result<Vec<Part>, Fault> {
    let refused = |at: usize, message: &str| Fault {
        span: start + at..start + key.len(),
        message: format!("`{key}` names no key: {message}"),
        help: "write the path to a key with dots, such as branches.left.length; quote names that have dots".to_owned(),
    };
    let mut parts = Vec::new();
    let mut at = 0;
    loop {
        let rest = &key[at..];
        let quote = rest.chars().next().filter(|c| matches!(c, '"' | '\''));
        let (name, length) = match quote {
            Some(quote) => {
                let end = rest[1..].find(quote).ok_or_else(|| refused(at, "a quote is not closed"))?;
                (&rest[1..1 + end], end + 2)
            }
            None => {
                let end = rest.find('.').unwrap_or(rest.len());
                (rest[..end].trim(), end)
            }
        };
        if name.is_empty() {
            return Err(refused(at, "a part of it is empty"));
        }
        let span = start + at..start + at + length;
        parts.push(Part { name: name.to_owned(), every: quote.is_none() && name == "*", span });
        at += length;
        match key[at..].chars().next() {
            None => return Ok(parts),
            Some('.') => at += 1,
            Some(_) => return Err(refused(at, "after a quote there must be a dot")),
        }
    }
}

/// The keys behind a part of the path, if they are known, and whether a missing table is created there.
pub(crate) fn below(keys: Option<&'static Keys>, name: &str) -> (Option<&'static Keys>, bool) {
    let form = keys.and_then(|keys| keys.get(name)).map(|key| key.form);
    let below = match form {
        Some(
            Form::Table(keys)
            | Form::Tables(keys)
            | Form::OneOrMoreTables(keys)
            | Form::Named(keys)
            | Form::NamesOrTables(keys),
        ) => Some(keys),
        // Entries of a table of tables have the keys of that table.
        None => keys,
        Some(_) => None,
    };
    (below, matches!(form, Some(Form::Table(_))))
}

/// The keys that are removed when this one is set (`word`: the value, if it is a word): the key that it excludes and,
/// if it chooses a kind, the parameters of other kinds.
pub(crate) fn stale(keys: Option<&'static Keys>, name: &str, word: Option<&str>, registry: &Registry) -> Vec<String> {
    let mut stale: Vec<String> =
        EITHER.iter().filter(|[one, _]| *one == name).map(|[_, other]| (*other).to_owned()).collect();
    if let (Some((key, family, _)), Some(kind)) = (keys.and_then(Keys::kind), word)
        && key == name
    {
        let kinds = kinds::all(registry, family);
        let Some(new) = kinds.iter().find(|other| other.name == kind) else { return stale };
        let stays = |name: &str| new.parameters.iter().any(|parameter| parameter.name == name);
        let own = |name: &str| keys.is_some_and(|keys| keys.get(name).is_some());
        let foreign = kinds.iter().flat_map(|kind| kind.parameters).map(|parameter| parameter.name.as_str());
        stale.extend(foreign.filter(|name| !stays(name) && !own(name)).map(str::to_owned));
    }
    stale
}
