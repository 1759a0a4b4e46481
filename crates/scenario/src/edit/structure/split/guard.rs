//! What a split would give another meaning is refused: it could turn a failed requirement of the text into one that
//! passes. What every harness must keep (its spans are long enough and do not buckle) goes on through the new joint.

use super::super::entries::{each_table, is, list, refused, word};
use super::super::lengths::metres;
use super::halves::{Side, Split};
use crate::edit::key_path::{self, Part};
use crate::edit::record::{as_json, index_of};
use crate::fault::Fault;
use serde_json::Value as Json;
use toml_edit::{DocumentMut, Item, TableLike};
use wildmatch::WildMatch;

/// Quantities of a branch as a whole, whichever part of it a requirement names.
const OF_WHOLE: [&str; 3] = ["contact_force", "reach", "turns"];

pub(super) fn refuse_what_changes(text: &str, document: &mut DocumentMut, split: &Split<'_>) -> Result<(), Fault> {
    refuse_places(text, document, split)?;
    refuse_moving_limit(text, document, split)?;
    // Those that will be two.
    let mut doubled = Vec::new();
    for own in list(document.as_table_mut(), "requirements") {
        let name = word(own, "name").unwrap_or_default().to_owned();
        match requirement(own, split) {
            Effect::Kept => {}
            Effect::Doubled => doubled.push(name),
            Effect::Changed(how, help) => {
                return Err(refused(text, format!("requirement \"{name}\" {how}"), help));
            }
        }
    }
    let json = as_json(text)?;
    for root in ["sweep", "optimise"] {
        refuse_study(text, &json, root, &doubled, split)?;
    }
    Ok(())
}

/// Refuses what acts along a stretch with the split inside it, and what closes at the nearest place of the branch.
fn refuse_places(text: &str, document: &mut DocumentMut, split: &Split<'_>) -> Result<(), Fault> {
    let Split { branch, s, .. } = *split;
    let mut found = None;
    each_table(document.as_item_mut(), &mut Vec::new(), &mut |way, table| {
        if !is(table, "branch", branch) {
            return;
        }
        let list = || way.first().cloned().unwrap_or_default();
        match way.last().map(String::as_str) {
            Some("span") if split.side(table) == Side::Both => {
                let message =
                    format!("an entry of `{}` acts along a span of branch \"{branch}\" across s = {s} m", list());
                found = Some((message, "end its span there first, or split the branch at another place"));
            }
            Some("at") if metres(table.get("s")).is_none() => {
                let message = format!("an entry of `{}` closes at the nearest place of branch \"{branch}\"", list());
                found = Some((message, "give it `s` first: the nearest place may be on either part"));
            }
            _ => {}
        }
    });
    found.map_or(Ok(()), |(message, help)| Err(refused(text, message, help)))
}

/// Refuses a limit of bends while the branch moves: it counts as moving, or not, as a whole.
fn refuse_moving_limit(text: &str, document: &DocumentMut, split: &Split<'_>) -> Result<(), Fault> {
    const LIMIT: &str = "min_bend_radius_moving";
    let mut own = document.clone();
    let mut branches = list(own.as_table_mut(), "branches");
    let Some(own) = branches.iter_mut().find(|own| is(**own, "name", split.branch)) else { return Ok(()) };
    let parts = list(*own, "sections").into_iter().filter_map(|part| Some(word(part, "section")?.to_owned()));
    let mut sections: Vec<String> = parts.collect();
    sections.extend(word(&**own, "section").map(str::to_owned));
    let is_limited = |section: &&String| {
        let keys = document.get("sections").and_then(|all| all.get(section.as_str())).and_then(Item::as_table_like);
        keys.is_some_and(|keys| keys.contains_key(LIMIT))
    };
    if let Some(section) = sections.iter().find(is_limited) {
        let message = format!(
            "section \"{section}\" has `{LIMIT}`, and branch \"{}\" counts as moving, or not, as a whole",
            split.branch
        );
        return Err(refused(text, message, "remove it, split the branch, and write it anew"));
    }
    Ok(())
}

/// What a split does to a requirement.
enum Effect {
    /// It means what it meant.
    Kept,
    /// It is needed for both halves.
    Doubled,
    /// It would mean something else: how, and what to do.
    Changed(String, &'static str),
}

fn requirement(own: &mut dyn TableLike, split: &Split<'_>) -> Effect {
    let Split { branch, second, .. } = *split;
    let quantity = word(own, "quantity").unwrap_or_default().to_owned();
    // A branch counts as moving, or not, as a whole.
    let ends = OF_WHOLE.contains(&quantity.as_str()) || own.contains_key("motion");
    // Of a part of a branch, but not of its halves: a chord, and a distance that the nearest place alone must keep.
    let whole = ends || quantity == "slack" || quantity == "clearance" && own.contains_key("max");
    let as_a_whole = || {
        let how = format!("limits the {quantity} of branch \"{branch}\" as a whole, which its two parts do not have");
        Effect::Changed(how, "remove it, split the branch, and require it of each part")
    };
    if !own.contains_key("of") && !own.contains_key("between") {
        return if own.contains_key("motion") || matches!(quantity.as_str(), "reach" | "slack" | "turns") {
            as_a_whole()
        } else {
            Effect::Kept
        };
    }
    let mut across = 0;
    for key in ["of", "between"] {
        for part in list(own, key) {
            if let Some(pattern) = word(part, "branches") {
                let fits = WildMatch::new(pattern);
                match (fits.matches(branch), fits.matches(second)) {
                    (true, true) if whole => return as_a_whole(),
                    (a, b) if a != b => {
                        let (one, other) = if a { (branch, second) } else { (second, branch) };
                        let how = format!("is about branches like \"{pattern}\": \"{one}\", and not \"{other}\"");
                        return Effect::Changed(how, "name its branches one by one first");
                    }
                    _ => {}
                }
            }
            if is(part, "branch", branch) {
                let both = split.side(part) == Side::Both;
                if ends || whole && both {
                    return as_a_whole();
                }
                across += usize::from(both);
            }
        }
    }
    match across {
        0 => Effect::Kept,
        1 => Effect::Doubled,
        _ => {
            let how = format!("is between branch \"{branch}\" and itself, on both sides of the split");
            Effect::Changed(how, "remove it, split the branch, and require it anew")
        }
    }
}

/// Refuses keys of a sweep or an optimisation that would vary something else, and what they measure there.
fn refuse_study(text: &str, json: &Json, root: &str, doubled: &[String], split: &Split<'_>) -> Result<(), Fault> {
    let Split { branch, .. } = *split;
    let Some(study) = json.get(root) else { return Ok(()) };
    let varied = ["vary", "cross"].iter().filter_map(|key| study.get(key)?.as_object()).flat_map(|keys| keys.keys());
    for key in varied {
        let parts = key_path::parts(key, 0).map_err(|fault| Fault { span: text.len()..text.len(), ..fault })?;
        if varies(json, &parts, doubled, branch) {
            let message = format!("[{root}] varies `{key}`, and branch \"{branch}\" is to become two");
            return Err(refused(text, message, "remove its keys there, split it, and add the keys of both parts"));
        }
    }
    if names(study, branch) {
        let message = format!("[{root}] names branch \"{branch}\", which is to become two");
        return Err(refused(text, message, "remove what names it there, split it, and name the part that is meant"));
    }
    let objective = study.get("minimise").unwrap_or(&Json::Null);
    if let Some(name) = doubled.iter().find(|name| has_word(objective, name)) {
        let message =
            format!("[{root}] minimises requirement \"{name}\" of branch \"{branch}\", which is to become two");
        return Err(refused(
            text,
            message,
            "remove it there, split the branch, and name the requirement that is meant",
        ));
    }
    Ok(())
}

/// Whether a key belongs to the branch, to something that refers to it, or to an entry whose number changes.
fn varies(json: &Json, parts: &[Part], doubled: &[String], branch: &str) -> bool {
    let mut passed = Vec::new();
    pass(json, parts, &mut passed);
    let is = |value: &Json, key: &str, name: &str| value.get(key).and_then(Json::as_str) == Some(name);
    let refers = passed.iter().any(|(value, last)| is(value, "branch", branch) || *last && names(value, branch));
    match parts {
        [list, entry, ..] if list.name == "branches" => {
            let all = json.get("branches").and_then(Json::as_array).map_or(&[][..], Vec::as_slice);
            let own = all.iter().position(|own| is(own, "name", branch));
            let numbered = index_of(all, &entry.name).filter(|k| !is(&all[*k], "name", &entry.name));
            passed.iter().any(|(value, _)| is(value, "name", branch)) || numbered.is_some_and(|k| Some(k) > own)
        }
        [list, ..] if list.name == "requirements" => {
            refers || passed.iter().any(|(value, _)| doubled.iter().any(|name| is(value, "name", name)))
        }
        _ => refers,
    }
}

/// The values that the path to a key passes, and whether it ends there; `*`: those of every entry.
fn pass<'j>(value: &'j Json, parts: &[Part], passed: &mut Vec<(&'j Json, bool)>) {
    passed.push((value, parts.is_empty()));
    let [part, rest @ ..] = parts else { return };
    let next: Vec<&Json> = match value {
        Json::Object(table) if part.every => table.values().collect(),
        Json::Object(table) => table.get(&part.name).into_iter().collect(),
        Json::Array(list) if part.every => list.iter().collect(),
        Json::Array(list) => index_of(list, &part.name).map(|k| &list[k]).into_iter().collect(),
        _ => Vec::new(),
    };
    next.into_iter().for_each(|value| pass(value, rest, passed));
}

/// Whether a value has, at any depth, an entry that refers to the branch.
fn names(value: &Json, branch: &str) -> bool {
    match value {
        Json::Object(table) => {
            let refers = table.get("branch").and_then(Json::as_str) == Some(branch);
            refers || table.values().any(|value| names(value, branch))
        }
        Json::Array(list) => list.iter().any(|value| names(value, branch)),
        _ => false,
    }
}

/// Whether a value has this word at any depth.
fn has_word(value: &Json, word: &str) -> bool {
    match value {
        Json::String(own) => own == word,
        Json::Array(list) => list.iter().any(|value| has_word(value, word)),
        Json::Object(table) => table.values().any(|value| has_word(value, word)),
        _ => false,
    }
}
