//! The shared KBL files of a real harness (see `shared/data/README.md`), read where they lie. Where they are absent the
//! tests show as ignored, with the reason. `WIRELOOM_SHARED` names another shared folder.

mod common;
#[path = "common/drawn.rs"]
mod drawn;

use drawn::{Drawn, Vector, rest, valid};
use libtest_mimic::{Arguments, Failed, Trial};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::PathBuf;
use std::process::ExitCode;
use wireloom_import::kbl::export::{Computed, export};
use wireloom_import::kbl::{Imported, Options, Selection, contents, import};

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let shared = std::env::var_os("WIRELOOM_SHARED")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared"), PathBuf::from);
    let folder = shared.join("data/old-beetle");
    let trials = [
        ("main_harness", main_harness as fn(&Imported) -> Result<(), Failed>),
        ("generator", generator),
        ("batterie_plus", batterie_plus),
    ]
    .into_iter()
    .flat_map(|(name, check)| {
        let path = folder.join(format!("{name}.kbl"));
        let absent = !path.is_file();
        let reason = if absent { format!(" (ignored: {} is not there)", path.display()) } else { String::new() };
        let (general, back) = (path.clone(), path.clone());
        [
            Trial::test(format!("{name}: what is in it{reason}"), move || check(&read(&path, 0.010)?)),
            Trial::test(format!("{name}: geometry and anatomy hold together{reason}"), move || {
                sound(&read(&general, 0.002)?, &vectors(&general)?)
            }),
            Trial::test(format!("{name}: what is not written keeps its bytes{reason}"), move || written(&back)),
        ]
        .map(|trial| trial.with_ignored_flag(absent))
    })
    .collect::<Vec<_>>();
    let path = folder.join("main_harness.kbl");
    let absent = !path.is_file();
    let reason = if absent { format!(" (ignored: {} is not there)", path.display()) } else { String::new() };
    let of_variants = Trial::test(format!("main_harness: its variants{reason}"), move || variants(&path));
    let path = folder.join("main_harness.kbl");
    let of_numbers = Trial::test(format!("main_harness: its part numbers{reason}"), move || part_numbers(&path));
    let more = [of_variants, of_numbers].map(|trial| trial.with_ignored_flag(absent));
    let trials = trials.into_iter().chain(more).collect();
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// Writes lines beside the drawn ones into the file: it is valid, the rest of it keeps its bytes, and what is imported
/// from it has the same lengths, and lines within the tolerance. Written once more, nodes and lengths stay.
fn written(path: &PathBuf) -> Result<(), Failed> {
    const TOLERANCE: f64 = 1e-4;
    let text = std::fs::read_to_string(path)?;
    // A smooth motion, the same for all branches that end at a node.
    let moved = |x: Vector| x + Vector::new((3.0 * x.y).sin(), (2.0 * x.z).cos(), (2.0 * x.x).sin()) * 0.02;
    let drawn: Vec<Drawn> = lines(&read(path, 0.002)?.scenario, moved)?;
    let computed = Computed { branches: drawn.iter().map(Drawn::branch).collect(), fixings: vec![] };
    let found = export(&text, &computed, TOLERANCE)?;
    valid(&found.text, &text);
    assert_eq!(rest(&found.text), rest(&text));
    let again = lines(&import(&found.text, &Options { max_segment: 0.002, ..Options::default() })?.scenario, |x| x)?;
    assert_eq!(again.len(), drawn.len());
    for (own, other) in drawn.iter().zip(&again) {
        assert_eq!((&own.segment, own.s.last()), (&other.segment, other.s.last()), "{}", own.name);
        for (k, x) in other.points.iter().enumerate() {
            let distance = own.distance(x);
            // The chords of 2 mm have corners, which smooth lines have not.
            assert!(distance < TOLERANCE + 1e-5, "{} {k}: {distance}", own.name);
        }
    }
    let computed = Computed { branches: again.iter().map(Drawn::branch).collect(), fixings: vec![] };
    let twice = export(&found.text, &computed, TOLERANCE)?;
    assert!(twice.nodes.is_empty() && twice.segments.iter().all(|own| !own.has_new_length()), "{:?}", twice.nodes);
    Ok(())
}

/// The lines of a scenario, moved.
fn lines(scenario: &str, moved: impl Fn(Vector) -> Vector) -> Result<Vec<Drawn>, Failed> {
    let table: toml::Table = toml::from_str(scenario)?;
    let mut lines = Vec::new();
    for branch in table["branches"].as_array().ok_or("branches")? {
        let [name, segment] = ["name", "kbl"].map(|key| string(&branch[key]));
        let path = branch["path"].as_array().ok_or("a path")?;
        let points = path.iter().map(|point| moved(Vector::from([0, 1, 2].map(|k| float(&point[k])))));
        lines.push(Drawn::new(name, segment, float(&branch["length"]), points.collect()));
    }
    Ok(lines)
}

fn read(path: &PathBuf, max_segment: f64) -> Result<Imported, Failed> {
    let options = Options { max_segment, ..Options::default() };
    Ok(import(&std::fs::read_to_string(path)?, &options)?)
}

/// `Start_vector` and `End_vector` by XML id of the segment, which is the name of the branch in these files.
fn vectors(path: &PathBuf) -> Result<HashMap<String, [[f64; 3]; 2]>, Failed> {
    let text = std::fs::read_to_string(path)?;
    let xml = roxmltree::Document::parse(&text)?;
    let mut vectors = HashMap::new();
    for segment in xml.root_element().children().filter(|node| node.has_tag_name("Segment")) {
        let read = |name: &str| -> Result<[f64; 3], Failed> {
            let parts = segment.children().filter(|node| node.has_tag_name(name)).filter_map(|node| node.text());
            let parts: Vec<f64> = parts.map(str::parse).collect::<Result<_, _>>()?;
            Ok(parts.try_into().map_err(|_| "a vector has three parts")?)
        };
        let id = segment.attribute("id").ok_or("segment without id")?;
        vectors.insert(id.to_owned(), [read("Start_vector")?, read("End_vector")?]);
    }
    Ok(vectors)
}

/// Every part number of the file is in the scenario: of 52 housings, 10 fixings, 6 protections, 98 wires, and the rest.
fn part_numbers(path: &PathBuf) -> Result<(), Failed> {
    let imported = read(path, 0.010)?;
    let all = common::checked(&imported.scenario).identities;
    let ends = all.connections.iter().flat_map(|own| &own.ends).flat_map(|end| [&end.terminal, &end.seal]);
    let identities = (all.parts.iter().map(|own| &own.identity))
        .chain(all.components.iter().map(|own| &own.identity))
        .chain(all.connections.iter().map(|own| &own.identity));
    let named: HashSet<&str> = identities.map(|own| &own.part).chain(ends).flatten().map(String::as_str).collect();
    let text = std::fs::read_to_string(path)?;
    let xml = roxmltree::Document::parse(&text)?;
    let mut numbers: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for part in xml.root_element().children().filter(|node| !node.has_tag_name("Harness")) {
        let number = part.children().find(|node| node.has_tag_name("Part_number")).and_then(|node| node.text());
        numbers.entry(part.tag_name().name()).or_default().extend(number);
    }
    let counted = |kind: &str| numbers[kind].len();
    let counts = ["Connector_housing", "Fixing", "Wire_protection", "General_wire"].map(counted);
    assert_eq!(counts, [52, 10, 6, 98]);
    for (kind, numbers) in &numbers {
        let missing: Vec<&&str> = numbers.iter().filter(|number| !named.contains(**number)).collect();
        assert!(missing.is_empty(), "{kind}: {missing:?}");
    }
    // All signals. Not used or named are a point and a unit that nothing refers to, the variants (all modules are
    // taken), lists of parts that belong to no module, and the families of modules.
    assert_eq!(all.connections.iter().filter(|own| own.signal.is_some() && own.ends.len() == 2).count(), 254);
    let unread: Vec<_> = imported.usage.iter().filter(|own| own.not_read > 0).map(|own| own.kind.as_str()).collect();
    let expected = ["Cartesian_point", "Harness_configuration", "Module_configuration", "Module_families", "Unit"];
    assert_eq!(unread, expected);
    Ok(())
}

fn main_harness(imported: &Imported) -> Result<(), Failed> {
    let scenario: toml::Table = toml::from_str(&imported.scenario)?;
    let degrees = degrees(&scenario);
    assert_eq!(list(&scenario, "branches").len(), 183);
    assert_eq!(degrees.len(), 184);
    let mut by_arms: BTreeMap<usize, usize> = BTreeMap::new();
    for arms in degrees.values() {
        *by_arms.entry(*arms).or_default() += 1;
    }
    let expected = [(1, 133), (2, 4), (3, 20), (4, 10), (5, 6), (6, 5), (7, 2), (10, 1), (12, 1), (13, 1), (16, 1)];
    assert_eq!(by_arms.into_iter().collect::<Vec<_>>(), expected);
    assert_eq!(list(&scenario, "joints").len(), 51);

    let lengths: Vec<f64> = list(&scenario, "branches").iter().map(|b| float(&b["length"])).collect();
    let total: f64 = lengths.iter().sum();
    assert!((total - 36.7).abs() < 0.05, "{total}");

    // 37 of the 133 ends are splices; of the 16 fixing assignments two are drawn far from their places.
    let kinds = |kind: &str| list(&scenario, "constraints").iter().filter(|c| c["kind"].as_str() == Some(kind)).count();
    assert_eq!((kinds("connector"), kinds("collar")), (96, 14));
    let found = |what: &str| -> Vec<usize> {
        let like = imported.findings.iter().filter(|finding| finding.what.contains(what));
        like.map(|finding| finding.items.len()).collect()
    };
    assert_eq!(found("ends carry splices"), [37]);
    assert_eq!(found("than a clip reaches"), [2]);
    // Three clips within 54 mm of a bundle 20 mm thick, a duct, and two near what holds.
    assert_eq!(found("let the cable slide along itself"), [5]);
    assert_eq!(found("fixings are assigned to no segment"), [1]);
    assert_eq!(found("connectors are drawn far from"), [1]);
    // Of the 183 curves 178 meet their nodes; the other five are curves of runs that were split, and hold the
    // piece between the nodes.
    assert_eq!((found("those of longer runs"), found("stale")), (vec![5], vec![]));
    assert_eq!(found("34 modules").len(), 1);
    // Equal things stand together.
    assert!(imported.findings.len() <= 20, "{}", imported.findings.len());
    Ok(())
}

/// The smallest and the largest variant of the main harness, which its file names.
fn variants(path: &PathBuf) -> Result<(), Failed> {
    let text = std::fs::read_to_string(path)?;
    let listed = contents(&text)?;
    let modules: Vec<_> = listed.variants.iter().map(|own| (own.name.as_str(), own.modules.len())).collect();
    assert_eq!(modules, [("Kombination_MAXI", 34), ("Kombination_MINI", 7), ("Freie Kombination", 0)]);
    let scenario = |selection: Selection| -> Result<toml::Table, Failed> {
        let imported = import(&text, &Options { selection, ..Options::default() })?;
        common::checked(&imported.scenario);
        Ok(toml::from_str(&imported.scenario)?)
    };
    let [least, most] =
        ["Kombination_MINI", "Kombination_MAXI"].map(|name| scenario(Selection::Variant(name.to_owned())));
    let (least, most, all) = (least?, most?, scenario(Selection::All)?);
    let counts = |scenario: &toml::Table| ["branches", "constraints"].map(|key| list(scenario, key).len());
    assert_eq!((counts(&least), counts(&most)), ([148, 79], counts(&all)));
    assert_eq!(most["sections"], all["sections"]);
    // What the smallest one does not have is left out, and not said to be used.
    let selection = Selection::Variant("Kombination_MINI".to_owned());
    let usage = import(&text, &Options { selection, ..Options::default() })?.usage;
    let found = ["Module", "Node", "Routing", "Segment"].map(|kind| {
        let own = usage.iter().find(|own| own.kind == kind).expect(kind);
        assert_eq!(own.not_read, 0, "{own:?}");
        [own.used, own.kept, own.left_out]
    });
    // One wire is routed through no segment: it is named, and not counted.
    assert_eq!(found, [[7, 0, 27], [149, 0, 35], [164, 1, 89], [148, 0, 35]]);
    Ok(())
}

fn generator(imported: &Imported) -> Result<(), Failed> {
    let scenario: toml::Table = toml::from_str(&imported.scenario)?;
    let mut arms: Vec<usize> = degrees(&scenario).into_values().collect();
    arms.sort_unstable();
    assert_eq!(arms, [1, 1, 1, 3]);
    assert_eq!(list(&scenario, "branches").len(), 3);
    assert_eq!(list(&scenario, "constraints").len(), 4);
    assert_eq!(list(&list(&scenario, "joints")[0], "wires").len(), 2);
    Ok(())
}

fn batterie_plus(imported: &Imported) -> Result<(), Failed> {
    let scenario: toml::Table = toml::from_str(&imported.scenario)?;
    assert_eq!(list(&scenario, "branches").len(), 1);
    assert_eq!(list(&scenario, "constraints").len(), 2);
    assert!(!scenario.contains_key("joints"));
    // A 25 mm² battery cable, 9.8 mm thick and 266 g/m.
    let section = &common::checked(&imported.scenario).sections[0];
    assert!((section.linear_density - 0.266).abs() < 1e-9 && (section.diameter - 0.0098).abs() < 1e-9, "{section:?}");
    assert!((0.03..0.1).contains(&section.bending_stiffness[0]), "{section:?}");
    // `Module_families` and parts of elements are not read; the wire is thicker than the cross-section drawn for it.
    assert_eq!(imported.findings.len(), 3, "{:?}", imported.findings);
    Ok(())
}

/// Checks for every file. The tangents of the curves are compared with `Start_vector` and `End_vector`, which
/// the importer does not read.
fn sound(imported: &Imported, vectors: &HashMap<String, [[f64; 3]; 2]>) -> Result<(), Failed> {
    let scenario: toml::Table = toml::from_str(&imported.scenario)?;
    let branches = list(&scenario, "branches");
    let read = common::checked(&imported.scenario);
    let stiffness_of: HashMap<&str, f64> =
        read.branches.iter().map(|b| (b.name.as_str(), read.sections[b.section].bending_stiffness[0])).collect();
    // Drawn places of the vertices, from the ends of the paths: all branches agree on them.
    let mut places: HashMap<&str, [f64; 3]> = HashMap::new();
    let mut by_name = HashMap::new();
    let mut sums = [0.0; 2];
    for branch in &branches {
        let name = string(&branch["name"]);
        by_name.insert(name, branch);
        let path: Vec<[f64; 3]> = branch["path"].as_array().ok_or("path")?.iter().map(triple).collect();
        for (vertex, place) in [(&branch["from"], path[0]), (&branch["to"], path[path.len() - 1])] {
            let known = places.entry(string(vertex)).or_insert(place);
            assert!(distance(known, &place) < 2e-9, "{name}");
        }
        let steps: Vec<f64> = path.windows(2).map(|w| distance(&w[0], &w[1])).collect();
        assert!(steps.iter().all(|step| (1e-4..0.002_1).contains(step)), "{name}");
        // The drawn curve is as long as the branch, and chords of 2 mm cut off a little at the corners.
        let (drawn, length): (f64, f64) = (steps.iter().sum(), float(&branch["length"]));
        assert!((drawn / length - 1.0).abs() < 1e-2, "{name}: {drawn} {length}");
        sums = [sums[0] + drawn, sums[1] + length];
    }
    assert!((sums[0] / sums[1] - 1.0).abs() < 1e-3, "{sums:?}");
    for joint in list(&scenario, "joints") {
        let name = string(&joint["name"]);
        let arms = list(&joint, "arms");
        let stiffness: HashMap<&str, f64> = arms
            .iter()
            .map(|arm| {
                let branch = string(&arm["branch"]);
                (branch, stiffness_of[branch])
            })
            .collect();
        for arm in &arms {
            let branch = by_name[string(&arm["branch"])];
            let end = if string(&branch["from"]) == name { 0 } else { 1 };
            let (d3, stated) = (third_column(&arm["orientation"]), vectors[string(&branch["name"])][end]);
            assert!(distance(&d3, &stated) < 2e-6, "{name}: {d3:?} {stated:?}");
        }
        // Row sums: as first arm at most all its wires, as either arm at most its stiffness.
        let (mut shares, mut coupled): (HashMap<&str, f64>, HashMap<&str, f64>) = Default::default();
        let wires = list(&joint, "wires");
        for pair in &wires {
            let between = pair["between"].as_array().ok_or("between")?;
            let (a, b, share) = (string(&between[0]), string(&between[1]), float(&pair["share"]));
            assert!(share > 0.0 && share <= 1.0);
            *shares.entry(a).or_default() += share;
            for arm in [a, b] {
                *coupled.entry(arm).or_default() += share * stiffness[a];
            }
        }
        assert!(shares.values().all(|sum| *sum <= 1.0), "{name}: {shares:?}");
        for (arm, sum) in coupled {
            assert!(sum <= stiffness[arm] * 1.001, "{name}: {arm} {sum} {}", stiffness[arm]);
        }
    }
    for section in &read.sections {
        let (ei, gj) = (section.bending_stiffness[0], section.torsion_stiffness);
        // Tubes bend with the cable, but slit as they are they hardly twist.
        assert!((1e-4..0.5).contains(&ei) && (0.2..0.8).contains(&(gj / ei)), "{section:?}");
        assert!((1e-3..0.04).contains(&section.diameter), "{section:?}");
        assert!((1e-3..3.0).contains(&section.linear_density), "{section:?}");
    }
    // Every section follows from its wires, and lies between its bounds.
    assert_eq!(read.by_rule.len(), read.sections.len());
    for by_rule in &read.by_rule {
        let (x, taken) = (by_rule.bundle.bending, read.sections[by_rule.section].bending_stiffness[0]);
        assert!(x.slip <= taken && taken <= x.bonded, "{by_rule:?}");
    }
    Ok(())
}

fn degrees(scenario: &toml::Table) -> HashMap<String, usize> {
    let mut degrees = HashMap::new();
    for branch in list(scenario, "branches") {
        for end in ["from", "to"] {
            *degrees.entry(string(&branch[end]).to_owned()).or_default() += 1;
        }
    }
    degrees
}

fn list(table: &toml::Table, key: &str) -> Vec<toml::Table> {
    let items = table.get(key).and_then(toml::Value::as_array).into_iter().flatten();
    items.filter_map(|item| item.as_table().cloned()).collect()
}

fn string(value: &toml::Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("{value:?} is no string"))
}

fn float(value: &toml::Value) -> f64 {
    value.as_float().unwrap_or_else(|| panic!("{value:?} is no float"))
}

fn triple(value: &toml::Value) -> [f64; 3] {
    std::array::from_fn(|i| float(&value[i]))
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// d3 of the quaternion `[w, x, y, z]`.
fn third_column(value: &toml::Value) -> [f64; 3] {
    let [w, x, y, z]: [f64; 4] = std::array::from_fn(|i| float(&value[i]));
    [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)]
}
