//! Reads a whole scenario, from the top: sections, branches, then what refers to them.
//!
//! A value at fault is replaced by a harmless one and the reading goes on, so that all faults are found. What comes
//! out is used only where there are none.

use crate::catalogue::Types;
use crate::keys;
use crate::library::Library;
use crate::reader::{Entry, Reader, Span};
use crate::scenario::{Branch, Division, Joint, Output, Scenario};
use crate::{fixings, joints, kinds, obstacles, operations, plugins, sections, sequence, sweep};
use std::collections::{BTreeMap, BTreeSet};
use toml::de::DeTable;
use wireloom_core::Vector;
use wireloom_core::obstacle::ContactSettings;

/// What is known of a vertex.
pub(crate) struct Vertex {
    /// Branches that end here, and whether they start here.
    pub ends: Vec<(usize, bool)>,
    /// Where it is first named.
    pub span: Span,
}

/// Names read so far, with what later entries need to know of them.
#[derive(Default)]
pub(crate) struct Names<'a> {
    pub sections: BTreeMap<&'a str, usize>,
    pub branches: BTreeMap<&'a str, usize>,
    /// Length of each branch, m; `None` where it is at fault.
    pub lengths: Vec<Option<f64>>,
    pub vertices: BTreeMap<&'a str, Vertex>,
    pub joints: BTreeMap<&'a str, usize>,
    pub constraints: BTreeMap<&'a str, usize>,
    /// Types of fixings.
    pub types: Types,
    /// How many constraints there are; some may have had the same name one after the other.
    pub fixings: usize,
    /// Constraints that have let go, and whose names may be taken again.
    pub let_go: BTreeSet<&'a str>,
    pub loads: BTreeMap<&'a str, usize>,
    pub obstacles: BTreeMap<&'a str, usize>,
    /// Segments so far, roughly.
    pub segments: f64,
    /// Whether a name leads nowhere, so that the harness cannot be put together.
    pub broken: bool,
}

/// Reads a scenario; the second value says whether all names lead somewhere.
pub(crate) fn read(reader: &Reader<'_>, table: &DeTable<'_>) -> (Scenario, bool) {
    let root = Entry::new(reader, table, 0..0, &keys::SCENARIO, "the scenario".to_owned());
    version(&root);
    if let Some(entry) = root.entry("plugins") {
        plugins::read(&entry);
    }
    let mut names = Names::default();
    let name = root.word("name").unwrap_or("harness").to_owned();
    let gravity = root.vector("gravity").unwrap_or(Vector::new(0.0, 0.0, -9.81));
    let library = Library::of(&root);
    let entries = root.named_entries("sections");
    let (sections, by_rule): (Vec<_>, Vec<_>) =
        entries.iter().map(|(name, entry)| sections::section(name, entry, &library, &mut names)).unzip();
    names.types = library.fixings;
    let entries = root.entries("branches");
    let branches: Vec<Branch> = entries.iter().map(|entry| branch(entry, &mut names)).collect();
    if entries.is_empty() {
        if root.has("branches") {
            root.fault_at("branches", "`branches` is empty", "a harness has at least one [[branches]] entry");
        }
        names.broken = true;
    }
    let entries = root.entries("joints");
    let joints: Vec<Joint> = entries.iter().filter_map(|entry| joints::joint(entry, &mut names)).collect();
    joints::refuse_dangling(&root, &mut names);
    let entries = root.entries("constraints");
    let mut constraints: Vec<_> =
        entries.iter().filter_map(|entry| fixings::constraint(entry, true, &mut names)).collect();
    let entries = root.entries("loads");
    let loads: Vec<_> = entries.iter().filter_map(|entry| fixings::load(entry, &mut names)).collect();
    let initial = root.entry("initial").and_then(|entry| sequence::initial(&entry, &mut names));
    let minimiser = sequence::minimiser(&root, &mut names);
    let lengths: f64 = branches.iter().map(|branch| branch.length).sum();
    let entries = root.entries("obstacles");
    let obstacles = entries.iter().filter_map(|entry| obstacles::obstacle(entry, lengths, &mut names)).collect();
    let contact = root.entry("contact").map_or_else(ContactSettings::default, |entry| obstacles::contact(&entry));
    let entries = root.entries("steps");
    let steps = sequence::steps(&entries, &mut constraints, &mut names);
    operations::settle_nearest(&mut constraints, &loads, &branches);
    let sweep = root.entry("sweep").and_then(|entry| sweep::sweep(&entry, &names));
    let output = root.entry("output").map_or(DEFAULT_OUTPUT, |entry| output(&entry));
    let scenario = Scenario {
        name,
        gravity,
        sections,
        by_rule: by_rule.into_iter().flatten().collect(),
        branches,
        joints,
        constraints,
        loads,
        obstacles,
        contact,
        initial,
        minimiser,
        steps,
        step_spans: entries.iter().map(|entry| entry.span.clone()).collect(),
        sweep,
        output,
    };
    (scenario, !names.broken)
}

const DEFAULT_OUTPUT: Output = Output {
    increments: false,
    csv: false,
    vtk: false,
    picture: true,
    clearance: false,
    report: false,
    gltf: false,
    swept: None,
};

fn output(entry: &Entry<'_>) -> Output {
    Output {
        increments: entry.flag("increments").unwrap_or(DEFAULT_OUTPUT.increments),
        csv: entry.flag("csv").unwrap_or(DEFAULT_OUTPUT.csv),
        vtk: entry.flag("vtk").unwrap_or(DEFAULT_OUTPUT.vtk),
        picture: entry.flag("picture").unwrap_or(DEFAULT_OUTPUT.picture),
        clearance: entry.flag("clearance").unwrap_or(DEFAULT_OUTPUT.clearance),
        report: entry.flag("report").unwrap_or(DEFAULT_OUTPUT.report),
        gltf: entry.flag("gltf").unwrap_or(DEFAULT_OUTPUT.gltf),
        swept: entry.number("swept"),
    }
}

fn version(root: &Entry<'_>) {
    let Some(node) = root.node("schema") else { return };
    let number = root.reader.count("schema", node, 0, usize::MAX);
    if let Some(number) = number
        && number != 1
    {
        let message = format!("`schema` = {number} is not known to this program");
        root.fault_at("schema", message, "it reads version 1 of the format: write schema = 1");
    }
}

/// Gives a name of the family to an entry; false, with a fault, where it is taken.
#[must_use]
pub(crate) fn register<'a>(
    entry: &Entry<'a>,
    what: &str,
    family: &mut BTreeMap<&'a str, usize>,
    name: &'a str,
    index: usize,
) -> bool {
    if family.contains_key(name) {
        let message = format!("there is another {what} of the name \"{name}\"");
        entry.fault_at("name", message, "give this one a name of its own");
        return false;
    }
    family.insert(name, index);
    true
}

/// Looks a name up; notes a fault where it is not known.
pub(crate) fn lookup<'m, T>(
    entry: &Entry<'_>,
    what: &str,
    family: &'m BTreeMap<&str, T>,
    name: &str,
    span: Span,
) -> Option<&'m T> {
    let found = family.get(name);
    if found.is_none() {
        let help = crate::fault::did_you_mean(name, family.keys().copied());
        entry.reader.fault(span, format!("unknown {what} \"{name}\" in {}", entry.label), help);
    }
    found
}

fn branch<'a>(entry: &Entry<'a>, names: &mut Names<'a>) -> Branch {
    let index = names.lengths.len();
    let kind = kinds::read(entry);
    let name = entry.word("name").filter(|name| register(entry, entry.keys.what, &mut names.branches, name, index));
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
    names.broken |= kind.is_none() || name.is_none() || from.is_none() || to.is_none();
    names.broken |= section.is_none() || length.is_none();
    let (rod, parameters) = kind.map(|kind| (kind.name, kind.parameters)).unwrap_or_default();
    Branch {
        name: name.unwrap_or_default().to_owned(),
        vertices: [from, to].map(|vertex| vertex.unwrap_or_default().to_owned()),
        section: section.unwrap_or_default(),
        length: length.unwrap_or(1.0),
        division: division(entry, length, names),
        rod,
        parameters,
        curvature: entry.vector("curvature").unwrap_or_default(),
        path: path(entry),
        spans: entry.spans(),
    }
}

fn division(entry: &Entry<'_>, length: Option<f64>, names: &mut Names<'_>) -> Division {
    const DEFAULT: Division = Division::Segments(1);
    let (segments, longest) = (entry.count("segments"), entry.number("max_segment"));
    let many = segments.map(|n| n as f64).or(length.zip(longest).map(|(length, longest)| length / longest));
    names.segments += many.unwrap_or(0.0);
    if names.segments > keys::MANY as f64 {
        let message = format!("with {} the harness has more than {} segments", entry.label, keys::MANY);
        let key = if entry.has("segments") { "segments" } else { "max_segment" };
        entry.fault_at(key, message, "divide the branches less finely");
        names.segments = 0.0;
        names.broken = true;
        return DEFAULT;
    }
    match (entry.has("segments"), entry.has("max_segment")) {
        (true, false) => segments.map_or(DEFAULT, Division::Segments),
        (false, true) => longest.map_or(DEFAULT, Division::MaxSegment),
        (true, true) => {
            let message = format!("{} has both `segments` and `max_segment`", entry.label);
            entry.fault_at("max_segment", message, "leave one of them out");
            DEFAULT
        }
        (false, false) => {
            let message = format!("{} has neither `segments` nor `max_segment`", entry.label);
            entry.fault_here(message, "add one of them, such as segments = 40 or max_segment = \"10 mm\"");
            DEFAULT
        }
    }
}

fn path(entry: &Entry<'_>) -> Vec<Vector> {
    let path = entry.points("path").unwrap_or_default();
    if let Some(k) = path.windows(2).position(|pair| pair[0] == pair[1]) {
        let message = format!("points {} and {} of `path` of {} coincide", k + 1, k + 2, entry.label);
        entry.fault_at("path", message, "leave one of them out");
    }
    path
}
