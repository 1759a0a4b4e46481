//! A branch that is split into two.

mod carried;
mod guard;
mod halves;

use super::branches::add_joint;
use super::entries::{append, copy_of, is, list, names, refused, retain, set, unknown, vertices, word};
use super::lengths::{length_like, metres, metres_of};
use super::part::Part;
use crate::edit::record;
use crate::fault::Fault;
use carried::carry_over;
use guard::refuse_what_changes;
use halves::{IDENTITY, SAME, Side, Split};
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, TableLike, Value};

pub(super) fn split(
    text: &str,
    document: &mut DocumentMut,
    branch: &str,
    s: f64,
    second: &str,
    joint: &str,
) -> Result<(), Fault> {
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
    let split = Split { branch, s, length, second, joint };
    refuse_what_changes(text, document, &split)?;
    let other = halve(text, document, &split)?;
    insert_behind(text, document, branch, other)?;
    // The joint at the far end has the second half as its arm.
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
    add_joint(text, document, joint, [branch, second])?;
    carry_over(text, document, &split)
}

/// Makes the branch its first half; returns the second: what the first has, with other ends.
fn halve(text: &str, document: &mut DocumentMut, split: &Split<'_>) -> Result<InlineTable, Fault> {
    let Split { branch, s, length, second, joint } = *split;
    let mut own = list(document.as_table_mut(), "branches");
    let entry = own.iter_mut().find(|own| is(**own, "name", branch)).ok_or_else(|| refused(text, "no branch", ""))?;
    let mut other = copy_of(&**entry);
    IDENTITY.iter().for_each(|key| drop(other.remove(key)));
    set(&mut other, "name", second.into());
    set(&mut other, "from", joint.into());
    let whole = entry.get("length").cloned();
    let unit = whole.as_ref().and_then(Item::as_str);
    set(&mut other, "length", length_like(unit, length - s));
    set(*entry, "length", length_like(unit, s));
    set(*entry, "to", joint.into());
    if let Some(count) = entry.get("segments").and_then(Item::as_integer) {
        let first = ((count as f64 * s / length).round() as i64).clamp(1, (count - 1).max(1));
        set(*entry, "segments", first.into());
        set(&mut other, "segments", (count - first).max(1).into());
    }
    halve_parts(*entry, &mut other, split);
    for key in ["path", "drawn"] {
        let Some(points) = entry.get(key).and_then(Item::as_array) else { continue };
        let [before, behind] = split_line(points, s / length).ok_or_else(|| {
            let message = format!("`{key}` of branch \"{branch}\" is not a list of points");
            refused(text, message, "write its points as [[x, y, z], …]")
        })?;
        set(*entry, key, Value::Array(before));
        set(&mut other, key, Value::Array(behind));
    }
    Ok(other)
}

/// The parts with another section on the half that they are on; one on both is cut.
fn halve_parts(first: &mut dyn TableLike, second: &mut dyn TableLike, split: &Split<'_>) {
    const PARTS: &str = "sections";
    retain(first, PARTS, &mut |part| split.side(part) != Side::Second);
    retain(second, PARTS, &mut |part| split.side(part) != Side::First);
    for part in list(first, PARTS).into_iter().filter(|part| split.side(*part) == Side::Both) {
        part.remove("to");
        part.fmt();
    }
    for part in list(second, PARTS) {
        let is_cut = split.side(part) == Side::Both;
        for key in ["from", "to"] {
            match split.behind(part.get(key)) {
                Some(_) if key == "from" && is_cut => drop(part.remove(key)),
                Some(place) => set(part, key, place),
                None => {}
            }
        }
        if is_cut {
            part.fmt();
        }
    }
    let drop_empty = |half: &mut dyn TableLike| {
        if half.contains_key(PARTS) && list(half, PARTS).is_empty() {
            half.remove(PARTS);
        }
    };
    drop_empty(first);
    drop_empty(second);
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
fn split_line(points: &Array, at: f64) -> Option<[Array; 2]> {
    let point = |value: &Value| -> Option<[f64; 3]> {
        let of = |k: usize| metres_of(value.as_array()?.get(k)?);
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
    let value = |p: &[f64; 3]| record::list(&p.map(|x| (x * 1e9).round() / 1e9));
    let before = all[..=k].iter().chain([&middle]).map(value).collect();
    let behind = [&middle].into_iter().chain(&all[k + 1..]).map(value).collect();
    Some([before, behind])
}
