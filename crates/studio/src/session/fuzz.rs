//! Whatever a page sends is refused or carried out: nothing makes a session panic, or keeps it busy for long. `WIRELOOM_FUZZ` sets how many
//! inputs there are; each is what a page sends from the opening of a session on, a message a line.

use super::*;
use std::time::Duration;
use wireloom::scenario::NoFiles;
use wireloom::testkit::fuzz::Fuzz;

/// Inputs where nothing else is said.
const FEW: u64 = 300;
/// One input may take so long on a machine that has much else to do.
const PATIENCE: Duration = Duration::from_secs(30);
/// Nodes of the largest harness that is carried out: a page may ask for as fine a mesh as it likes.
const NODES: usize = 300;

/// Messages of an input that are looked at: each of them may have the whole harness solved.
const MESSAGES_EACH: usize = 12;

/// As small as may be, so that many sessions can be opened.
const CABLE: &str = r#"schema = 1
[sections.s]
diameter = "8 mm"
linear_density = "120 g/m"
axial_stiffness = "20 kN"
bending_stiffness = "0.012 N m^2"
torsion_stiffness = "0.009 N m^2"
[[branches]]
name = "b"
from = "A"
to = "B"
section = "s"
length = "400 mm"
segments = 4
[[constraints]]
name = "plug"
kind = "connector"
at = { end = "A" }
[[steps]]
name = "lift"
increments = 2
[[steps.move]]
constraint = "plug"
position = [0, 0, 0.1]
"#;

/// What a page may send: every request, some in an order that makes sense.
const MESSAGES: [&str; 3] = [
    r#"{"do":"hold","branch":"b","s":0.2,"how":"handle"}
{"do":"target","constraint":"hand","position":[0.1,0.05,-0.1],"orientation":[1,0,0,0]}
{"do":"target","constraint":"hand","position":null,"orientation":null}
{"do":"drop","constraint":"hand"}
{"do":"undo"}
{"do":"redo"}
{"do":"save"}
"#,
    r#"{"do":"hold","branch":"b","s":0.4,"how":"pin"}
{"do":"pin","constraint":"pin"}
{"do":"release","constraint":"pin"}
{"do":"go","frame":1}
{"do":"frames","from":0,"to":3}
{"do":"stop"}
"#,
    r#"{"do":"set","key":"minimiser.kind","value":"lbfgs"}
{"do":"set","key":"sections.s.bending_stiffness","value":0.02}
{"do":"set","key":"branches.b.segments","value":8}
{"do":"hold","branch":"b","s":0.1,"how":"collar"}
{"do":"target","constraint":"plug","position":[0,0,0.2]}
{"do":"draft","take":false}
"#,
];

const WORDS: [&str; 22] = [
    "\"handle\"",
    "\"pin\"",
    "\"collar\"",
    "\"constraint\":\"plug\"",
    "\"constraint\":\"clip\"",
    "\"branch\":\"b\"",
    "{\"do\":\"undo\"}\n",
    "{\"do\":\"redo\"}\n",
    "{\"do\":\"stop\"}\n",
    "{\"do\":\"save\"}\n",
    "{\"do\":\"go\",\"frame\":0}\n",
    "\"branches.b.rod\"",
    "\"sections.s.diameter\"",
    "\"mass-spring\"",
    "\"kirchhoff\"",
    "\"ncg\"",
    "null",
    "true",
    "[]",
    "1e-300",
    "\\u0000",
    "\\ud800",
];

#[test]
fn messages_never_make_a_session_panic() {
    let inputs = std::env::var("WIRELOOM_FUZZ").ok().and_then(|text| text.parse().ok()).unwrap_or(FEW);
    let corpus = MESSAGES.map(|messages| messages.as_bytes().to_vec());
    let fuzz = Fuzz { name: "messages", corpus: &corpus, words: &WORDS, seed: 1, inputs, patience: PATIENCE };
    let (taken, _) = fuzz.hunt(|bytes| {
        let opened = SessionInput {
            text: CABLE.to_owned(),
            name: "cable.toml".into(),
            files: Box::new(NoFiles),
            registry: wireloom::registry(),
            unsaved: false,
        };
        let mut session = Session::open(opened, Monitor::default()).unwrap_or_else(|faults| panic!("{faults:?}"));
        let mut taken = false;
        for line in String::from_utf8_lossy(bytes).lines().take(MESSAGES_EACH) {
            let Ok(request) = serde_json::from_str::<Request>(line) else { continue };
            while session.has_work() && session.now.harness.network.points <= NODES {
                session.work();
            }
            session.handle(1, request);
            let Changes { said, .. } = session.take_changes();
            taken |= said.is_empty();
        }
        session.detach(1);
        taken
    });
    assert!(taken > inputs / 10, "of {inputs} inputs {taken} had a message that was carried out");
}
