//! What a split carries over to the second half of a branch.

use super::super::entries::{append, copy_of, each_table, is, list, names, put, set, unused, word};
use super::super::lengths::metres;
use super::super::part::Part;
use super::halves::{IDENTITY, SAME, Side, Split};
use crate::fault::Fault;
use std::collections::{BTreeMap, BTreeSet};
use toml_edit::{Array, DocumentMut, InlineTable, Item, TableLike};

pub(super) fn carry_over(text: &str, document: &mut DocumentMut, split: &Split<'_>) -> Result<(), Fault> {
    let requirements = requirements_of_second(document, split);
    let components = components_of_second(document, split);
    move_places(document, split);
    for (key, copies) in [("requirements", requirements), ("components", components)] {
        for copy in copies {
            append(text, document, key, copy)?;
        }
    }
    lengthen_lists(document, split);
    Ok(())
}

/// Leaves a part on both halves on the first one, and puts its copy on the second. Returns whether it is on both.
fn divide(first: &mut dyn TableLike, copy: &mut dyn TableLike, split: &Split<'_>) -> bool {
    if !is(first, "branch", split.branch) || split.side(first) != Side::Both {
        return false;
    }
    let to = split.behind(first.get("to"));
    first.remove("to");
    set(copy, "branch", split.second.into());
    copy.remove("from");
    match to {
        Some(to) => set(copy, "to", to),
        None => drop(copy.remove("to")),
    }
    true
}

/// Requirements on the whole branch, or on a part of it on both halves, for the second half.
fn requirements_of_second(document: &mut DocumentMut, split: &Split<'_>) -> Vec<InlineTable> {
    let mut taken = names(document, Part::Requirement);
    let mut copies = Vec::new();
    for own in list(document.as_table_mut(), "requirements") {
        let mut copy = copy_of(own);
        let mut divided = false;
        for key in ["of", "between"] {
            for (first, second) in list(own, key).into_iter().zip(list(&mut copy, key)) {
                divided |= divide(first, second, split);
            }
        }
        if divided {
            rename(&mut copy, &mut taken, split);
            copies.push(copy);
        }
    }
    copies
}

/// Components on both halves, for the second half. The first has what the parts list says of them.
fn components_of_second(document: &mut DocumentMut, split: &Split<'_>) -> Vec<InlineTable> {
    let mut taken = names(document, Part::Constraint);
    let components = list(document.as_table_mut(), "components");
    taken.extend(components.iter().filter_map(|own| word(*own, "name").map(str::to_owned)));
    let mut copies = Vec::new();
    for own in components {
        let mut copy = copy_of(own);
        if divide(own, &mut copy, split) {
            rename(&mut copy, &mut taken, split);
            for key in IDENTITY.iter().chain(&["connector", "cavity", "vertex"]) {
                copy.remove(key);
            }
            copies.push(copy);
        }
    }
    copies
}

/// Gives a copy a name that says where it is.
fn rename(copy: &mut InlineTable, taken: &mut BTreeSet<String>, split: &Split<'_>) {
    let name = unused(taken, &format!("{} ({})", word(copy, "name").unwrap_or_default(), split.second));
    set(copy, "name", name.as_str().into());
    taken.insert(name);
}

/// What attaches to the branch beyond the split attaches to its second half; what is exactly there to the joint.
fn move_places(document: &mut DocumentMut, split: &Split<'_>) {
    let Split { branch, s, length, second, joint } = *split;
    each_table(document.as_item_mut(), &mut Vec::new(), &mut |way, table| {
        if !is(table, "branch", branch) {
            return;
        }
        let shift = |table: &mut dyn TableLike, key: &str| {
            let value = split.behind(table.get(key));
            if let (Some(item), Some(value)) = (table.get_mut(key), value) {
                put(item, value);
            }
        };
        let way: Vec<&str> = way.iter().map(String::as_str).collect();
        match (way.as_slice(), metres(table.get("s"))) {
            ([.., "at"], Some(own)) if (own - s).abs() <= SAME * length => {
                table.remove("branch");
                table.remove("s");
                table.insert("joint", toml_edit::value(joint));
            }
            ([.., "at"], Some(own)) if own > s => {
                set(table, "branch", second.into());
                shift(table, "s");
            }
            ([.., "span" | "of" | "between"] | ["components"], _) if split.side(table) == Side::Second => {
                set(table, "branch", second.into());
                shift(table, "from");
                shift(table, "to");
            }
            _ => {}
        }
    });
}

/// What names the branch in a list names both halves: a temperature, and the way of a wire.
fn lengthen_lists(document: &mut DocumentMut, split: &Split<'_>) {
    let root = document.as_table_mut();
    for step in list(root, "steps") {
        for own in list(step, "temperature") {
            lengthen(own, split, &|_, _| false);
        }
    }
    let ends = list(root, "branches").into_iter().filter_map(|own| {
        let of = |key| word(own, key).map(str::to_owned);
        Some((of("name")?, [of("from")?, of("to")?]))
    });
    let ends: BTreeMap<String, [String; 2]> = ends.collect();
    let vertex = |branch: &str, end: usize| ends.get(branch).map(|ends| ends[end].as_str());
    let touches = |other: Option<&String>, vertex: Option<&str>| {
        let ends = other.and_then(|branch| ends.get(branch));
        ends.is_some_and(|ends| ends.iter().any(|end| Some(end.as_str()) == vertex))
    };
    // A wire may run against the direction of the branch.
    let backwards = |way: &[String], k: usize| {
        let (before, after) = (k.checked_sub(1).and_then(|k| way.get(k)), way.get(k + 1));
        let (start, end) = (vertex(split.branch, 0), vertex(split.second, 1));
        let against = touches(before, end) || touches(after, start);
        against && !touches(before, start) && !touches(after, end)
    };
    for own in list(root, "connections") {
        lengthen(own, split, &backwards);
    }
}

/// Puts the second half beside the first one in the list `branches` of an entry; `backwards`: whether before it.
fn lengthen(entry: &mut dyn TableLike, split: &Split<'_>, backwards: &dyn Fn(&[String], usize) -> bool) {
    let Some(list) = entry.get_mut("branches").and_then(Item::as_array_mut) else { return };
    let way: Vec<String> = list.iter().map(|name| name.as_str().unwrap_or_default().to_owned()).collect();
    for k in (0..way.len()).rev().filter(|k| way[*k] == split.branch) {
        list.insert(k + 1, split.second);
        if backwards(&way, k) {
            swap(list, k);
        }
    }
}

/// Swaps an entry of a list and the next one; the layout stays.
fn swap(list: &mut Array, k: usize) {
    let names = [k + 1, k].map(|from| list.get(from).cloned());
    for (at, value) in [k, k + 1].into_iter().zip(names) {
        if let (Some(old), Some(mut value)) = (list.get_mut(at), value) {
            *value.decor_mut() = old.decor().clone();
            *old = value;
        }
    }
}
