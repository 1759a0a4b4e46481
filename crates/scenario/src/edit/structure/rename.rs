//! Names of parts, wherever they are meant.

use super::entries::each_table;
use super::part::{BEGINNINGS, Part};
use crate::edit::adjust::quoted;
use crate::edit::key_path;
use toml_edit::{DocumentMut, Item, Key, TableLike, Value};

pub(super) fn rename(document: &mut DocumentMut, part: Part, from: &str, to: &str) {
    each_table(document.as_item_mut(), &mut Vec::new(), &mut |way, table| {
        let way: Vec<&str> = way.iter().map(String::as_str).collect();
        let own = |key: &str| refers(&way, part, key);
        let keys: Vec<String> = table.iter().map(|(key, _)| key.to_owned()).filter(|key| own(key)).collect();
        for key in keys {
            match table.get_mut(&key) {
                Some(Item::Value(Value::String(word))) if word.value() == from => {
                    let decor = word.decor().clone();
                    *word = toml_edit::Formatted::new(to.to_owned());
                    *word.decor_mut() = decor;
                }
                Some(Item::Value(Value::Array(list))) => {
                    for value in list.iter_mut().filter(|value| value.as_str() == Some(from)) {
                        let decor = value.decor().clone();
                        *value = Value::from(to);
                        *value.decor_mut() = decor;
                    }
                }
                _ => {}
            }
        }
    });
    if part == Part::Section
        && let Some(sections) = document.get_mut("sections").and_then(Item::as_table_mut)
        && let Some((key, item)) = sections.remove_entry(from)
    {
        let new = Key::new(to).with_leaf_decor(key.leaf_decor().clone()).with_dotted_decor(key.dotted_decor().clone());
        sections.insert_formatted(&new, item);
    }
    for key in ["sweep", "optimise"] {
        if let Some(item) = document.get_mut(key) {
            each_table(item, &mut Vec::new(), &mut |_, table| rename_paths(table, part, from, to));
        }
    }
}

/// Whether a key of an entry holds names of such parts; `way`: the keys that lead to the entry.
fn refers(way: &[&str], part: Part, key: &str) -> bool {
    let first = way.first().copied().unwrap_or_default();
    let begins = matches!(way, ["steps", operation] if BEGINNINGS.contains(operation));
    let named = way == [part.list()] && key == "name";
    match part {
        Part::Branch => {
            named
                || key == "branch"
                || (key == "branches" && !way.is_empty())
                || (way == ["joints", "wires"] && key == "between")
        }
        Part::Vertex => {
            named
                || (way == ["branches"] && matches!(key, "from" | "to"))
                || key == "end"
                || (way == ["components"] && key == "vertex")
                || (key == "joint" && way != ["steps", "drive"] && first != "mechanisms")
        }
        Part::Section => matches!(way, ["branches"] | ["branches", "sections"]) && key == "section",
        Part::Constraint => {
            named
                || (begins && key == "name")
                || key == "constraint"
                || (matches!(way, ["components"] | ["connections", "ends"]) && key == "connector")
                || (key == "constraints" && way.len() > 1)
                || (way == ["steps"] && key == "release")
                || (way.starts_with(&["steps", "carry"]) && key == "what")
        }
        Part::Obstacle => named || key == "obstacle" || (key == "obstacles" && way.len() > 1),
        Part::Requirement => named || (first == "optimise" && key == "name"),
        Part::Load => named || key == "load",
        Part::Step => named || (way == ["requirements"] && key == "steps") || (first == "sweep" && key == "step"),
    }
}

/// Renames the part in the paths of keys, which are keys or words of this table.
fn rename_paths(table: &mut dyn TableLike, part: Part, from: &str, to: &str) {
    let path = |key: &str| {
        let parts = key_path::parts(key, 0).ok()?;
        let meant = parts.len() > 2 && parts[0].name == part.list() && parts[1].name == from;
        meant.then(|| format!("{}{}{}", &key[..parts[1].span.start], quoted(to), &key[parts[1].span.end..]))
    };
    let keys: Vec<String> = table.iter().map(|(key, _)| key.to_owned()).collect();
    for key in keys {
        if let Some(Item::Value(Value::String(word))) = table.get_mut(&key)
            && let Some(new) = path(word.value())
        {
            let decor = word.decor().clone();
            *word = toml_edit::Formatted::new(new);
            *word.decor_mut() = decor;
        }
        if let Some(new) = path(&key)
            && let Some(item) = table.remove(&key)
        {
            table.insert(&new, item);
        }
    }
}
