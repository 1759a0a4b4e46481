//! Changes to the parts of a scenario's text that keep the author's comments and layout: parts are renamed, deleted and
//! added, together with everything that refers to them, and branches are split.
//!
//! A change is made in the text alone. Whether the text is then a valid scenario, its checks say.

mod branches;
mod delete;
pub(super) mod entries;
mod lengths;
mod part;
mod pose;
mod rename;
mod split;
#[cfg(test)]
mod tests;

use super::key_path;
use super::record::{Attachment, document, inline, of_json};
use crate::fault::Fault;
use crate::format::form::{Form, Keys};
use crate::format::keys;
use branches::{add_arm, end_becomes_joint, spacing};
use delete::{forget_connectors, forget_constraint, of_steps, remove_branch, requirements, wait_in_empty_steps};
use entries::{append, drop_empty_lists, is, list, names, refused, remove_in, retain, unknown, unused, vertices, word};
use part::BEGINNINGS;
pub use part::Part;
use rename::rename;
use split::split;
use std::collections::BTreeSet;
use toml_edit::{DocumentMut, InlineTable, Item, Value};
use wildmatch::WildMatch;
use wireloom_core::{Rotation, Vector};

/// A branch to be added.
#[derive(Clone, Debug, PartialEq)]
pub struct NewBranch {
    /// Its name.
    pub name: String,
    /// Where it begins: at a joint, a free end, or a point of a branch, which is split there.
    pub from: Attachment,
    /// The vertex where it ends; new.
    pub to: String,
    /// Its section.
    pub section: String,
    /// Its length as the file shall have it.
    pub length: serde_json::Value,
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

/// The text in which an obstacle has another position (m), another orientation, or both.
///
/// # Errors
/// If the text is not TOML, or has no such obstacle.
pub fn with_pose(
    text: &str,
    obstacle: &str,
    position: Option<&Vector>,
    orientation: Option<&Rotation>,
) -> Result<String, Fault> {
    let mut document = document(text)?;
    let there = names(&document, Part::Obstacle);
    let mut own = list(document.as_table_mut(), "obstacles");
    let Some(entry) = own.iter_mut().find(|own| is(**own, "name", obstacle)) else {
        return Err(unknown(text, Part::Obstacle, obstacle, &there));
    };
    if let Some(position) = position {
        pose::set_position(*entry, position);
    }
    if let Some(orientation) = orientation {
        pose::set_orientation(*entry, orientation);
    }
    Ok(document.to_string())
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
    refuse_patterns(text, &mut document, part, from, to)?;
    rename(&mut document, part, from, to);
    Ok(document.to_string())
}

/// Refuses a new name by which a pattern of a requirement would have one part more or less: a failed one could pass.
fn refuse_patterns(text: &str, document: &mut DocumentMut, part: Part, from: &str, to: &str) -> Result<(), Fault> {
    for own in list(document.as_table_mut(), "requirements") {
        let name = word(own, "name").unwrap_or_default().to_owned();
        for key in ["of", "between"] {
            for place in list(own, key) {
                let pattern = word(place, part.list()).filter(|pattern| *pattern != from);
                let fits = |name: &str| pattern.is_some_and(|pattern| WildMatch::new(pattern).matches(name));
                if fits(from) != fits(to) {
                    let pattern = pattern.unwrap_or_default();
                    let (one, other) = if fits(from) { (from, to) } else { (to, from) };
                    let message = format!(
                        "requirement \"{name}\" is about {} like \"{pattern}\": \"{one}\", and not \"{other}\"",
                        part.list()
                    );
                    return Err(refused(text, message, "choose another name, or name them one by one there first"));
                }
            }
        }
    }
    Ok(())
}

/// The text without a part, and without everything that is of no use without it: the constraints on a branch, the
/// operations of steps with a constraint. A joint that has one branch left becomes an end.
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
    // Constraints and components.
    let mut gone = BTreeSet::new();
    match part {
        Part::Branch => gone = remove_branch(&mut document, name, &mut emptied),
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
    for name in constraints.difference(&names(&document, Part::Constraint)) {
        forget_constraint(&mut document, name, &mut emptied);
        gone.insert(name.clone());
    }
    forget_connectors(&mut document, gone);
    wait_in_empty_steps(&mut document, &emptied);
    drop_empty_lists(&mut document);
    Ok(document.to_string())
}

/// The text with a branch split at an arc length (m) into two that meet in a joint: the first part keeps its name and
/// its part number. What attaches beyond the joint follows the second part; requirements and components on both parts
/// become two.
///
/// # Errors
/// If the text is not TOML, there is no such branch, the arc length is not inside it, a name is taken, or something
/// would mean something else with two branches: a span across the joint, a requirement on the branch as a whole, a key
/// that a sweep or an optimisation varies.
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
        Attachment::Joint(joint) => {
            add_arm(text, &mut document, joint, name)?;
            joint.clone()
        }
        Attachment::End(end) => {
            end_becomes_joint(text, &mut document, end, name)?;
            end.clone()
        }
        Attachment::Branch(branch, s) => {
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
