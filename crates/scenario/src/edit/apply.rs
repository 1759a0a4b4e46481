//! Applies settings to the table of a scenario.

use super::key_path::{NAMES, Part, below, parts, stale};
use crate::fault::{Fault, did_you_mean};
use crate::format::form::Keys;
use crate::format::keys;
use crate::settings::Setting;
use std::borrow::Cow;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use wireloom_core::Registry;

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

/// A value with its places in the whole text.
fn value(text: &str, start: usize) -> Result<Spanned<DeValue<'_>>, Fault> {
    let span = start..start + text.len();
    match DeValue::parse(text) {
        Ok(value) => Ok(shifted(value, start)),
        Err(error) if text.trim().is_empty() || text.trim_start().starts_with(['[', '{', '"', '\'']) => Err(Fault {
            span,
            message: format!("`{text}` is not a value: {}", error.message()),
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

/// A place on the path of a setting.
struct Place<'r> {
    /// The keys of entries here, if they are known.
    keys: Option<&'static Keys>,
    /// Its name in messages.
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

    /// Follows the path behind one of its parts.
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
                help: format!("end the path to the key with `{}`", part.name),
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

/// Name of an entry of a list.
fn name_of(item: &Spanned<DeValue<'_>>) -> Option<String> {
    let DeValue::Table(table) = item.get_ref() else { return None };
    NAMES.iter().find_map(|key| match table.get(*key)?.get_ref() {
        DeValue::String(name) => Some(name.to_string()),
        _ => None,
    })
}
