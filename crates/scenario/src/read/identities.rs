//! Reads part numbers and the like, components that do not act, and electrical connections.

use super::entry::Entry;
use super::fixing_types::of_part;
use super::names::{Names, lookup, register};
use std::collections::{BTreeMap, BTreeSet};
use wireloom_core::identity::{Component, Connection, Identified, Identities, KblFile, WireEnd};

/// Part numbers of constraints that no type of fixing has, each once.
pub(crate) fn unmatched(names: &Names<'_>) -> Vec<String> {
    let constraints = names.parts.iter().filter(|part| part.of == Identified::Constraint);
    let numbers: BTreeSet<&String> = constraints.filter_map(|part| part.identity.part.as_ref()).collect();
    numbers.into_iter().filter(|number| matches!(of_part(&names.types, number), Ok(None))).cloned().collect()
}

/// All identities of a scenario whose parts have been read.
pub(crate) fn identities<'a>(root: &Entry<'a>, names: &Names<'a>) -> Identities {
    let mut parts = names.parts.clone();
    parts.sort_by_key(|part| part.of);
    let (components, mut taken) = (root.entries("components"), BTreeMap::new());
    // A constraint that a step has released is a part of the harness, too.
    let mut connectors: BTreeMap<&str, ()> = names.constraints.keys().map(|name| (*name, ())).collect();
    connectors.extend(names.outputs.keys().map(|name| (*name, ())));
    for entry in &components {
        // A missing or faulty name is noted where the component is read.
        let Some(name) = entry.text("name") else { continue };
        if connectors.contains_key(name) && !taken.contains_key(name) {
            let message = format!("there is a constraint of the name \"{name}\"");
            entry.fault_at("name", message, "give the component a name of its own, or the constraint its part number");
        }
        taken.insert(name, taken.len());
    }
    connectors.extend(taken.keys().map(|name| (*name, ())));
    taken.clear();
    let components = components.iter().enumerate();
    let components = components.filter_map(|(k, entry)| component(entry, k, names, &connectors, &mut taken)).collect();
    let (connections, mut taken) = (root.entries("connections"), BTreeMap::new());
    let connections = connections.iter().enumerate();
    let connections = connections.filter_map(|(k, entry)| connection(entry, k, names, &connectors, &mut taken));
    let connections = connections.collect();
    let kbl = root.entry("kbl").and_then(|entry| kbl(&entry, names));
    Identities { parts, components, connections, kbl, ..Identities::default() }
}

/// The KBL file of the import.
fn kbl(entry: &Entry<'_>, names: &Names<'_>) -> Option<KblFile> {
    let (file, sha256) = (entry.word("file")?.to_owned(), entry.word("sha256")?.to_owned());
    Some(KblFile { file, sha256, elements: names.elements.clone() })
}

/// The connector that an entry names; refuses one that is neither a constraint nor a component.
fn connector(entry: &Entry<'_>, connectors: &BTreeMap<&str, ()>) -> Option<String> {
    let name = entry.word("connector")?;
    lookup(entry, "connector", connectors, name, entry.span_of("connector"));
    Some(name.to_owned())
}

fn component<'a>(
    entry: &Entry<'a>,
    index: usize,
    names: &Names<'a>,
    connectors: &BTreeMap<&str, ()>,
    taken: &mut BTreeMap<&'a str, usize>,
) -> Option<Component> {
    let name = entry.word("name").filter(|name| register(entry, entry.keys.what, taken, name, index));
    let word = |key: &str| entry.word(key).map(str::to_owned);
    let connector = connector(entry, connectors);
    let vertex = entry.word("vertex");
    if let Some(vertex) = vertex {
        lookup(entry, "vertex", &names.vertices, vertex, entry.span_of("vertex"));
    }
    let (from, to) = (entry.number("from"), entry.number("to"));
    let branch = entry.word("branch");
    let index = branch.and_then(|name| lookup(entry, "branch", &names.branches, name, entry.span_of("branch")));
    if let Some(length) = index.and_then(|index| *names.lengths.get(*index)?) {
        let reach = length * (1.0 + 1e-9);
        let branch = branch.unwrap_or_default();
        for (key, s) in [("from", from), ("to", to)] {
            if let Some(s) = s.filter(|s| *s > reach) {
                let message = format!("`{key}` = {s} of {} is beyond branch \"{branch}\"", entry.label);
                entry.fault_at(key, message, format!("the branch is {length} m long"));
            }
        }
        if let (Some(from), Some(to)) = (from, to)
            && to < from
        {
            let message = format!("{} ends at {to}, before it begins at {from}", entry.label);
            entry.fault_at("to", message, "give the smaller arc length as `from`");
        }
    }
    Some(Component {
        name: name?.to_owned(),
        kind: word("kind"),
        identity: entry.identity(),
        connector,
        cavity: word("cavity"),
        vertex: vertex.map(str::to_owned),
        branch: branch.map(str::to_owned),
        from,
        to,
    })
}

fn connection<'a>(
    entry: &Entry<'a>,
    index: usize,
    names: &Names<'a>,
    connectors: &BTreeMap<&str, ()>,
    taken: &mut BTreeMap<&'a str, usize>,
) -> Option<Connection> {
    let name = entry.word("name").filter(|name| register(entry, entry.keys.what, taken, name, index));
    let word = |key: &str| entry.word(key).map(str::to_owned);
    let end = |entry: &Entry<'_>| {
        let word = |key: &str| entry.word(key).map(str::to_owned);
        WireEnd {
            connector: connector(entry, connectors),
            cavity: word("cavity"),
            terminal: word("terminal"),
            seal: word("seal"),
        }
    };
    let ends = entry.entries("ends");
    if ends.len() > 2 {
        let message = format!("{} has {} ends", entry.label, ends.len());
        entry.fault_at("ends", message, "a wire has two; give a splice a connection for each wire");
    }
    let branches = entry.names("branches");
    let mut length = 0.0;
    for (branch, span) in &branches {
        if let Some(index) = lookup(entry, "branch", &names.branches, branch, span.clone()) {
            length += names.lengths.get(*index).copied().flatten().unwrap_or(0.0);
        }
    }
    Some(Connection {
        name: name?.to_owned(),
        signal: word("signal"),
        identity: entry.identity(),
        wire: word("wire"),
        ends: ends.iter().map(end).collect(),
        branches: branches.into_iter().map(|(branch, _)| branch.to_owned()).collect(),
        length,
    })
}
