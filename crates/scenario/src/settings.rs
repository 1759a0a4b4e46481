//! Values that take the place of what a file says: given on the command line, or by a sweep.
//!
//! A setting names its key by the way to it: `branches.left.length`. Entries of lists go by their name (or the branch,
//! constraint, load or vertex they are about), or by their number from 0, which also leads to the parts of a vector:
//! `constraints.clip-1.position.2`. `*` stands for every entry: `branches.*.segments`. A part with a dot in it stands in quotes:
//! `steps."plug B.1".increments`. What is set is read as if it stood in the file, and refused as it would be there.

use crate::Span;
use crate::fault::{Fault, did_you_mean};
use crate::keys::{self, Form, Keys};
use crate::kinds;
use std::borrow::Cow;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use wireloom_core::Registry;

/// Where an entry of a list has its name, or that of what it is about.
pub(crate) const NAMES: [&str; 6] = ["name", "branch", "constraint", "load", "joint", "of"];
/// Of such keys an entry has one: setting one takes the other's place.
const EITHER: [[&str; 2]; 2] = [["segments", "max_segment"], ["max_segment", "segments"]];

/// A value for a key, as text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// The way to the key.
    pub key: String,
    /// Its value as TOML; what is no TOML, such as `500 mm`, is a string.
    pub value: String,
}

impl Setting {
    /// A value for a key.
    pub fn new(key: impl Into<String>, value: impl Into<String>) -> Self {
        Self { key: key.into(), value: value.into() }
    }

    /// The kind of the minimiser.
    pub fn minimiser(kind: &str) -> Self {
        Self::new("minimiser.kind", kind)
    }
}

/// The settings as lines, one each, in which faults have places that begin after the scenario's text and its last line feed.
pub fn lines(settings: &[Setting]) -> String {
    settings.iter().map(|setting| format!("{} = {}\n", setting.key, setting.value)).collect()
}

/// Faults of the text, and faults of the [`lines`] of the settings, each with places of its own.
pub fn apart(text: &str, faults: Vec<Fault>) -> (Vec<Fault>, Vec<Fault>) {
    let first = text.len() + 1;
    let (mut set, own): (Vec<Fault>, Vec<Fault>) = faults.into_iter().partition(|fault| fault.span.start >= first);
    for fault in &mut set {
        fault.span = fault.span.start - first..fault.span.end - first;
    }
    (own, set)
}

/// Puts settings into a table. `text` is that of the table, a line feed, and the [`lines`].
pub(crate) fn put<'a>(
    table: &mut DeTable<'a>,
    text: &'a str,
    own: usize,
    settings: &[Setting],
    registry: &Registry,
) -> Vec<Fault> {
    let mut faults = Vec::new();
    let mut start = own + 1;
    for setting in settings {
        let key = start..start + setting.key.len();
        let at = key.end + " = ".len();
        let span = at..at + setting.value.len();
        start = span.end + 1;
        let put = parts(&setting.key, key.start)
            .and_then(|parts| Ok((parts, value(text.get(span.clone()).unwrap_or_default(), span.start)?)))
            .and_then(|(parts, value)| {
                let place = Place { keys: Some(&keys::SCENARIO), what: "the scenario".to_owned(), registry };
                place.table(table, &parts, &value)
            });
        faults.extend(put.err());
    }
    faults
}

/// One part of the way to a key.
pub(crate) struct Part {
    pub name: String,
    /// `*`, without quotes.
    every: bool,
    span: Span,
}

pub(crate) fn parts(key: &str, start: usize) -> Result<Vec<Part>, Fault> {
    let refused = |at: usize, message: &str| Fault {
        span: start + at..start + key.len(),
        message: format!("`{key}` names no key: {message}"),
        help: "write the way to a key with dots, such as branches.left.length; quote names that have dots".to_owned(),
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

/// A value with its places in the whole text.
fn value(text: &str, start: usize) -> Result<Spanned<DeValue<'_>>, Fault> {
    let span = start..start + text.len();
    match DeValue::parse(text) {
        Ok(value) => Ok(shifted(value, start)),
        Err(error) if text.trim().is_empty() || text.trim_start().starts_with(['[', '{', '"', '\'']) => Err(Fault {
            span,
            message: format!("`{text}` is no value: {}", error.message()),
            help: "write a value as in the file, such as 0.5, \"500 mm\" or [0, 0, 1]".to_owned(),
        }),
        Err(_) => Ok(Spanned::new(span, DeValue::String(Cow::Borrowed(text.trim())))),
    }
}

fn shifted(node: Spanned<DeValue<'_>>, by: usize) -> Spanned<DeValue<'_>> {
    let span = node.span().start + by..node.span().end + by;
    let value = match node.into_inner() {
        DeValue::Array(list) => DeValue::Array(list.into_iter().map(|item| shifted(item, by)).collect()),
        DeValue::Table(table) => DeValue::Table(
            table
                .into_iter()
                .map(|(key, value)| {
                    let place = key.span().start + by..key.span().end + by;
                    (Spanned::new(place, key.into_inner()), shifted(value, by))
                })
                .collect(),
        ),
        plain => plain,
    };
    Spanned::new(span, value)
}

/// The keys of what lies behind a part of the way, where they are known, and whether it may come into being by being named.
pub(crate) fn below(keys: Option<&'static Keys>, name: &str) -> (Option<&'static Keys>, bool) {
    let form = keys.and_then(|keys| keys.get(name)).map(|key| key.form);
    let below = match form {
        Some(Form::Table(keys) | Form::Tables(keys) | Form::Named(keys) | Form::NamesOrTables(keys)) => Some(keys),
        // Entries of a table of tables have the keys of that table.
        None => keys,
        Some(_) => None,
    };
    (below, matches!(form, Some(Form::Table(_))))
}

/// The keys that go when this one gets a value (`word`, where that is one): what an entry has instead of it, and, where it chooses a kind, the
/// parameters of other kinds.
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

/// Where on the way a setting is.
struct Place<'r> {
    /// The keys of entries here, where they are known.
    keys: Option<&'static Keys>,
    /// What messages call it.
    what: String,
    registry: &'r Registry,
}

impl Place<'_> {
    fn next(&self, part: &str, keys: Option<&'static Keys>) -> Self {
        Place { keys, what: format!("`{part}` of {}", self.what), registry: self.registry }
    }

    fn table<'a>(&self, table: &mut DeTable<'a>, parts: &[Part], value: &Spanned<DeValue<'a>>) -> Result<(), Fault> {
        let [part, rest @ ..] = parts else { return Ok(()) };
        let name = part.name.as_str();
        if part.every {
            let mut found = false;
            for (key, node) in table.iter_mut() {
                found = true;
                self.next(key.get_ref(), self.keys).node(node, part, rest, value)?;
            }
            return if found { Ok(()) } else { Err(self.nothing(part)) };
        }
        if rest.is_empty() {
            self.insert(table, part, value.clone());
            return Ok(());
        }
        let (below, makes) = below(self.keys, name);
        if !table.contains_key(name) {
            if !makes {
                let known: Vec<String> = table.keys().map(|key| key.get_ref().to_string()).collect();
                return Err(self.unknown(part, "key", &known));
            }
            let empty = Spanned::new(part.span.clone(), DeValue::Table(DeTable::new()));
            table.insert(Spanned::new(part.span.clone(), Cow::Owned(name.to_owned())), empty);
        }
        let Some(node) = table.get_mut(name) else { return Ok(()) };
        self.next(name, below).node(node, part, rest, value)
    }

    /// What lies behind a part of the way.
    fn node<'a>(
        &self,
        node: &mut Spanned<DeValue<'a>>,
        part: &Part,
        rest: &[Part],
        value: &Spanned<DeValue<'a>>,
    ) -> Result<(), Fault> {
        let [next, after @ ..] = rest else {
            *node = value.clone();
            return Ok(());
        };
        match node.get_mut() {
            DeValue::Table(table) => self.table(table, rest, value),
            DeValue::Array(list) => {
                let mut found = false;
                let number: Option<usize> = next.name.parse().ok();
                let names: Vec<Option<String>> = list.iter().map(name_of).collect();
                let named = names.iter().flatten().any(|name| *name == next.name);
                for (k, item) in list.iter_mut().enumerate() {
                    let here = if named { names[k].as_ref() == Some(&next.name) } else { number == Some(k) };
                    if next.every || here {
                        found = true;
                        self.next(&next.name, self.keys).node(item, next, after, value)?;
                    }
                }
                match (found, next.every) {
                    (true, _) => Ok(()),
                    (false, true) => Err(self.nothing(next)),
                    (false, false) => {
                        Err(self.unknown(next, "entry", &names.into_iter().flatten().collect::<Vec<_>>()))
                    }
                }
            }
            _ => Err(Fault {
                span: next.span.clone(),
                message: format!("{} has no parts, so it has no `{}`", self.what, next.name),
                help: format!("end the way to the key with `{}`", part.name),
            }),
        }
    }

    fn insert<'a>(&self, table: &mut DeTable<'a>, part: &Part, value: Spanned<DeValue<'a>>) {
        let name = part.name.as_str();
        let kind = if let DeValue::String(kind) = value.get_ref() { Some(kind.as_ref()) } else { None };
        for stale in stale(self.keys, name, kind, self.registry) {
            table.remove(stale.as_str());
        }
        table.remove(name);
        table.insert(Spanned::new(part.span.clone(), Cow::Owned(name.to_owned())), value);
    }

    fn unknown(&self, part: &Part, word: &str, there: &[String]) -> Fault {
        if word == "key" && self.keys.is_some_and(|keys| keys.get(&part.name).is_some()) {
            return Fault {
                span: part.span.clone(),
                message: format!("{} has no `{}`, so it has no parts", self.what, part.name),
                help: format!("set `{}` as a whole, or write it in the file", part.name),
            };
        }
        let declared = self.keys.filter(|_| word == "key").into_iter().flat_map(|keys| keys.keys).map(|key| key.name);
        let known: Vec<&str> = there.iter().map(String::as_str).chain(declared).collect();
        Fault {
            span: part.span.clone(),
            message: format!("there is no {word} `{}` in {}", part.name, self.what),
            help: did_you_mean(&part.name, known.iter().copied()),
        }
    }

    fn nothing(&self, part: &Part) -> Fault {
        Fault {
            span: part.span.clone(),
            message: format!("{} has no entries", self.what),
            help: "`*` stands for every entry of a list".to_owned(),
        }
    }
}

/// What an entry of a list is called.
fn name_of(item: &Spanned<DeValue<'_>>) -> Option<String> {
    let DeValue::Table(table) = item.get_ref() else { return None };
    NAMES.iter().find_map(|key| match table.get(*key)?.get_ref() {
        DeValue::String(name) => Some(name.to_string()),
        _ => None,
    })
}
