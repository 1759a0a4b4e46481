//! Branches that are split, and branches that are added.

use super::entries::{append, each_attachment, each_table, is, list, names, put, refused, unknown, vertices, word};
use super::part::Part;
use crate::edit::adjust::quoted;
use crate::edit::record::{inline, number};
use crate::fault::{Fault, did_you_mean};
use crate::format::units;
use std::collections::BTreeSet;
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, TableLike, Value};

/// Arc lengths nearer than this, relative to the branch, are the same.
const SAME: f64 = 1e-9;

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
pub(super) fn add_arm(text: &str, document: &mut DocumentMut, joint: &str, branch: &str) -> Result<(), Fault> {
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
pub(super) fn end_becomes_joint(text: &str, document: &mut DocumentMut, end: &str, branch: &str) -> Result<(), Fault> {
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
pub(super) fn spacing(document: &mut DocumentMut) -> Option<Value> {
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
