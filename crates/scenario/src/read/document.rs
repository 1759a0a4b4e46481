//! Reads a whole scenario: sections, branches, then the entries that refer to them.
//!
//! A faulty value is replaced by a harmless one and reading continues, so that all faults are found. The result is used
//! only if there are none.

use super::branches::branch;
use super::constraints::constraint;
use super::entry::Entry;
use super::initial::initial;
use super::library::Library;
use super::loads::load;
use super::minimiser::minimiser;
use super::names::Names;
use super::nearest::place_nearest;
use super::optimise::optimise;
use super::reader::Reader;
use super::requirements::{Named, marker, requirement};
use super::steps::{Pull, Spin, steps};
use super::sweep::sweep;
use super::{identities, joints, mechanisms, obstacles, plugins, sections};
use crate::format::keys;
use crate::output::{self, Output};
use crate::scenario::{Branch, ByRule, Joint, Scenario};
use std::collections::BTreeMap;
use toml::de::DeTable;
use wireloom_core::Vector;
use wireloom_core::conditions::RotatingAxes;
use wireloom_core::identity::Identities;
use wireloom_core::obstacle::ContactSettings;

/// Reads a scenario; the second value says whether all names refer to something.
pub(crate) fn read(reader: &Reader<'_>, table: &DeTable<'_>) -> (Scenario, bool) {
    let root = Entry::new(reader, table, 0..0, &keys::SCENARIO, "the scenario".to_owned());
    version(&root);
    if let Some(entry) = root.entry("plugins") {
        plugins::read(&entry);
    }
    let mut names = Names::default();
    let name = root.word("name").unwrap_or("harness").to_owned();
    let mut pull = Pull { gravity: Vector::new(0.0, 0.0, -9.81), acceleration: Vector::zeros() };
    pull.read(&root);
    let gravity = pull.total();
    let spin = root.entry("rotation").map(|entry| Spin::read(&entry));
    let rotation = spin.map_or_else(RotatingAxes::default, Spin::at_the_beginning);
    let library = Library::of(&root);
    let entries = root.named_entries("sections");
    let (sections, by_rule): (Vec<_>, Vec<_>) =
        entries.iter().map(|(name, entry)| sections::section(name, entry, &library, &mut names)).unzip();
    names.types = library.constraints;
    let accuracy = root.entry("mesh").and_then(|entry| entry.number("accuracy"));
    names.by_accuracy = root.has("mesh");
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
    let cables = obstacles::Cables {
        length: branches.iter().map(|branch| branch.length).sum(),
        thinnest: sections.iter().map(|section| section.diameter).fold(f64::INFINITY, f64::min),
    };
    let entries = root.entries("mechanisms");
    let links: Vec<_> = entries.iter().flat_map(|entry| mechanisms::mechanism(entry, cables, &mut names)).collect();
    let entries = root.entries("constraints");
    let mut constraints: Vec<_> =
        entries.iter().filter_map(|entry| constraint(entry, true, false, &mut names)).collect();
    let entries = root.entries("loads");
    let loads: Vec<_> = entries.iter().filter_map(|entry| load(entry, &mut names)).collect();
    let initial = root.entry("initial").and_then(|entry| initial(&entry, &mut names));
    let minimiser = minimiser(&root, &mut names);
    let entries = root.entries("obstacles");
    let own = entries.iter().filter_map(|entry| obstacles::obstacle(entry, cables, &mut names));
    let obstacles = links.into_iter().chain(own).collect();
    let contact = root.entry("contact").map_or_else(ContactSettings::default, |entry| obstacles::contact(&entry));
    let step_entries = root.entries("steps");
    let steps = steps(&step_entries, (pull, spin), &mut constraints, &mut names);
    place_nearest(&mut constraints, &loads, &branches);
    let sweep = root.entry("sweep").and_then(|entry| sweep(&entry, &names, &steps));
    let optimise = root.entry("optimise").and_then(|entry| optimise(&entry));
    let named = Named { names: &names, branches: &branches, constraints: &constraints, steps: &steps, contact };
    let (entries, mut taken) = (root.entries("requirements").into_iter().enumerate(), BTreeMap::new());
    let requirements = entries.filter_map(|(k, entry)| requirement(&entry, k, &named, &mut taken)).collect();
    let (entries, mut taken) = (root.entries("markers").into_iter().enumerate(), BTreeMap::new());
    let markers = entries.filter_map(|(k, entry)| marker(&entry, k, &names, &mut taken)).collect();
    let output = root.entry("output").map_or_else(Output::default, |entry| output::read(&entry));
    let unmatched = if root.has("catalogue") { identities::unmatched(&names) } else { Vec::new() };
    let by_rule: Vec<ByRule> = by_rule.into_iter().flatten().collect();
    let in_use = by_rule.iter().filter(|own| branches.iter().any(|branch| branch.has_section(own.section)));
    let cross_sections = in_use.map(|own| own.made_of.clone()).collect();
    let identities = Identities { cross_sections, ..identities::identities(&root, &names) };
    let scenario = Scenario {
        name,
        gravity,
        rotation,
        sections,
        by_rule,
        branches,
        accuracy,
        joints,
        constraints,
        loads,
        obstacles,
        contact,
        mechanisms: names.mechanisms.clone(),
        initial,
        minimiser,
        steps,
        step_spans: step_entries.iter().map(|entry| entry.span.clone()).collect(),
        requirements,
        markers,
        sweep,
        optimise,
        identities,
        unmatched,
        file_notes: names.file_notes.clone(),
        output,
    };
    (scenario, !names.broken)
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
