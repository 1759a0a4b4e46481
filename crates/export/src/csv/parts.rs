//! Tables of what the parts list of a harness says: part numbers, and electrical connections.

use std::io::{self, Write};
use wireloom_core::identity::{Component, Connection, Identities, Identity, WireEnd};

/// The columns of [`write_parts`]. Arc lengths are in metres; they and the last columns say where a component sits.
pub const PARTS_HEADER: [&str; 12] = [
    "of",
    "name",
    "part",
    "description",
    "supplier",
    "colour",
    "connector",
    "cavity",
    "vertex",
    "branch",
    "from s [m]",
    "to s [m]",
];

/// The columns of [`write_connections`].
pub const CONNECTIONS_HEADER: [&str; 17] = [
    "name",
    "signal",
    "wire",
    "part",
    "description",
    "supplier",
    "colour",
    "from",
    "from cavity",
    "from terminal",
    "from seal",
    "to",
    "to cavity",
    "to terminal",
    "to seal",
    "length [m]",
    "through",
];

/// Writes [`PARTS_HEADER`] and a row for each part of the model that has an identity, then for each component, with its
/// kind in place of that of the part.
///
/// # Errors
/// Those of `out`.
pub fn write_parts(all: &Identities, out: &mut impl Write) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    table.write_record(PARTS_HEADER)?;
    for part in &all.parts {
        let [number, description, supplier, colour] = identity(&part.identity);
        let mut row = [""; PARTS_HEADER.len()];
        row[..6].copy_from_slice(&[part.of.word(), &part.name, number, description, supplier, colour]);
        table.write_record(row)?;
    }
    for component in &all.components {
        let Component { name, kind, identity: own, connector, cavity, vertex, branch, from, to } = component;
        let [number, description, supplier, colour] = identity(own);
        let [from, to] = [from, to].map(|s| s.map_or_else(String::new, |s| format!("{s:?}")));
        let place = [connector, cavity, vertex, branch].map(word);
        let kind = word(kind);
        let row = [kind, name, number, description, supplier, colour].into_iter().chain(place);
        table.write_record(row.chain([from.as_str(), to.as_str()]))?;
    }
    table.flush()
}

/// Writes [`CONNECTIONS_HEADER`] and a row for each connection, with its first two ends; the branches that it runs
/// through are separated by semicolons.
///
/// # Errors
/// Those of `out`.
pub fn write_connections(all: &[Connection], out: &mut impl Write) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    table.write_record(CONNECTIONS_HEADER)?;
    let none = WireEnd::default();
    for Connection { name, signal, identity: own, wire, ends, branches, length } in all {
        let (length, through) = (format!("{length:?}"), branches.join("; "));
        let [number, description, supplier, colour] = identity(own);
        let what = [name, word(signal), word(wire), number, description, supplier, colour];
        let ends = [0, 1].into_iter().flat_map(|k| {
            let WireEnd { connector, cavity, terminal, seal } = ends.get(k).unwrap_or(&none);
            [connector, cavity, terminal, seal].map(word)
        });
        table.write_record(what.into_iter().chain(ends).chain([length.as_str(), &through]))?;
    }
    table.flush()
}

fn identity(Identity { part, description, supplier, colour }: &Identity) -> [&str; 4] {
    [part, description, supplier, colour].map(word)
}

fn word(text: &Option<String>) -> &str {
    text.as_deref().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom_core::identity::{Identified, Part};

    fn rows(write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>) -> Vec<Vec<String>> {
        let mut text = Vec::new();
        write(&mut text).expect("it can be written");
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(&text[..]);
        let rows = reader.records().map(|row| row.expect("a row").iter().map(str::to_owned).collect());
        rows.collect()
    }

    #[test]
    fn a_parts_list_comes_back_from_its_tables() {
        let identity = Identity {
            part: Some("8K0 971, \"824\"".into()),
            description: None,
            supplier: Some("GCMC".into()),
            colour: None,
        };
        let plug = Component {
            name: "plug-3".into(),
            kind: Some("cavity plug".into()),
            identity: identity.clone(),
            connector: Some("XA".into()),
            cavity: Some("3".into()),
            vertex: None,
            branch: Some("trunk".into()),
            from: Some(0.1),
            to: None,
        };
        let wire = Connection {
            name: "W1".into(),
            signal: Some("KL30".into()),
            identity: identity.clone(),
            wire: None,
            ends: vec![WireEnd { connector: Some("XA".into()), cavity: Some("1".into()), ..WireEnd::default() }],
            branches: vec!["trunk".into(), "left".into()],
            length: 1.25,
        };
        let all = Identities {
            parts: vec![Part { of: Identified::Branch, name: "trunk".into(), identity }],
            components: vec![plug],
            connections: vec![wire],
            ..Identities::default()
        };
        let parts = rows(|out| write_parts(&all, out));
        assert_eq!(parts[0], PARTS_HEADER);
        assert_eq!(parts[1], ["branch", "trunk", "8K0 971, \"824\"", "", "GCMC", "", "", "", "", "", "", ""]);
        let place = ["XA", "3", "", "trunk", "0.1", ""];
        assert_eq!(parts[2][..3], ["cavity plug", "plug-3", "8K0 971, \"824\""]);
        assert_eq!(parts[2][6..], place);
        let connections = rows(|out| write_connections(&all.connections, out));
        assert_eq!(connections[0], CONNECTIONS_HEADER);
        assert_eq!(connections[1][..4], ["W1", "KL30", "", "8K0 971, \"824\""]);
        assert_eq!(connections[1][7..], ["XA", "1", "", "", "", "", "", "", "1.25", "trunk; left"]);
    }
}
