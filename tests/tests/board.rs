//! `wireloom formboard`: what is written is true to the harness, and the harness is at rest on its board. The real
//! harnesses lie outside the repository: where they are absent their tests show as ignored.

use libtest_mimic::{Arguments, Failed, Trial};
use std::fs;
use std::path::Path;
use wireloom::Status;
use wireloom::session::Monitor;
use wireloom_tests::place::{Ended, Place};
use wireloom_tests::{root, shared};

/// Largest force of a peg, N, on a harness that is at rest but for its weight.
const MOST: f64 = 1.0;

fn main() {
    let folder = shared("data/old-beetle");
    let real = ["batterie_plus", "generator", "main_harness"].into_iter().map(|name| {
        let file = folder.join(format!("{name}.kbl"));
        let absent = !file.is_file();
        let reason = if absent { format!(" (ignored: {} is not there)", file.display()) } else { String::new() };
        Trial::test(format!("{name}: a board at rest{reason}"), move || at_rest(&file)).with_ignored_flag(absent)
    });
    let made = ["first", "branches/sixteen_arms", "branches/comb_six_arms", "branches/two_trees"].map(|name| {
        let file = root().join(format!("scenarios/{name}.toml"));
        Trial::test(format!("{name}: a board at rest"), move || at_rest(&file))
    });
    let others: [(&str, Check); 9] = [
        ("small.kbl: a board at rest", || at_rest(&root().join("crates/import/tests/small.kbl"))),
        ("a loop is cut open, and told", loops),
        ("a weight at a joint that a cut makes an end stays there", weight_at_a_cut),
        ("weights are told from other loads with their factors", factors),
        ("drawn lines of the vehicle are not those of the board", drawn),
        ("irregularities of a KBL file are told", irregularities),
        ("a short board has bends, and its harness is at rest", bends),
        ("memory is between the file and the board", memory),
        ("bad input is refused with what would be right", refused),
    ];
    let others = others.into_iter().map(|(name, check)| Trial::test(name, check));
    libtest_mimic::run(&Arguments::from_args(), real.chain(made).chain(others).collect()).exit();
}

/// A test.
type Check = fn() -> Result<(), Failed>;

fn ensure(holds: bool, what: impl FnOnce() -> String) -> Result<(), Failed> {
    if holds { Ok(()) } else { Err(what().into()) }
}

/// Lays a file in a folder `o`.
fn lay(place: &Place, file: &str, more: &[&str]) -> Ended {
    place.run(&[&["formboard", file, "-o", "o"], more].concat())
}

/// Pegs of the equilibrium on the board, and the forces that they exert, N, beside the weight of a connector that lies
/// on one of them; all else that holds it is a root.
fn forces(text: &str) -> Result<Vec<(String, f64)>, Failed> {
    let registry = wireloom::registry();
    let (scenario, built) = wireloom::load(text, &registry).map_err(|faults| format!("{faults:?}"))?;
    let meshed = wireloom::mesh::by_accuracy(scenario, built, &registry, &Monitor::default());
    let (scenario, built) = meshed.map_err(|faults| format!("{faults:?}"))?;
    let run = wireloom::run(built, &mut |_, _| wireloom::Control::Continue);
    ensure(run.status() == Status::Converged, || format!("{:?}", run.status()))?;
    let step = &run.steps[0];
    let table: toml::Table = toml::from_str(text)?;
    let entries = |key: &str| table.get(key).and_then(toml::Value::as_array).cloned().unwrap_or_default();
    let (constraints, loads) = (entries("constraints"), entries("loads"));
    let weight = |name: &str| {
        let at = constraints.iter().find(|own| own["name"].as_str() == Some(name)).map(|own| &own["at"]);
        let here = loads.iter().filter(|load| at.is_some() && load.get("at") == at);
        let down = |load: &toml::Value| load["force"][2].as_float().unwrap_or(0.0);
        here.map(down).sum::<f64>()
    };
    let pegs = scenario.constraints.iter().zip(&step.constraints).filter(|(own, _)| !own.name.starts_with("root, "));
    Ok(pegs
        .map(|(own, found)| {
            let [x, y, z] = found.force.into();
            (own.name.clone(), f64::hypot(x.hypot(y), z + weight(&own.name)))
        })
        .collect())
}

/// Everything about a board that has no bends: four files, the same bytes twice, lengths, pegs that bear weight alone.
fn at_rest(file: &Path) -> Result<(), Failed> {
    let place = Place::new("");
    let name = file.to_str().ok_or("a path of UTF-8")?;
    lay(&place, name, &[]).says(0, &[]);
    let files = ["board.svg", "board.dxf", "board.pdf", "board.toml"];
    let first: Vec<Vec<u8>> =
        files.iter().map(|name| fs::read(place.path(&format!("o/{name}")))).collect::<Result<_, _>>()?;
    lay(&place, name, &[]).says(0, &[]);
    for (name, bytes) in files.iter().zip(&first) {
        ensure(fs::read(place.path(&format!("o/{name}")))? == *bytes, || format!("{name} has other bytes"))?;
    }
    let text = place.text("o/board.toml");
    let (scenario, _) = wireloom::load(&text, &wireloom::registry()).map_err(|faults| format!("{faults:?}"))?;
    for branch in &scenario.branches {
        let [a, b] = branch.path[..] else { return Err(format!("{branch:?} is not straight").into()) };
        let drawn = (b - a).norm();
        ensure((drawn / branch.length - 1.0).abs() < 1e-9, || format!("{drawn} of {branch:?}"))?;
    }
    let pegs = forces(&text)?;
    ensure(!pegs.is_empty(), || format!("{pegs:?}"))?;
    let worst = pegs.iter().max_by(|a, b| a.1.total_cmp(&b.1)).ok_or("no pegs")?;
    ensure(worst.1 <= MOST, || format!("{worst:?}"))
}

/// A square of four branches with a tail.
const LOOP: &str = r#"
schema = 1
name = "loop"
[sections.cable]
diameter = "6 mm"
linear_density = "50 g/m"
axial_stiffness = 1e4
bending_stiffness = 0.01
torsion_stiffness = 0.008
min_bend_radius = "30 mm"
BRANCHES
[[joints]]
name = "P"
arms = [
  { branch = "tail", direction = [-1, 0, 0], up = [0, 0, 1] },
  { branch = "pq", direction = [1, 0, 0], up = [0, 0, 1] },
  { branch = "sp", direction = [0, 1, 0], up = [0, 0, 1] },
]
[[joints]]
name = "Q"
arms = [
  { branch = "pq", direction = [-1, 0, 0], up = [0, 0, 1] },
  { branch = "qs", direction = [0, 1, 0], up = [0, 0, 1] },
]
[[joints]]
name = "S"
arms = [
  { branch = "qs", direction = [0, -1, 0], up = [0, 0, 1] },
  { branch = "sp", direction = [-1, 0, 0], up = [0, 0, 1] },
]
[[constraints]]
name = "plug"
kind = "connector"
at = { end = "A" }
position = [0, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
"#;

fn loop_of(length: &str) -> String {
    let branch = |name: &str, from: &str, to: &str, length: &str| {
        format!(
            "[[branches]]\nname = \"{name}\"\nfrom = \"{from}\"\nto = \"{to}\"\nsection = \"cable\"\n\
             length = \"{length}\"\nsegments = 20\n"
        )
    };
    let branches = [
        branch("tail", "A", "P", "300 mm"),
        branch("pq", "P", "Q", "200 mm"),
        branch("qs", "Q", "S", "250 mm"),
        branch("sp", "S", "P", length),
    ];
    LOOP.replace("BRANCHES", &branches.concat())
}

fn loops() -> Result<(), Failed> {
    let place = Place::new(&loop_of("400 mm"));
    let ended = lay(&place, "s.toml", &[]);
    ended.says(0, &["branches close loops and are cut open at one end: `sp` from `P`"]);
    let text = place.text("o/board.toml");
    let table: toml::Table = toml::from_str(&text)?;
    let joints: Vec<usize> =
        table["joints"].as_array().ok_or("joints")?.iter().map(|j| j["arms"].as_array().map_or(0, Vec::len)).collect();
    ensure(joints == [2, 2, 2], || format!("{joints:?}"))?;
    ensure(forces(&text)?.iter().all(|(_, force)| *force <= MOST), || text.clone())
}

/// The square, cut open at the end of the branch from Q to S: one branch is left at S.
fn cut_at_s() -> String {
    loop_of("400 mm").replace("length = \"250 mm\"", "length = \"500 mm\"")
}

/// The command failed with a fault of the scenario that it had made.
fn weight_at_a_cut() -> Result<(), Failed> {
    let weight = "[[loads]]\nname = \"w\"\nat = { joint = \"S\" }\nforce = [0, 0, -0.1]\n";
    let place = Place::new(&(cut_at_s() + weight));
    lay(&place, "s.toml", &[]).says(0, &["branches close loops and are cut open at one end: `qs` from `S`"]);
    let text = place.text("o/board.toml");
    let table: toml::Table = toml::from_str(&text)?;
    let load = &table["loads"][0];
    ensure(load["at"]["end"].as_str() == Some("S") && load["force"][2].as_float() == Some(-0.1), || {
        format!("{load:?}")
    })?;
    ensure(table["joints"].as_array().map(Vec::len) == Some(2), || text.clone())?;
    ensure(forces(&text)?.iter().all(|(_, force)| *force <= MOST), || text.clone())
}

/// A load with a factor below zero counted by its force alone: what pulls upwards became a weight.
fn factors() -> Result<(), Failed> {
    let load = |name: &str, what: &str| format!("[[loads]]\nname = \"{name}\"\n{what}\n");
    let at = "at = { branch = \"pq\", s = 0.1 }";
    let loads = [
        load("up", &format!("{at}\nforce = [0, 0, -0.05]\nfactor = -1")),
        load("down", &format!("{at}\nforce = [0, 0, 0.05]\nfactor = -2")),
        load("tape", "span = { branch = \"tail\" }\nforce_per_length = [0, 0, -0.1]"),
        load("wind", "span = { branch = \"tail\" }\nforce_per_length = [0.1, 0, -0.1]"),
    ];
    let place = Place::new(&(cut_at_s() + &loads.concat()));
    lay(&place, "s.toml", &[]).says(0, &["loads that are no weights are left out (2 of them): `up`, `wind`"]);
    let table: toml::Table = toml::from_str(&place.text("o/board.toml"))?;
    let loads = table["loads"].as_array().ok_or("loads")?;
    let names: Vec<_> = loads.iter().map(|own| own["name"].as_str().unwrap_or_default()).collect();
    ensure(names == ["down", "tape"], || format!("{names:?}"))?;
    let is = |value: &toml::Value, expected: f64| value.as_float().is_some_and(|own| (own - expected).abs() < 1e-12);
    let [down, tape] = [&loads[0]["force"][2], &loads[1]["force_per_length"][2]];
    ensure(is(down, 0.05) && is(tape, -0.1), || format!("{loads:?}"))
}

fn drawn() -> Result<(), Failed> {
    let line = "drawn = [[0, 0, 1], [0.3, 0, 1]]";
    let place = Place::new(&loop_of("400 mm").replace("length = \"300 mm\"", &format!("length = \"300 mm\"\n{line}")));
    lay(&place, "s.toml", &[]).says(0, &[]);
    ensure(place.text("s.toml").contains(line) && !place.text("o/board.toml").contains("drawn ="), || {
        place.text("o/board.toml")
    })
}

fn irregularities() -> Result<(), Failed> {
    let place = Place::new("");
    let file = root().join("crates/import/tests/small.kbl");
    let ended = lay(&place, file.to_str().ok_or("a path of UTF-8")?, &[]);
    ended.says(0, &["found: ends carry no component; left free: n4", "found: stale centre curves"]);
    // What is not shown is where the message says.
    ensure(place.text("o/board.toml").contains("# Irregularities of the KBL file"), || place.text("o/board.toml"))
}

fn bends() -> Result<(), Failed> {
    let place = Place::new(&fs::read_to_string(root().join("scenarios/first.toml"))?);
    // The trunk and an arm are 1 m long together.
    let ended = lay(&place, "s.toml", &["--board", "800x700"]);
    ended.says(0, &["the trunk is not straight"]);
    let text = place.text("o/board.toml");
    ensure(forces(&text)?.iter().all(|(_, force)| *force <= MOST), || text.clone())
}

fn memory() -> Result<(), Failed> {
    let place = Place::new(&fs::read_to_string(root().join("scenarios/branches/y_cosserat.toml"))?);
    let arm = |memory: &str| -> Result<Vec<f64>, Failed> {
        lay(&place, "s.toml", &["--memory", memory]).says(0, &[]);
        place.run(&["run", "o/board.toml", "--quiet"]).says(0, &[]);
        let table: toml::Table = toml::from_str(&place.text("o/board.toml"))?;
        let arms = table["joints"][0]["arms"].as_array().ok_or("arms")?;
        // Angles between the frames of the first arm and of the others.
        let frame = |k: usize| [0, 1, 2, 3].map(|i| arms[k]["orientation"][i].as_float().unwrap_or(0.0));
        let between = |a: [f64; 4], b: [f64; 4]| {
            2.0 * (0..4).map(|i| a[i] * b[i]).sum::<f64>().abs().min(1.0).acos().to_degrees()
        };
        Ok((1..arms.len()).map(|k| between(frame(0), frame(k))).collect())
    };
    let (none, part, all) = (arm("0")?, arm("0.3")?, arm("1")?);
    for ((none, part), all) in none.iter().zip(&part).zip(&all) {
        let (low, high) = (none.min(*all) - 1e-6, none.max(*all) + 1e-6);
        ensure((low..=high).contains(part), || format!("{none} {part} {all}"))?;
    }
    ensure(none != all, || format!("{none:?} {all:?}"))
}

fn refused() -> Result<(), Failed> {
    let place = Place::new(&loop_of("400 mm"));
    let says = |more: &[&str], code: i32, words: &[&str]| {
        let ended = lay(&place, more[0], &more[1..]);
        ended.says(code, words);
        ensure(!place.path("o").exists(), || format!("{ended:#?}"))
    };
    place.file("harness.txt", "");
    says(&["harness.txt"], 1, &["a scenario (.toml), a KBL file (.kbl, .xml) or a VEC file (.vec), not of `.txt`"])?;
    place.file("not.kbl", "<other/>");
    says(&["not.kbl"], 1, &["not.kbl cannot be imported: 1:1: "])?;
    says(&["s.toml", "--memory", "1.2"], 1, &["between 0 (as in the scenario) and 1 (as on the board), not 1.2"])?;
    says(&["s.toml", "--memory", "-0.1"], 1, &["not -0.1"])?;
    says(&["s.toml", "--memory", "nan"], 1, &["not NaN"])?;
    says(&["s.toml", "--board", "120x110"], 1, &["does not fit on a board of 120 mm x 110 mm", "larger --board"])?;
    says(&["s.toml", "--board", "large"], 1, &["is no width and height: write such as 4000x1600 (mm)"])?;
    says(&["s.toml", "--board", "200 m x 1 m"], 1, &["200.0 m x 1.0 m cannot be drawn; 100 m is the longest side"])?;
    place.file("long.toml", loop_of("400 mm").replace("\"300 mm\"", "\"150 m\""));
    says(&["long.toml"], 1, &["long.toml: a board of 15", " m cannot be drawn; 100 m is the longest side"])?;
    says(&["s.toml", "--gap", "-1 mm"], 1, &["above zero"])?;
    says(&["s.toml", "--gap", "-1"], 1, &["above zero"])?;
    says(&["s.toml", "--margin", "-1"], 1, &["above zero"])?;
    says(&["s.toml", "--paper", "a9"], 1, &["a0"])?;
    says(&["s.toml", "--variant", "x"], 1, &["--variant chooses modules of a KBL or VEC file; s.toml is a scenario"])?;
    place.file("faulty.toml", loop_of("-1 mm"));
    says(&["faulty.toml"], 1, &["faulty.toml:"])?;
    let body = fs::read_to_string(root().join("scenarios/assembly/springy_on_an_offset_arm.toml"))?;
    place.file("body.toml", body);
    says(&["body.toml"], 1, &["body.toml:33:", "a formboard takes joints for points", "leave `offset` out"])?;
    says(&["missing.toml"], 3, &["missing.toml"])
}
