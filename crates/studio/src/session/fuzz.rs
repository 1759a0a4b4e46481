//! Fuzzing of requests: none makes a session panic or busy for long. `WIRELOOM_FUZZ` sets the number of inputs; each is
//! a list of messages from the opening of a session on, one per line.

use super::edits::Memory;
use super::*;
use std::time::Duration;
use wireloom::scenario::NoFiles;
use wireloom::testing::fuzz::Fuzz;

/// Number of inputs by default.
const FEW: u64 = 300;
/// Time limit for one input, on a loaded machine.
const PATIENCE: Duration = Duration::from_secs(30);
/// Largest number of nodes: a page may ask for an arbitrarily fine mesh.
const NODES: usize = 300;

/// Largest number of messages of an input: each may need a full solution.
const MESSAGES_EACH: usize = 12;

/// As small as possible, because many sessions are opened.
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

/// Possible messages: every request, some in a useful order.
const MESSAGES: [&str; 5] = [
    r#"{"do":"hold","branch":"b","s":0.2,"how":"handle"}
{"do":"target","constraint":"hand","position":[0.1,0.05,-0.1],"orientation":[1,0,0,0]}
{"do":"target","constraint":"hand","position":null,"orientation":null}
{"do":"sensitivities","constraint":"hand"}
{"do":"drop","constraint":"hand"}
{"do":"sensitivities","constraint":"plug"}
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
{"do":"draft","number":0,"take":false}
"#,
    concat!(
        r#"{"do":"edit","edit":{"is":"put","key":"branches.b.length","value":"420 mm"}}
{"do":"edit","edit":{"is":"split","branch":"b","s":0.2}}
{"do":"edit","edit":{"is":"branch","name":"c","from":{"point":{"branch":"b","s":0.1}},"section":"s","length":0.1}}
{"do":"edit","edit":{"is":"branch","name":"d","from":{"end":"B"},"section":"s","length":"100 mm"}}
{"do":"edit","edit":{"is":"rename","part":"branch","name":"b","to":"b.1"}}
{"do":"edit","edit":{"is":"delete","part":"constraint","name":"plug"}}
{"do":"edit","edit":{"is":"add","list":"obstacles","entry":{"name":"o","shape":"box","size":[0.1,0.1,0.1]}}}
{"do":"edit","edit":{"is":"move","obstacle":"o","from":{"position":[0,0,0],"orientation":[1,0,0,0]},"#,
        r#""to":{"position":[0,1,0],"orientation":[1,1,0,0]}}}
{"do":"edit","edit":{"is":"remove","key":"steps.lift.move.plug"}}
{"do":"edit","edit":{"is":"delete_all","parts":[["obstacle","o"],["constraint","plug"]]}}
{"do":"apply","text":"schema = 1","base":1}
"#
    ),
    r#"{"do":"store","name":"z.toml","replace":false}
{"do":"set","key":"branches.b.segments","value":8}
{"do":"store","name":null,"replace":true}
{"do":"reload"}
{"do":"undo"}
{"do":"check","text":"schema = 1\n[sections.s]\ndiameter = \"8 mm\"\n","number":1}
{"do":"check","text":"\ud83e\uddf5 = [","number":2}
"#,
];

const WORDS: [&str; 24] = [
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
    "{\"do\":\"reload\"}\n",
    "{\"do\":\"store\",\"name\":null,\"replace\":false}\n",
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
            files: Arc::new(NoFiles),
            registry: wireloom::registry(),
            unsaved: false,
            storage: Some(Box::new(Memory::of(CABLE))),
        };
        let mut session = Session::open(opened, Monitor::default()).unwrap_or_else(|faults| panic!("{faults:?}"));
        let mut taken = false;
        for line in String::from_utf8_lossy(bytes).lines().take(MESSAGES_EACH) {
            let Ok(request) = serde_json::from_str::<Request>(line) else { continue };
            while session.has_work() && session.now.harness.network.points <= NODES {
                session.work();
            }
            if let Request::Check { text, .. } = &request {
                // The server answers these, on other threads.
                text_faults(text, &session.known().check(text));
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
