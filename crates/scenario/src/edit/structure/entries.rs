//! Lists and tables of a text, in whichever form they are written.

use super::part::{BEGINNINGS, Part};
use crate::edit::key_path;
use crate::edit::record::{entry_of, name_of};
use crate::fault::{Fault, did_you_mean};
use std::collections::BTreeSet;
use toml_edit::{ArrayOfTables, DocumentMut, InlineTable, Item, TableLike, Value};

/// The entries of a list, or the one table that stands for it.
pub(super) fn entries(item: &mut Item) -> Vec<&mut dyn TableLike> {
    match item {
        Item::ArrayOfTables(tables) => tables.iter_mut().map(|table| table as &mut dyn TableLike).collect(),
        Item::Value(Value::Array(list)) => {
            list.iter_mut().filter_map(|value| Some(value.as_inline_table_mut()? as &mut dyn TableLike)).collect()
        }
        other => other.as_table_like_mut().into_iter().collect(),
    }
}

pub(in crate::edit) fn list<'d>(table: &'d mut dyn TableLike, key: &str) -> Vec<&'d mut dyn TableLike> {
    table.get_mut(key).map_or(Vec::new(), entries)
}

/// Keeps some of the entries of a list, or the one table that stands for it.
pub(in crate::edit) fn retain(table: &mut dyn TableLike, key: &str, keep: &mut dyn FnMut(&dyn TableLike) -> bool) {
    let gone = match table.get_mut(key) {
        Some(Item::ArrayOfTables(tables)) => {
            tables.retain(|own| keep(own));
            false
        }
        Some(Item::Value(Value::Array(list))) => {
            let bare = |value: &Value| value.decor().prefix().and_then(|prefix| prefix.as_str()) == Some("");
            let began_bare = list.get(0).is_some_and(bare);
            list.retain(|value| value.as_inline_table().is_none_or(|own| keep(own)));
            if let Some(first) = list.get_mut(0).filter(|_| began_bare) {
                first.decor_mut().set_prefix("");
            }
            false
        }
        Some(item) => item.as_table_like().is_some_and(|own| !keep(own)),
        None => false,
    };
    if gone {
        table.remove(key);
    }
}

pub(in crate::edit) fn word<'t>(table: &'t dyn TableLike, key: &str) -> Option<&'t str> {
    table.get(key)?.as_str()
}

pub(super) fn is(table: &dyn TableLike, key: &str, name: &str) -> bool {
    word(table, key) == Some(name)
}

/// Replaces a value, and keeps what stands beside it.
pub(super) fn put(item: &mut Item, value: Value) {
    match item {
        Item::Value(old) => {
            let decor = old.decor().clone();
            *old = value;
            *old.decor_mut() = decor;
        }
        other => *other = Item::Value(value),
    }
}

/// Gives a key another value; what stands beside it stays.
pub(super) fn set(table: &mut dyn TableLike, key: &str, value: Value) {
    match table.get_mut(key) {
        Some(item) => put(item, value),
        None => {
            table.insert(key, Item::Value(value));
        }
    }
}

/// A table in one line, without comments.
pub(super) fn copy_of(table: &dyn TableLike) -> InlineTable {
    let mut copy = InlineTable::new();
    for (key, item) in table.iter() {
        if let Ok(mut value) = item.clone().into_value() {
            value.decor_mut().clear();
            copy.insert(key, value);
        }
    }
    copy
}

/// Removes what is at a path within a table. Returns whether it was there.
pub(super) fn remove_in(table: &mut dyn TableLike, parts: &[key_path::Part]) -> bool {
    let [part, rest @ ..] = parts else { return false };
    let [next, behind @ ..] = rest else { return table.remove(&part.name).is_some() };
    let Some(item) = table.get_mut(&part.name) else { return false };
    let Some(k) = index_of(item, &next.name) else {
        return item.as_table_like_mut().is_some_and(|table| remove_in(table, rest));
    };
    match item {
        _ if !behind.is_empty() => entries(item).into_iter().nth(k).is_some_and(|table| remove_in(table, behind)),
        Item::ArrayOfTables(tables) => {
            tables.remove(k);
            true
        }
        Item::Value(Value::Array(list)) => {
            list.remove(k);
            true
        }
        _ => false,
    }
}

/// Index of the entry of a list with this name or number.
pub(super) fn index_of(item: &Item, name: &str) -> Option<usize> {
    let names: Vec<Option<String>> = match item {
        Item::ArrayOfTables(tables) => tables.iter().map(|table| name_of(table)).collect(),
        Item::Value(Value::Array(list)) => {
            list.iter().map(|value| value.as_inline_table().and_then(|table| name_of(table))).collect()
        }
        _ => return None,
    };
    entry_of(&names, name)
}

/// Appends an entry to a list of the top level, in the form that the list has.
pub(super) fn append(text: &str, document: &mut DocumentMut, key: &str, entry: InlineTable) -> Result<(), Fault> {
    let item = document.as_table_mut().entry(key).or_insert(Item::ArrayOfTables(ArrayOfTables::new()));
    match item {
        Item::ArrayOfTables(tables) => {
            let mut table = entry.into_table();
            table.decor_mut().set_prefix("\n");
            // As a person writes them: inline below the top level.
            tables.push(table);
            Ok(())
        }
        Item::Value(Value::Array(list)) => {
            let multiline = list.iter().any(|value| value.decor().prefix().is_some_and(|p| has_line_feed(p.as_str())));
            list.push(entry);
            if multiline && let Some(last) = list.get_mut(list.len() - 1) {
                last.decor_mut().set_prefix("\n  ");
            }
            Ok(())
        }
        _ => Err(refused(text, format!("`{key}` is no list"), "write it as [[tables]]")),
    }
}

pub(super) fn has_line_feed(text: Option<&str>) -> bool {
    text.is_some_and(|text| text.contains('\n'))
}

/// Removes lists that have lost their last entry.
pub(super) fn drop_empty_lists(document: &mut DocumentMut) {
    let empty: Vec<String> = document
        .iter()
        .filter(|(_, item)| match item {
            Item::ArrayOfTables(tables) => tables.is_empty(),
            Item::Value(Value::Array(list)) => list.is_empty(),
            _ => false,
        })
        .map(|(key, _)| key.to_owned())
        .collect();
    for key in empty {
        document.remove(&key);
    }
}

/// The names of the parts of a kind.
pub(super) fn names(document: &DocumentMut, part: Part) -> BTreeSet<String> {
    let mut document = document.clone();
    if part == Part::Vertex {
        return vertices(&document);
    }
    if part == Part::Section {
        let sections = document.get("sections").and_then(Item::as_table_like);
        return sections.into_iter().flat_map(TableLike::iter).map(|(name, _)| name.to_owned()).collect();
    }
    let root = document.as_table_mut();
    let mut all: BTreeSet<String> =
        list(root, part.list()).iter().filter_map(|own| Some(word(*own, "name")?.to_owned())).collect();
    if part == Part::Constraint {
        for step in list(root, "steps") {
            for key in BEGINNINGS {
                all.extend(list(step, key).iter().filter_map(|own| Some(word(*own, "name")?.to_owned())));
            }
        }
    }
    all
}

pub(super) fn vertices(document: &DocumentMut) -> BTreeSet<String> {
    let mut document = document.clone();
    let branches = list(document.as_table_mut(), "branches");
    let ends = branches.iter().flat_map(|own| [word(*own, "from"), word(*own, "to")]);
    ends.flatten().map(str::to_owned).collect()
}

/// Visits every table of an item, with the keys that lead to it.
pub(super) fn each_table(item: &mut Item, way: &mut Vec<String>, act: &mut dyn FnMut(&[String], &mut dyn TableLike)) {
    for table in entries(item) {
        each_below(table, way, act);
    }
}

/// Visits a table, and every table within it.
pub(super) fn each_below(
    table: &mut dyn TableLike,
    way: &mut Vec<String>,
    act: &mut dyn FnMut(&[String], &mut dyn TableLike),
) {
    act(way, table);
    let keys: Vec<String> = table.iter().map(|(key, _)| key.to_owned()).collect();
    for key in keys {
        if let Some(item) = table.get_mut(&key) {
            way.push(key);
            each_table(item, way, act);
            way.pop();
        }
    }
}

pub(super) fn unused(there: &BTreeSet<String>, wanted: &str) -> String {
    let numbered = (2..).map(|k| format!("{wanted} {k}"));
    std::iter::once(wanted.to_owned()).chain(numbered).find(|name| !there.contains(name)).unwrap_or_default()
}

pub(super) fn refused(text: &str, message: impl Into<String>, help: &str) -> Fault {
    Fault { span: text.len()..text.len(), message: message.into(), help: help.to_owned() }
}

pub(super) fn unknown(text: &str, part: Part, name: &str, there: &BTreeSet<String>) -> Fault {
    let help = did_you_mean(name, there.iter().map(String::as_str));
    refused(text, format!("there is no {} \"{name}\" in the text", part.word()), &help)
}

/// What attaches to a vertex as `from` ("end" or "joint") attaches to it as `to`.
pub(super) fn each_attachment(table: &mut dyn TableLike, from: &str, vertex: &str, to: &str) {
    each_below(table, &mut Vec::new(), &mut |way, table| {
        // Their joints are those of mechanisms.
        let of_mechanism =
            way.first().is_some_and(|first| first == "mechanisms") || way.last().is_some_and(|last| last == "drive");
        if !of_mechanism && is(table, from, vertex) {
            table.remove(from);
            table.insert(to, toml_edit::value(vertex));
        }
    });
}
