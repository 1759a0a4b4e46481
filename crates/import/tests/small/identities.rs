//! Part numbers, signals and cavities of the small file, and what became of each of its elements.

use super::*;

/// The small harness with part numbers, cavities, a plug, a seal, terminals, a spare connector and a module family.
fn numbered() -> String {
    let text = with(
        "<Id>plug A</Id>",
        "<Id>plug A</Id><Part>housing</Part>\
         <Contact_points id=\"kp1\"><Associated_parts>t1 e1</Associated_parts><Contacted_cavity>o1</Contacted_cavity>\
         </Contact_points><Slots id=\"sl\"><Cavities id=\"o1\"><Part>h1</Part></Cavities>\
         <Cavities id=\"o2\"><Associated_plug>g1</Associated_plug><Part>h2</Part></Cavities></Slots>",
    );
    let text = text.replace(
        "<General_wire id=\"part1\">",
        "<Connector_housing id=\"housing\"><Part_number>H 1</Part_number><Company_name>ACME</Company_name>\
         <Description>housing \"2\"</Description><Housing_colour>black</Housing_colour><Slots id=\"hs\">\
         <Cavities id=\"h1\"><Cavity_number>1</Cavity_number></Cavities>\
         <Cavities id=\"h2\"><Cavity_number>2</Cavity_number></Cavities></Slots></Connector_housing>\
         <Cavity_plug id=\"plug\"><Part_number>P 1</Part_number></Cavity_plug>\
         <Cavity_seal id=\"seal\"><Part_number>E 1</Part_number></Cavity_seal>\
         <General_terminal id=\"terminal\"><Part_number>T 1</Part_number></General_terminal>\
         <Fixing id=\"fixing\"><Part_number>F 1</Part_number></Fixing>\
         <General_wire id=\"part1\"><Part_number>W 1</Part_number><Description>/NULL</Description>\
         <Cover_colour id=\"cc1\"><Colour_value>bk</Colour_value></Cover_colour>\
         <Cover_colour id=\"cc2\"><Colour_value>gn</Colour_value></Cover_colour>",
    );
    let text = text.replace("<General_wire id=\"cable\">", "<General_wire id=\"cable\"><Part_number>W 2</Part_number>");
    let text =
        text.replace("<Wire_protection id=\"tape\">", "<Wire_protection id=\"tape\"><Part_number>V 1</Part_number>");
    let text = text.replace(
        "<Connection id=\"c1\"><Wire>w1</Wire>",
        "<Connection id=\"c1\"><Id>line 1</Id><Signal_name>CAN-H</Signal_name><Wire>w1</Wire>\
         <Extremities id=\"x1\"><Contact_point>kp1</Contact_point></Extremities>",
    );
    let text = text.replace("<Id>clip-1</Id>", "<Id>clip-1</Id><Part>fixing</Part>");
    text.replace(
        "<General_wire_occurrence id=\"w1\">",
        "<Terminal_occurrence id=\"t1\"><Part>terminal</Part></Terminal_occurrence>\
         <Cavity_seal_occurrence id=\"e1\"><Part>seal</Part></Cavity_seal_occurrence>\
         <Cavity_plug_occurrence id=\"g1\"><Part>plug</Part></Cavity_plug_occurrence>\
         <Connector_occurrence id=\"lost\"><Id>plug A</Id><Part>housing</Part></Connector_occurrence>\
         <Module_families id=\"mf\"><Families>1</Families></Module_families>\
         <General_wire_occurrence id=\"w1\"><Wire_number>17</Wire_number>",
    )
}

/// Every number of the file is at the part that it belongs to, and comes back from the written text.
#[test]
fn part_numbers_signals_and_cavities_stay_with_their_parts() {
    let numbered = numbered();
    let Identities { parts, components, connections, .. } = checked(&imported(&numbered).scenario).identities;
    let part = |name: &str| {
        let found = parts.iter().find(|part| part.of == Identified::Constraint && part.name == name);
        found.unwrap_or_else(|| panic!("{name}: {parts:?}")).identity.clone()
    };
    let text = |text: &str| Some(text.to_owned());
    let housing = Identity {
        part: text("H 1"),
        description: text("housing \"2\""),
        supplier: text("ACME"),
        colour: text("black"),
    };
    assert_eq!((part("plug A"), part("clip-1").part), (housing, text("F 1")));
    let component = |kind: &str| components.iter().find(|own| own.kind.as_deref() == Some(kind)).expect(kind);
    let plug = component("cavity plug");
    assert_eq!((&plug.identity.part, &plug.connector, &plug.cavity), (&text("P 1"), &text("plug A"), &text("2")));
    let tape = component("wire protection");
    assert_eq!((&tape.identity.part, &tape.branch, tape.from), (&text("V 1"), &text("trunk"), Some(0.0)));
    assert!((tape.to.expect("an end") - 0.5 * 0.3079).abs() < 1e-9, "{tape:?}");
    let spare = components.iter().find(|own| own.name == "plug A-2").expect("the spare connector");
    assert_eq!((spare.identity.part.as_deref(), &spare.vertex), (Some("H 1"), &None));
    let splice = components.iter().find(|own| own.name == "S1").expect("the splice");
    assert_eq!(splice.vertex.as_deref(), Some("S"));

    assert_eq!(connections.len(), 4, "{connections:?}");
    let line = &connections[0];
    assert_eq!((line.name.as_str(), &line.signal, &line.wire), ("line 1", &text("CAN-H"), &text("17")));
    assert_eq!((&line.identity.part, &line.identity.colour), (&text("W 1"), &text("bk/gn")));
    assert_eq!(line.identity.description, None);
    let end = WireEnd { connector: text("plug A"), cavity: text("1"), terminal: text("T 1"), seal: text("E 1") };
    assert_eq!(line.ends, [end]);
    assert_eq!(line.branches, ["trunk", "left"]);
    assert!((line.length - (0.3079 + 0.26)).abs() < 1e-9, "{line:?}");
    // A core of a cable has the number of the cable.
    assert_eq!(connections[2].identity.part, text("W 2"));
}

/// A row of the table of an import, which counts every element once.
fn row(imported: &Imported, kind: &str) -> [usize; 4] {
    let own = imported.usage.iter().find(|own| own.kind == kind).unwrap_or_else(|| panic!("{kind}"));
    assert_eq!(own.total, own.used + own.kept + own.left_out + own.not_read, "{own:?}");
    [own.used, own.kept, own.left_out, own.not_read]
}

#[test]
fn an_import_says_what_became_of_each_element() {
    let imported = imported(&numbered());
    let row = |kind: &str| row(&imported, kind);
    assert_eq!(row("Segment"), [4, 0, 0, 0]);
    assert_eq!(row("Cartesian_point"), [7, 0, 0, 0]);
    // Plugs A and B act, the splice and the spare one do not.
    assert_eq!(row("Connector_occurrence"), [2, 2, 0, 0]);
    assert_eq!(row("Fixing_occurrence"), [1, 0, 0, 0]);
    assert_eq!(row("Cavity_plug_occurrence"), [0, 1, 0, 0]);
    assert_eq!(row("Cavity_seal"), [0, 1, 0, 0]);
    assert_eq!(row("General_wire"), [2, 0, 0, 0]);
    assert_eq!(row("Module_families"), [0, 0, 0, 1]);
    assert!(imported.scenario.contains("# - 1 Module_families: 0 used, 0 named, 0 of other modules, 1 not read"));
}

/// What other modules have, and what only these need, is left out; what nothing reads is not called used.
#[test]
fn with_chosen_modules_an_import_says_what_is_left_out() {
    let plain = selected(Selection::Variant("plain".to_owned())).unwrap();
    let expected = [
        ("Connection", [2, 0, 2, 0]),
        // The housing of plug A, in every car, acts; plug B and the splice belong to the left arm.
        ("Connector_occurrence", [1, 0, 2, 0]),
        ("Fixing_occurrence", [1, 0, 0, 0]),
        ("General_wire", [2, 0, 0, 0]),
        ("General_wire_occurrence", [2, 0, 2, 0]),
        ("Harness_configuration", [1, 0, 2, 0]),
        ("Module", [1, 0, 2, 0]),
        ("Module_configuration", [1, 0, 0, 0]),
        ("Node", [3, 0, 2, 0]),
        ("Routing", [2, 0, 2, 0]),
        ("Segment", [2, 0, 2, 0]),
        ("Wire_protection_occurrence", [1, 0, 0, 0]),
        // The end of the stub, and the metre, in which only the left arm has its length.
        ("Cartesian_point", [6, 0, 1, 0]),
        ("Unit", [4, 0, 1, 0]),
    ];
    for (kind, expected) in expected {
        assert_eq!(row(&plain, kind), expected, "{kind}");
    }
    let said: Vec<String> = plain.findings.iter().map(ToString::to_string).collect();
    assert!(!said.iter().any(|line| line.contains("elements that are not read: ")), "{said:#?}");
    // With all modules the variants choose nothing.
    let all = selected(Selection::All).unwrap();
    let rows = ["Harness_configuration", "Module", "Segment", "Unit"].map(|kind| row(&all, kind));
    assert_eq!(rows, [[0, 0, 0, 3], [3, 0, 0, 0], [4, 0, 0, 0], [5, 0, 0, 0]]);
}

/// A variant complained of coverings and fixings of other modules, and of those on segments that it does not have.
#[test]
fn with_chosen_modules_nothing_is_said_of_what_is_left_out() {
    let left = selected(Selection::Modules(vec!["L-1".to_owned()])).unwrap();
    let plain = selected(Selection::Variant("plain".to_owned())).unwrap();
    for finding in left.findings.iter().chain(&plain.findings) {
        let wrong = ["cover no segment", "assigned to no segment", "sit at no node", "in the file; left out"];
        assert!(!wrong.iter().any(|words| finding.what.contains(words)), "{finding}");
    }
}

/// Occurrences that stand in parts were counted as not read, and so was what stands in a part that is not read.
#[test]
fn parts_of_elements_are_told_once_and_only_if_nothing_reads_them() {
    let said = |text: &str| {
        let findings = imported(text).findings;
        findings.into_iter().find(|own| own.what == "parts of elements that are not read").map(|own| own.items)
    };
    // Of the core of the cable that no wire is, its copper alone is read.
    let unused = ["1 Bend_radius", "1 Outside_diameter"];
    assert_eq!(said(SMALL).unwrap(), unused);
    let length = "<Length_information><Length_type>cut</Length_type><Length_value><Value_component>1</Value_component>\
                  </Length_value></Length_information>";
    let text = assembled(1)
        .replace("<General_wire_occurrence id=\"w1\">", &format!("<General_wire_occurrence id=\"w1\">{length}"));
    assert_eq!(said(&text).unwrap(), ["1 Bend_radius", "1 Length_information", "1 Outside_diameter"]);
}

/// The small harness with so many occurrences of an assembly, in which a fixing stands.
fn assembled(count: usize) -> String {
    let occurrences: String = (0..count)
        .map(|k| {
            format!(
                "<Assembly_part_occurrence id=\"ao{k}\"><Id>assembly {k}</Id><Part>assembly</Part>\
                 </Assembly_part_occurrence>"
            )
        })
        .collect();
    with("<General_wire_occurrence id=\"w1\">", &format!("{occurrences}<General_wire_occurrence id=\"w1\">")).replace(
        "<General_wire id=\"part1\">",
        "<Assembly_part id=\"assembly\"><Part_number>A 1</Part_number>\
         <Fixing_occurrence id=\"inner\"><Id>inner clip</Id><Part>clamp</Part></Fixing_occurrence></Assembly_part>\
         <Fixing id=\"clamp\"><Part_number>F 2</Part_number></Fixing><General_wire id=\"part1\">",
    )
}

/// Only the first assembly of several had what stands in it.
#[test]
fn what_stands_in_a_part_is_at_each_occurrence_of_it() {
    let components = checked(&imported(&assembled(3)).scenario).identities.components;
    let inner = components.iter().filter(|own| own.identity.part.as_deref() == Some("F 2"));
    let at: Vec<&str> = inner.filter_map(|own| own.connector.as_deref()).collect();
    assert_eq!(at, ["assembly 0", "assembly 1", "assembly 2"]);
}

/// On the board nothing but pegs holds the harness: its connectors and clips are listed.
#[test]
fn the_board_and_the_assembly_keep_part_numbers_too() {
    for arrangement in [Arrangement::Board, Arrangement::Assembly] {
        let options = Options { arrangement, ..Options::default() };
        let scenario = import(&numbered(), &options).unwrap().scenario;
        let all = checked(&scenario).identities;
        let numbers: Vec<&str> = (all.parts.iter().map(|own| &own.identity))
            .chain(all.components.iter().map(|own| &own.identity))
            .filter_map(|identity| identity.part.as_deref())
            .collect();
        for number in ["H 1", "F 1", "P 1", "V 1"] {
            assert!(numbers.contains(&number), "{arrangement:?} {number}: {numbers:?}");
        }
        // What is drawn in the vehicle is compared with the end of an assembly, not with a board.
        let drawn = checked(&scenario).branches.iter().filter(|branch| !branch.own_drawn.is_empty()).count();
        assert_eq!(drawn, if arrangement == Arrangement::Assembly { 4 } else { 0 });
    }
}
