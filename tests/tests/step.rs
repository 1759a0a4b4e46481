//! Surroundings out of STEP files: triangles, names, colours and places; what is refused; the cache; the other process.

use libtest_mimic::{Arguments, Failed, Trial};
use serde_json::Value;
use std::collections::HashMap;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, ExitCode, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use wireloom::geometry::Vector;
use wireloom::harness::ShapeFile;
use wireloom::session::Monitor;
use wireloom::shapes::mesh::{Mesh, read};
use wireloom::step::{Assembly, PYTHON, Reader};
use wireloom_tests::cables::{branch, connector, hanging, section};
use wireloom_tests::{program, root};

type Checked = Result<(), Failed>;
type Check = fn() -> Checked;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let with_open_cascade: [(&str, Check); 11] = [
        ("triangles are closed, on the surface, and have its volume to what the deflection allows", volumes),
        ("an assembly keeps tree, names, colours and places, in millimetres and in inches", assembly),
        ("a whole file is one obstacle at the places of its parts", whole_file),
        ("a scenario takes the obstacles of an import", imported_obstacles),
        ("a cable rests on a box out of a STEP file as on the primitive", rests_on_a_box),
        ("names that are there twice become unique, which is said", same_names),
        ("parts are left out by pattern", left_out),
        ("files without solids, units or faultless text are refused by part and line", refused),
        ("what Open CASCADE does not understand is refused or noted", not_understood),
        ("a deflection with which a part loses its shape is refused", too_coarse),
        ("what was read is kept: the same bytes without Open CASCADE, never for another deflection or file", kept),
    ];
    let python = with_package(&python()).then(python);
    let reason =
        if python.is_some() { "" } else { " (ignored: no python3, or the one WIRELOOM_PYTHON names, with OCP)" };
    let open_cascade = with_open_cascade
        .into_iter()
        .map(|(name, check)| Trial::test(format!("{name}{reason}"), check).with_ignored_flag(python.is_none()));
    let alone: [(&str, Check); 3] = [
        ("what is no whole STEP file is refused before anything is started", not_started),
        ("keys that do not go with a STEP file, or only with one, are refused with their place", keys),
        ("a missing Python or package is said, with what to install", missing),
    ];
    let alone = alone.into_iter().map(|(name, check)| Trial::test(name, check));
    let shell: [(&str, Check); 3] = [
        ("a process that crashes, or writes what cannot be read, is a message", crashes),
        ("a process that hangs is ended after the time limit", hangs),
        ("Ctrl-C ends the process that reads, too", interrupted),
    ];
    let reason = if cfg!(unix) { "" } else { " (ignored: no shell on this system)" };
    let shell = shell
        .into_iter()
        .map(|(name, check)| Trial::test(format!("{name}{reason}"), check).with_ignored_flag(!cfg!(unix)));
    libtest_mimic::run(&arguments, open_cascade.chain(alone).chain(shell).collect()).exit_code()
}

fn ensure(holds: bool, otherwise: impl std::fmt::Debug) -> Checked {
    if holds { Ok(()) } else { Err(format!("{otherwise:#?}").into()) }
}

fn python() -> String {
    std::env::var(PYTHON).unwrap_or_else(|_| "python3".into())
}

/// Whether a Python has Open CASCADE.
fn with_package(python: &str) -> bool {
    let mut asked = Command::new(python);
    asked.args(["-c", "import OCP.STEPCAFControl"]).stdout(Stdio::null()).stderr(Stdio::null());
    asked.status().is_ok_and(|status| status.success())
}

/// A folder to work in, with a cache of its own.
struct Place(TempDir);

impl Place {
    fn new() -> Result<Self, Failed> {
        Ok(Self(tempfile::tempdir()?))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Makes a STEP file; returns what `make.py` says of it.
    fn make(&self, kind: &str, unit: &str, name: &str) -> Result<Value, Failed> {
        let script = self.path("make.py");
        fs::write(&script, include_str!("step/make.py"))?;
        let output = Command::new(python()).arg(script).args([kind, unit]).arg(self.path(name)).output()?;
        ensure(output.status.success(), &output)?;
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        let json = said.lines().find(|line| line.starts_with('{'));
        Ok(json.map(serde_json::from_str).transpose()?.unwrap_or_default())
    }

    /// Reads a file of this folder.
    fn read(&self, name: &str, deflection: f64) -> Result<Assembly, Failed> {
        let bytes = fs::read(self.path(name))?;
        let read = Reader::from_environment(Monitor::default()).with_cache(self.path("cache")).read(&bytes, deflection);
        Ok(read.map(|assembly| (*assembly).clone()).map_err(|error| error.to_string())?)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(program());
        command.args(arguments).current_dir(self.0.path()).env("WIRELOOM_CACHE", self.path("cache"));
        command
    }

    fn run(&self, arguments: &[&str]) -> Result<Ended, Failed> {
        Ok(self.command(arguments).output()?.into())
    }

    /// Imports a file into the folder `around`; returns the names, meshes, positions and orientations of the obstacles.
    fn import(&self, name: &str, more: &[&str]) -> Result<(Vec<toml::Table>, Ended), Failed> {
        let ended = self.run(&[&["import", "step", name, "-o", "around"], more].concat())?;
        ensure(ended.code == Some(0), &ended)?;
        let table: toml::Table = fs::read_to_string(self.path("around/obstacles.toml"))?.parse()?;
        let obstacles = table["obstacles"].as_array().ok_or("no obstacles")?;
        Ok((obstacles.iter().filter_map(|own| own.as_table().cloned()).collect(), ended))
    }
}

#[derive(Debug)]
struct Ended {
    code: Option<i32>,
    out: String,
    /// Without the lines that tell how long a slow machine has worked so far.
    err: String,
}

impl From<Output> for Ended {
    fn from(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        let is_progress = |line: &str| line.contains("s: reading ");
        let err = text(output.stderr).split_inclusive('\n').filter(|line| !is_progress(line)).collect();
        Self { code: output.status.code(), out: text(output.stdout), err }
    }
}

/// Enclosed volume, m³, and the number of edges that do not have one triangle on either side.
fn volume(surface: &wireloom::harness::Surface) -> (f64, usize) {
    let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
    for [a, b, c] in &surface.triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *edges.entry([*from.min(to), *from.max(to)]).or_default() += if from < to { 1 } else { -1 };
        }
    }
    let at = |k: u32| surface.corners[k as usize];
    let volume = surface.triangles.iter().map(|[a, b, c]| at(*a).dot(&at(*b).cross(&at(*c)))).sum::<f64>() / 6.0;
    (volume, edges.values().filter(|balance| **balance != 0).count())
}

/// Triangles lie at most the deflection away from the surface: the volume between them is at most its area times that.
fn volumes() -> Checked {
    let place = Place::new()?;
    for (kind, deflections) in [("bracket", &[5e-4, 1e-4, 2e-5][..]), ("torus", &[1e-4]), ("sphere", &[1e-4])] {
        let exact = place.make(kind, "MM", "part.step")?;
        let exact = |key: &str, unit: f64| exact[key].as_f64().map(|x| x * unit).ok_or("no number");
        let (exact_volume, area) = (exact("volume", 1e-9)?, exact("area", 1e-6)?);
        for deflection in deflections {
            let assembly = place.read("part.step", *deflection)?;
            let solid = &assembly.parts[0].solids[0];
            let (found, open) = volume(&solid.surface);
            ensure(open == 0, (kind, deflection, open, "edges are open"))?;
            ensure((solid.volume / exact_volume - 1.0).abs() < 1e-9, (kind, solid.volume, exact_volume))?;
            let allowed = area * deflection;
            ensure((found - exact_volume).abs() <= allowed, (kind, deflection, found, exact_volume, allowed))?;
            Mesh::new(&solid.surface, false)?;
            let off = solid.surface.corners.iter().map(|corner| match kind {
                "sphere" => (corner.norm() - 0.02).abs(),
                "torus" => (corner.xy().norm() - 0.03).hypot(corner.z) - 0.005,
                _ => 0.0,
            });
            let worst = off.fold(0.0, |worst: f64, off| worst.max(off.abs()));
            ensure(worst < 1e-9, (kind, "corners are off the surface", worst))?;
        }
    }
    // Closed forms: of Pappus and Archimedes.
    let torus = std::f64::consts::PI.powi(2) * 2.0 * 0.03 * 0.005_f64.powi(2);
    let exact = place.make("torus", "MM", "part.step")?["volume"].as_f64().unwrap_or(0.0) * 1e-9;
    ensure((exact / torus - 1.0).abs() < 1e-9, (exact, torus))
}

/// Corners of the box of `make.py` in the frame of the car, and of the spare one.
fn boxes() -> [Vec<Vector>; 2] {
    let corners =
        || (0..8).map(|k| Vector::new(f64::from(k & 1) * 40.0, f64::from(k >> 1 & 1) * 30.0, f64::from(k >> 2) * 20.0));
    // A quarter turn about z takes x to y and y to −x.
    let turned = |x: Vector| Vector::new(-x.y, x.x, x.z);
    let front = corners().map(|x| (Vector::new(1000.0, 0.0, 3.0) + turned(Vector::new(100.0, 20.0, -7.0) + x)) * 1e-3);
    let spare = corners().map(|x| (Vector::new(-30.0, 5.0, 1.0) + x) * 1e-3);
    [front.collect(), spare.collect()]
}

/// Largest distance of the expected corners from those that were found.
fn missed(expected: &[Vector], found: &[Vector]) -> f64 {
    let nearest = |x: &Vector| found.iter().map(|y| (x - y).norm()).fold(f64::INFINITY, f64::min);
    expected.iter().map(nearest).fold(0.0, f64::max)
}

fn vector(own: &toml::Table, key: &str) -> Option<Vec<f64>> {
    own.get(key)?.as_array()?.iter().map(toml::Value::as_float).collect()
}

fn assembly() -> Checked {
    for unit in ["MM", "INCH"] {
        let place = Place::new()?;
        place.make("assembly", unit, "car.stp")?;
        let (obstacles, ended) = place.import("car.stp", &["--deflection", "0.05"])?;
        ensure(ended.out.contains("(3 obstacles, 2 meshes, "), &ended)?;
        ensure(ended.out.contains(&*place.path("cache").to_string_lossy()), &ended)?;
        let names: Vec<_> = obstacles.iter().map(|own| own["name"].as_str()).collect();
        ensure(names == [Some("car/front/box"), Some("car/front/ring"), Some("car/spare")], &names)?;
        let meshes: Vec<_> = obstacles.iter().map(|own| own["mesh"].as_str()).collect();
        ensure(meshes == [Some("around/box.glb"), Some("around/ring.glb"), Some("around/box.glb")], &meshes)?;
        // Positions of the parts: of the front box (1000, 0, 3) + a quarter turn of (100, 20, −7).
        let positions: Vec<_> = obstacles.iter().filter_map(|own| vector(own, "position")).collect();
        let expected = [[0.98, 0.1, -0.004], [1.0, 0.0, 0.053], [-0.03, 0.005, 0.001]];
        let off = positions.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs());
        ensure(positions.len() == 3 && off.fold(0.0, f64::max) < 1e-9, &positions)?;
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turn = vector(&obstacles[0], "orientation").ok_or("no orientation")?;
        ensure(turn.iter().zip([half, 0.0, 0.0, half]).all(|(a, b)| (a - b).abs() < 1e-9), &turn)?;
        ensure(!obstacles[2].contains_key("orientation"), &obstacles[2])?;
        // The mesh: name, colour, corners.
        let bytes = fs::read(place.path("around/box.glb"))?;
        let text = &bytes[20..20 + u32::from_le_bytes(bytes[12..16].try_into()?) as usize];
        let gltf: Value = serde_json::from_slice(text)?;
        ensure(gltf["nodes"][0]["name"] == "box" && gltf["meshes"][0]["name"] == "box", &gltf)?;
        let material = gltf["meshes"][0]["primitives"][0]["material"].as_u64().ok_or("no material")? as usize;
        let colour = &gltf["materials"][material]["pbrMetallicRoughness"]["baseColorFactor"];
        ensure(*colour == serde_json::json!([1.0, 0.0, 0.0, 1.0]), &gltf)?;
        let surface = read(&ShapeFile { name: "box.glb".into(), bytes, scale: 1.0 })?;
        let corners: Vec<Vector> = boxes()[1].iter().map(|x| x - Vector::new(-0.03, 0.005, 0.001)).collect();
        ensure(surface.corners.len() == 8, surface.corners.len())?;
        ensure(missed(&corners, &surface.corners) < 1e-9, missed(&corners, &surface.corners))?;
    }
    Ok(())
}

fn whole_file() -> Checked {
    let place = Place::new()?;
    place.make("assembly", "INCH", "car.step")?;
    let table = "[[obstacles]]\nname = \"car\"\nmesh = \"car.step\"\ndeflection = \"0.5 mm\"\nposition = [5, 0, 0]\n";
    fs::write(place.path("s.toml"), hanging("s", 6, table))?;
    let ended = place.run(&["check", "s.toml"])?;
    ensure(ended.code == Some(0), &ended)?;
    let (surface, _) = place.read("car.step", 5e-4)?.surface(5e-4).map_err(|error| error.to_string())?;
    let off = boxes().map(|corners| missed(&corners, &surface.corners));
    ensure(off.iter().all(|off| *off < 1e-9), off)?;
    // Bodies that touch share edges, which one surface cannot have.
    place.make("touching", "MM", "pair.step")?;
    fs::write(place.path("s.toml"), hanging("s", 6, "[[obstacles]]\nname = \"pair\"\nmesh = \"pair.step\"\n"))?;
    let ended = place.run(&["check", "s.toml"])?;
    ensure(ended.code == Some(1) && ended.err.contains("import step makes a file of each part"), &ended)?;
    let (obstacles, _) = place.import("pair.step", &[])?;
    ensure(obstacles.len() == 2, obstacles)
}

fn imported_obstacles() -> Checked {
    let place = Place::new()?;
    place.make("assembly", "MM", "car.step")?;
    place.import("car.step", &[])?;
    let obstacles = fs::read_to_string(place.path("around/obstacles.toml"))?;
    fs::write(place.path("s.toml"), hanging("s", 6, &obstacles.replace("position = [-0.03", "position = [-3.0")))?;
    let ended = place.run(&["check", "s.toml"])?;
    ensure(ended.code == Some(0), &ended)?;
    // Files of an earlier import go.
    place.import("car.step", &["--without", "ring"])?;
    ensure(!place.path("around/ring.glb").exists() && place.path("around/box.glb").exists(), "old meshes are there")
}

/// The sides and edges of the box are exact in triangles, so only round-off and tolerances of the solver differ. A
/// cable that a plug holds lies on the top of the box, then over its edge.
fn rests_on_a_box() -> Checked {
    let place = Place::new()?;
    place.make("box", "MM", "box.step")?;
    let positions = |shape: &str, x: f64| {
        let text = [
            "schema = 1\nname = \"s\"\n",
            &section("cable"),
            &branch("cable", ["A", "B"], "cable", 0.35, 14),
            &connector("plug", "A", [0.0, 0.0, 0.0]),
            &format!("[[obstacles]]\nname = \"box\"\n{shape}position = [{x}, 0, -0.08]\n"),
        ];
        fs::write(place.path("s.toml"), text.concat())?;
        let ended = place.run(&["run", "s.toml", "--quiet", "--out", "out"])?;
        ensure(ended.code == Some(0), &ended)?;
        let result: Value = serde_json::from_str(&fs::read_to_string(place.path("out/result.json"))?)?;
        let step = &result["steps"][0];
        let force = step["obstacles"]["box"]["force"][2].as_f64().ok_or("no force")?;
        let nodes = step["branches"]["cable"]["position"].as_array().ok_or("no positions")?;
        let numbers = nodes.iter().flat_map(|x| x.as_array().into_iter().flatten());
        Ok::<_, Failed>((force, numbers.filter_map(Value::as_f64).collect::<Vec<f64>>()))
    };
    for x in [0.3, 0.06] {
        let primitive = positions("shape = \"box\"\nsize = [0.25, 0.2, 0.12]\n", x)?;
        let step = positions("mesh = \"box.step\"\n", x)?;
        ensure(primitive.0 > 0.01, ("it does not touch", primitive.0))?;
        let off = primitive.1.iter().zip(&step.1).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        ensure(primitive.1.len() == 45 && step.1.len() == 45 && off < 1e-7, (x, off, primitive.1.len()))?;
        ensure((primitive.0 / step.0 - 1.0).abs() < 1e-5, (x, primitive.0, step.0))?;
    }
    Ok(())
}

fn same_names() -> Checked {
    let place = Place::new()?;
    place.make("twice", "MM", "pair.step")?;
    let (obstacles, ended) = place.import("pair.step", &[])?;
    let names: Vec<_> = obstacles.iter().map(|own| own["name"].as_str()).collect();
    ensure(names == [Some("pair/box"), Some("pair/box 2")], &names)?;
    let said = "found: the name \"pair/box\" is there more than once: one is now \"pair/box 2\"";
    ensure(ended.err.contains(said), &ended)
}

fn left_out() -> Checked {
    let place = Place::new()?;
    place.make("assembly", "MM", "car.step")?;
    let (obstacles, ended) = place.import("car.step", &["--without", "*/front/*"])?;
    ensure(obstacles.len() == 1 && ended.err.contains("2 parts left out by \"*/front/*\""), &ended)?;
    let (obstacles, _) = place.import("car.step", &["--without", "box"])?;
    ensure(obstacles.len() == 1, "by the name of the part")?;
    let ended = place.run(&["import", "step", "car.step", "-o", "new", "--without", "screw*"])?;
    let said = "error: car.step: the pattern \"screw*\" fits no part\n  help: its parts are \"car/front/box\"";
    ensure(ended.code == Some(1) && ended.err.starts_with(said) && !place.path("new").exists(), &ended)?;
    // An open shell that is left out is no fault.
    place.make("sheet", "MM", "sheet.step")?;
    let ended = place.run(&["import", "step", "sheet.step", "-o", "new"])?;
    let said = "error: sheet.step: part \"sheet\" is an open shell: it has 1 face that encloses no solid";
    ensure(ended.code == Some(1) && ended.err.starts_with(said), &ended)?;
    let (obstacles, _) = place.import("sheet.step", &["--without", "panel"])?;
    ensure(obstacles.len() == 1, obstacles)
}

fn refused() -> Checked {
    let place = Place::new()?;
    place.make("box", "MM", "box.step")?;
    let text = fs::read_to_string(place.path("box.step"))?;
    let refusal = |text: &str| {
        fs::write(place.path("bad.step"), text)?;
        let ended = place.run(&["import", "step", "bad.step", "-o", "new"])?;
        ensure(ended.code == Some(1) && !place.path("new").exists(), &ended)?;
        Ok::<_, Failed>(ended.err)
    };
    let unit = text.find("LENGTH_UNIT()").ok_or("no unit")?;
    let begin = text[..unit].rfind('(').ok_or("no unit")?;
    let end = unit + text[unit..].find(';').ok_or("no unit")?;
    let without = format!("{}( NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.) ){}", &text[..begin], &text[end..]);
    let line = text[..text.find("GLOBAL_UNIT_ASSIGNED_CONTEXT").ok_or("no context")?].lines().count();
    let said = refusal(&without)?;
    ensure(said.starts_with(&format!("error: bad.step:{line}: it says no unit of length")), (said, line))?;
    let said = refusal(&text.replacen("#20 = ", "#20 = = ", 1))?;
    ensure(
        said.starts_with("error: bad.step") && said.contains("Open CASCADE finds faults in it: ERR StepFile"),
        said,
    )?;
    // A face that is missing opens the shell.
    let shell = text.find("CLOSED_SHELL('',(").ok_or("no shell")? + "CLOSED_SHELL('',(".len();
    let next = shell + text[shell..].find(',').ok_or("one face")? + 1;
    let said = refusal(&format!("{}{}", &text[..shell], &text[next..]))?;
    ensure(said.contains("part \"box\" is an open shell: it has 5 faces that enclose no solid"), said)?;
    place.make("wire", "MM", "wire.step")?;
    let said = refusal(&fs::read_to_string(place.path("wire.step"))?)?;
    ensure(said.starts_with("error: bad.step: it has no solids\n  help: contact needs solid bodies"), said)?;
    // In a scenario, at the key.
    fs::write(place.path("s.toml"), hanging("s", 6, "[[obstacles]]\nname = \"x\"\nmesh = \"bad.step\"\n"))?;
    let ended = place.run(&["check", "s.toml"])?;
    let line = fs::read_to_string(place.path("s.toml"))?.lines().count();
    let said = format!("s.toml:{line}:8: obstacle \"x\": \"bad.step\" cannot be read as STEP: it has no solids");
    ensure(ended.code == Some(1) && ended.err.starts_with(&said), (ended, said))
}

/// Types that another version of the format has.
fn not_understood() -> Checked {
    let place = Place::new()?;
    place.make("assembly", "MM", "car.step")?;
    let text = fs::read_to_string(place.path("car.step"))?;
    let import = |from: &str, to: &str| {
        fs::write(place.path("other.step"), text.replacen(from, to, 1))?;
        place.run(&["import", "step", "other.step", "-o", "new"])
    };
    let ended = import("MANIFOLD_SOLID_BREP", "OTHER_SOLID_BREP")?;
    let said = "error: other.step: part \"box\" has no shape: Open CASCADE could make none of what the file says";
    ensure(ended.code == Some(1) && ended.err.starts_with(said), &ended)?;
    let ended = import("ITEM_DEFINED_TRANSFORMATION", "OTHER_TRANSFORMATION")?;
    let note = "Open CASCADE does not know OTHER_TRANSFORMATION (1 in the file): parts may be missing or misplaced";
    ensure(ended.code == Some(0) && ended.err.contains(&format!("found: {note}")), &ended)?;
    let table = "[[obstacles]]\nname = \"car\"\nmesh = \"other.step\"\nposition = [5, 0, 0]\n";
    fs::write(place.path("s.toml"), hanging("s", 6, table))?;
    let ended = place.run(&["run", "s.toml", "--out", "out"])?;
    ensure(ended.code == Some(0) && ended.out.contains(note), &ended)?;
    let ended = import("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION", "OTHER_REPRESENTATION")?;
    ensure(ended.code == Some(0) && ended.err.contains("does not know OTHER_REPRESENTATION"), &ended)?;
    ensure(ended.err.contains("of 4 placements of parts in the file"), &ended)
}

fn too_coarse() -> Checked {
    let place = Place::new()?;
    place.make("sphere", "MM", "ball.step")?;
    let ended = place.run(&["import", "step", "ball.step", "-o", "new", "--deflection", "100 m"])?;
    let said = "error: ball.step: part \"sphere\" loses its shape: with a deflection of 100000 mm its triangles have";
    let help = "help: give a smaller deflection, such as ";
    ensure(ended.code == Some(1) && ended.err.starts_with(said) && ended.err.contains(help), &ended)?;
    let table = "[[obstacles]]\nname = \"ball\"\nmesh = \"ball.step\"\ndeflection = 100\n";
    fs::write(place.path("s.toml"), hanging("s", 6, table))?;
    let ended = place.run(&["check", "s.toml"])?;
    ensure(ended.code == Some(1) && ended.err.contains("loses its shape"), ended)
}

fn kept() -> Checked {
    let place = Place::new()?;
    place.make("torus", "MM", "ring.step")?;
    let import = |python: &str, more: &[&str]| {
        let arguments = [&["import", "step", "ring.step", "-o", "around"], more].concat();
        let ended: Ended = place.command(&arguments).env(PYTHON, python).output()?.into();
        let mesh = fs::read(place.path("around/torus.glb")).unwrap_or_default();
        Ok::<_, Failed>((ended, mesh))
    };
    let (ended, first) = import(&python(), &[])?;
    ensure(ended.code == Some(0), &ended)?;
    // This one says its version and reads nothing.
    let says = Command::new(python()).arg(root().join("crates/step/src/read.py")).output()?;
    let version = String::from_utf8_lossy(&says.stdout).trim().to_owned();
    if cfg!(unix) {
        let other = fake(&place, &version, "exit 9")?;
        let (ended, again) = import(&other, &[])?;
        ensure(ended.code == Some(0) && again == first, &ended)?;
        let (ended, _) = import(&other, &["--deflection", "0.2"])?;
        ensure(ended.code == Some(1), ("another deflection", &ended))?;
        let newer = fake(&place, "cadquery-ocp-novtk 99.0", "exit 9")?;
        let (ended, _) = import(&newer, &[])?;
        ensure(ended.code == Some(1), ("another version", &ended))?;
    }
    // What is damaged is read again.
    for entry in fs::read_dir(place.path("cache"))? {
        let path = entry?.path();
        let mut bytes = fs::read(&path)?;
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&path, bytes)?;
    }
    let (ended, again) = import(&python(), &[])?;
    ensure(ended.code == Some(0) && again == first, &ended)?;
    // Another file of this name is another one.
    place.make("sphere", "MM", "ring.step")?;
    let (ended, _) = import(&python(), &[])?;
    ensure(ended.code == Some(0) && place.path("around/sphere.glb").exists(), &ended)
}

fn not_started() -> Checked {
    let place = Place::new()?;
    let cases = [
        ("", "bad.step:1: the file is empty"),
        ("solid x\n", "bad.step:1: it is no STEP file: it begins with `solid x`, not with `ISO-10303-21;`"),
        ("ISO-10303-21;\nDATA;\n#1 = PL", "bad.step:3: it is cut off: it ends with `#1 = PL`"),
    ];
    for (text, said) in cases {
        fs::write(place.path("bad.step"), text)?;
        let mut command = place.command(&["import", "step", "bad.step", "-o", "new"]);
        let ended: Ended = command.env(PYTHON, "no-such-python").output()?.into();
        ensure(ended.code == Some(1) && ended.err.starts_with(&format!("error: {said}")), ended)?;
    }
    for wrong in ["0", "-1", "nan", "0 mm", "1 furlong"] {
        let deflection = format!("--deflection={wrong}");
        let ended = place.run(&["import", "step", "bad.step", "-o", "new", &deflection])?;
        ensure(ended.code == Some(1) && ended.err.contains("'--deflection <LENGTH>'"), ended)?;
    }
    let ended = place.run(&["import", "step", "none.step", "-o", "new"])?;
    ensure(ended.code == Some(3) && ended.err.contains("none.step"), ended)
}

fn keys() -> Checked {
    let place = Place::new()?;
    fs::write(place.path("bad.step"), "")?;
    let cases = [
        ("mesh = \"bad.step\"\n", 8, "\"bad.step\" cannot be read as STEP: line 1: the file is empty"),
        ("mesh = \"bad.step\"\nscale = 0.001\n", 9, "`scale` = 0.001 beside the STEP file \"bad.step\""),
        ("mesh = \"bad.step\"\ndeflection = 0\n", 14, "`deflection` = 0"),
        ("mesh = \"bad.step\"\ndeflection = \"-1 mm\"\n", 14, "`deflection` = \"-1 mm\""),
        ("mesh = \"bad.stl\"\ndeflection = 1\n", 14, "\"bad.stl\" has triangles already"),
    ];
    fs::write(place.path("bad.stl"), "")?;
    for (table, column, said) in cases {
        fs::write(place.path("s.toml"), hanging("s", 6, &format!("[[obstacles]]\nname = \"x\"\n{table}")))?;
        let line = fs::read_to_string(place.path("s.toml"))?.lines().count();
        let ended = place.run(&["check", "s.toml"])?;
        let at = format!("s.toml:{line}:{column}: ");
        ensure(ended.code == Some(1) && ended.err.starts_with(&at) && ended.err.contains(said), (ended, at, said))?;
    }
    Ok(())
}

/// A STEP file that is whole as far as its text shows.
const HOLLOW: &str = "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n";

fn missing() -> Checked {
    let place = Place::new()?;
    fs::write(place.path("a.step"), HOLLOW)?;
    let import = |python: &str| {
        let mut command = place.command(&["import", "step", "a.step", "-o", "new"]);
        Ok::<Ended, Failed>(command.env(PYTHON, python).output()?.into())
    };
    let ended = import("no-such-python")?;
    let help = "python3 -m pip install \"cadquery-ocp-novtk>=8\"";
    ensure(ended.code == Some(3) && ended.err.contains("`no-such-python` cannot be started"), &ended)?;
    ensure(ended.err.contains(help), &ended)?;
    if cfg!(unix) {
        let without = fake(&place, "", "exit 3")?;
        let ended = import(&without)?;
        ensure(ended.code == Some(3) && ended.err.contains("-m pip install \"cadquery-ocp-novtk>=8\""), &ended)?;
        let old = fake(&place, "cadquery-ocp 7.8.1", "exit 9")?;
        let ended = import(&old)?;
        ensure(ended.code == Some(3) && ended.err.contains("has cadquery-ocp 7.8.1 instead of"), &ended)?;
    }
    Ok(())
}

/// A program in place of Python that says a version and then does something else than reading.
fn fake(place: &Place, version: &str, does: &str) -> Result<String, Failed> {
    let path = place.path("python");
    let answer = if version.is_empty() { "exit 3".into() } else { format!("echo '{version}'; exit 0") };
    fs::write(&path, format!("#!/bin/sh\nif [ $# -le 1 ]; then {answer}; fi\n{does}\n"))?;
    #[cfg(unix)]
    fs::set_permissions(&path, std::os::unix::fs::PermissionsExt::from_mode(0o755))?;
    Ok(path.to_string_lossy().into_owned())
}

/// Imports with a program in place of Python.
fn import_with(place: &Place, does: &str, more: &[&str]) -> Result<Command, Failed> {
    fs::write(place.path("a.step"), HOLLOW)?;
    let python = fake(place, "cadquery-ocp-novtk 8.0", does)?;
    let mut command = place.command(&[&["import", "step", "a.step", "-o", "new"], more].concat());
    command.env(PYTHON, python);
    Ok(command)
}

fn crashes() -> Checked {
    let cases = [
        ("echo out of luck >&2; kill -SEGV $$", "Open CASCADE failed (signal: 11 (SIGSEGV)"),
        ("echo out of luck >&2; exit 7", "Open CASCADE failed (exit status: 7): out of luck"),
        ("exit 0", "Open CASCADE failed (it wrote nothing)"),
        ("echo '{}' >\"$3\"", "Open CASCADE failed (what it wrote is damaged)"),
    ];
    for (does, said) in cases {
        let place = Place::new()?;
        let ended: Ended = import_with(&place, does, &[])?.output()?.into();
        let said = format!("error: a.step: {said}");
        ensure(ended.code == Some(1) && ended.err.starts_with(&said) && !place.path("new").exists(), (ended, said))?;
    }
    Ok(())
}

fn hangs() -> Checked {
    let place = Place::new()?;
    let began = Instant::now();
    let ended: Ended = import_with(&place, "exec sleep 100", &["--time-limit", "1s"])?.output()?.into();
    let said = "error: a.step: Open CASCADE has not read the file within 1 s, and was ended";
    ensure(ended.code == Some(1) && ended.err.starts_with(said), &ended)?;
    ensure(began.elapsed() < Duration::from_secs(20), began.elapsed())
}

fn interrupted() -> Checked {
    let place = Place::new()?;
    let process = place.path("process");
    let does = format!("echo $$ >'{}'; exec sleep 100", process.display());
    let mut child = import_with(&place, &does, &[])?.stdout(Stdio::piped()).spawn()?;
    let began = Instant::now();
    let reader = loop {
        match fs::read_to_string(&process).ok().filter(|text| text.ends_with('\n')) {
            Some(text) => break text.trim().to_owned(),
            None if began.elapsed() > Duration::from_secs(20) => return Err("it does not begin".into()),
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    let signal = |name: &str, process: &str| Command::new("kill").args([name, process]).stderr(Stdio::null()).status();
    ensure(signal("-INT", &child.id().to_string())?.success(), "no signal")?;
    let code = child.wait()?.code();
    let said = std::io::read_to_string(child.stdout.take().ok_or("no output")?)?;
    ensure(code == Some(2) && said == "interrupted; nothing is written\n", (code, said))?;
    ensure(!signal("-0", &reader)?.success(), "the other process is still there")
}
