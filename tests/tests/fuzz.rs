//! Whatever reads bytes of a stranger refuses them or takes them; it never panics, nor thinks them over for long. The
//! inputs are those of `corpus/` with small random changes, the same in every run. `WIRELOOM_FUZZ` sets how many for
//! each reader (100000 now and then), `WIRELOOM_FUZZ_SEED` where they begin.

use std::cell::Cell;
use std::path::Path;
use std::time::Duration;
use wireloom::export::json;
use wireloom::harness::ShapeFile;
use wireloom::import::kbl::{Arrangement, Options, Order, import};
use wireloom::import::vec;
use wireloom::scenario::{Files, record, render};
use wireloom::session::{Checkpoint, Observer, Progress};
use wireloom::shapes::mesh;
use wireloom::testing::fuzz::Fuzz;
use wireloom::{Control, StepResult};
use wireloom_tests::root;

/// Inputs where nothing else is said.
const FEW: u64 = 300;
/// One input may take so long on a machine that has much else to do.
const PATIENCE: Duration = Duration::from_secs(30);

fn number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

fn bytes(path: impl AsRef<Path>) -> Vec<u8> {
    let path = root().join(path);
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn corpus(names: &[&str]) -> Vec<Vec<u8>> {
    names.iter().map(|name| bytes(Path::new("tests/corpus").join(name))).collect()
}

/// Tries a reader; good inputs come first, and all of them must be taken.
#[allow(clippy::print_stdout, reason = "how many inputs there were and what they took is asked for with --nocapture")]
fn fuzz(name: &str, corpus: &[Vec<u8>], words: &[&str], reads: impl FnMut(&[u8]) -> bool) {
    let mut reads = reads;
    for (k, good) in corpus.iter().enumerate() {
        assert!(reads(good), "{name}: input {k} of the corpus is good");
    }
    let (seed, inputs) = (number("WIRELOOM_FUZZ_SEED", 1), number("WIRELOOM_FUZZ", FEW));
    let (taken, slowest) = Fuzz { name, corpus, words, seed, inputs, patience: PATIENCE }.hunt(reads);
    assert!(taken > inputs / 100, "{name}: of {inputs} inputs {taken} were taken: they say little of what comes after");
    println!("{name}: {inputs} inputs, {taken} taken, the slowest took {slowest:?}");
}

/// The files beside a scenario, one of which is another one.
struct Beside<'b> {
    name: &'b str,
    bytes: &'b [u8],
}

impl Files for Beside<'_> {
    fn read(&self, path: &str) -> Result<String, String> {
        String::from_utf8(self.bytes(path)?).map_err(|error| error.to_string())
    }

    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        match path {
            path if path == self.name => Ok(self.bytes.to_vec()),
            "poses.csv" | "tetrahedron-binary.stl" => Ok(bytes(Path::new("tests/corpus").join(path))),
            _ => Err("no such file".into()),
        }
    }
}

const NOTHING: Beside<'_> = Beside { name: "", bytes: &[] };

/// Words of scenarios.
const KEYS: [&str; 40] = [
    "[[steps]]\n",
    "[[branches]]\n",
    "[[joints]]\n",
    "[[constraints]]\n",
    "[[steps.move]]\n",
    "[[steps.add]]\n",
    "[sweep]\n",
    "[contact]\n",
    "arms = []\n",
    "arms = 3\n",
    "wait = true\n",
    "cables = true\n",
    "resolve = true\n",
    "turns = ",
    "segments = ",
    "increments = ",
    "length = ",
    "max_segment = ",
    "orientation = [1, 0, 0, 0]\n",
    "hold = [\"twist\"]\n",
    "rail = [[1, 0, 0]]\n",
    "free_axis = [0, 0, 1]\n",
    "slide = true\n",
    "release = [\"plug\"]\n",
    "kind = \"collar\"\n",
    "kind = \"handle\"\n",
    "model = \"fused\"\n",
    "model = \"cosserat\"\n",
    "rod = \"mass-spring\"\n",
    "shape = \"sphere\"\n",
    "radius = ",
    "stiffness = ",
    "\"1e300 km\"",
    "µm",
    "\"",
    "'''",
    "[",
    "]",
    "{ ",
    " }",
];

#[test]
fn scenarios_never_make_the_reader_panic() {
    let mut good = corpus(&["cable.toml"]);
    for name in ["first", "branches/sixteen_arms", "assembly/clips_in_any_order", "contact/crossed_cables"] {
        good.push(bytes(format!("scenarios/{name}.toml")));
    }
    let registry = wireloom::registry();
    fuzz("scenario", &good, &KEYS, |bytes| {
        let text = String::from_utf8_lossy(bytes);
        let _ = record::with_steps(&text, 1, &[]);
        match wireloom::load_with_files(&text, &NOTHING, &registry) {
            Ok(_) => true,
            Err(faults) => {
                assert!(!faults.is_empty() && !render(&text, &faults).is_empty());
                false
            }
        }
    });
}

/// Stops after some increments.
struct Impatient(usize);

impl Observer for Impatient {
    fn increment(&mut self, _: &Progress, _: &StepResult, _: bool) -> Control {
        self.0 = self.0.saturating_sub(1);
        if self.0 == 0 { Control::Stop } else { Control::Continue }
    }
}

#[test]
fn scenarios_that_are_taken_can_be_run() {
    let registry = wireloom::registry();
    let runs = Cell::new(0);
    let inputs = number("WIRELOOM_FUZZ", FEW);
    fuzz("run", &corpus(&["cable.toml"]), &KEYS, |bytes| {
        let text = String::from_utf8_lossy(bytes);
        let Ok((_, mut built)) = wireloom::load_with_files(&text, &NOTHING, &registry) else { return false };
        // One in ten, of few segments and with few iterations: what they come to is for others to judge.
        if built.network.points > 500 || runs.get() > inputs / 10 {
            return true;
        }
        runs.set(runs.get() + 1);
        built.stop.max_iterations = built.stop.max_iterations.min(20);
        let run = wireloom::run_observed(built, None, &mut Impatient(4));
        json::write(&run, &json::Provenance::default(), &mut Vec::new()).expect("bytes");
        true
    });
}

#[test]
fn key_frames_never_make_the_reader_panic() {
    let scenario = String::from_utf8(bytes("tests/corpus/cable.toml")).expect("text");
    let registry = wireloom::registry();
    let words = ["t", "x [mm]", "qw", ",", "\"", "\n", "nan", "\u{feff}", ";"];
    fuzz("key-frames", &corpus(&["poses.csv"]), &words, |bytes| {
        wireloom::load_with_files(&scenario, &Beside { name: "poses.csv", bytes }, &registry).is_ok()
    });
}

#[test]
fn urdf_files_never_make_the_reader_panic_and_lead_no_body_out_of_the_world() {
    let words = [
        "<joint name=\"x\" type=\"prismatic\">",
        "</joint>",
        "<link name=\"x\"/>",
        "<parent link=\"base\"/>",
        "<mimic joint=\"turn\" multiplier=\"-1\"/>",
        "<axis xyz=\"0 0 1\"/>",
        "<origin xyz=\"1 2 3\" rpy=\"1 2 3\"/>",
        "<limit lower=\"-1\" upper=\"1\"/>",
        "floating",
        "1e308",
        "nan",
        "0",
        "hand",
        "&#0;",
        "<!--",
    ];
    let scenario = String::from_utf8(bytes("scenarios/mechanisms/robot.toml")).expect("text");
    let registry = wireloom::registry();
    fuzz("URDF", &[bytes("scenarios/mechanisms/arm.urdf")], &words, |bytes| {
        let files = Beside { name: "arm.urdf", bytes };
        let Ok((_, built)) = wireloom::load_with_files(&scenario, &files, &registry) else { return false };
        for drive in &built.schedule.steps[0].drives {
            let poses = built.network.mechanisms[drive.mechanism].poses(drive.way.end());
            assert!(poses.iter().all(|pose| pose.position.iter().all(|x| x.is_finite())));
        }
        true
    });
}

#[test]
fn kbl_files_never_make_the_importer_panic_and_what_it_writes_is_a_scenario() {
    let words = [
        "<Segment id=\"x\">",
        "</Segment>",
        "<Node id=\"y\">",
        "<Center_curve>",
        "<Control_points>",
        "<Virtual_length>",
        "<Fixing_assignment>",
        "<!--",
        "-->",
        "<![CDATA[",
        "&#0;",
        "&amp;",
        " id=\"\"",
        " xmlns:a=\"b\"",
        "/NULL",
        "n1 n2",
    ];
    let registry = wireloom::registry();
    let turn = Cell::new(0);
    fuzz("KBL", &[bytes("crates/import/tests/small.kbl")], &words, |bytes| {
        let text = String::from_utf8_lossy(bytes);
        turn.set(turn.get() + 1);
        let arrangement = [Arrangement::Installed, Arrangement::Board, Arrangement::Assembly][turn.get() % 3];
        let order = if turn.get().is_multiple_of(2) { Order::Outward } else { Order::Random(turn.get() as u64) };
        let Ok(imported) = import(&text, &Options { arrangement, order, ..Options::default() }) else { return false };
        if let Err(faults) = wireloom::load(&imported.scenario, &registry) {
            panic!("{}\n{}", render(&imported.scenario, &faults), imported.scenario);
        }
        true
    });
}

#[test]
fn vec_files_never_make_the_importer_panic_and_what_it_writes_is_a_scenario() {
    let words = [
        "<TopologySegment id=\"x\">",
        "</TopologySegment>",
        "<Knots>",
        "<Knots>1</Knots>",
        "<Weight>",
        "<Segment>",
        "<SubWireElement id=\"y\">",
        "<Exponent>-9",
        "xsi:type=\"vec:CompositeUnit\"",
        "<Factors>uGM uGM",
        "FromEndNode",
        "<!--",
        "n1 n2",
        "s1 s2 s1",
    ];
    let registry = wireloom::registry();
    let turn = Cell::new(0);
    fuzz("VEC", &[bytes("crates/import/tests/small.vec")], &words, |bytes| {
        let text = String::from_utf8_lossy(bytes);
        turn.set(turn.get() + 1);
        let arrangement = [Arrangement::Installed, Arrangement::Board, Arrangement::Assembly][turn.get() % 3];
        let Ok(imported) = vec::import(&text, &Options { arrangement, ..Options::default() }) else { return false };
        if let Err(faults) = wireloom::load(&imported.scenario, &registry) {
            panic!("{}\n{}", render(&imported.scenario, &faults), imported.scenario);
        }
        true
    });
}

/// Files of one format.
fn meshes(ending: &str, names: &[&str], words: &[&str]) {
    fuzz(ending, &corpus(names), words, |bytes| {
        let file = ShapeFile { name: format!("body.{ending}"), bytes: bytes.to_vec(), scale: 1.0 };
        let Ok(surface) = mesh::read(&file) else { return false };
        // What can be read need be no body.
        let _ = (mesh::Mesh::new(&surface, false), mesh::Mesh::new(&surface, true));
        true
    });
}

#[test]
fn stl_files_never_make_the_reader_panic() {
    meshes("stl", &["tetrahedron.stl", "tetrahedron-binary.stl"], &["facet normal ", "vertex ", "endloop\n", "solid "]);
}

#[test]
fn obj_files_never_make_the_reader_panic() {
    meshes(
        "obj",
        &["tetrahedron.obj"],
        &["v ", "f ", "f 1/2/3 ", "o x\n", "g x\n", "usemtl m\n", "l 1 2\n", "//", "-"],
    );
}

#[test]
fn ply_files_never_make_the_reader_panic() {
    let words = [
        "element vertex ",
        "element face ",
        "element nothing 999999999999\n",
        "property list uchar int vertex_indices\n",
        "property float x\n",
        "property list double float x\n",
        "format ascii 1.0\n",
        "end_header\n",
    ];
    meshes("ply", &["tetrahedron.ply", "tetrahedron-little.ply", "tetrahedron-big.ply"], &words);
}

#[test]
fn gltf_files_never_make_the_reader_panic() {
    let words = [
        "\"children\":[0,1],",
        "\"mesh\":0,",
        "\"matrix\":[1],",
        "\"count\":",
        "\"byteStride\":",
        "5121",
        "5125",
        "[",
        "{",
    ];
    meshes("gltf", &["tetrahedron.gltf"], &words);
    meshes("glb", &["tetrahedron.glb"], &words);
}

/// A run of the small scenario, and the checkpoints it left.
fn small_run() -> (Vec<u8>, Vec<Vec<u8>>) {
    #[derive(Default)]
    struct Keep(Vec<Vec<u8>>);
    impl Observer for Keep {
        fn increment(&mut self, _: &Progress, _: &StepResult, _: bool) -> Control {
            Control::Continue
        }
        fn checkpoint(&mut self, checkpoint: &Checkpoint) {
            self.0.push(postcard::to_stdvec(checkpoint).expect("bytes"));
        }
    }
    let text = String::from_utf8(bytes("tests/corpus/cable.toml")).expect("text");
    let (_, built) = wireloom::load_with_files(&text, &NOTHING, &wireloom::registry()).expect("no faults");
    let mut keep = Keep::default();
    let run = wireloom::run_observed(built, None, &mut keep);
    let mut result = Vec::new();
    json::write(&run, &json::Provenance::default(), &mut result).expect("bytes");
    (result, keep.0)
}

#[test]
fn results_never_make_the_reader_panic() {
    let words = ["null", "\"s\":[", "\"steps\":[{", "\"status\":\"converged\"", "true", "[]", "{}", "1e999", "\\ud800"];
    fuzz("result", &[small_run().0], &words, |bytes| {
        let whole = json::read_run(bytes);
        let end = json::read(bytes);
        whole.is_ok() && end.is_ok()
    });
}

#[test]
fn checkpoints_never_make_the_reader_panic() {
    let (_, checkpoints) = small_run();
    let text = String::from_utf8(bytes("tests/corpus/cable.toml")).expect("text");
    let (_, built) = wireloom::load_with_files(&text, &NOTHING, &wireloom::registry()).expect("no faults");
    fuzz("checkpoint", &checkpoints, &[], |bytes| {
        let read = postcard::from_bytes::<Checkpoint>(bytes);
        read.is_ok_and(|checkpoint| checkpoint.fits(&built.network))
    });
}
