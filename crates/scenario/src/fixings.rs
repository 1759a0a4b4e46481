//! Reads what attaches to the harness: constraints and loads, where they attach, which way they face.

use crate::catalogue::FixingType;
use crate::document::{Names, lookup, register};
use crate::reader::Entry;
use crate::scenario::{At, Constraint, Facing, Load, NOWHERE, Stretch};
use crate::{keys, kinds};
use toml::Spanned;
use toml::de::DeValue;
use wireloom_core::constraint::{Limits, Slide, SpanUse};
use wireloom_core::rotation::frame_from;
use wireloom_core::{HoldWord, Vector};

/// A constraint. `None` where it has no name of its own; the names are broken where anything is at fault.
pub(crate) fn constraint<'a>(entry: &Entry<'a>, from_start: bool, names: &mut Names<'a>) -> Option<Constraint> {
    let before = entry.reader.fault_count();
    let (kind, of) = kinds::read_among(entry, &names.types).map(|(kind, of)| (kind, of.cloned())).unzip();
    let of = of.flatten();
    let name = entry.word("name").filter(|name| begin(entry, name, names));
    // Not every entry has every key of a constraint: a hand takes hold where the cable is.
    let own = |key: &str| entry.keys.get(key).is_some();
    let clip = entry.keys.what == keys::CLIP.what;
    let given = entry.one_or_more("at");
    let places: Vec<_> = given.iter().filter_map(|at| attachment(at, names, clip)).collect();
    let span = if own("span") { entry.entry("span") } else { None };
    let span = span.map(|span| stretch(&span, names));
    let attached = places.len() == given.len() && places.len() + usize::from(span.is_some()) > 0 && span != Some(None);
    let at = places.first().map(|place| place.0);
    let position = if own("position") { entry.vector("position") } else { None };
    let facing = if own("tangent") { facing(entry) } else { Facing::Left };
    let hold = hold(entry).or_else(|| of.as_ref()?.hold.clone());
    let free_axis = if own("free_axis") { entry.direction("free_axis").map(|axis| *axis) } else { None };
    let rails = if own("rail") { rails(entry) } else { Vec::new() };
    let slide = slide(entry, of.as_ref(), at, names);
    let limits = limits(entry, &of.as_ref().map(|of| of.limits).unwrap_or_default());
    for need in of.iter().flat_map(|of| &of.needs) {
        refuse_unmet(entry, need);
    }
    if let Some(kind) = &kind {
        refuse_count(entry, &kind.kind, places.len(), span.is_some());
    }
    names.broken |= entry.reader.fault_count() > before || !attached || kind.is_none();
    let (called, kind, parameters) = kind.map(|kind| (kind.name, kind.kind, kind.parameters)).unwrap_or_default();
    let whole = matches!(facing, Facing::Orientation(_));
    Some(Constraint {
        name: name?.to_owned(),
        kind,
        called,
        parameters,
        at: places.iter().map(|place| place.0).collect(),
        span: span.flatten(),
        position,
        facing,
        tangent_given: whole || matches!(facing, Facing::Tangent(_)),
        up_given: whole,
        hold,
        free_axis,
        rails,
        slide,
        limits,
        nearest: places.iter().any(|place| place.1),
        from_start,
        spans: entry.spans(),
    })
}

/// Gives a constraint its name; that of one that has let go may be taken again.
fn begin<'a>(entry: &Entry<'a>, name: &'a str, names: &mut Names<'a>) -> bool {
    if names.let_go.remove(name) {
        names.constraints.remove(name);
    }
    let free = register(entry, keys::CONSTRAINT.what, &mut names.constraints, name, names.fixings);
    names.fixings += usize::from(free);
    free
}

/// Refuses what does not attach to as much as its kind does.
fn refuse_count(entry: &Entry<'_>, kind: &str, stations: usize, span: bool) {
    let Some(attaches) = entry.reader.registry.constraint(kind).map(|kind| &kind.attaches) else { return };
    if attaches.span == SpanUse::Never && span {
        let message = format!("{} has a `span`, and its kind \"{kind}\" does not act along one", entry.label);
        entry.fault_at("span", message, "leave `span` out, or choose a kind that acts along a span");
    } else if attaches.span == SpanUse::Always && !span && !entry.has("span") {
        let message = format!("{} has no `span`, along which its kind \"{kind}\" acts", entry.label);
        entry.fault_at("at", message, "add span = { branch = \"…\", from = …, to = … }");
    } else if !attaches.stations.contains(&stations) && (stations > 0 || span) {
        let places = |count: usize| if count == 1 { "one place".to_owned() } else { format!("{count} places") };
        let help = match (*attaches.stations.start(), *attaches.stations.end()) {
            (_, 0) => "leave `at` out".to_owned(),
            (least, most) if least == most => format!("give {} in `at`", places(least)),
            (least, usize::MAX) => format!("give at least {} in `at`", places(least)),
            (least, most) => format!("give {least} to {} in `at`", places(most)),
        };
        let (key, message) = match stations {
            0 => ("span", format!("{} attaches to no place, and its kind \"{kind}\" does", entry.label)),
            _ => ("at", format!("{} attaches to {}, and its kind \"{kind}\" does not", entry.label, places(stations))),
        };
        entry.fault_at(key, message, help);
    }
    if entry.keys.get("slide").is_some() && entry.flag("slide") == Some(true) && (stations > 1 || span) {
        let message = format!("no cable can run through {}: it does not act on one place alone", entry.label);
        entry.fault_at("slide", message, "leave `slide` out");
    }
}

/// A part of a branch.
pub(crate) fn stretch(entry: &Entry<'_>, names: &Names<'_>) -> Option<Stretch> {
    let (branch, from, to) = (entry.word("branch"), entry.number("from"), entry.number("to"));
    if names.vertices.is_empty() {
        return None; // The branches have their own fault.
    }
    let branch = branch?;
    let index = *lookup(entry, "branch", &names.branches, branch, entry.span_of("branch"))?;
    let length = (*names.lengths.get(index)?)?;
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
    Some(Stretch { branch: index, from, to })
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

/// What is borne, where the entry says nothing else.
pub(crate) fn limits(entry: &Entry<'_>, otherwise: &Limits) -> Limits {
    // A hand that takes hold is not pushed home.
    let number = |key: &str| if entry.keys.get(key).is_some() { entry.number(key) } else { None };
    Limits {
        pull_out_force: number("pull_out_force").or(otherwise.pull_out_force),
        max_moment: number("max_moment").or(otherwise.max_moment),
        insertion_force: number("insertion_force").or(otherwise.insertion_force),
    }
}

/// Notes that a key is not given which the type of fixing needs.
fn refuse_unmet(entry: &Entry<'_>, need: &str) {
    if entry.has(need) {
        return;
    }
    let kind = entry.word("kind").unwrap_or_default();
    let message = format!("{} has no `{need}`, which a \"{kind}\" needs", entry.label);
    let help = match entry.keys.get(need) {
        Some(key) => format!("add `{need}`: {}", key.doc),
        None => format!("begin it by `add`, where it can have `{need}`, and `move` it"),
    };
    entry.fault_at("kind", message, help);
}

/// The freedoms that are spelt out.
pub(crate) fn hold(entry: &Entry<'_>) -> Option<Vec<HoldWord>> {
    if !entry.has("hold") {
        return None;
    }
    let words: Vec<HoldWord> = entry
        .choices("hold")
        .into_iter()
        .map(|word| match word {
            "position" => HoldWord::Position,
            "tangent" => HoldWord::Tangent,
            _ => HoldWord::Twist,
        })
        .collect();
    if matches!(entry.node("hold").map(Spanned::get_ref), Some(DeValue::Array(list)) if list.is_empty()) {
        let message = format!("`hold` of {} is empty: it would hold nothing", entry.label);
        entry.fault_at("hold", message, "name some of \"position\", \"tangent\", \"twist\", or leave `hold` out");
    }
    Some(words)
}

fn rails(entry: &Entry<'_>) -> Vec<Vector> {
    let rails: Vec<Vector> = entry.directions("rail").unwrap_or_default().into_iter().map(|rail| *rail).collect();
    let parallel = matches!(rails.as_slice(), [a, b] if a.cross(b).norm() < 1e-9);
    if rails.len() > 2 || parallel {
        let what = if parallel { "two parallel directions" } else { "more than two directions" };
        let message = format!("`rail` of {} has {what}", entry.label);
        entry.fault_at("rail", message, "give one direction for a line, two different ones for a plane");
    }
    rails
}

/// Whether and how the cable runs through a fixing; that needs cable on both sides of it.
fn slide(entry: &Entry<'_>, of: Option<&FixingType>, at: Option<At>, names: &Names<'_>) -> Option<Slide> {
    let otherwise = of.and_then(|of| of.slide);
    let own = entry.keys.get("slide").is_some();
    let slides = if own { entry.flag("slide") } else { None }.unwrap_or(otherwise.is_some());
    let friction = if own { entry.number("friction") } else { None };
    if entry.has("friction") && !slides {
        let message = format!("{} has `friction` but lets no cable through", entry.label);
        entry.fault_at("friction", message, "add slide = true, or leave `friction` out");
    }
    if !slides {
        return None;
    }
    let place = match at {
        Some(At::Joint(_)) => Some("a joint"),
        Some(At::Branch { branch, s }) if s == 0.0 || names.lengths.get(branch) == Some(&Some(s)) => Some("an end"),
        _ => None,
    };
    if let Some(place) = place {
        let within = "attach it within a branch, { branch = \"…\", s = … }";
        if entry.has("slide") {
            let message = format!("`slide` = true of {}, which is at {place}: no cable can run through", entry.label);
            entry.fault_at("slide", message, format!("{within}, or leave `slide` out"));
        } else {
            let message = format!("{} lets the cable through, and is at {place}: none can run through", entry.label);
            entry.fault_at("kind", message, format!("{within}, choose another kind, or add slide = false"));
        }
    }
    Some(Slide { friction: friction.or(otherwise.map(|slide| slide.friction)).unwrap_or(0.0) })
}

/// A dead load. `None` where it has no name of its own; the names are broken where it attaches to nothing.
pub(crate) fn load<'a>(entry: &Entry<'a>, names: &mut Names<'a>) -> Option<Load> {
    let index = names.loads.len();
    let name = entry.word("name").filter(|name| register(entry, entry.keys.what, &mut names.loads, name, index));
    let at = entry.entry("at").and_then(|at| attachment(&at, names, false)).map(|place| place.0);
    let force = entry.vector("force").unwrap_or_default();
    let moment = entry.vector("moment").unwrap_or_default();
    let factor = entry.number("factor").unwrap_or(1.0);
    if !entry.has("force") && !entry.has("moment") {
        let message = format!("{} has neither `force` nor `moment`", entry.label);
        entry.fault_here(message, "give one of them, such as force = [0, 0, -2] in N");
    }
    names.broken |= name.is_none() || at.is_none();
    let at = at.unwrap_or(NOWHERE);
    Some(Load { name: name?.to_owned(), at, force, moment, factor, spans: entry.spans() })
}

/// Where something attaches, and whether that is the nearest place of a branch, which is known only when it begins.
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
            at.fault_here(format!("{} does not say one place", at.label), help);
            None
        }
    }
}

fn free_end(at: &Entry<'_>, end: &str, names: &Names<'_>) -> Option<At> {
    let vertex = lookup(at, "end", &names.vertices, end, at.span_of("end"))?;
    let [(branch, starts_here)] = vertex.ends.as_slice() else {
        let message = format!("\"{end}\" is no free end: {} branches meet there", vertex.ends.len());
        at.fault_at("end", message, format!("write {{ joint = \"{end}\" }}, or {{ branch = …, s = … }}"));
        return None;
    };
    let length = (*names.lengths.get(*branch)?)?;
    Some(At::Branch { branch: *branch, s: if *starts_here { 0.0 } else { length } })
}

fn joint_place(at: &Entry<'_>, joint: &str, names: &Names<'_>) -> Option<At> {
    if !names.joints.contains_key(joint) && names.vertices.get(joint).is_some_and(|vertex| vertex.ends.len() == 1) {
        let message = format!("\"{joint}\" is no joint: only one branch ends there");
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
