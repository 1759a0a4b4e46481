//! Reads joints, and checks that they fit the graph of branches.

use super::entry::Entry;
use super::kinds;
use super::names::{Names, lookup, register};
use super::sections::arm_friction;
use crate::fault::listed;
use crate::scenario::{Arm, Joint};
use std::collections::BTreeMap;
use wireloom_core::identity::Identified;
use wireloom_core::joint::WireShare;
use wireloom_core::rotation::frame_from;
use wireloom_core::{ArmSpring, Rotation};

/// A joint. `None`, with the names marked as broken, if it does not fit the graph.
pub(crate) fn joint<'a>(entry: &Entry<'a>, names: &mut Names<'a>) -> Option<Joint> {
    let kind = kinds::read(entry);
    let mass = entry.number("mass").unwrap_or(0.0);
    let index = names.joints.len();
    let name = entry.word("name").filter(|name| register(entry, entry.keys.what, &mut names.joints, name, index));
    names.identify(entry, Identified::Joint, name);
    let fits = name.is_some_and(|name| vertex_joins(entry, name, names));
    let spring = spring(entry, &ArmSpring::default());
    let arm_entries = entry.entries("arms");
    let mut by_branch = BTreeMap::new();
    let mut arm = |arm_entry| arm(arm_entry, name.unwrap_or_default(), &spring, &mut by_branch, names);
    let arms: Vec<Option<Arm>> = arm_entries.iter().map(&mut arm).collect();
    if let (Some(name), true) = (name, fits) {
        refuse_missing_arms(entry, name, &by_branch, names);
    }
    let wires = wires(entry, &by_branch);
    let mut spans = entry.spans();
    if let Some(offset) = arm_entries.iter().find(|arm| arm.has("offset")) {
        spans.keys.insert("offset".to_owned(), offset.span_of("offset"));
    }
    let branch = |arm: &Entry<'_>| Some((format!("arms.{}", arm.text("branch")?), arm.span.clone()));
    spans.keys.extend(arm_entries.iter().filter_map(branch));
    let arms: Option<Vec<Arm>> = arms.into_iter().collect();
    let joint = name.zip(kind).zip(arms).map(|((name, kind), arms)| Joint {
        name: name.to_owned(),
        model: kind.name,
        parameters: kind.parameters,
        mass,
        spring,
        arms,
        wires,
        spans,
    });
    // Models are built for all arms of a vertex, or not at all.
    let whole = name.and_then(|name| names.vertices.get(name)).is_some_and(|v| v.ends.len() == by_branch.len());
    names.broken |= joint.is_none() || !fits || !whole;
    joint
}

/// Whether the vertex exists and joins branches.
fn vertex_joins(entry: &Entry<'_>, name: &str, names: &Names<'_>) -> bool {
    let Some(vertex) = lookup(entry, "vertex", &names.vertices, name, entry.span_of("name")) else { return false };
    if let [(branch, _)] = vertex.ends.as_slice() {
        let branch = names.branch_names[*branch];
        let message = format!("{} has only the branch \"{branch}\": it is a free end", entry.label);
        entry.fault_at("name", message, "leave the joint out, or let another branch begin or end there");
        return false;
    }
    true
}

/// What holds an arm to its hub, or all arms of a joint; `other` has what is not given.
fn spring(entry: &Entry<'_>, other: &ArmSpring) -> ArmSpring {
    let own_friction = entry.entry("friction").map(|own| arm_friction(&own));
    ArmSpring {
        bending: entry.one_or_two("bending_stiffness").or(other.bending),
        torsion: entry.number("torsion_stiffness").or(other.torsion),
        friction: own_friction.unwrap_or_else(|| other.friction.clone()),
    }
}

/// An arm; notes its branch and place in the list under the branch's name. `of_joint` has what its spring leaves out.
fn arm<'a>(
    entry: &Entry<'a>,
    joint: &str,
    of_joint: &ArmSpring,
    by_branch: &mut BTreeMap<&'a str, usize>,
    names: &Names<'a>,
) -> Option<Arm> {
    let spring = spring(entry, of_joint);
    let offset = entry.vector("offset").unwrap_or_default();
    let branch = entry.word("branch")?;
    let index = *lookup(entry, "branch", &names.branches, branch, entry.span_of("branch"))?;
    let Some(&(_, starts_here)) =
        names.vertices.get(joint).and_then(|vertex| vertex.ends.iter().find(|(b, _)| *b == index))
    else {
        let message = format!("branch \"{branch}\" does not end at joint \"{joint}\"");
        entry.fault_at("branch", message, "leave this arm out, or correct `from` and `to` of the branch");
        return None;
    };
    let place = by_branch.len();
    if by_branch.contains_key(branch) {
        let message = format!("branch \"{branch}\" is given twice in {}", entry.label);
        entry.fault_at("branch", message, "give one arm for every branch");
        return None;
    }
    by_branch.insert(branch, place);
    let rest = rest_frame(entry, branch, starts_here).unwrap_or_default();
    Some(Arm { branch: index, starts_here, rest, offset, spring })
}

/// Frame of the branch in the joint's frame: d3 leads out of the joint if the branch starts here, else into it.
fn rest_frame(entry: &Entry<'_>, branch: &str, starts_here: bool) -> Option<Rotation> {
    let (direction, up, orientation) =
        (entry.direction("direction"), entry.direction("up"), entry.orientation("orientation"));
    match (entry.has("direction"), entry.has("up"), entry.has("orientation")) {
        (false, false, true) => orientation,
        (true, true, false) => {
            let (direction, up) = (direction?, up?);
            let tangent = if starts_here { *direction } else { -*direction };
            let frame = frame_from(&tangent, &up);
            if frame.is_none() {
                let message = format!("`up` of arm \"{branch}\" is parallel to its direction");
                entry.fault_at("up", message, "`up` is d1 of the branch: give a vector across the direction");
            }
            frame
        }
        (_, _, true) => {
            let message = format!("arm \"{branch}\" has `orientation` beside `direction` or `up`");
            entry.fault_at("orientation", message, "give either `orientation`, or `direction` and `up`");
            None
        }
        (has_direction, _, false) => {
            let missing = if has_direction { "`up`" } else { "`direction`" };
            let message = format!("arm \"{branch}\" has no {missing}");
            entry.fault_here(message, "give `direction` (out of the joint) and `up` (d1), or `orientation`");
            None
        }
    }
}

fn refuse_missing_arms(entry: &Entry<'_>, joint: &str, by_branch: &BTreeMap<&str, usize>, names: &Names<'_>) {
    let Some(vertex) = names.vertices.get(joint) else { return };
    let missing: Vec<String> = vertex
        .ends
        .iter()
        .map(|(branch, _)| names.branch_names[*branch])
        .filter(|name| !name.is_empty() && !by_branch.contains_key(name))
        .map(|name| format!("\"{name}\""))
        .collect();
    if missing.is_empty() || !entry.has("arms") {
        return;
    }
    let message = format!("{} has no arm for {}", entry.label, listed(&missing));
    entry.fault_at("arms", message, "every branch that begins or ends at the joint has an arm");
}

fn wires(entry: &Entry<'_>, by_branch: &BTreeMap<&str, usize>) -> Vec<WireShare> {
    let mut shares: Vec<WireShare> = Vec::new();
    for wire in entry.entries("wires") {
        let between = wire.names("between");
        let share = wire.number("share");
        let given = between.len();
        let arms: Vec<usize> = between
            .into_iter()
            .filter_map(|(name, span)| lookup(&wire, "arm", by_branch, name, span).copied())
            .collect();
        let ([from, to], Some(share)) = (arms.as_slice(), share) else {
            if wire.has("between") && given != 2 {
                let message = format!("`between` names {given} arms");
                wire.fault_at("between", message, "name two: [\"from this arm\", \"to that arm\"]");
            }
            continue;
        };
        let pair = [*from.min(to), *from.max(to)];
        if from == to || shares.iter().any(|other| [other.from.min(other.to), other.from.max(other.to)] == pair) {
            let message =
                if from == to { "`between` names the same arm twice" } else { "this pair of arms is given twice" };
            wire.fault_at("between", message, "give one entry for every pair of different arms");
            continue;
        }
        shares.push(WireShare { from: *from, to: *to, fraction: share });
    }
    for (branch, arm) in by_branch {
        let sum: f64 = shares.iter().filter(|wire| wire.from == *arm).map(|wire| wire.fraction).sum();
        if sum > 1.0 + 1e-9 {
            let sum = (sum * 1e9).round() / 1e9;
            let message = format!("the shares of the wires of arm \"{branch}\" add up to {sum}, more than 1");
            entry.fault_at("wires", message, "let the shares of an arm add up to at most 1");
        }
    }
    shares
}

/// Refuses vertices that join branches without a joint.
pub(crate) fn refuse_dangling(root: &Entry<'_>, names: &mut Names<'_>) {
    for (name, vertex) in &names.vertices {
        let first = vertex.ends[0].0;
        if vertex.ends.iter().all(|(branch, _)| *branch == first) || names.joints.contains_key(name) {
            continue;
        }
        let branches: Vec<String> =
            vertex.ends.iter().map(|(branch, _)| format!("\"{}\"", names.branch_names[*branch])).collect();
        root.reader.fault(
            vertex.span.clone(),
            format!("branches {} meet at \"{name}\", but there is no such joint", listed(&branches)),
            format!("add a [[joints]] entry with name = \"{name}\""),
        );
        names.broken = true;
    }
}
