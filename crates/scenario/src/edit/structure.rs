//! Changes to the parts of a scenario's text that keep the author's comments and layout: parts are renamed, deleted and
//! added, together with everything that refers to them, and branches are split.
//!
//! A change is made in the text alone. Whether the text is then a valid scenario, its checks say.

use super::key_path;
use super::record::{Attachment, document, entry_of, inline, name_of, number, of_json};
use crate::edit::adjust::quoted;
use crate::fault::{Fault, did_you_mean};
use crate::format::form::{Form, Keys};
use crate::format::{keys, units};
use std::collections::BTreeSet;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Key, Table, TableLike, Value};

/// A kind of parts that have names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A branch.
    Branch,
    /// A vertex: an end or a joint.
    Vertex,
    /// A section.
    Section,
    /// A constraint, whether it acts from the start or begins with a step.
    Constraint,
    /// An obstacle.
    Obstacle,
    /// A requirement.
    Requirement,
    /// A load.
    Load,
    /// A step.
    Step,
}

impl Part {
    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Part::Branch => "branch",
            Part::Vertex => "vertex",
            Part::Section => "section",
            Part::Constraint => "constraint",
            Part::Obstacle => "obstacle",
            Part::Requirement => "requirement",
            Part::Load => "load",
            Part::Step => "step",
        }
    }

    /// The list of its entries at the top level of a scenario.
    fn list(self) -> &'static str {
        match self {
            Part::Branch => "branches",
            Part::Vertex => "joints",
            Part::Section => "sections",
            Part::Constraint => "constraints",
            Part::Obstacle => "obstacles",
            Part::Requirement => "requirements",
            Part::Load => "loads",
            Part::Step => "steps",
        }
    }
}

/// A branch to be added.
#[derive(Clone, Debug, PartialEq)]
pub struct NewBranch {
    /// Its name.
    pub name: String,
    /// Where it begins: at a joint, a free end, a point of a branch (which is split there), or at a new vertex (`None`).
    pub from: Option<Attachment>,
    /// The vertex where it ends; new.
    pub to: String,
    /// Its section.
    pub section: String,
    /// Its length as the file shall have it.
    pub length: serde_json::Value,
}

/// Tables of the step operations that begin a constraint.
const BEGINNINGS: [&str; 4] = ["add", "grasp", "clip", "mate"];
/// Arc lengths nearer than this, relative to the branch, are the same.
const SAME: f64 = 1e-9;

/// The text as JSON, with every value as it is written.
///
/// # Errors
/// If the text is not TOML.
pub fn as_json(text: &str) -> Result<serde_json::Value, Fault> {
    // Its errors have places.
    document(text)?;
    toml::from_str(text).map_err(|error| refused(text, format!("this is not TOML: {}", error.message()), ""))
}

/// The text without a key, or without an entry of a list; `key` as in [`crate::settings`], without `*`.
///
/// # Errors
/// If the text is not TOML, or there is no such key.
pub fn without_key(text: &str, key: &str) -> Result<String, Fault> {
    let mut document = document(text)?;
    let end = text.len()..text.len();
    let parts = key_path::parts(key, 0).map_err(|fault| Fault { span: end.clone(), ..fault })?;
    if !remove_in(document.as_table_mut(), &parts) {
        return Err(refused(text, format!("`{key}` names no key"), "write the path to a key of the text"));
    }
    drop_empty_lists(&mut document);
    Ok(document.to_string())
}

/// The text with a further entry at the end of one of its lists, such as `obstacles`.
///
/// # Errors
/// If the text is not TOML, the list is none, or the entry is no table of values that TOML has.
pub fn with_entry(text: &str, list: &str, entry: &serde_json::Value) -> Result<String, Fault> {
    let mut document = document(text)?;
    let Some(Value::InlineTable(entry)) = of_json(entry) else {
        return Err(refused(text, format!("{entry} is no entry of `{list}`"), "give a table: names with values"));
    };
    append(text, &mut document, list, in_order(list, entry))?;
    Ok(document.to_string())
}

/// An entry with its keys in the order of their table; parameters of its kind follow the kind.
fn in_order(list: &str, entry: InlineTable) -> InlineTable {
    let keys = key_path::below(Some(&keys::SCENARIO), list).0;
    let kind = keys.and_then(Keys::kind).map(|(name, ..)| name);
    let place = |name: &str| {
        let own = |name: &str| keys.and_then(|keys| keys.keys.iter().position(|key| key.name == name));
        own(name).map_or((kind.and_then(own).unwrap_or(usize::MAX), true), |place| (place, false))
    };
    let mut all: Vec<(String, Value)> = entry.into_iter().map(|(key, value)| (key.to_string(), value)).collect();
    all.sort_by_key(|(name, _)| place(name));
    all.into_iter().collect()
}

/// The text in which a part has another name, everywhere where it is meant.
///
/// # Errors
/// If the text is not TOML, there is no such part, or the new name is taken or empty.
pub fn renamed(text: &str, part: Part, from: &str, to: &str) -> Result<String, Fault> {
    let mut document = document(text)?;
    let there = names(&document, part);
    if !there.contains(from) {
        return Err(unknown(text, part, from, &there));
    }
    if to.trim().is_empty() {
        return Err(refused(text, format!("a {} must have a name", part.word()), "type one that is not empty"));
    }
    if there.contains(to) {
        let message = format!("there is already a {} \"{to}\"", part.word());
        return Err(refused(text, message, "choose another name"));
    }
    rename(&mut document, part, from, to);
    Ok(document.to_string())
}

/// The text without a part, and without everything that is of no use without it: the constraints on a branch, the steps'
/// operations with a constraint. A joint that has one branch left becomes an end.
///
/// # Errors
/// If the text is not TOML, or there is no such part.
pub fn without_part(text: &str, part: Part, name: &str) -> Result<String, Fault> {
    let mut document = document(text)?;
    let there = names(&document, part);
    if !there.contains(name) {
        return Err(unknown(text, part, name, &there));
    }
    let constraints = names(&document, Part::Constraint);
    let mut emptied = BTreeSet::new();
    match part {
        Part::Branch => remove_branch(&mut document, name, &mut emptied),
        Part::Section => {
            if let Some(sections) = document.get_mut("sections").and_then(Item::as_table_like_mut) {
                sections.remove(name);
            }
        }
        Part::Vertex => retain(document.as_table_mut(), "joints", &mut |entry| !is(entry, "name", name)),
        Part::Constraint => {
            retain(document.as_table_mut(), "constraints", &mut |entry| !is(entry, "name", name));
            of_steps(&mut document, &BEGINNINGS, &mut emptied, &mut |entry| !is(entry, "name", name));
        }
        Part::Obstacle => {
            retain(document.as_table_mut(), "obstacles", &mut |entry| !is(entry, "name", name));
            of_steps(&mut document, &["move"], &mut emptied, &mut |entry| !is(entry, "obstacle", name));
            requirements(&mut document, &mut |of| !is(of, "obstacle", name));
        }
        Part::Requirement => retain(document.as_table_mut(), "requirements", &mut |entry| !is(entry, "name", name)),
        Part::Load => {
            retain(document.as_table_mut(), "loads", &mut |entry| !is(entry, "name", name));
            of_steps(&mut document, &["load"], &mut emptied, &mut |entry| !is(entry, "load", name));
        }
        Part::Step => retain(document.as_table_mut(), "steps", &mut |entry| !is(entry, "name", name)),
    }
    let gone: Vec<String> = constraints.difference(&names(&document, Part::Constraint)).cloned().collect();
    gone.iter().for_each(|name| forget_constraint(&mut document, name, &mut emptied));
    wait_in_empty_steps(&mut document, &emptied);
    drop_empty_lists(&mut document);
    Ok(document.to_string())
}

/// The text with a branch split at an arc length (m) into two that meet in a joint: the first part keeps its name. What
/// attaches beyond the joint follows the second part.
///
/// # Errors
/// If the text is not TOML, there is no such branch, the arc length is not inside it, a name is taken, or something
/// lies across the joint.
pub fn with_split(text: &str, branch: &str, s: f64, second: &str, joint: &str) -> Result<String, Fault> {
    let mut document = document(text)?;
    split(text, &mut document, branch, s, second, joint)?;
    Ok(document.to_string())
}

/// The text with a further branch.
///
/// # Errors
/// If the text is not TOML, a name is taken, or there is no such place.
pub fn with_branch(text: &str, new: &NewBranch) -> Result<String, Fault> {
    let mut document = document(text)?;
    let NewBranch { name, from, to, section, length } = new;
    let free = |names: &BTreeSet<String>, part: Part, name: &str| match names.contains(name) {
        true => Err(refused(text, format!("there is already a {} \"{name}\"", part.word()), "choose another name")),
        false => Ok(()),
    };
    free(&names(&document, Part::Branch), Part::Branch, name)?;
    free(&vertices(&document), Part::Vertex, to)?;
    let Some(length) = of_json(length) else {
        return Err(refused(text, format!("{length} is no length"), "give a number of metres, or such as \"200 mm\""));
    };
    let first = match from {
        None => unused(&vertices(&document), &format!("{name} start")),
        Some(Attachment::Joint(joint)) => {
            add_arm(text, &mut document, joint, name)?;
            joint.clone()
        }
        Some(Attachment::End(end)) => {
            end_becomes_joint(text, &mut document, end, name)?;
            end.clone()
        }
        Some(Attachment::Branch(branch, s)) => {
            let second = unused(&names(&document, Part::Branch), &format!("{branch} 2"));
            let joint = unused(&vertices(&document), &format!("{branch} joint"));
            split(text, &mut document, branch, *s, &second, &joint)?;
            add_arm(text, &mut document, &joint, name)?;
            joint
        }
    };
    let mut entry = inline([
        ("name", name.as_str().into()),
        ("from", first.as_str().into()),
        ("to", to.as_str().into()),
        ("section", section.as_str().into()),
        ("length", length),
    ]);
    if let Some(spacing) = spacing(&mut document) {
        entry.insert("max_segment", spacing);
    }
    append(text, &mut document, "branches", entry)?;
    Ok(document.to_string())
}

/// Words of the quantities that a requirement may limit.
pub fn required_quantities() -> &'static [&'static str] {
    let requirement = key_path::below(Some(&keys::SCENARIO), "requirements").0;
    match requirement.and_then(|keys| keys.get("quantity")).map(|key| key.form) {
        Some(Form::Choice(words)) => words,
        _ => &[],
    }
}

/// A name that none of the parts has: `wanted`, or with a number behind it.
///
/// # Errors
/// If the text is not TOML.
pub fn unused_name(text: &str, part: Part, wanted: &str) -> Result<String, Fault> {
    let document = document(text)?;
    let there = if part == Part::Vertex { vertices(&document) } else { names(&document, part) };
    Ok(unused(&there, wanted))
}

fn unused(there: &BTreeSet<String>, wanted: &str) -> String {
    let numbered = (2..).map(|k| format!("{wanted} {k}"));
    std::iter::once(wanted.to_owned()).chain(numbered).find(|name| !there.contains(name)).unwrap_or_default()
}

fn refused(text: &str, message: impl Into<String>, help: &str) -> Fault {
    Fault { span: text.len()..text.len(), message: message.into(), help: help.to_owned() }
}

fn unknown(text: &str, part: Part, name: &str, there: &BTreeSet<String>) -> Fault {
    let help = did_you_mean(name, there.iter().map(String::as_str));
    refused(text, format!("there is no {} \"{name}\" in the text", part.word()), &help)
}

// ---- the document -------------------------------------------------------------------------------------------------

/// The entries of a list, or the one table that stands for it.
fn entries(item: &mut Item) -> Vec<&mut dyn TableLike> {
    match item {
        Item::ArrayOfTables(tables) => tables.iter_mut().map(|table| table as &mut dyn TableLike).collect(),
        Item::Value(Value::Array(list)) => {
            list.iter_mut().filter_map(|value| Some(value.as_inline_table_mut()? as &mut dyn TableLike)).collect()
        }
        other => other.as_table_like_mut().into_iter().collect(),
    }
}

fn list<'d>(table: &'d mut dyn TableLike, key: &str) -> Vec<&'d mut dyn TableLike> {
    table.get_mut(key).map_or(Vec::new(), entries)
}

/// Keeps some of the entries of a list, or the one table that stands for it.
fn retain(table: &mut dyn TableLike, key: &str, keep: &mut dyn FnMut(&dyn TableLike) -> bool) {
    let gone = match table.get_mut(key) {
        Some(Item::ArrayOfTables(tables)) => {
            tables.retain(|own| keep(own));
            false
        }
        Some(Item::Value(Value::Array(list))) => {
            list.retain(|value| value.as_inline_table().is_none_or(|own| keep(own)));
            false
        }
        Some(item) => item.as_table_like().is_some_and(|own| !keep(own)),
        None => false,
    };
    if gone {
        table.remove(key);
    }
}

fn word<'t>(table: &'t dyn TableLike, key: &str) -> Option<&'t str> {
    table.get(key)?.as_str()
}

fn is(table: &dyn TableLike, key: &str, name: &str) -> bool {
    word(table, key) == Some(name)
}

/// Replaces a value, and keeps what stands beside it.
fn put(item: &mut Item, value: Value) {
    match item {
        Item::Value(old) => {
            let decor = old.decor().clone();
            *old = value;
            *old.decor_mut() = decor;
        }
        other => *other = Item::Value(value),
    }
}

/// Removes what is at a path within a table. Returns whether it was there.
fn remove_in(table: &mut dyn TableLike, parts: &[key_path::Part]) -> bool {
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
fn index_of(item: &Item, name: &str) -> Option<usize> {
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
fn append(text: &str, document: &mut DocumentMut, key: &str, entry: InlineTable) -> Result<(), Fault> {
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

fn has_line_feed(text: Option<&str>) -> bool {
    text.is_some_and(|text| text.contains('\n'))
}

/// Removes lists that have lost their last entry.
fn drop_empty_lists(document: &mut DocumentMut) {
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
fn names(document: &DocumentMut, part: Part) -> BTreeSet<String> {
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

fn vertices(document: &DocumentMut) -> BTreeSet<String> {
    let mut document = document.clone();
    let branches = list(document.as_table_mut(), "branches");
    let ends = branches.iter().flat_map(|own| [word(*own, "from"), word(*own, "to")]);
    ends.flatten().map(str::to_owned).collect()
}

/// Visits every table of an item, with the keys that lead to it.
fn each_table(item: &mut Item, way: &mut Vec<String>, act: &mut dyn FnMut(&[String], &mut dyn TableLike)) {
    for table in entries(item) {
        each_below(table, way, act);
    }
}

/// Visits a table, and every table within it.
fn each_below(table: &mut dyn TableLike, way: &mut Vec<String>, act: &mut dyn FnMut(&[String], &mut dyn TableLike)) {
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

// ---- renaming -----------------------------------------------------------------------------------------------------

fn rename(document: &mut DocumentMut, part: Part, from: &str, to: &str) {
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
                || (key == "branches" && way.len() > 1)
                || (way == ["joints", "wires"] && key == "between")
        }
        Part::Vertex => {
            named
                || (way == ["branches"] && matches!(key, "from" | "to"))
                || key == "end"
                || (key == "joint" && way != ["steps", "drive"] && first != "mechanisms")
        }
        Part::Section => way == ["branches"] && key == "section",
        Part::Constraint => {
            named
                || (begins && key == "name")
                || key == "constraint"
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

// ---- deleting -----------------------------------------------------------------------------------------------------

/// Keeps some of the operations of all steps; notes the steps that have lost one.
fn of_steps(
    document: &mut DocumentMut,
    operations: &[&str],
    emptied: &mut BTreeSet<usize>,
    keep: &mut dyn FnMut(&dyn TableLike) -> bool,
) {
    for (k, step) in list(document.as_table_mut(), "steps").into_iter().enumerate() {
        for operation in operations {
            let before = list(step, operation).len();
            retain(step, operation, keep);
            let after = list(step, operation).len();
            if after < before {
                emptied.insert(k);
            }
            if after == 0 {
                step.remove(operation);
            }
        }
    }
}

/// Keeps the requirements whose parts are kept.
fn requirements(document: &mut DocumentMut, keep: &mut dyn FnMut(&dyn TableLike) -> bool) {
    retain(document.as_table_mut(), "requirements", &mut |entry| {
        ["of", "between"].iter().all(|key| match entry.get(key) {
            Some(Item::Value(Value::Array(list))) => list.iter().filter_map(Value::as_inline_table).all(|of| keep(of)),
            Some(Item::ArrayOfTables(tables)) => tables.iter().all(|of| keep(of)),
            Some(item) => item.as_table_like().is_none_or(&mut *keep),
            None => true,
        })
    });
}

/// Removes what steps and requirements say of a constraint that there is no more.
fn forget_constraint(document: &mut DocumentMut, name: &str, emptied: &mut BTreeSet<usize>) {
    requirements(document, &mut |of| !is(of, "constraint", name));
    of_steps(document, &["move", "mate"], emptied, &mut |entry| !is(entry, "constraint", name));
    for (k, step) in list(document.as_table_mut(), "steps").into_iter().enumerate() {
        for carry in list(step, "carry") {
            retain(carry, "timing", &mut |timing| !is(timing, "what", name));
            if let Some(what) = carry.get_mut("what").and_then(Item::as_array_mut) {
                what.retain(|value| value.as_str() != Some(name));
            }
        }
        let count = list(step, "carry").len();
        retain(step, "carry", &mut |carry| {
            carry.get("what").and_then(Item::as_array).is_none_or(|what| !what.is_empty())
        });
        let left = list(step, "carry").len();
        if left == 0 {
            step.remove("carry");
        }
        let mut released = false;
        if let Some(release) = step.get_mut("release").and_then(Item::as_array_mut) {
            let before = release.len();
            release.retain(|value| value.as_str() != Some(name));
            released = release.len() < before;
            if release.is_empty() {
                step.remove("release");
            }
        }
        if released || left < count {
            emptied.insert(k);
        }
    }
}

/// A step that has lost all that it did waits.
fn wait_in_empty_steps(document: &mut DocumentMut, emptied: &BTreeSet<usize>) {
    for (k, step) in list(document.as_table_mut(), "steps").into_iter().enumerate() {
        let nothing = step.iter().all(|(key, _)| matches!(key, "name" | "increments"));
        if emptied.contains(&k) && nothing {
            step.insert("wait", toml_edit::value(true));
        }
    }
}

/// Removes a branch, its arms at its joints, and what attaches to it.
fn remove_branch(document: &mut DocumentMut, name: &str, emptied: &mut BTreeSet<usize>) {
    let root = document.as_table_mut();
    let mut ends: Vec<String> = Vec::new();
    for branch in list(root, "branches") {
        if is(branch, "name", name) {
            ends.extend([word(branch, "from"), word(branch, "to")].into_iter().flatten().map(str::to_owned));
        }
    }
    retain(root, "branches", &mut |entry| !is(entry, "name", name));
    let mut lost: Vec<String> = Vec::new();
    for vertex in &ends {
        let touches = |own: &&mut dyn TableLike| is(*own, "from", vertex) || is(*own, "to", vertex);
        let root = document.as_table_mut();
        let left = list(root, "branches").iter().filter(|own| touches(own)).count();
        match left {
            0 => lost.push(vertex.clone()),
            1 => {
                retain(root, "joints", &mut |entry| !is(entry, "name", vertex));
                each_attachment(root, "joint", vertex, "end");
            }
            _ => {
                for joint in list(root, "joints").into_iter().filter(|joint| is(*joint, "name", vertex)) {
                    retain(joint, "arms", &mut |arm| !is(arm, "branch", name));
                    retain(joint, "wires", &mut |wires| {
                        let between = wires.get("between").and_then(Item::as_array);
                        between.is_none_or(|list| list.iter().all(|value| value.as_str() != Some(name)))
                    });
                    if list(joint, "wires").is_empty() {
                        joint.remove("wires");
                    }
                }
            }
        }
        if lost.contains(vertex) {
            retain(root, "joints", &mut |entry| !is(entry, "name", vertex));
        }
    }
    let stays = |place: &dyn TableLike| {
        !is(place, "branch", name)
            && ["end", "joint"].iter().all(|key| word(place, key).is_none_or(|own| lost.iter().all(|v| v != own)))
    };
    let mut keep = |entry: &dyn TableLike| {
        ["at", "span"].iter().all(|key| match entry.get(key) {
            Some(Item::Value(Value::Array(list))) => {
                list.iter().filter_map(Value::as_inline_table).all(|own| stays(own))
            }
            Some(Item::ArrayOfTables(tables)) => tables.iter().all(|own| stays(own)),
            Some(item) => item.as_table_like().is_none_or(stays),
            None => true,
        })
    };
    for key in ["constraints", "loads", "markers"] {
        retain(document.as_table_mut(), key, &mut keep);
    }
    of_steps(document, &BEGINNINGS, emptied, &mut keep);
    requirements(document, &mut |of| !is(of, "branch", name));
    retain(document.as_table_mut(), "initial", &mut |initial| !is(initial, "branch", name));
    for step in list(document.as_table_mut(), "steps") {
        for own in list(step, "temperature") {
            if let Some(branches) = own.get_mut("branches").and_then(Item::as_array_mut) {
                branches.retain(|value| value.as_str() != Some(name));
            }
        }
    }
}

/// What attaches to a vertex as `from` ("end" or "joint") attaches to it as `to`.
fn each_attachment(table: &mut dyn TableLike, from: &str, vertex: &str, to: &str) {
    each_below(table, &mut Vec::new(), &mut |way, table| {
        let drives = way.iter().map(String::as_str).eq(["steps", "drive"]);
        if !drives && is(table, from, vertex) {
            table.remove(from);
            table.insert(to, toml_edit::value(vertex));
        }
    });
}

// ---- splitting and adding branches --------------------------------------------------------------------------------

/// A length as it is written, m.
fn metres(item: Option<&Item>) -> Option<f64> {
    let value = item?.as_value()?;
    let plain = value.as_float().or_else(|| Some(value.as_integer()? as f64));
    plain.or_else(|| units::any(value.as_str()?).ok().map(|(metres, _)| metres))
}

/// A length in the unit of another one, rounded to a part in 10⁹ of a metre.
fn length_like(other: Option<&Item>, metres: f64) -> Value {
    let rounded = |x: f64, part: f64| (x * part).round() / part;
    let unit = other.and_then(Item::as_str).map(|word| word.trim_start_matches(|c: char| !c.is_alphabetic()).trim());
    match unit.and_then(|unit| Some((unit, units::any(&format!("1 {unit}")).ok()?.0))) {
        Some((unit, factor)) => Value::from(format!("{} {unit}", rounded(metres / factor, 1e9 * factor))),
        None => number(rounded(metres, 1e9)),
    }
}

fn split(text: &str, document: &mut DocumentMut, branch: &str, s: f64, second: &str, joint: &str) -> Result<(), Fault> {
    let there = names(document, Part::Branch);
    if !there.contains(branch) {
        return Err(unknown(text, Part::Branch, branch, &there));
    }
    for (taken, word, name) in
        [(there.contains(second), "branch", second), (vertices(document).contains(joint), "vertex", joint)]
    {
        if taken {
            return Err(refused(text, format!("there is already a {word} \"{name}\""), "choose another name"));
        }
    }
    for key in ["sweep", "optimise"] {
        if document.get(key).is_some_and(|item| item.to_string().contains(&format!("branches.{}", quoted(branch)))) {
            let message = format!("[{key}] varies branch \"{branch}\", which is to become two");
            return Err(refused(text, message, "remove its keys there, split it, and add the keys of both parts"));
        }
    }
    refuse_across(text, document, branch, s)?;
    let mut own = list(document.as_table_mut(), "branches");
    let entry = own.iter_mut().find(|own| is(**own, "name", branch)).ok_or_else(|| refused(text, "no branch", ""))?;
    let length = metres(entry.get("length")).ok_or_else(|| {
        let message = format!("the length of branch \"{branch}\" is not given as a number");
        refused(text, message, "write it in the file, such as length = \"600 mm\"")
    })?;
    if !(s > SAME * length && s < length * (1.0 - SAME)) {
        let message = format!("branch \"{branch}\" cannot be split at s = {s} m");
        return Err(refused(text, message, &format!("give a place inside it, between 0 and {length} m")));
    }
    let to = word(&**entry, "to").unwrap_or_default().to_owned();
    if is(&**entry, "from", &to) {
        let message = format!("branch \"{branch}\" begins and ends at \"{to}\"");
        return Err(refused(text, message, "name its ends differently first"));
    }
    // The second part: what the first has, with other ends.
    let mut other = InlineTable::new();
    for (key, item) in entry.iter() {
        if let Some(value) = item.as_value() {
            let mut value = value.clone();
            value.decor_mut().clear();
            other.insert(key, value);
        }
    }
    let set = |table: &mut dyn TableLike, key: &str, value: Value| match table.get_mut(key) {
        Some(item) => put(item, value),
        None => {
            table.insert(key, Item::Value(value));
        }
    };
    set(&mut other, "name", second.into());
    set(&mut other, "from", joint.into());
    let whole = entry.get("length").cloned();
    set(&mut other, "length", length_like(whole.as_ref(), length - s));
    set(*entry, "length", length_like(whole.as_ref(), s));
    set(*entry, "to", joint.into());
    if let Some(count) = entry.get("segments").and_then(Item::as_integer) {
        let first = ((count as f64 * s / length).round() as i64).clamp(1, (count - 1).max(1));
        set(*entry, "segments", first.into());
        set(&mut other, "segments", (count - first).max(1).into());
    }
    if let Some(points) = entry.get("path").and_then(Item::as_array) {
        let [before, behind] = split_path(points, s / length).ok_or_else(|| {
            let message = format!("the path of branch \"{branch}\" is not a list of points");
            refused(text, message, "write its points as [[x, y, z], …]")
        })?;
        set(*entry, "path", Value::Array(before));
        set(&mut other, "path", Value::Array(behind));
    }
    insert_behind(text, document, branch, other)?;
    // The joint at the far end has the second part as its arm.
    for own in list(document.as_table_mut(), "joints").into_iter().filter(|own| is(*own, "name", &to)) {
        for arm in list(own, "arms").into_iter().filter(|arm| is(*arm, "branch", branch)) {
            set(arm, "branch", second.into());
        }
        for wires in list(own, "wires") {
            if let Some(between) = wires.get_mut("between").and_then(Item::as_array_mut) {
                between
                    .iter_mut()
                    .filter(|value| value.as_str() == Some(branch))
                    .for_each(|value| *value = second.into());
            }
        }
    }
    let arm = |branch: &str, x: f64| {
        Value::InlineTable(inline([
            ("branch", branch.into()),
            ("direction", [x, 0.0, 0.0].into_iter().map(number).collect::<Array>().into()),
            ("up", [0.0, 0.0, 1.0].into_iter().map(number).collect::<Array>().into()),
        ]))
    };
    let arms: Array = [arm(branch, -1.0), arm(second, 1.0)].into_iter().collect();
    append(text, document, "joints", inline([("name", joint.into()), ("arms", on_lines(arms).into())]))?;
    move_behind(document, branch, s, length, second, joint);
    Ok(())
}

/// One line for every entry.
fn on_lines(mut list: Array) -> Array {
    list.iter_mut().for_each(|value| value.decor_mut().set_prefix("\n  "));
    list.set_trailing_comma(true);
    list.set_trailing("\n");
    list
}

/// A branch of the document directly behind another one.
fn insert_behind(text: &str, document: &mut DocumentMut, branch: &str, entry: InlineTable) -> Result<(), Fault> {
    match document.get_mut("branches") {
        Some(Item::ArrayOfTables(tables)) => {
            let at = tables.iter().position(|own| is(own, "name", branch)).map_or(tables.len(), |k| k + 1);
            let mut table = entry.into_table();
            table.decor_mut().set_prefix("\n");
            let mut all: Vec<Table> = std::mem::take(tables).into_iter().collect();
            let position = all.get(at - 1).and_then(Table::position);
            table.set_position(position);
            all.insert(at, table);
            *tables = all.into_iter().collect();
            Ok(())
        }
        Some(Item::Value(Value::Array(list))) => {
            let at = list.iter().position(|own| own.as_inline_table().is_some_and(|own| is(own, "name", branch)));
            let at = at.map_or(list.len(), |k| k + 1);
            let decor = list.get(at.saturating_sub(1)).map(|value| value.decor().clone());
            list.insert(at, entry);
            if let (Some(value), Some(decor)) = (list.get_mut(at), decor) {
                *value.decor_mut() = decor;
            }
            Ok(())
        }
        _ => append(text, document, "branches", entry),
    }
}

/// A drawn line divided at a fraction of its length.
fn split_path(points: &Array, at: f64) -> Option<[Array; 2]> {
    let point = |value: &Value| -> Option<[f64; 3]> {
        let of = |k: usize| metres(Some(&Item::Value(value.as_array()?.get(k)?.clone())));
        Some([of(0)?, of(1)?, of(2)?])
    };
    let all: Vec<[f64; 3]> = points.iter().map(point).collect::<Option<_>>()?;
    let distance = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    let lengths: Vec<f64> = all.windows(2).map(|pair| distance(&pair[0], &pair[1])).collect();
    let mut left = at * lengths.iter().sum::<f64>();
    let k = lengths.iter().position(|length| {
        let here = left <= *length;
        if !here {
            left -= length;
        }
        here
    })?;
    let share = if lengths[k] > 0.0 { left / lengths[k] } else { 0.0 };
    let middle = [0, 1, 2].map(|i| all[k][i] + share * (all[k + 1][i] - all[k][i]));
    let value = |p: &[f64; 3]| Value::Array(p.iter().map(|x| number((x * 1e9).round() / 1e9)).collect());
    let before = all[..=k].iter().chain([&middle]).map(value).collect();
    let behind = [&middle].into_iter().chain(&all[k + 1..]).map(value).collect();
    Some([before, behind])
}

/// Refuses what acts along a stretch with the split inside it.
fn refuse_across(text: &str, document: &mut DocumentMut, branch: &str, s: f64) -> Result<(), Fault> {
    let mut across = None;
    each_table(document.as_item_mut(), &mut Vec::new(), &mut |way, table| {
        if way.last().is_some_and(|key| key == "span") && is(table, "branch", branch) {
            let from = metres(table.get("from")).unwrap_or(0.0);
            let to = metres(table.get("to")).unwrap_or(f64::INFINITY);
            if from < s && s < to {
                across = Some(way.first().cloned().unwrap_or_default());
            }
        }
    });
    match across {
        Some(list) => {
            let message = format!("an entry of `{list}` acts along a span of branch \"{branch}\" across s = {s} m");
            Err(refused(text, message, "end its span there first, or split the branch at another place"))
        }
        None => Ok(()),
    }
}

/// What attaches to a branch beyond an arc length attaches to its second part; what is exactly there to the joint.
fn move_behind(document: &mut DocumentMut, branch: &str, s: f64, length: f64, second: &str, joint: &str) {
    each_table(document.as_item_mut(), &mut Vec::new(), &mut |way, table| {
        if !is(table, "branch", branch) {
            return;
        }
        let shift = |table: &mut dyn TableLike, key: &str| {
            if let Some(own) = metres(table.get(key)) {
                let value = length_like(table.get(key), own - s);
                if let Some(item) = table.get_mut(key) {
                    put(item, value);
                }
            }
        };
        let name = |table: &mut dyn TableLike| {
            if let Some(item) = table.get_mut("branch") {
                put(item, second.into());
            }
        };
        match (way.last().map(String::as_str), metres(table.get("s"))) {
            (Some("at"), Some(own)) if (own - s).abs() <= SAME * length => {
                table.remove("branch");
                table.remove("s");
                table.insert("joint", toml_edit::value(joint));
            }
            (Some("at"), Some(own)) if own > s => {
                name(table);
                shift(table, "s");
            }
            (Some("span" | "of" | "between"), _) if metres(table.get("from")).is_some_and(|from| from >= s) => {
                name(table);
                shift(table, "from");
                shift(table, "to");
            }
            _ => {}
        }
    });
    // A requirement on the whole branch, or on a part of it across the joint, counts on both parts.
    let root = document.as_table_mut();
    let mut further = Vec::new();
    for own in list(root, "requirements") {
        let name = word(own, "name").unwrap_or_default().to_owned();
        let mut copy = InlineTable::new();
        for (key, item) in own.iter() {
            if let Some(mut value) = item.as_value().cloned() {
                value.decor_mut().clear();
                copy.insert(key, value);
            }
        }
        let Some(of) = own.get_mut("of").and_then(Item::as_table_like_mut).filter(|of| is(*of, "branch", branch))
        else {
            continue;
        };
        let to = metres(of.get("to"));
        if to.is_some_and(|to| to <= s) {
            continue;
        }
        of.remove("to");
        copy.insert("name", format!("{name} ({second})").into());
        if let Some(of) = copy.get_mut("of").and_then(Value::as_inline_table_mut) {
            let rest = to.map(|to| length_like(of.get("to").map(|value| Item::Value(value.clone())).as_ref(), to - s));
            of.insert("branch", second.into());
            of.remove("from");
            of.remove("to");
            if let Some(rest) = rest {
                of.insert("to", rest);
            }
            further.push(copy);
        }
    }
    if let Some(item) = root.get_mut("requirements") {
        for copy in further {
            match item {
                Item::ArrayOfTables(tables) => {
                    let mut table = copy.into_table();
                    table.decor_mut().set_prefix("\n");
                    tables.push(table);
                }
                Item::Value(Value::Array(list)) => list.push(copy),
                _ => {}
            }
        }
    }
    for step in list(root, "steps") {
        for own in list(step, "temperature") {
            if let Some(branches) = own.get_mut("branches").and_then(Item::as_array_mut)
                && branches.iter().any(|value| value.as_str() == Some(branch))
            {
                branches.push(second);
            }
        }
    }
}

/// Adds an arm for a new branch to a joint, pointing away from the others.
fn add_arm(text: &str, document: &mut DocumentMut, joint: &str, branch: &str) -> Result<(), Fault> {
    let joints = list(document.as_table_mut(), "joints");
    let there: BTreeSet<String> = joints.iter().filter_map(|own| Some(word(*own, "name")?.to_owned())).collect();
    let own = joints.into_iter().find(|own| is(*own, "name", joint));
    let own = own.ok_or_else(|| {
        let help = did_you_mean(joint, there.iter().map(String::as_str));
        refused(text, format!("there is no joint \"{joint}\" in the text"), &help)
    })?;
    let vector = |item: Option<&Item>| -> Option<[f64; 3]> {
        let list = item?.as_array()?;
        let of = |k: usize| list.get(k).and_then(|x| x.as_float().or_else(|| Some(x.as_integer()? as f64)));
        Some([of(0)?, of(1)?, of(2)?])
    };
    let directions: Vec<[f64; 3]> =
        list(own, "arms").iter().filter_map(|arm| unit(vector(arm.get("direction"))?)).collect();
    let sum = directions.iter().fold([0.0; 3], |sum, d| [0, 1, 2].map(|i| sum[i] + d[i]));
    // Opposite to the others; across the first one, where they balance.
    let away = unit(sum.map(|x| -x)).filter(|_| sum.iter().map(|x| x * x).sum::<f64>() > 0.01);
    let direction = away.or_else(|| directions.first().map(|first| across(*first))).unwrap_or([1.0, 0.0, 0.0]);
    let up = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
    let flat = |up: &[f64; 3]| up.iter().zip(direction).map(|(a, b)| a * b).sum::<f64>().abs() < 0.9;
    let up = up.into_iter().find(flat).unwrap_or([0.0, 0.0, 1.0]);
    let list_of = |v: [f64; 3]| Value::Array(v.iter().map(|x| number((x * 1e6).round() / 1e6 + 0.0)).collect());
    let arm = inline([("branch", branch.into()), ("direction", list_of(direction)), ("up", list_of(up))]);
    match own.get_mut("arms") {
        Some(Item::Value(Value::Array(arms))) => {
            let decor = arms.iter().last().map(|value| value.decor().clone());
            arms.push(arm);
            if let (Some(decor), Some(value)) = (decor, arms.iter_mut().last()) {
                *value.decor_mut() = decor;
            }
        }
        Some(Item::ArrayOfTables(tables)) => tables.push(arm.into_table()),
        _ => return Err(refused(text, format!("joint \"{joint}\" has no list of arms"), "write arms = [ … ]")),
    }
    Ok(())
}

/// A unit vector; `None` of one that is zero.
fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    (norm > 0.0).then(|| v.map(|x| x / norm))
}

/// A direction across another one, in the plane of x and y if it can be.
fn across([x, y, _]: [f64; 3]) -> [f64; 3] {
    unit([-y, x, 0.0]).unwrap_or([1.0, 0.0, 0.0])
}

/// A free end becomes a joint: a new branch continues the one that ends there.
fn end_becomes_joint(text: &str, document: &mut DocumentMut, end: &str, branch: &str) -> Result<(), Fault> {
    let mut copy = document.clone();
    let branches = list(copy.as_table_mut(), "branches");
    let there: Vec<&str> = branches
        .iter()
        .filter(|own| is(**own, "from", end) || is(**own, "to", end))
        .filter_map(|own| word(*own, "name"))
        .collect();
    let [other] = there.as_slice() else {
        let message = format!("\"{end}\" is no free end: {} branches end there", there.len());
        return Err(refused(text, message, "name a vertex with one branch"));
    };
    let arm = |branch: &str, x: i64| {
        let list = |v: [i64; 3]| Value::Array(v.into_iter().collect());
        let entries = [("branch", branch.into()), ("direction", list([x, 0, 0])), ("up", list([0, 0, 1]))];
        Value::InlineTable(inline(entries))
    };
    let arms: Array = [arm(other, -1), arm(branch, 1)].into_iter().collect();
    append(text, document, "joints", inline([("name", end.into()), ("arms", on_lines(arms).into())]))?;
    each_attachment(document.as_table_mut(), "end", end, "joint");
    Ok(())
}

/// The longest segment that a new branch may have: as fine as the finest branch; none where [mesh] decides.
fn spacing(document: &mut DocumentMut) -> Option<Value> {
    let of = |own: &dyn TableLike| {
        let length = metres(own.get("length"))?;
        let counted = own.get("segments").and_then(Item::as_integer).map(|count| length / count.max(1) as f64);
        counted.or_else(|| metres(own.get("max_segment")))
    };
    if document.get("mesh").and_then(Item::as_table_like).is_some_and(|mesh| mesh.contains_key("accuracy")) {
        return None;
    }
    let finest = list(document.as_table_mut(), "branches").iter().filter_map(|own| of(*own)).reduce(f64::min);
    Some(Value::from(format!("{} mm", (finest.unwrap_or(0.01) * 1e6).round() / 1e3)))
}

#[cfg(test)]
mod tests;
