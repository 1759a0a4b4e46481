//! Reads places of the harness that something attaches to, and directions and frames.

use super::entry::Entry;
use super::names::{Names, lookup};
use crate::attachment::{At, Stretch};
use crate::scenario::Facing;
use wireloom_core::rotation::frame_from;

/// A place that something attaches to, and whether it is the nearest place of a branch, which is known only when it
/// begins. `nearest`: whether the latter is allowed.
pub(crate) fn attachment(at: &Entry<'_>, names: &Names<'_>, nearest: bool) -> Option<(At, bool)> {
    let (end, joint, branch) = (at.word("end"), at.word("joint"), at.word("branch"));
    let s = at.number("s");
    if names.vertices.is_empty() {
        return None; // Without branches every place is unknown, and the branches have their own fault.
    }
    match (at.has("end"), at.has("joint"), at.has("branch"), at.has("s")) {
        (true, false, false, false) => free_end(at, end?, names).map(|at| (at, false)),
        (false, true, false, false) => joint_place(at, joint?, names).map(|at| (at, false)),
        (false, false, true, true) => {
            let branch = branch?;
            let index = *lookup(at, "branch", &names.branches, branch, at.span_of("branch"))?;
            let (s, length) = (s?, (*names.lengths.get(index)?)?);
            let s = along(at, "s", s, branch, length)?;
            Some((At::Branch { branch: index, s }, false))
        }
        (false, false, true, false) if nearest => {
            let branch = branch?;
            let index = *lookup(at, "branch", &names.branches, branch, at.span_of("branch"))?;
            Some((At::Branch { branch: index, s: 0.5 * (*names.lengths.get(index)?)? }, true))
        }
        (false, false, true, false) => {
            at.fault_here(format!("{} has `branch` but no `s`", at.label), "add `s`: arc length along the branch");
            None
        }
        _ => {
            let help = "write { end = \"…\" }, { joint = \"…\" } or { branch = \"…\", s = … }";
            at.fault_here(format!("{} does not give one place", at.label), help);
            None
        }
    }
}

fn free_end(at: &Entry<'_>, end: &str, names: &Names<'_>) -> Option<At> {
    let vertex = lookup(at, "end", &names.vertices, end, at.span_of("end"))?;
    let [(branch, starts_here)] = vertex.ends.as_slice() else {
        let message = format!("\"{end}\" is not a free end: {} branches meet there", vertex.ends.len());
        at.fault_at("end", message, format!("write {{ joint = \"{end}\" }}, or {{ branch = …, s = … }}"));
        return None;
    };
    let length = (*names.lengths.get(*branch)?)?;
    Some(At::Branch { branch: *branch, s: if *starts_here { 0.0 } else { length } })
}

fn joint_place(at: &Entry<'_>, joint: &str, names: &Names<'_>) -> Option<At> {
    if !names.joints.contains_key(joint) && names.vertices.get(joint).is_some_and(|vertex| vertex.ends.len() == 1) {
        let message = format!("\"{joint}\" is not a joint: only one branch ends there");
        at.fault_at("joint", message, format!("write {{ end = \"{joint}\" }}"));
        return None;
    }
    lookup(at, "joint", &names.joints, joint, at.span_of("joint")).map(|index| At::Joint(*index))
}

/// Tangent, up and orientation of an entry.
pub(crate) fn facing(entry: &Entry<'_>) -> Facing {
    let (tangent, up, orientation) =
        (entry.direction("tangent"), entry.direction("up"), entry.orientation("orientation"));
    match (entry.has("tangent"), entry.has("up"), entry.has("orientation")) {
        (false, false, false) => Facing::Left,
        (false, false, true) => orientation.map_or(Facing::Left, Facing::Orientation),
        (true, false, false) => tangent.map_or(Facing::Left, |tangent| Facing::Tangent(*tangent)),
        (true, true, false) => {
            let Some((tangent, up)) = tangent.zip(up) else { return Facing::Left };
            let frame = frame_from(&tangent, &up);
            if frame.is_none() {
                let message = format!("`up` of {} is parallel to its tangent", entry.label);
                entry.fault_at("up", message, "`up` is d1 of the branch: give a vector across the tangent");
            }
            frame.map_or(Facing::Left, Facing::Orientation)
        }
        (false, true, false) => {
            let message = format!("{} has `up` but no `tangent`", entry.label);
            let doc = entry.keys.get("tangent").map_or("", |key| key.doc);
            entry.fault_at("up", message, format!("add `tangent`: {doc}"));
            Facing::Left
        }
        (_, _, true) => {
            let message = format!("{} has `orientation` beside `tangent` or `up`", entry.label);
            entry.fault_at("orientation", message, "give either `orientation`, or `tangent` and `up`");
            Facing::Left
        }
    }
}

/// A part of a branch.
pub(crate) fn stretch(entry: &Entry<'_>, names: &Names<'_>) -> Option<Stretch> {
    let branch = entry.word("branch");
    if names.vertices.is_empty() {
        return None; // The branches have their own fault.
    }
    let branch = branch?;
    let index = *lookup(entry, "branch", &names.branches, branch, entry.span_of("branch"))?;
    let [from, to] = range(entry, branch, (*names.lengths.get(index)?)?)?;
    Some(Stretch { branch: index, from, to })
}

/// Arc lengths `from` and `to` on a branch of this length (m); without them from its start, or to its end.
pub(crate) fn range(entry: &Entry<'_>, branch: &str, length: f64) -> Option<[f64; 2]> {
    let (from, to) = (entry.number("from"), entry.number("to"));
    let mut ends = [0.0, length];
    for (end, (key, s)) in ends.iter_mut().zip([("from", from), ("to", to)]) {
        if entry.has(key) {
            *end = along(entry, key, s?, branch, length)?;
        }
    }
    let [from, to] = ends;
    if to - from <= 1e-9 * length {
        let message = format!("the span of branch \"{branch}\" from {from} m to {to} m has no length");
        entry.fault_here(message, "`from` comes before `to`, both in arc length along the branch");
        return None;
    }
    Some([from, to])
}

/// An arc length that is on its branch.
fn along(entry: &Entry<'_>, key: &str, s: f64, branch: &str, length: f64) -> Option<f64> {
    if s < -1e-9 * length || s > length * (1.0 + 1e-9) {
        let message = format!("`{key}` = {s} m is outside branch \"{branch}\"");
        entry.fault_at(key, message, format!("give an arc length from 0 to {length} m"));
        return None;
    }
    Some(s.clamp(0.0, length))
}
