//! `wireloom export kbl`: results of runs in their KBL files, imported again. The real harnesses lie outside the
//! repository: where they are absent their tests show as ignored.

use libtest_mimic::{Arguments, Failed, Trial};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use wireloom::geometry::Vector;
use wireloom_tests::place::Place;
use wireloom_tests::{root, shared};

/// The default, m.
const TOLERANCE: f64 = 1e-4;

fn main() {
    let folder = shared("data/old-beetle");
    // The main harness on a coarse mesh: its shape does not matter here.
    let real =
        [("batterie_plus", ""), ("generator", ""), ("main_harness", "30 mm")].into_iter().map(|(name, spacing)| {
            let file = folder.join(format!("{name}.kbl"));
            let absent = !file.is_file();
            let reason = if absent { format!(" (ignored: {} is not there)", file.display()) } else { String::new() };
            let check = move || round_trip(&file, spacing);
            Trial::test(format!("{name}: a result comes back from its file{reason}"), check).with_ignored_flag(absent)
        });
    let own: [(&str, Check); 5] = [
        ("small.kbl: a result comes back from its file", || round_trip(&small(), "")),
        ("an assembly ends in the vehicle, and comes back from there", assembly),
        ("lengths that were changed are written and listed", changed_lengths),
        ("a scenario is carried out, a result is read, and both give the same file", sources),
        ("what cannot be written is refused with the reason", refused),
    ];
    let own = own.into_iter().map(|(name, check)| Trial::test(name, check));
    libtest_mimic::run(&Arguments::from_args(), real.chain(own).collect()).exit();
}

/// A test.
type Check = fn() -> Result<(), Failed>;

fn ensure(holds: bool, what: impl FnOnce() -> String) -> Result<(), Failed> {
    if holds { Ok(()) } else { Err(what().into()) }
}

fn small() -> std::path::PathBuf {
    root().join("crates/import/tests/small.kbl")
}

/// A place with a copy of a KBL file, the scenario `s.toml` of it, and its result in `o`.
fn carried_out(file: &Path, import: &[&str], run: &[&str]) -> Result<Place, Failed> {
    let place = Place::new("");
    place.file("harness.kbl", fs::read(file)?);
    place.run(&[&["import", "kbl", "harness.kbl", "-o", "s.toml"], import].concat()).says(0, &[]);
    place.run(&[&["run", "s.toml", "--out", "o", "--quiet"], run].concat()).says(0, &[]);
    Ok(place)
}

/// Writes the result, and imports what was written as `again.toml`; returns what the program says of it.
fn written(place: &Place) -> Result<(Value, toml::Table), Failed> {
    let ended = place.run(&["export", "kbl", "o", "-o", "written.kbl", "--json"]);
    ended.says(0, &[]);
    place.run(&["import", "kbl", "written.kbl", "--spacing", "2 mm", "-o", "again.toml"]).says(0, &[]);
    Ok((serde_json::from_str(&ended.out)?, toml::from_str(&place.text("again.toml"))?))
}

fn vector(value: &toml::Value) -> Result<Vector, Failed> {
    let parts: Option<Vec<f64>> = value.as_array().map(|list| list.iter().filter_map(toml::Value::as_float).collect());
    let parts = parts.and_then(|parts| <[f64; 3]>::try_from(parts).ok());
    Ok(Vector::from(parts.ok_or("three numbers")?))
}

/// Entries of a table by a key.
fn by<'t>(table: &'t toml::Table, list: &str, key: &str) -> BTreeMap<&'t str, &'t toml::Value> {
    let entries = table.get(list).and_then(toml::Value::as_array).into_iter().flatten();
    entries.filter_map(|own| Some((own.get(key)?.as_str()?, own))).collect()
}

/// Distance of a point from a line through points, m.
fn distance(x: &Vector, line: &[Vector]) -> f64 {
    let to_chord = |pair: &[Vector]| {
        let chord = pair[1] - pair[0];
        let part = ((x - pair[0]).dot(&chord) / chord.norm_squared()).clamp(0.0, 1.0);
        (pair[0] + chord * part - x).norm()
    };
    line.windows(2).map(to_chord).fold(f64::INFINITY, f64::min)
}

/// A result comes back: lengths exactly, lines within the tolerance, connectors where they were, clips within 2 mm.
fn round_trip(file: &Path, spacing: &str) -> Result<(), Failed> {
    let import: &[&str] = if spacing.is_empty() { &[] } else { &["--spacing", spacing] };
    let place = carried_out(file, import, &[])?;
    comes_back(&place)
}

fn comes_back(place: &Place) -> Result<(), Failed> {
    let scenario: toml::Table = toml::from_str(&place.text("s.toml"))?;
    let (said, again) = written(place)?;
    let result = place.result("o");
    let steps = result["steps"].as_array().ok_or("steps")?;
    let computed = &steps[steps.len() - 1]["branches"];
    let (before, now) = (by(&scenario, "branches", "kbl"), by(&again, "branches", "kbl"));
    ensure(before.len() == now.len() && !now.is_empty(), || format!("{} {}", before.len(), now.len()))?;
    for (segment, branch) in &now {
        ensure(branch["length"] == before[segment]["length"], || format!("{segment}: {:?}", branch["length"]))?;
        let path = branch["path"].as_array().ok_or("a path")?;
        let path: Vec<Vector> = path.iter().map(vector).collect::<Result<_, _>>()?;
        let name = before[segment]["name"].as_str().ok_or("a name")?;
        let nodes = computed[name]["position"].as_array().ok_or("positions")?;
        for node in nodes {
            let x: [f64; 3] = serde_json::from_value(node.clone())?;
            let apart = distance(&Vector::from(x), &path);
            // Chords of 2 mm cut a bend of radius 10 mm by 0.05 mm.
            ensure(apart < TOLERANCE + 6e-5, || format!("{segment} {node}: {apart}"))?;
        }
    }
    let (held, seats) = (by(&scenario, "constraints", "name"), by(&again, "constraints", "name"));
    for (name, seat) in &seats {
        let Some(own) = held.get(name) else { continue };
        let apart = (vector(&own["position"])? - vector(&seat["position"])?).norm();
        // A clip is drawn beside the cable: where that turns by little its nearest point moves by the lever.
        let room = if own["kind"].as_str() == Some("connector") { 1e-6 } else { 2e-3 };
        ensure(apart <= room, || format!("{name}: {apart}"))?;
    }
    let segments = said["segments"].as_array().ok_or("segments")?;
    ensure(segments.len() == now.len(), || format!("{} segments", segments.len()))?;
    let kept = |own: &Value| own["curve"].is_null() || own["curve"]["distance"].as_f64() <= Some(TOLERANCE);
    ensure(segments.iter().all(|own| kept(own) && own["length_changed"] == false), || said.to_string())
}

/// After an assembly connectors and clips are in their seats, so that what is drawn of them stays.
fn assembly() -> Result<(), Failed> {
    let place = carried_out(&small(), &["--as", "assembly"], &[])?;
    let (said, again) = written(&place)?;
    ensure(said["placements"].as_array().is_some_and(Vec::is_empty), || said["placements"].to_string())?;
    let scenario: toml::Table = toml::from_str(&place.text("s.toml"))?;
    let lengths = |table: &toml::Table| -> Vec<_> {
        by(table, "branches", "kbl").into_values().map(|own| own["length"].clone()).collect()
    };
    ensure(lengths(&again) == lengths(&scenario), || format!("{:?}", lengths(&again)))
}

fn changed_lengths() -> Result<(), Failed> {
    let longer = "branches.left.length=\"270 mm\"";
    let place = carried_out(&small(), &[], &["--set", longer])?;
    let ended = place.run(&["export", "kbl", "o", "-o", "written.kbl"]);
    ended.says(0, &[]);
    let row = ended.out.lines().find(|line| line.starts_with("s2")).unwrap_or_default();
    let row: Vec<&str> = row.split_whitespace().collect();
    ensure(row == ["s2", "left", "260.000", "270.000", "+10.000"], || ended.out.clone())?;
    ensure(ended.out.contains("lengths: 1 of 4 segments changed"), || ended.out.clone())?;
    let (said, again) = written(&place)?;
    ensure(by(&again, "branches", "kbl")["s2"]["length"].as_float() == Some(0.27), || format!("{again:?}"))?;
    let changed = said["segments"].as_array().ok_or("segments")?.iter().filter(|own| own["length_changed"] == true);
    let nanometres = |value: &Value| value.as_f64().map(|x| (x * 1e9).round());
    let changed: Vec<_> =
        changed.map(|own| (&own["id"], nanometres(&own["length_before"]), nanometres(&own["length"]))).collect();
    ensure(changed == [(&"s2".into(), Some(0.26e9), Some(0.27e9))], || format!("{changed:?}"))
}

fn sources() -> Result<(), Failed> {
    let place = carried_out(&small(), &[], &[])?;
    place.run(&["export", "kbl", "o", "-o", "a.kbl"]).says(0, &[]);
    place.run(&["export", "kbl", "o/result.json", "-o", "b.kbl", "--kbl", "harness.kbl"]).says(0, &[]);
    place.run(&["export", "kbl", "s.toml", "-o", "c.kbl"]).says(0, &[]);
    let texts = ["a.kbl", "b.kbl", "c.kbl"].map(|name| place.text(name));
    ensure(texts[0] == texts[1] && texts[0] == texts[2], || "they differ".to_owned())
}

fn refused() -> Result<(), Failed> {
    let place = carried_out(&small(), &[], &[])?;
    let export = |more: &[&str]| place.run(&[&["export", "kbl", "o", "-o", "w.kbl"], more].concat());
    // Another file, which lacks a segment.
    place.file("other.kbl", place.text("harness.kbl").replace("id=\"s4\"", "id=\"s5\"").replace("s4", "s5"));
    let words = ["other.kbl: it is not `harness.kbl` as the scenario was imported from it", "no segments `s4`"];
    export(&["--kbl", "other.kbl"]).says(1, &words);
    export(&["--kbl", "nowhere.kbl"]).says(3, &["nowhere.kbl"]);
    export(&["--tolerance", "0"]).says(1, &["0 is not above zero"]);
    export(&["--tolerance", "1e-9 mm"]).says(1, &["cannot be fitted to", "give a larger tolerance"]);
    place.run(&["export", "kbl", "o", "-o", "harness.kbl"]).says(1, &["harness.kbl is the file that is read"]);
    let changed = |old: &str, new: &str| {
        let text = place.text("s.toml");
        assert!(text.contains(old), "{old}");
        place.file("t.toml", text.replacen(old, new, 1));
        place.run(&["export", "kbl", "t.toml", "-o", "w.kbl"])
    };
    let not_converged = ["the run did not converge (iteration limit): its shapes are not those of the harness"];
    changed("[minimiser]", "[minimiser]\nmax_iterations = 1").says(1, &not_converged);
    changed("[kbl]", "#").says(1, &[]);
    changed("kbl = \"s4\"", "kbl = \"s7\"").says(1, &["no segments `s7` (of branch `stub`)"]);
    // Without its id a branch is listed.
    changed("kbl = \"s4\"", "")
        .says(0, &["come from no segment of the file; not written: stub", "left as they are: s4"]);
    // Arms of a hub leave it beside its point.
    let offset = "{ branch = \"stub\", offset = [0.0, 0.0, 0.004], ";
    let text = place.text("s.toml").replacen("model = \"cosserat\"", "model = \"rigid-body\"", 1);
    assert!(text.contains("{ branch = \"stub\", "));
    place.file("t.toml", text.replacen("{ branch = \"stub\", ", offset, 1));
    let ended = place.run(&["export", "kbl", "t.toml", "-o", "w.kbl"]);
    ended.says(1, &["`stub` end at node `n2` of the file but 4.000 mm apart"]);
    place.file("plain.toml", fs::read(root().join("scenarios/first.toml"))?);
    let no_file = ["its scenario names no KBL file in [kbl]"];
    place.run(&["export", "kbl", "plain.toml", "-o", "w.kbl"]).says(1, &no_file);
    fs::remove_file(place.path("harness.kbl"))?;
    export(&[]).says(1, &["`harness.kbl` is neither here nor beside it: say with --kbl where it is"]);
    Ok(())
}
