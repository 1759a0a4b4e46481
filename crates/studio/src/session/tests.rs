//! Sessions on a small Y: interactive operations, the recorded text, and that `run` reproduces it.

use super::edits::Memory;
use super::*;
use crate::frame;
use crate::protocol::Holding;
use serde_json::json;
use std::sync::atomic::{AtomicBool, Ordering};
use wireloom::Control;
use wireloom::geometry::Vector;
use wireloom::harness::{Problem, State};
use wireloom::parts::{Minimiser, MinimiserKind, Report, Stop};
use wireloom::scenario::NoFiles;

pub(super) const Y: &str = r#"# A Y for the studio.
schema = 1
name = "y"

[sections.trunk] # of many wires
diameter = "8 mm"
linear_density = "120 g/m"
axial_stiffness = "20 kN"
bending_stiffness = "0.012 N m^2" # measured
torsion_stiffness = "0.009 N m^2"
min_bend_radius = "48 mm"

[sections.arm]
diameter = "5 mm"
linear_density = "60 g/m"
axial_stiffness = "10 kN"
bending_stiffness = "0.006 N m^2"
torsion_stiffness = "0.0045 N m^2"

[[branches]]
name = "trunk"
from = "A"
to = "J"
section = "trunk"
length = "400 mm"
max_segment = "20 mm"

[[branches]]
name = "left"
from = "J"
to = "B"
section = "arm"
length = "300 mm"
max_segment = "20 mm"

[[branches]]
name = "right"
from = "J"
to = "C"
section = "arm"
length = "300 mm"
segments = 15

[[joints]]
name = "J"
model = "cosserat" # as measured
arms = [
  { branch = "trunk", direction = [-1, 0, 0], up = [0, 0, 1] },
  { branch = "left", direction = [0.866, 0.5, 0], up = [0, 0, 1] },
  { branch = "right", direction = [0.866, -0.5, 0], up = [0, 0, 1] },
]

[[constraints]]
name = "plug-A"
kind = "connector"
at = { end = "A" }
position = [0, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
"#;

pub(super) const STEPS: &str = r#"
[[steps]] # by the author
name = "plug B"
increments = 4
[[steps.add]]
name = "plug-B"
kind = "connector"
at = { end = "B" }
[[steps.move]]
constraint = "plug-B"
position = [0.55, 0.2, 0.05]
tangent = [1, 0, 0]
up = [0, 0, 1]

[[steps]]
name = "clip the trunk"
increments = 2
[[steps.add]]
name = "clip"
kind = "collar"
at = { branch = "trunk", s = 0.2 }
"#;

/// Largest difference (m) between `run` and a session after a grab on the way: 1e-6 of the longest path through the Y.
/// The grab adds a station, and the harness is brought back to equilibrium with it.
pub(super) const ALIKE: f64 = 7e-7;

pub(super) fn session(text: &str) -> Session {
    let mut session = opened(text);
    work(&mut session);
    session
}

/// A session that has computed nothing.
pub(super) fn opened(text: &str) -> Session {
    opened_in(text, None)
}

fn opened_in(text: &str, storage: Option<Box<dyn Storage>>) -> Session {
    let input = SessionInput {
        text: text.to_owned(),
        name: "y.toml".into(),
        files: Arc::new(NoFiles),
        registry: wireloom::registry(),
        unsaved: false,
        storage,
    };
    Session::open(input, Monitor::default()).unwrap_or_else(|faults| panic!("{faults:?}"))
}

pub(super) fn work(session: &mut Session) {
    while session.has_work() {
        session.work();
    }
}

/// Sends a request, computes, and returns the notices.
pub(super) fn ask(session: &mut Session, request: Request) -> Vec<Notice> {
    session.handle(1, request);
    work(session);
    session.take_changes().said.into_iter().map(|(_, notice)| notice).collect()
}

pub(super) fn done(session: &mut Session, request: Request) {
    let said = ask(session, request.clone());
    assert!(said.is_empty(), "{request:?}: {said:?}");
}

pub(super) fn refused(session: &mut Session, request: Request) -> String {
    match ask(session, request.clone()).as_slice() {
        [Notice::Refused { message, .. }] => message.clone(),
        other => panic!("{request:?}: {other:?}"),
    }
}

fn to(constraint: &str, position: [f64; 3]) -> Request {
    Request::Target { constraint: constraint.into(), position: Some(position), orientation: None }
}

/// The end of the drag.
fn drop_(constraint: &str) -> Request {
    Request::Drop { constraint: constraint.into() }
}

fn drag(session: &mut Session, constraint: &str, places: &[[f64; 3]]) {
    places.iter().for_each(|place| done(session, to(constraint, *place)));
    done(session, drop_(constraint));
}

pub(super) fn hold(session: &mut Session, branch: &str, s: f64, how: Holding) {
    done(session, Request::Hold { branch: branch.into(), s, how });
}

pub(super) fn text(session: &mut Session) -> String {
    match ask(session, Request::Save).as_slice() {
        [Notice::Saved { text, .. }] => text.clone(),
        other => panic!("{other:?}"),
    }
}

/// Results of all increments of a run.
pub(super) fn ends(text: &str) -> Vec<StepResult> {
    let registry = wireloom::registry();
    let (_, built) = wireloom::load(text, &registry).unwrap_or_else(|faults| panic!("{text}\n{faults:?}"));
    let mut ends = Vec::new();
    let run = wireloom::run(built, &mut |_, end| {
        ends.push(end.clone());
        Control::Continue
    });
    assert_eq!(run.status(), Status::Converged, "{text}");
    ends
}

/// Largest distance between nodes of two results, m.
pub(super) fn apart(one: &StepResult, other: &StepResult) -> f64 {
    let nodes = |end: &StepResult| end.branches.iter().flat_map(|branch| branch.position.clone()).collect::<Vec<_>>();
    let (a, b) = (nodes(one), nodes(other));
    assert_eq!(a.len(), b.len());
    a.iter().zip(&b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

pub(super) fn last(session: &Session) -> StepResult {
    (**session.now.last.as_ref().expect("an end")).clone()
}

fn bits(end: &StepResult) -> String {
    let branches: Vec<_> = end.branches.iter().map(|branch| (&branch.position, &branch.frame, &branch.force)).collect();
    format!("{branches:?}")
}

#[test]
fn a_session_carries_out_the_scenario_as_run_does() {
    let session = session(&format!("{Y}{STEPS}"));
    let ends = ends(&format!("{Y}{STEPS}"));
    assert_eq!(session.now.frames(), 1 + ends.len());
    assert_eq!(bits(&last(&session)), bits(&ends[5]));
    let timeline = session.timeline();
    let steps: Vec<_> = timeline.steps.iter().map(|s| (s.name.as_str(), s.first, s.frames, s.by_hand)).collect();
    assert_eq!(steps, [("start", 0, 1, false), ("plug B", 1, 4, false), ("clip the trunk", 5, 2, false)]);
    let record = session.record();
    assert_eq!((record.ends.len(), record.status), (2, Status::Converged));
    let mut iterations = 0;
    for (k, frame) in session.frames_from(0).iter().enumerate() {
        let (header, nodes) = frame::decode(frame.as_ref().expect("there")).expect("a frame");
        iterations += header.iterations;
        assert_eq!((header.frame as usize, nodes.len()), (k, 21 + 16 + 16));
    }
    // Each is counted for its own increment.
    assert_eq!(iterations as usize, ends[3].minimiser.iterations + ends[5].minimiser.iterations);
}

#[test]
fn a_drag_is_reproduced_by_run_bit_for_bit() {
    let mut session = session(&format!("{Y}{STEPS}"));
    drag(&mut session, "plug-B", &[[0.54, 0.2, 0.06], [0.53, 0.19, 0.07], [0.52, 0.19, 0.08]]);
    // Rotated on the way, by more than one increment allows.
    done(&mut session, to("plug-B", [0.52, 0.19, 0.07]));
    let q = Some([0.9, 0.1, 0.5, 0.3]);
    done(&mut session, Request::Target { constraint: "plug-B".into(), position: None, orientation: q });
    done(&mut session, drop_("plug-B"));
    // A clip has a tangent only.
    let q = Some([0.7, 0.0, 0.75, 0.1]);
    done(&mut session, Request::Target { constraint: "clip".into(), position: Some([0.2, 0.01, 0.0]), orientation: q });
    done(&mut session, drop_("clip"));
    let text = text(&mut session);
    assert!(text.starts_with(&format!("{Y}{STEPS}")), "{text}");
    let ends = ends(&text);
    assert_eq!(session.now.frames(), 1 + ends.len());
    assert_eq!(bits(&last(&session)), bits(&ends[ends.len() - 1]), "{text}");
    assert!(!session.unsaved());
}

/// Limits that the end of the drag exceeds at rest, and that are nearly reached while it moves.
const LIMITS: &str = r#"
[[requirements]]
name = "bends at rest"
quantity = "bend_radius"
of = { branches = "*" }
motion = "rest"
min = "200 mm"

[[requirements]]
name = "bends while it moves"
quantity = "bend_radius"
of = { branches = "*" }
motion = "moving"
min = "1 mm"

[[requirements]]
name = "pull"
quantity = "force"
of = { constraint = "plug-B" }
max = "1 kN"
severity = "should"
"#;

fn run_of(text: &str) -> wireloom::Run {
    let (_, built) = wireloom::load(text, &wireloom::registry()).unwrap_or_else(|faults| panic!("{text}\n{faults:?}"));
    wireloom::run(built, &mut |_, _| Control::Continue)
}

/// The first increment of a drag counted as the end of its step, and the last one did not.
#[test]
fn the_sheet_of_a_session_is_that_of_run() {
    let mut session = session(&format!("{Y}{STEPS}{LIMITS}"));
    let path = [[0.54, 0.2, 0.06], [0.52, 0.19, 0.07], [0.5, 0.19, 0.08]];
    drag(&mut session, "plug-B", &path);
    let text = text(&mut session);
    let (own, run) = (session.record().requirements, run_of(&text).requirements);
    assert_eq!(own.len(), run.len());
    for (own, run) in own.iter().zip(&run) {
        let at = |line: &RequirementResult| line.moment.as_ref().map(|moment| (moment.step.clone(), moment.increment));
        assert_eq!((&own.name, own.verdict, at(own)), (&run.name, run.verdict, at(run)), "{own:?}\n{run:?}");
        let close = own.worst.zip(run.worst).is_none_or(|(own, run)| (own - run).abs() <= 1e-9 * run.abs());
        assert!(close, "{own:?}\n{run:?}");
    }
    let rest = own.iter().find(|line| line.name == "bends at rest").expect("a line");
    assert!(rest.verdict == wireloom::result::Verdict::Fail, "{rest:?}");
    // The frame of the end says so, too.
    let frames = session.frames_from(session.now.frames() - 1);
    let header = frame::header(frames[0].as_ref().expect("there")).expect("a frame");
    assert!(header.violations.iter().any(|own| own.name == "bends at rest"), "{:?}", header.violations);
}

#[test]
fn undo_takes_the_sheet_back_and_nothing_passes_while_steps_are_missing() {
    let mut session = session(&format!("{Y}{STEPS}{LIMITS}"));
    let before = session.sheet();
    assert_eq!((before.done, before.steps), (2, 2));
    let from = last(&session).constraints[1].position;
    // Far beyond what the arm reaches.
    done(&mut session, to("plug-B", [from.x + 0.4, from.y, from.z]));
    done(&mut session, drop_("plug-B"));
    let stretched = session.sheet();
    assert_eq!((stretched.verdict.as_str(), stretched.lines[0].verdict.as_str()), ("fail", "fail"));
    let reach = stretched.lines.iter().find(|line| line.measure == "reach").expect("a line");
    assert!(reach.verdict == "fail" && reach.worst > Some(1.01), "{reach:?}");
    assert_eq!(session.sheet().lines.len(), before.lines.len());
    done(&mut session, Request::Undo);
    assert_eq!(session.sheet(), before);

    let mut halfway = opened(&format!("{Y}{STEPS}"));
    while halfway.now.steps.len() < 2 {
        halfway.work();
    }
    let sheet = halfway.sheet();
    assert_eq!((sheet.done, sheet.steps, sheet.status.as_str()), (0, 2, "converged"));
    assert_ne!(sheet.verdict, "pass");
}

#[test]
fn the_start_is_checked_and_shown() {
    let tight = "[[requirements]]\nname = \"straight\"\nquantity = \"bend_radius\"\nmin = \"100 m\"\n";
    let session = session(&format!("{Y}{tight}"));
    assert_eq!(session.now.frames(), 1);
    let sheet = session.sheet();
    let line = sheet.lines.iter().find(|line| line.name == "straight").expect("a line");
    assert_eq!((line.verdict.as_str(), line.frame, line.increment), ("fail", Some(0), Some(0)));
    let header = frame::header(session.frames_from(0)[0].as_ref().expect("there")).expect("a frame");
    assert!(header.violations.iter().any(|own| own.name == "straight"));
}

#[test]
fn grab_pin_clip_and_release_are_reproduced_by_run() {
    let mut session = session(Y);
    hold(&mut session, "left", 0.301, Holding::Handle);
    drag(&mut session, "handle 1", &[[0.6, 0.1, -0.05], [0.6, 0.12, 0.0]]);
    hold(&mut session, "trunk", 0.21, Holding::Collar);
    hold(&mut session, "right", 0.15, Holding::Handle);
    assert_eq!(session.held(), [("handle 2".to_owned(), 1)]);
    drag(&mut session, "handle 2", &[[0.5, -0.05, 0.0]]);
    assert_eq!(session.held(), []);
    refused(
        &mut session,
        Request::Target { constraint: "handle 2".into(), position: None, orientation: Some([1.0, 0.0, 0.0, 0.0]) },
    );
    done(&mut session, Request::Pin { constraint: "handle 2".into() });
    let q = Some([0.8, 0.1, 0.6, 0.0]);
    done(&mut session, Request::Target { constraint: "handle 2".into(), position: None, orientation: q });
    done(&mut session, Request::Release { constraint: "handle 1".into() });
    let text = text(&mut session);
    let ends = ends(&text);
    assert_eq!(session.now.frames(), 1 + ends.len(), "{text}");
    let farthest = apart(&last(&session), &ends[ends.len() - 1]);
    assert!(farthest < ALIKE, "{farthest:e}\n{text}");
    let names: Vec<String> = session.timeline().steps.into_iter().map(|step| step.name).collect();
    let expected = [
        "start",
        "add handle 1",
        "drag handle 1",
        "add clip 1",
        "add handle 2",
        "drag handle 2",
        "pin handle 2",
        "drag handle 2 2",
        "release handle 1",
    ];
    assert_eq!(names, expected);
    assert!(session.scene().constraints.iter().any(|constraint| constraint.name == "clip 1" && constraint.by_hand));
}

#[test]
fn undo_and_redo_restore_every_state() {
    let mut session = session(&format!("{Y}{STEPS}"));
    let mut stood = vec![(bits(&last(&session)), session.now.frames())];
    drag(&mut session, "plug-B", &[[0.54, 0.2, 0.06], [0.53, 0.19, 0.07]]);
    stood.push((bits(&last(&session)), session.now.frames()));
    hold(&mut session, "right", 0.3, Holding::Handle);
    stood.push((bits(&last(&session)), session.now.frames()));
    done(&mut session, Request::Set { key: "joints.J.model".into(), value: json!("fused") });
    stood.push((bits(&last(&session)), session.now.frames()));
    done(&mut session, Request::Go { frame: 3 });
    stood.push((bits(&last(&session)), session.now.frames()));
    assert_eq!(session.now.frames(), 5);
    for k in (0..stood.len() - 1).rev() {
        done(&mut session, Request::Undo);
        assert_eq!((bits(&last(&session)), session.now.frames()), stood[k], "{k}");
    }
    refused(&mut session, Request::Undo);
    for after in &stood[1..] {
        done(&mut session, Request::Redo);
        assert_eq!((bits(&last(&session)), session.now.frames()), *after);
    }
    refused(&mut session, Request::Redo);
}

#[test]
fn a_drag_from_an_earlier_step_cuts_off_what_came_after() {
    let mut session = session(&format!("{Y}{STEPS}"));
    done(&mut session, Request::Go { frame: 2 });
    drag(&mut session, "plug-B", &[[0.54, 0.2, 0.06]]);
    let text = text(&mut session);
    assert!(!text.contains("clip the trunk"), "{text}");
    let ends = ends(&text);
    assert!(apart(&last(&session), &ends[ends.len() - 1]) < ALIKE);
    assert_eq!(session.now.frames(), 1 + ends.len());
}

#[test]
fn settings_are_written_and_the_run_is_repeated() {
    let mut session = session(&format!("{Y}{STEPS}"));
    drag(&mut session, "plug-B", &[[0.54, 0.2, 0.06], [0.53, 0.19, 0.07]]);
    let before = last(&session);
    done(&mut session, Request::Set { key: "joints.J.model".into(), value: json!("rigid-body") });
    done(&mut session, Request::Set { key: "sections.trunk.bending_stiffness".into(), value: json!(0.02) });
    assert!(apart(&before, &last(&session)) > 1e-3);
    let settings = session.scene().settings;
    let now = |key: &str| settings.iter().find(|setting| setting.key == key).map(|setting| setting.value.clone());
    assert_eq!(now("joints.J.model"), Some(json!("rigid-body")));
    assert_eq!(now("sections.trunk.bending_stiffness"), Some(json!(0.02)));
    let text = text(&mut session);
    assert!(text.contains("model = \"rigid-body\" # as measured"), "{text}");
    assert!(text.contains("bending_stiffness = 0.02 # measured"), "{text}");
    assert_eq!(bits(&last(&session)), bits(&ends(&text)[7]));
    // A compliant hub needs the stiffness of its springs first.
    let model = || Request::Set { key: "joints.J.model".into(), value: json!("compliant-hub") };
    assert!(refused(&mut session, model()).contains("has no `bending_stiffness`"));
    done(&mut session, Request::Set { key: "joints.J.bending_stiffness".into(), value: json!(0.3) });
    done(&mut session, Request::Set { key: "joints.J.torsion_stiffness".into(), value: json!(0.2) });
    let rigid = last(&session);
    done(&mut session, model());
    assert!(apart(&rigid, &last(&session)) > 1e-3);
    let text = self::text(&mut session);
    assert_eq!(bits(&last(&session)), bits(&ends(&text)[7]));
    for (key, value) in [
        ("joints.J.model", json!("soft")),
        ("sections.trunk.bending_stiffness", json!(-1.0)),
        ("sections.trunk.bending_stiffness", json!("much")),
        ("minimiser.max_iterations", json!(-3)),
        ("name", json!("x")),
        ("", json!(null)),
    ] {
        refused(&mut session, Request::Set { key: key.into(), value });
    }
}

#[test]
fn invalid_requests_are_refused_without_effect() {
    let mut session = session(&format!("{Y}{STEPS}"));
    let before = (bits(&last(&session)), session.now.frames());
    for request in [
        to("plug-Z", [0.0; 3]),
        to("plug-B", [f64::NAN, 0.0, 0.0]),
        to("plug-B", [1e300, 0.0, 0.0]),
        Request::Target { constraint: "plug-B".into(), position: None, orientation: None },
        Request::Target { constraint: "plug-B".into(), position: None, orientation: Some([0.0; 4]) },
        Request::Target {
            constraint: "plug-B".into(),
            position: None,
            orientation: Some([f64::INFINITY, 0.0, 0.0, 1.0]),
        },
        Request::Hold { branch: "trunk".into(), s: f64::NAN, how: Holding::Handle },
        Request::Hold { branch: "trunk".into(), s: 9.0, how: Holding::Pin },
        Request::Hold { branch: "none".into(), s: 0.0, how: Holding::Collar },
        Request::Release { constraint: "none".into() },
        Request::Pin { constraint: String::new() },
        Request::Go { frame: 99 },
        Request::Undo,
    ] {
        refused(&mut session, request);
        assert_eq!((bits(&last(&session)), session.now.frames()), before);
    }
    // The harness would be unsupported.
    let mut alone = self::session(Y);
    let message = refused(&mut alone, Request::Release { constraint: "plug-A".into() });
    assert!(message.contains("not held"), "{message}");
    drag(&mut alone, "plug-A", &[[0.01, 0.0, 0.0]]);
}

/// Newton, unless it is disabled.
struct Lazy {
    newton: Box<dyn Minimiser>,
    rests: Arc<AtomicBool>,
}

impl Minimiser for Lazy {
    fn name(&self) -> &str {
        "lazy"
    }

    fn minimise(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report {
        let allowed = if self.rests.load(Ordering::Relaxed) { 0 } else { stop.max_iterations };
        self.newton.minimise(problem, state, &Stop { max_iterations: allowed, ..*stop })
    }

    fn forget(&mut self) {
        self.newton.forget();
    }
}

/// A registry with the minimiser `lazy`, which does nothing while this flag is set.
fn with_lazy(rests: &Arc<AtomicBool>) -> Registry {
    let mut registry = wireloom::registry();
    let rests = rests.clone();
    let kind = MinimiserKind {
        name: "lazy".into(),
        doc: "rests now and then".into(),
        parameters: vec![],
        build: Box::new(move |(), parameters| {
            let newton = wireloom::registry().minimiser("newton").map(|kind| (kind.build)(&(), parameters));
            Ok(Box::new(Lazy { newton: newton.expect("built in")?, rests: rests.clone() }))
        }),
    };
    registry.add_minimiser(kind).unwrap_or_else(|_| panic!("there is no such kind"));
    registry
}

/// An increment that does not converge is shown, and removed by the next request.
#[test]
fn increments_without_equilibrium_are_shown_but_not_recorded() {
    let rests = Arc::new(AtomicBool::new(false));
    let input = SessionInput {
        text: format!("{Y}{STEPS}\n[minimiser]\nkind = \"lazy\"\n"),
        name: "y.toml".into(),
        files: Arc::new(NoFiles),
        registry: with_lazy(&rests),
        unsaved: false,
        storage: None,
    };
    let mut session = Session::open(input, Monitor::default()).unwrap_or_else(|faults| panic!("{faults:?}"));
    work(&mut session);
    let status = |session: &Session| {
        let frame = session.frames_from(session.now.frames() - 1)[0].clone().expect("there");
        frame::decode(&frame).expect("a frame").0.status
    };
    let unbalanced = |session: &mut Session, request: Request| {
        rests.store(true, Ordering::Relaxed);
        done(session, request);
        rests.store(false, Ordering::Relaxed);
        assert_eq!(status(session), "iteration limit");
    };
    let (shape, frames) = (bits(&last(&session)), session.now.frames());
    unbalanced(&mut session, to("plug-B", [0.54, 0.2, 0.06]));
    assert_eq!(session.now.frames(), frames + 1);
    let events = session.timeline().events;
    assert!(
        events.iter().any(|event| event.kind == "not-converged" && event.frame == frame::number(frames)),
        "{events:?}"
    );
    // Another target replaces it; another constraint's frame is removed by its release.
    done(&mut session, to("plug-B", [0.54, 0.2, 0.05]));
    assert_eq!((status(&session).as_str(), session.now.frames()), ("converged", frames + 1));
    unbalanced(&mut session, to("plug-B", [0.54, 0.2, 0.06]));
    assert_eq!(session.now.frames(), frames + 2);
    done(&mut session, drop_("plug-B"));
    assert_eq!((status(&session).as_str(), session.now.frames()), ("converged", frames + 1));
    assert!(session.timeline().events.iter().all(|event| event.kind != "not-converged"));
    done(&mut session, Request::Undo);
    assert_eq!((bits(&last(&session)), session.now.frames()), (shape.clone(), frames));
    // Without an equilibrium there is no step, and nothing to undo.
    unbalanced(&mut session, to("plug-B", [0.54, 0.2, 0.06]));
    done(&mut session, drop_("plug-B"));
    assert_eq!((bits(&last(&session)), session.now.frames()), (shape.clone(), frames));
    refused(&mut session, Request::Undo);
    // Nor for a release.
    rests.store(true, Ordering::Relaxed);
    refused(&mut session, Request::Release { constraint: "plug-B".into() });
    rests.store(false, Ordering::Relaxed);
    assert_eq!((bits(&last(&session)), session.now.frames()), (shape, frames));
}

/// A stopped computation is not part of the state that operations extend.
#[test]
fn a_stopped_run_continues_interactively() {
    let input = SessionInput {
        text: format!("{Y}{STEPS}"),
        name: "y.toml".into(),
        files: Arc::new(NoFiles),
        registry: wireloom::registry(),
        unsaved: false,
        storage: None,
    };
    let mut session = Session::open(input, Monitor::default()).unwrap_or_else(|faults| panic!("{faults:?}"));
    session.work();
    session.work();
    let refused_now = |session: &mut Session| {
        session.handle(1, to("plug-A", [0.0, 0.0, 0.01]));
        session.take_changes().said
    };
    assert!(matches!(refused_now(&mut session)[..], [(Some(1), Notice::Refused { .. })]));
    assert_eq!(session.busy().as_deref(), Some("step plug B"));
    done(&mut session, Request::Stop);
    assert_eq!((session.busy(), session.now.frames()), (None, 2));
    drag(&mut session, "plug-A", &[[0.0, 0.0, 0.01]]);
    assert_eq!(session.now.frames(), 2);
    let text = text(&mut session);
    assert!(!text.contains("plug B"), "{text}");
    assert_eq!(ends(&text).len(), 1);
    done(&mut session, Request::Undo);
    assert_eq!(session.now.frames(), 2);
    // An aborted start leaves a session that still answers.
    session.handle(1, Request::Set { key: "joints.J.model".into(), value: json!("fused") });
    session.monitor.stop();
    session.work();
    session.monitor.go_on();
    refused(&mut session, to("plug-A", [0.0, 0.0, 0.01]));
    done(&mut session, Request::Undo);
    assert_eq!(session.now.frames(), 2);
}

/// Frames within steps are dropped first, and steps whose end was dropped are recomputed.
#[test]
fn memory_is_bounded() {
    let mut session = session(&format!("{Y}{STEPS}"));
    drag(&mut session, "plug-B", &[[0.54, 0.2, 0.06], [0.53, 0.19, 0.07], [0.52, 0.19, 0.08]]);
    let (frames, shape) = (session.frames_from(0), bits(&last(&session)));
    let weight = frames.iter().flatten().map(|frame| frame.len()).sum::<usize>();
    session.limit_memory(weight, usize::MAX);
    assert_eq!(session.frames_from(0), frames);
    session.limit_memory(1, 1);
    assert!(session.take_changes().thinned);
    let left: Vec<usize> = (0..).zip(session.frames_from(0)).filter_map(|(k, frame)| frame.map(|_| k)).collect();
    assert_eq!(left, [0, 4, 6, 9]);
    drag(&mut session, "plug-B", &[[0.52, 0.2, 0.08]]);
    done(&mut session, Request::Undo);
    assert_eq!(bits(&last(&session)), shape);
    done(&mut session, Request::Go { frame: 5 });
    assert_eq!(session.now.frames(), 7);
    assert_eq!(bits(&last(&session)), bits(&ends(&format!("{Y}{STEPS}"))[5]));
}

/// Any sequence of requests gets an answer, and none causes a panic.
#[test]
fn any_sequence_of_requests_keeps_the_session_alive() {
    let mut random = fastrand::Rng::with_seed(8);
    let given = format!("{Y}{STEPS}");
    let mut session = opened_in(&given, Some(Box::new(Memory::of(&given))));
    work(&mut session);
    let names = ["plug-A", "plug-B", "clip", "handle 1", "handle 2", "pin 1", "clip 1", "nobody", ""];
    let numbers = [f64::NAN, f64::NEG_INFINITY, 1e308, -1e-300, 0.0, 1.0];
    for _ in 0..300 {
        let number = |random: &mut fastrand::Rng| match random.u32(..12) {
            0 => numbers[random.usize(..numbers.len())],
            _ => random.f64() - 0.3,
        };
        let constraint = names[random.usize(..names.len())].to_owned();
        let request = match random.u32(..22) {
            0 | 1 => Request::Hold {
                branch: ["trunk", "left", "right", "x"][random.usize(..4)].into(),
                s: number(&mut random),
                how: [Holding::Handle, Holding::Pin, Holding::Collar][random.usize(..3)],
            },
            2..10 => Request::Target {
                constraint,
                position: random.bool().then(|| std::array::from_fn(|_| number(&mut random))),
                orientation: (random.u32(..3) == 0).then(|| std::array::from_fn(|_| number(&mut random))),
            },
            10 | 11 => Request::Drop { constraint },
            12 => Request::Release { constraint },
            13 => Request::Pin { constraint },
            14 => Request::Undo,
            15 => Request::Redo,
            16 => Request::Go { frame: random.u32(..60) },
            17 => Request::Stop,
            18 => Request::Save,
            19 => {
                let name = ["y.toml", "z.toml", "../z.toml", ""][random.usize(..4)].to_owned();
                Request::Store { name: random.bool().then_some(name), replace: random.bool() }
            }
            20 => Request::Reload,
            _ => {
                let settings = session.scene().settings;
                let key = settings[random.usize(..settings.len())].key.clone();
                let value = [json!(0.02), json!("fused"), json!("cosserat"), json!(1e-9), json!(null)];
                Request::Set { key, value: value[random.usize(..value.len())].clone() }
            }
        };
        session.handle(random.u32(1..3), request);
        for _ in 0..random.u32(..4) {
            if session.has_work() {
                session.work();
            }
        }
        if random.u32(..10) == 0 {
            session.detach(random.u32(1..3));
        }
        session.take_changes();
    }
    work(&mut session);
    session.take_changes();
    // It answers, and its text is a valid scenario.
    let said = ask(&mut session, Request::Save);
    assert!(matches!(said.first(), Some(Notice::Saved { .. })), "{said:?}");
    assert!(said.len() == 1, "{said:?}");
}

/// Sliding rings, obstacles, clips that find their place, springs: `run` reproduces operations on all of them.
#[test]
fn operations_on_all_kinds_of_harnesses_are_reproduced_by_run() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios");
    for name in [
        "analytic/ring_friction",
        "assembly/clip_nearest",
        "assembly/out_of_the_ring",
        "branches/rail",
        "branches/springy_handle",
        "branches/two_trees",
        "contact/cable_on_plane",
    ] {
        let given = std::fs::read_to_string(folder.join(name).with_extension("toml")).expect("a scenario");
        let mut session = session(&given);
        let end = last(&session);
        let line = &end.branches[end.branches.len() - 1];
        let middle = line.s.len() / 2;
        let at = line.position[middle];
        hold(&mut session, &line.name, line.s[middle], Holding::Handle);
        drag(&mut session, "handle 1", &[[at.x, at.y + 0.01, at.z + 0.02], [at.x + 0.005, at.y + 0.02, at.z + 0.02]]);
        let text = text(&mut session);
        let ends = ends(&text);
        let farthest = apart(&last(&session), &ends[ends.len() - 1]);
        let length = session.now.harness.total_length();
        assert!(farthest <= 1e-6 * length, "{name}: {farthest:e} of {length}");
    }
}

/// A joint of a mechanism is driven, what is mounted on it goes along, and the steps that are saved do the same. What
/// is moved by hand on the open door is saved as the door is drawn.
#[test]
fn a_door_is_driven_and_its_plug_moved_on_it() {
    let door = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/mechanisms/door.toml");
    let mut session = session(&std::fs::read_to_string(door).expect("a scenario"));
    let [joint] = &session.scene().mechanism_joints[..] else { panic!() };
    assert_eq!(
        (joint.name.as_str(), joint.is_length, joint.limits.map(|l| l[0])),
        ("front door/hinge", false, Some(0.0))
    );
    let drive = |value: f64| Request::Drive { joint: "front door/hinge".into(), value };
    done(&mut session, drive(1.0));
    let on_arc = |x: f64, y: f64| {
        let (sin, cos) = 1.0_f64.sin_cos();
        Vector::new(0.1 + x * cos - y * sin, x * sin + y * cos, 0.0)
    };
    assert!((last(&session).constraints[1].position - on_arc(0.2, -0.02)).norm() < 1e-12);
    let frames = session.frames_from(session.now.frames() - 1);
    assert_eq!(frame::header(frames[0].as_ref().expect("there")).expect("a frame").mechanism_values, [1.0]);
    // Beyond the limit, and a joint that there is not.
    assert!(refused(&mut session, drive(2.0)).contains("beyond its limit 75.000 deg"));
    let none = Request::Drive { joint: "hinges".into(), value: 0.0 };
    assert_eq!(refused(&mut session, none), "there is no joint \"hinges\"");
    // A handle is taken, so that the harness is built anew, and the door stays open.
    hold(&mut session, "loop", 0.3, Holding::Handle);
    drag(&mut session, "door plug", &[on_arc(0.21, -0.03).into()]);
    assert!((last(&session).constraints[1].position - on_arc(0.21, -0.03)).norm() < 1e-12);
    done(&mut session, drive(0.0));
    assert!((last(&session).constraints[1].position - Vector::new(0.31, -0.03, 0.0)).norm() < 1e-12);
    let saved = text(&mut session);
    let run = ends(&saved);
    let shown = last(&session);
    let nodes = run.last().expect("an end").branches[0].position.iter().zip(&shown.branches[0].position);
    assert!(nodes.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) < ALIKE, "{saved}");
}

/// What it does to move a plug is told of the harness as it is now, and why it is not.
#[test]
fn what_it_does_to_move_a_plug_is_told() {
    let of = |constraint: &str| Request::Sensitivities { constraint: constraint.to_owned() };
    let told = |said: Vec<Notice>| match &said[..] {
        [Notice::Sensitivities(found)] => found.clone(),
        other => panic!("{other:?}"),
    };
    let text = format!("{Y}{STEPS}");
    let mut session = opened(&text);
    session.handle(1, of("plug-B"));
    let said = session.take_changes().said.into_iter().map(|(_, notice)| notice).collect();
    assert_eq!(told(said).reason.as_deref(), Some("the harness is being computed"));
    work(&mut session);
    let found = told(ask(&mut session, of("plug-B")));
    assert_eq!((found.constraint.as_str(), found.reason), ("plug-B", None));
    let trunk = found.lines.iter().find(|line| line.name == "trunk").expect("the limit of a section");
    assert_eq!((trunk.measure.as_str(), trunk.unit.as_str(), trunk.limit), ("bend_radius", "m", 0.048));
    let by = trunk.by.map(|sides| sides.map(|side| side.expect("a derivative")));
    assert!(by.as_flattened().iter().all(|by| by.abs() > 1e-4), "{by:?}");
    let none = told(ask(&mut session, of("plug-X"))).reason.expect("a reason");
    assert!(none.contains("no constraint \"plug-X\" is active"), "{none}");
}
