//! Scenario texts that many tests share, in pieces, and runs of them.
#![allow(clippy::missing_panics_doc, reason = "a scenario of a test that is refused ends the test")]

use wireloom::parts::Registry;
use wireloom::session::{Checkpoint, Ended, InteractiveDriver, Monitor};
use wireloom::{Built, Control, Run, Status};

/// Table of a section: a cable of 6 mm and 50 g/m, EA = 1e4 N, EI = 0.01 N m², GJ = 0.008 N m².
pub fn section(name: &str) -> String {
    format!(
        "[sections.{name}]\ndiameter = \"6 mm\"\nlinear_density = \"50 g/m\"\naxial_stiffness = 1e4\n\
         bending_stiffness = 0.01\ntorsion_stiffness = 0.008\n"
    )
}

/// Table of a branch between two vertices; length in m.
pub fn branch(name: &str, ends: [&str; 2], section: &str, length: f64, segments: usize) -> String {
    let [from, to] = ends;
    format!(
        "[[branches]]\nname = \"{name}\"\nfrom = \"{from}\"\nto = \"{to}\"\nsection = \"{section}\"\n\
         length = {length:?}\nsegments = {segments}\n"
    )
}

/// Table of a connector that holds a vertex at a position (m), with the cable along x there.
pub fn connector(name: &str, end: &str, position: [f64; 3]) -> String {
    connector_along(name, end, position, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
}

/// Table of a connector that holds a vertex at a position (m), with a tangent of the cable and a direction `up`.
pub fn connector_along(name: &str, end: &str, position: [f64; 3], tangent: [f64; 3], up: [f64; 3]) -> String {
    format!(
        "[[constraints]]\nname = \"{name}\"\nkind = \"connector\"\nat = {{ end = \"{end}\" }}\n\
         position = {position:?}\ntangent = {tangent:?}\nup = {up:?}\n"
    )
}

/// Cable of 1 m that hangs between `plug-A` and `plug-B`, 0.6 m apart; `more` is the rest of the text.
pub fn hanging(name: &str, segments: usize, more: &str) -> String {
    [
        &*format!("schema = 1\nname = \"{name}\"\n"),
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 1.0, segments),
        &connector("plug-A", "A", [0.0, 0.0, 0.0]),
        &connector("plug-B", "B", [0.6, 0.0, 0.0]),
        more,
    ]
    .concat()
}

/// Harness of a scenario that names no other files, with the built-in kinds.
pub fn built(text: &str) -> Built {
    built_with(text, &wireloom::registry())
}

/// Harness of a scenario that names no other files.
#[track_caller]
pub fn built_with(text: &str, registry: &Registry) -> Built {
    let loaded = wireloom::load(text, registry);
    loaded.unwrap_or_else(|faults| panic!("{}", wireloom::scenario::render(text, &faults))).1
}

/// Run of a scenario that names no other files, with the built-in kinds.
#[track_caller]
pub fn run(text: &str) -> Run {
    run_with(text, &wireloom::registry())
}

/// Run of a scenario that names no other files.
#[track_caller]
pub fn run_with(text: &str, registry: &Registry) -> Run {
    wireloom::run(built_with(text, registry), &mut |_, _| Control::Continue)
}

/// Driver of single increments, with the minimiser of a scenario.
#[track_caller]
pub fn driver(text: &str) -> InteractiveDriver {
    let Built { minimiser, stop, .. } = built(text);
    InteractiveDriver::new(minimiser, stop, false, Monitor::default())
}

/// End of the step of this index, whose increments are carried out one by one from a checkpoint at its beginning.
#[track_caller]
pub fn advanced(text: &str, from: &Checkpoint, step: usize) -> Ended {
    let Built { network, schedule, .. } = built(text);
    let (step, mut at) = (&schedule.steps[step], from.clone());
    let mut last = None;
    for _ in 0..step.increments {
        let ended = driver(text).advance(&network, step, &at).expect("an end");
        assert_eq!(ended.end.status, Status::Converged);
        at = ended.checkpoint.clone();
        last = Some(ended);
    }
    last.expect("an increment")
}
