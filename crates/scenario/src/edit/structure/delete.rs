//! What is of no use without a part that is deleted.

use super::entries::{each_attachment, is, list, retain, word};
use super::part::BEGINNINGS;
use std::collections::BTreeSet;
use toml_edit::{Array, DocumentMut, Item, TableLike, Value};

/// Keeps some of the operations of all steps; notes the steps that have lost one.
pub(super) fn of_steps(
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

/// Strikes a name from a list of names.
fn strike(table: &mut dyn TableLike, key: &str, name: &str) {
    if let Some(names) = table.get_mut(key).and_then(Item::as_array_mut) {
        names.retain(|value| value.as_str() != Some(name));
    }
}

/// Whether a list of names has any, or is left out.
fn has_names(table: &dyn TableLike, key: &str) -> bool {
    table.get(key).and_then(Item::as_array).is_none_or(|names| !names.is_empty())
}

/// Removes components; returns their names.
fn remove_components(document: &mut DocumentMut, goes: &dyn Fn(&dyn TableLike) -> bool) -> BTreeSet<String> {
    let mut gone = BTreeSet::new();
    retain(document.as_table_mut(), "components", &mut |own| {
        let stays = !goes(own);
        if !stays {
            gone.extend(word(own, "name").map(str::to_owned));
        }
        stays
    });
    gone
}

/// Removes the components that belong to constraints and components that are gone, and their names from the ends of
/// wires.
pub(super) fn forget_connectors(document: &mut DocumentMut, mut gone: BTreeSet<String>) {
    let belongs = |own: &dyn TableLike, gone: &BTreeSet<String>| {
        word(own, "connector").is_some_and(|connector| gone.contains(connector))
    };
    let mut last = gone.clone();
    while !last.is_empty() {
        last = remove_components(document, &|own| belongs(own, &last));
        gone.extend(last.iter().cloned());
    }
    for connection in list(document.as_table_mut(), "connections") {
        // An end stays, even if nothing is known of it: the first is where the wire begins.
        for end in list(connection, "ends").into_iter().filter(|end| belongs(*end, &gone)) {
            end.remove("connector");
            end.remove("cavity");
        }
    }
}

/// Keeps the requirements whose parts are kept.
pub(super) fn requirements(document: &mut DocumentMut, keep: &mut dyn FnMut(&dyn TableLike) -> bool) {
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
pub(super) fn forget_constraint(document: &mut DocumentMut, name: &str, emptied: &mut BTreeSet<usize>) {
    requirements(document, &mut |of| !is(of, "constraint", name));
    of_steps(document, &["move", "mate"], emptied, &mut |entry| !is(entry, "constraint", name));
    for (k, step) in list(document.as_table_mut(), "steps").into_iter().enumerate() {
        for carry in list(step, "carry") {
            retain(carry, "timing", &mut |timing| !is(timing, "what", name));
            strike(carry, "what", name);
        }
        let released = |step: &dyn TableLike| step.get("release").and_then(Item::as_array).map_or(0, Array::len);
        let before = released(step);
        strike(step, "release", name);
        if released(step) < before {
            emptied.insert(k);
        }
        if !has_names(step, "release") {
            step.remove("release");
        }
    }
    of_steps(document, &["carry"], emptied, &mut |carry| has_names(carry, "what"));
}

/// A step that has lost all that it did waits.
pub(super) fn wait_in_empty_steps(document: &mut DocumentMut, emptied: &BTreeSet<usize>) {
    for (k, step) in list(document.as_table_mut(), "steps").into_iter().enumerate() {
        let nothing = step.iter().all(|(key, _)| matches!(key, "name" | "increments"));
        if emptied.contains(&k) && nothing {
            step.insert("wait", toml_edit::value(true));
        }
    }
}

/// Removes a branch, its arms at its joints, and what attaches to it. Returns the names of the components that go.
pub(super) fn remove_branch(document: &mut DocumentMut, name: &str, emptied: &mut BTreeSet<usize>) -> BTreeSet<String> {
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
        list(step, "temperature").into_iter().for_each(|own| strike(own, "branches", name));
    }
    of_steps(document, &["temperature"], emptied, &mut |own| has_names(own, "branches"));
    for connection in list(document.as_table_mut(), "connections") {
        strike(connection, "branches", name);
        if !has_names(connection, "branches") {
            connection.remove("branches");
        }
    }
    remove_components(document, &|own| {
        is(own, "branch", name) || word(own, "vertex").is_some_and(|vertex| lost.iter().any(|v| v == vertex))
    })
}
