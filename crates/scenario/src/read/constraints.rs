//! Reads constraints.

use super::entry::Entry;
use super::fixing_types::{FixingType, of_part};
use super::kinds;
use super::mechanisms::refuse_turning;
use super::names::{Names, register};
use super::places::{attachment, facing, stretch};
use crate::attachment::At;
use crate::format::keys;
use crate::scenario::{Constraint, Facing};
use toml::Spanned;
use toml::de::DeValue;
use wireloom_core::constraint::{Limits, Slide, SpanUse};
use wireloom_core::identity::Identified;
use wireloom_core::{HoldWord, Vector};

/// A constraint; `nearest`: whether it may attach to the nearest place of a branch. `None` if it has no name of its
/// own; marks the names as broken if anything is faulty.
pub(crate) fn constraint<'a>(
    entry: &Entry<'a>,
    from_start: bool,
    nearest: bool,
    names: &mut Names<'a>,
) -> Option<Constraint> {
    let before = entry.reader.fault_count();
    let of_part = type_of_part(entry, names).map(str::to_owned);
    let (kind, of) =
        kinds::read_among(entry, &names.types, of_part.as_deref()).map(|(kind, of)| (kind, of.cloned())).unzip();
    let of = of.flatten();
    let name = entry.word("name").filter(|name| begin(entry, name, names));
    // Not every entry has every key of a constraint: a grasp has no position, for example.
    let own = |key: &str| entry.keys.get(key).is_some();
    if own("part") {
        names.identify(entry, Identified::Constraint, name);
    }
    let given = entry.one_or_more("at");
    let places: Vec<_> = given.iter().filter_map(|at| attachment(at, names, nearest)).collect();
    let span = if own("span") { entry.entry("span") } else { None };
    let span = span.map(|span| stretch(&span, names));
    let attached = places.len() == given.len() && places.len() + usize::from(span.is_some()) > 0 && span != Some(None);
    let at = places.first().map(|place| place.0);
    let position = if own("position") { entry.vector("position") } else { None };
    let facing = if own("tangent") { facing(entry) } else { Facing::Left };
    let mount = names.mount(entry);
    let hold = hold(entry).or_else(|| of.as_ref()?.hold.clone());
    let free_axis = if own("free_axis") { entry.direction("free_axis").map(|axis| *axis) } else { None };
    let rails = if own("rail") { rails(entry) } else { Vec::new() };
    let slide = slide(entry, of.as_ref(), at, names);
    if let Some(mount) = mount {
        let of_rails = rails.iter().map(|rail| ("rail", *rail));
        let directions: Vec<_> = free_axis.iter().map(|axis| ("free_axis", *axis)).chain(of_rails).collect();
        refuse_turning(entry, mount, &directions, names);
    }
    let limits = limits(entry, &of.as_ref().map(|of| of.limits).unwrap_or_default());
    for need in of.iter().flat_map(|of| &of.needs) {
        refuse_missing_need(entry, need);
    }
    if let Some(kind) = &kind {
        refuse_count(entry, &kind.kind, places.len(), span.is_some());
    }
    names.broken |= entry.reader.fault_count() > before || !attached || kind.is_none();
    if let (Some(name), Some(kind)) =
        (name, kind.as_ref().and_then(|kind| entry.reader.registry.constraint(&kind.kind)))
    {
        names.outputs.insert(name, kind.outputs.iter().map(|output| output.name.clone()).collect());
    }
    let (called, kind, parameters) = kind.map(|kind| (kind.name, kind.kind, kind.parameters)).unwrap_or_default();
    let whole = matches!(facing, Facing::Orientation(_));
    Some(Constraint {
        name: name?.to_owned(),
        kind,
        called,
        parameters,
        at: places.iter().map(|place| place.0).collect(),
        span: span.flatten(),
        mount,
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

/// The kind of a clip that its part number may say more about.
const GENERIC: &str = "collar";

/// The type of the part number of a constraint. It takes the place of a collar, the generic clip. A type that the
/// constraint names goes before it; another kind must be that of the type.
fn type_of_part<'n>(entry: &Entry<'_>, names: &'n Names<'_>) -> Option<&'n str> {
    entry.keys.get("part")?;
    let part = entry.text("part")?;
    let found = match of_part(&names.types, part) {
        Ok(found) => found?,
        Err(several) => {
            let places: Vec<String> =
                several.iter().map(|(name, own)| format!("{} (\"{name}\", \"{}\")", own.place, own.text)).collect();
            let message =
                format!("the part number \"{part}\" of {} fits several types: {}", entry.label, places.join(", "));
            entry.fault_at("part", message, "give the number itself to one of them, or make the patterns narrower");
            return None;
        }
    };
    let of = names.types.get(found)?.as_ref()?;
    let (key, _, default) = entry.keys.kind()?;
    let kind = if entry.has(key) { entry.text(key) } else { default }?;
    if names.types.contains_key(kind) || kind == GENERIC || kind == of.kind {
        return Some(found);
    }
    let message = format!(
        "{} has the part number \"{part}\", which is that of the type \"{found}\", a {}, and kind = \"{kind}\"",
        entry.label, of.kind
    );
    entry.fault_at(key, message, format!("write kind = \"{found}\", or correct the part number"));
    None
}

/// Gives a constraint its name; the name of a released one may be used again.
fn begin<'a>(entry: &Entry<'a>, name: &'a str, names: &mut Names<'a>) -> bool {
    if names.let_go.remove(name) {
        names.constraints.remove(name);
    }
    let free = register(entry, keys::CONSTRAINT.what, &mut names.constraints, name, names.constraint_count);
    names.constraint_count += usize::from(free);
    free
}

/// Refuses a constraint that does not attach to as many places as its kind does.
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
        let message = format!("no cable can slide through {}: it does not act on one place alone", entry.label);
        entry.fault_at("slide", message, "leave `slide` out");
    }
}

/// The load limits of an entry; `otherwise`: those that it does not give.
pub(crate) fn limits(entry: &Entry<'_>, otherwise: &Limits) -> Limits {
    // A grasp has no insertion force.
    let number = |key: &str| if entry.keys.get(key).is_some() { entry.number(key) } else { None };
    Limits {
        pull_out_force: number("pull_out_force").or(otherwise.pull_out_force),
        max_moment: number("max_moment").or(otherwise.max_moment),
        insertion_force: number("insertion_force").or(otherwise.insertion_force),
    }
}

/// Refuses a constraint without a key that its type of fixing needs.
fn refuse_missing_need(entry: &Entry<'_>, need: &str) {
    if entry.has(need) {
        return;
    }
    let kind = entry.word("kind").unwrap_or_default();
    let message = format!("{} has no `{need}`, which a \"{kind}\" needs", entry.label);
    let help = match entry.keys.get(need) {
        Some(key) => format!("add `{need}`: {}", key.doc),
        None => format!("begin it with `add`, which has the key `{need}`, and `move` it"),
    };
    entry.fault_at("kind", message, help);
}

/// The freedoms that the entry lists.
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
        let message = format!("`hold` of {} is empty", entry.label);
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

/// The sliding of the cable through a constraint, which needs cable on both sides.
fn slide(entry: &Entry<'_>, of: Option<&FixingType>, at: Option<At>, names: &Names<'_>) -> Option<Slide> {
    let otherwise = of.and_then(|of| of.slide);
    let own = entry.keys.get("slide").is_some();
    let slides = if own { entry.flag("slide") } else { None }.unwrap_or(otherwise.is_some());
    let friction = if own { entry.number("friction") } else { None };
    if entry.has("friction") && !slides {
        let message = format!("{} has `friction`, but the cable does not slide", entry.label);
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
            let message = format!("`slide` = true of {}, but it is at {place}: no cable can slide there", entry.label);
            entry.fault_at("slide", message, format!("{within}, or leave `slide` out"));
        } else {
            let message = format!("{} lets the cable slide, but is at {place}: no cable can slide there", entry.label);
            entry.fault_at("kind", message, format!("{within}, choose another kind, or add slide = false"));
        }
    }
    Some(Slide { friction: friction.or(otherwise.map(|slide| slide.friction)).unwrap_or(0.0) })
}
