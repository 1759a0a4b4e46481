//! Reads branches.

use super::entry::Entry;
use super::kinds;
use super::names::{Names, Vertex, lookup, register};
use super::places;
use crate::format::limits::MAX_COUNT;
use crate::scenario::{Branch, Division, SectionPart};
use wireloom_core::Vector;
use wireloom_core::identity::Identified;

/// A branch. Marks the names as broken if something that it needs is missing.
pub(crate) fn branch<'a>(entry: &Entry<'a>, names: &mut Names<'a>) -> Branch {
    let index = names.lengths.len();
    let kind = kinds::read(entry);
    let name = entry.word("name").filter(|name| register(entry, entry.keys.what, &mut names.branches, name, index));
    names.branch_names.push(name.unwrap_or_default());
    let (from, to) = (entry.word("from"), entry.word("to"));
    for (key, vertex, starts_here) in [("from", from, true), ("to", to, false)] {
        let Some(vertex) = vertex else { continue };
        let span = entry.span_of(key);
        names.vertices.entry(vertex).or_insert(Vertex { ends: Vec::new(), span }).ends.push((index, starts_here));
    }
    if let (Some(from), Some(to)) = (from, to)
        && from == to
    {
        let message = format!("{} begins and ends at the same vertex \"{from}\"", entry.label);
        entry.fault_at("to", message, "make two branches of the loop, with a joint between them");
        names.broken = true;
    }
    let section = entry
        .word("section")
        .and_then(|section| lookup(entry, "section", &names.sections, section, entry.span_of("section")).copied());
    let length = entry.number("length");
    names.lengths.push(length);
    names.identify(entry, Identified::Branch, name);
    names.broken |= kind.is_none() || name.is_none() || from.is_none() || to.is_none();
    names.broken |= section.is_none() || length.is_none();
    let (rod, parameters) = kind.map(|kind| (kind.name, kind.parameters)).unwrap_or_default();
    Branch {
        name: name.unwrap_or_default().to_owned(),
        vertices: [from, to].map(|vertex| vertex.unwrap_or_default().to_owned()),
        section: section.unwrap_or_default(),
        parts: length.map_or_else(Vec::new, |length| parts(entry, length, names)),
        length: length.unwrap_or(1.0),
        division: division(entry, length, names),
        sizes: Vec::new(),
        nodes: Vec::new(),
        shares: Vec::new(),
        rod,
        parameters,
        curvature: entry.vector("curvature").unwrap_or_default(),
        path: path(entry, "path"),
        own_drawn: path(entry, "drawn"),
        spans: entry.spans(),
    }
}

/// Parts of a branch of this length (m) that have another section, in the order of arc length.
fn parts(entry: &Entry<'_>, length: f64, names: &mut Names<'_>) -> Vec<SectionPart> {
    let branch = entry.word("name").unwrap_or_default();
    let mut parts: Vec<(SectionPart, Entry<'_>)> = Vec::new();
    for own in entry.entries("sections") {
        let section = own.word("section");
        let section =
            section.and_then(|name| lookup(&own, "section", &names.sections, name, own.span_of("section")).copied());
        match (section, places::range(&own, branch, length)) {
            (Some(section), Some(range)) => parts.push((SectionPart { section, range }, own)),
            _ => names.broken = true,
        }
    }
    parts.sort_by(|(a, _), (b, _)| a.range[0].total_cmp(&b.range[0]));
    for pair in parts.windows(2) {
        let [(before, _), (after, own)] = pair else { continue };
        if after.range[0] < before.range[1] - Branch::COINCIDENT * length {
            let message = format!(
                "parts of {} lie over each other: one ends at {} m, the next one begins at {} m",
                entry.label, before.range[1], after.range[0]
            );
            let help = "one part ends before the next one begins; for coverings over each other write a section with \
                        both";
            own.fault_here(message, help);
            names.broken = true;
        }
    }
    parts.into_iter().map(|(part, _)| part).collect()
}

fn division(entry: &Entry<'_>, length: Option<f64>, names: &mut Names<'_>) -> Division {
    const DEFAULT: Division = Division::Segments(1);
    let (segments, longest) = (entry.count("segments"), entry.number("max_segment"));
    let many = segments.map(|n| n as f64).or(length.zip(longest).map(|(length, longest)| length / longest));
    names.segments += many.unwrap_or(0.0);
    if names.segments > MAX_COUNT as f64 {
        let message = format!("with {} the harness has more than {} segments", entry.label, MAX_COUNT);
        let key = if entry.has("segments") { "segments" } else { "max_segment" };
        entry.fault_at(key, message, "divide the branches less finely");
        names.segments = 0.0;
        names.broken = true;
        return DEFAULT;
    }
    match (entry.has("segments"), entry.has("max_segment")) {
        (true, false) => segments.map_or(DEFAULT, Division::Segments),
        (false, true) => match longest {
            Some(longest) if names.by_accuracy => Division::ByAccuracy { longest },
            Some(longest) => Division::MaxSegment(longest),
            None => DEFAULT,
        },
        (true, true) => {
            let message = format!("{} has both `segments` and `max_segment`", entry.label);
            entry.fault_at("max_segment", message, "leave one of them out");
            DEFAULT
        }
        (false, false) if names.by_accuracy => Division::ByAccuracy { longest: f64::INFINITY },
        (false, false) => {
            let message = format!("{} has neither `segments` nor `max_segment`", entry.label);
            entry.fault_here(
                message,
                "add one of them, such as segments = 40 or max_segment = \"10 mm\", or [mesh] with accuracy = \"2 %\"",
            );
            DEFAULT
        }
    }
}

fn path(entry: &Entry<'_>, key: &str) -> Vec<Vector> {
    let path = entry.points(key).unwrap_or_default();
    if let Some(k) = path.windows(2).position(|pair| pair[0] == pair[1]) {
        let message = format!("points {} and {} of `{key}` of {} coincide", k + 1, k + 2, entry.label);
        entry.fault_at(key, message, "leave one of them out");
    }
    path
}
