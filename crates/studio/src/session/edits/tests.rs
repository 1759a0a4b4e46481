//! Changes of the text of a session, and that `run` carries out what they make.

use super::super::tests::{ALIKE, STEPS, Y, apart, ask, done, ends, hold, last, opened, refused, session, text, work};
use super::super::{SessionInput, Storage, StoreError};
use super::*;
use crate::protocol::{Holding, Request};
use serde_json::json;
use std::sync::Mutex;
use wireloom::scenario::{Files, NoFiles};
use wireloom::session::Monitor;

fn edit(session: &mut Session, edit: Edit) {
    done(session, Request::Edit { edit });
}

/// The session shows what `run` makes of its text.
fn as_run(session: &mut Session) -> String {
    let text = session.text().expect("a text");
    let ends = ends(&text);
    let shown = last(session);
    // Without steps, the start is all there is.
    let frames = if session.now.harness.schedule.steps.is_empty() { 1 } else { 1 + ends.len() };
    assert_eq!(session.now.frames(), frames, "{text}");
    assert!(apart(&shown, &ends[ends.len() - 1]) < ALIKE, "{text}");
    text
}

#[test]
fn edits_are_named_commands_that_undo_and_that_run_carries_out() {
    let given = format!("{Y}{STEPS}");
    let mut session = session(&given);
    let put = |key: &str, value: Json| Edit::Put { key: key.into(), value };
    let add = |list, entry| Edit::Add { list, entry };
    let rename = |part, name: &str, to: &str| Edit::Rename { part, name: name.into(), to: to.into() };
    let delete = |part, name: &str| Edit::Delete { part, name: name.into() };
    let at = |position, orientation| Placed { position, orientation };
    // Wherever a mechanism has carried it.
    let from = at([7.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]);
    let by = |[x, y, z]: [f64; 3], turn| Edit::Move { obstacle: "ball".into(), from, to: at([7.0 + x, y, z], turn) };
    let ball = json!({ "name": "ball", "shape": "sphere", "radius": "30 mm", "position": [0.3, 0.3, 0.1] });
    let bend = json!({ "name": "bend", "quantity": "bend_radius", "of": { "branch": "long arm" }, "min": "20 mm" });
    let clip = json!({ "name": "tie", "kind": "collar", "at": { "branch": "right", "s": "200 mm" },
        "position": [0.6, -0.1, -0.1], "tangent": [0.8, -0.5, 0] });
    for (what, label, has) in [
        (put("branches.left.length", json!("420 mm")), "length of branches.left", "length = \"420 mm\""),
        (put("branches.left.section", json!("trunk")), "section of branches.left", "section = \"trunk\""),
        (rename(PartKind::Branch, "left", "long arm"), "rename branch left to long arm", "branch = \"long arm\""),
        (add(List::Constraints, clip), "add constraint tie", "at = { branch = \"right\", s = \"200 mm\" }"),
        (put("constraints.tie.hold", json!(["position"])), "hold of constraints.tie", "hold = [\"position\"]"),
        (Edit::Remove { key: "constraints.tie.tangent".into() }, "remove tangent of constraints.tie", ""),
        (add(List::Obstacles, ball), "add obstacle ball", "[[obstacles]]\nname = \"ball\"\nshape = \"sphere\""),
        (put("obstacles.ball.position", json!([0.3, 0.35, 0.1])), "position of obstacles.ball", "[0.3, 0.35, 0.1]"),
        (by([0.0, 0.05, 0.0], [1.0, 0.0, 0.0, 0.0]), "move obstacle ball", "position = [0.3, 0.4, 0.1]"),
        (by([0.0; 3], [1.0, 0.0, 0.0, 1.0]), "turn obstacle ball", "orientation = [0.7071068, 0, 0, 0.7071068]"),
        (delete(PartKind::Obstacle, "ball"), "delete obstacle ball", ""),
        (Edit::Split { branch: "right".into(), s: 0.1 }, "split branch right", "name = \"right 2\""),
        (delete(PartKind::Constraint, "tie"), "delete constraint tie", ""),
        (delete(PartKind::Branch, "right 2"), "delete branch right 2", ""),
    ] {
        let before = session.text().expect("a text");
        edit(&mut session, what);
        assert_eq!(session.undo_labels()[0].as_deref(), Some(label));
        let text = as_run(&mut session);
        assert!(text.contains(has) && text.contains("# by the author"), "{label}: {text}");
        done(&mut session, Request::Undo);
        assert_eq!(session.text().as_deref(), Ok(before.as_str()), "{label}");
        done(&mut session, Request::Redo);
        assert_eq!(session.text().as_deref(), Ok(text.as_str()), "{label}");
    }
    edit(&mut session, add(List::Requirements, bend));
    assert!(session.sheet().lines.iter().any(|line| line.name == "bend" && line.verdict != "not checked"));
    edit(&mut session, put("requirements.bend.min", json!("2 m")));
    let line = session.sheet().lines.into_iter().find(|line| line.name == "bend").expect("a line");
    assert_eq!((line.verdict.as_str(), line.limit), ("fail", 2.0));
    edit(&mut session, delete(PartKind::Requirement, "bend"));
    assert!(session.sheet().lines.iter().all(|line| line.name != "bend"));
    assert!(session.unsaved());
}

#[test]
fn branches_are_added_at_a_joint_an_end_and_a_point() {
    for from in [Start::Joint("J".into()), Start::End("C".into()), Start::Point { branch: "trunk".into(), s: 0.2 }] {
        let mut session = session(Y);
        let new = Edit::Branch { name: "tap".into(), from, section: "arm".into(), length: json!("120 mm") };
        edit(&mut session, new);
        let text = as_run(&mut session);
        let end = last(&session);
        let tap = end.branches.iter().find(|branch| branch.name == "tap").expect("a branch");
        assert!((tap.s.last().expect("nodes") - 0.12).abs() < 1e-12, "{text}");
        let starts = end.branches.iter().filter(|branch| branch.name != "tap");
        let meets = starts.flat_map(|branch| [branch.position[0], branch.position[branch.position.len() - 1]]);
        assert!(meets.map(|x| (x - tap.position[0]).norm()).fold(f64::INFINITY, f64::min) < 1e-9, "{text}");
    }
}

#[test]
fn several_parts_are_deleted_as_one_command_and_a_branch_with_its_clip() {
    let given = format!("{Y}{STEPS}");
    let mut session = session(&given);
    let clip = json!({ "name": "tie", "kind": "collar", "at": { "branch": "right", "s": "200 mm" },
        "position": [0.6, -0.1, -0.1], "tangent": [0.8, -0.5, 0] });
    edit(&mut session, Edit::Add { list: List::Constraints, entry: clip });
    let ball = json!({ "name": "ball", "shape": "sphere", "radius": "30 mm", "position": [0.3, 0.5, 0.1] });
    edit(&mut session, Edit::Add { list: List::Obstacles, entry: ball });
    edit(&mut session, Edit::Split { branch: "right".into(), s: 0.1 });
    let before = session.text();
    let parts = [(PartKind::Branch, "right 2"), (PartKind::Constraint, "tie"), (PartKind::Obstacle, "ball")];
    let parts = parts.map(|(part, name)| (part, name.to_owned()));
    edit(&mut session, Edit::DeleteAll { parts: [parts.to_vec(), parts.to_vec()].concat() });
    assert_eq!(session.undo_labels()[0].as_deref(), Some("delete 3 parts"));
    let text = as_run(&mut session);
    assert!(!["right 2", "tie", "ball"].iter().any(|name| text.contains(name)), "{text}");
    done(&mut session, Request::Undo);
    assert_eq!(session.text(), before);
    let said = refused(&mut session, Request::Edit { edit: Edit::DeleteAll { parts: Vec::new() } });
    assert!(said.contains("nothing to delete"), "{said}");
}

#[test]
fn edits_that_make_no_scenario_are_refused_and_change_nothing() {
    let mut session = session(&format!("{Y}{STEPS}"));
    let before = (session.text(), session.now.frames());
    let at = |orientation| Placed { position: [0.0; 3], orientation };
    let by = |name: &str, turn| Edit::Move { obstacle: name.into(), from: at([1.0, 0.0, 0.0, 0.0]), to: at(turn) };
    for (edit, says) in [
        (Edit::Put { key: "branches.left.length".into(), value: json!(-1) }, "length"),
        (Edit::Put { key: "branches.lft.length".into(), value: json!(1) }, "there is no `lft`"),
        (Edit::Put { key: "branches.left.section".into(), value: json!("wire") }, "wire"),
        (Edit::Remove { key: "branches.left.length".into() }, "length"),
        (Edit::Rename { part: PartKind::Branch, name: "left".into(), to: "right".into() }, "already a branch"),
        (Edit::Delete { part: PartKind::Branch, name: "none".into() }, "no branch \"none\""),
        (Edit::Split { branch: "left".into(), s: 7.0 }, "cannot be split"),
        (by("none", [1.0, 0.0, 0.0, 0.0]), "no obstacle \"none\""),
        (by("none", [0.0; 4]), "length 0"),
        (Edit::DeleteAll { parts: vec![(PartKind::Branch, "left".into()), (PartKind::Branch, "x".into())] }, "\"x\""),
        (Edit::Add { list: List::Obstacles, entry: json!({ "name": "x" }) }, "neither `shape` nor `mesh`"),
        (Edit::Add { list: List::Requirements, entry: json!([]) }, "is no entry"),
    ] {
        let said = refused(&mut session, Request::Edit { edit: edit.clone() });
        assert!(said.contains(says), "{edit:?}: {said}");
        assert_eq!((session.text(), session.now.frames()), before, "{edit:?}");
    }
    assert!(!session.unsaved() && session.undo_labels() == [None, None]);
}

#[test]
fn a_text_that_differs_in_a_later_step_is_carried_out_from_there() {
    let given = format!("{Y}{STEPS}");
    let mut session = session(&given);
    hold(&mut session, "left", 0.17, Holding::Handle);
    let (run, frames) = (session.scene().run, session.now.frames());
    let document = session.changed_document().expect("never asked for");
    let apply = |text: &str, base: u32| Request::Apply { text: text.to_owned(), base };
    // The second step takes more increments; the first one, and the start, stay computed.
    let text = document.text.replace("increments = 2", "increments = 3");
    session.handle(1, apply(&text, document.version));
    assert!(session.take_changes().said.is_empty());
    assert_eq!((session.scene().run, session.now.frames()), (run, 5), "nothing is computed yet");
    work(&mut session);
    assert_eq!(session.now.frames(), frames + 1);
    assert_eq!(as_run(&mut session), text);
    // A comment changes nothing that is computed.
    let base = session.changed_document().expect("another text").version;
    session.handle(1, apply(&format!("# seen\n{text}"), base));
    assert!(!session.has_work() && session.scene().run == run);
    // Without its last step, and with another length: from the start.
    let base = session.changed_document().expect("another text").version;
    session.handle(1, apply(&text.replace("length = \"400 mm\"", "length = \"410 mm\""), base));
    assert!(session.take_changes().said.is_empty() && session.scene().run > run);
    work(&mut session);
    as_run(&mut session);
    done(&mut session, Request::Undo);
    assert_eq!(session.text(), Ok(format!("# seen\n{text}")));
    assert_eq!((session.scene().run, session.now.frames()), (run, frames + 1));
}

#[test]
fn a_text_with_faults_or_of_an_older_version_is_refused_in_place() {
    let mut session = session(Y);
    let base = session.changed_document().expect("never asked for").version;
    // A character of two UTF-16 units before the fault.
    let faulty = format!("# \u{1f9f5}\n{Y}").replace("model = \"cosserat\"", "model = \"coserat\"");
    let faulty =
        if faulty.contains("coserat") { faulty } else { faulty.replace("kind = \"connector\"", "kind = \"conector\"") };
    let said = ask(&mut session, Request::Apply { text: faulty.clone(), base });
    let [Notice::Checked { number: None, faults }, Notice::Refused { message, .. }] = &said[..] else {
        panic!("{said:?}")
    };
    let units: Vec<u16> = faulty.encode_utf16().collect();
    let marked = String::from_utf16_lossy(&units[faults[0].from as usize..faults[0].to as usize]);
    assert!(marked.contains("conector") || marked.contains("coserat"), "{marked}: {faults:?}");
    assert!(message.starts_with(&format!("line {}, column {}: ", faults[0].line, faults[0].column)), "{message}");
    hold(&mut session, "left", 0.17, Holding::Handle);
    let said = refused(&mut session, Request::Apply { text: format!("{Y}\n"), base });
    assert_eq!(said, "the scenario was changed while this text was edited");
    let huge = Request::Apply { text: "#".repeat(5 << 20), base: session.document.0 };
    let said = ask(&mut session, huge);
    assert!(format!("{said:?}").contains("the text has 5242880 bytes"));
}

/// A file in memory: its text, and whether another program has changed it since it was written or taken.
#[derive(Clone)]
pub(in super::super) struct Memory(Arc<Mutex<(String, bool)>>);

impl Memory {
    pub fn of(text: &str) -> Self {
        Self(Arc::new(Mutex::new((text.to_owned(), false))))
    }

    fn text(&self) -> String {
        self.0.lock().expect("not poisoned").0.clone()
    }

    fn change_outside(&self, text: &str) {
        *self.0.lock().expect("not poisoned") = (text.to_owned(), true);
    }
}

impl Storage for Memory {
    fn store(&mut self, text: &str, name: Option<&str>, replace: bool) -> Result<String, StoreError> {
        let mut file = self.0.lock().expect("not poisoned");
        if file.1 && !replace {
            return Err(StoreError::Changed { name: "y.toml".into() });
        }
        *file = (text.to_owned(), false);
        Ok(name.unwrap_or("y.toml").to_owned())
    }

    fn read(&self) -> Result<String, Refusal> {
        Ok(self.text())
    }

    fn taken(&mut self, text: &str) {
        let mut file = self.0.lock().expect("not poisoned");
        file.1 &= file.0 != text;
    }
}

fn opened_from(file: &Memory, files: Arc<dyn SessionFiles>) -> Session {
    let input = SessionInput {
        text: file.text(),
        name: "y.toml".into(),
        files,
        registry: wireloom::registry(),
        unsaved: false,
        storage: Some(Box::new(file.clone())),
    };
    let mut session = Session::open(input, Monitor::default()).expect("no faults");
    work(&mut session);
    session
}

fn store(name: Option<&str>, replace: bool) -> Request {
    Request::Store { name: name.map(str::to_owned), replace }
}

fn lengthen_left(session: &mut Session, length: &str) {
    edit(session, Edit::Put { key: "branches.left.length".into(), value: json!(length) });
}

#[test]
fn the_text_is_stored_in_its_file_and_read_anew() {
    let file = Memory::of(Y);
    let mut session = opened_from(&file, Arc::new(NoFiles));
    lengthen_left(&mut session, "420 mm");
    let _ = text(&mut session);
    assert!(session.unsaved(), "a copy is not the file");
    assert_eq!(ask(&mut session, store(None, false)), [Notice::Stored { name: "y.toml".into() }]);
    assert!(!session.unsaved() && file.text().contains("420 mm"));
    file.change_outside(&Y.replace("400 mm", "390 mm"));
    lengthen_left(&mut session, "430 mm");
    let conflict = [Notice::Conflict { name: "y.toml".into(), own: true }];
    assert_eq!(ask(&mut session, store(None, false)), conflict);
    assert!(session.unsaved());
    done(&mut session, Request::Reload);
    assert_eq!(session.text(), Ok(Y.replace("400 mm", "390 mm")));
    assert!(!session.unsaved());
    assert_eq!(session.undo_labels()[0].as_deref(), Some("load y.toml anew"));
    done(&mut session, Request::Undo);
    assert!(session.text().expect("a text").contains("430 mm"));
    assert_eq!(ask(&mut session, store(Some("z.toml"), false)), [Notice::Stored { name: "z.toml".into() }]);
    assert_eq!(session.document().name, "z.toml");
    let mut bare = opened(Y);
    assert_eq!(refused(&mut bare, store(None, false)), "this session has no file");
}

/// The file counted as known although the session had refused its text: the next save replaced it unasked.
#[test]
fn a_file_that_cannot_be_loaded_is_not_replaced_unasked() {
    let file = Memory::of(Y);
    let mut session = opened_from(&file, Arc::new(NoFiles));
    file.change_outside("schema = ");
    let said = ask(&mut session, Request::Reload);
    assert!(matches!(&said[..], [Notice::Checked { .. }, Notice::Refused { .. }]), "{said:?}");
    assert_eq!(session.text().as_deref(), Ok(Y), "the session stays");
    let conflict = [Notice::Conflict { name: "y.toml".into(), own: true }];
    assert_eq!(ask(&mut session, store(None, false)), conflict);
    assert_eq!(file.text(), "schema = ");
}

/// A file of any name, and what was read of it.
struct Shelf {
    now: Arc<Mutex<String>>,
    read: String,
}

impl Files for Shelf {
    fn read(&self, _: &str) -> Result<String, String> {
        Ok(self.read.clone())
    }
}

impl SessionFiles for Shelf {
    fn anew(&self) -> Arc<dyn SessionFiles> {
        let read = self.now.lock().expect("not poisoned").clone();
        Arc::new(Self { now: self.now.clone(), read })
    }
}

/// Files that the scenario names were those of the beginning, whatever was loaded anew.
#[test]
fn a_reload_reads_the_files_that_the_text_names_and_computes_from_the_start() {
    let now = Arc::new(Mutex::new(String::new()));
    let shelf = Shelf { now: now.clone(), read: String::new() };
    let given = format!("{Y}{STEPS}\n[library]\nfiles = [\"more.toml\"]\n");
    let mut session = opened_from(&Memory::of(&given), Arc::new(shelf));
    let run = session.scene().run;
    "wrong = 1".clone_into(&mut now.lock().expect("not poisoned"));
    lengthen_left(&mut session, "310 mm");
    assert_eq!(session.known().check(&given), [], "what was read stays");
    done(&mut session, Request::Undo);
    let said = ask(&mut session, Request::Reload);
    assert!(format!("{said:?}").contains("more.toml:1:1"), "{said:?}");
    assert_eq!(session.known().check(&given), [], "the session goes on with what it had");
    "# other".clone_into(&mut now.lock().expect("not poisoned"));
    session.handle(1, Request::Reload);
    assert!(session.take_changes().said.is_empty() && session.scene().run > run);
    assert_eq!(session.now.frames(), 0, "nothing computed is kept");
    "wrong = 1".clone_into(&mut now.lock().expect("not poisoned"));
    work(&mut session);
    done(&mut session, Request::Undo);
    assert_eq!((session.scene().run, session.text()), (run, Ok(given)));
}
