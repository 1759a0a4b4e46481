//! The solver thread as a server uses it: several tabs, a closed tab, a solver that panics.

mod common;

use common::TEXT as CABLE;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use wireloom::Registry;
use wireloom::harness::{Problem, State};
use wireloom::parts::{Minimiser, MinimiserKind, Report, Stop};
use wireloom::scenario::NoFiles;
use wireloom_studio::protocol::{Holding, Notice, Request, Scene, Session, Sheet, Timeline};
use wireloom_studio::{SessionInput, Studio, Subscription, TabMessage, frame};

fn open(text: &str, registry: Registry) -> Studio {
    let (text, name) = (text.to_owned(), "cable.toml".to_owned());
    let opened = SessionInput { text, name, files: Arc::new(NoFiles), registry, unsaved: false, storage: None };
    wireloom_studio::open(opened).unwrap_or_else(|faults| panic!("{faults:?}"))
}

/// A tab and its last messages.
struct Tab {
    number: u32,
    feed: Subscription,
    woken: mpsc::Receiver<()>,
    scene: Option<Scene>,
    timeline: Option<Timeline>,
    session: Option<Session>,
    sheet: Option<Sheet>,
    said: Vec<Notice>,
    frame: Option<frame::Header>,
}

impl Tab {
    fn of(studio: &Studio) -> Self {
        let (wake, woken) = mpsc::channel();
        // The receiver is gone when the test is over.
        let (number, feed) = studio.attach(Box::new(move || wake.send(()).unwrap_or_default()));
        Self { number, feed, woken, scene: None, timeline: None, session: None, sheet: None, said: vec![], frame: None }
    }

    /// Takes messages until a condition holds.
    fn until(&mut self, what: impl Fn(&Self) -> bool) {
        while !what(self) {
            match self.feed.take() {
                Some(TabMessage::Notice(Notice::Scene(scene))) => self.scene = Some(scene),
                Some(TabMessage::Notice(Notice::Timeline(timeline))) => self.timeline = Some(timeline),
                Some(TabMessage::Notice(Notice::Session(session))) => self.session = Some(session),
                Some(TabMessage::Notice(Notice::Sheet(sheet))) => self.sheet = Some(sheet),
                Some(TabMessage::Notice(Notice::Document(_))) => {}
                Some(TabMessage::Notice(notice)) => self.said.push(notice),
                Some(TabMessage::Frame(bytes)) => self.frame = frame::decode(&bytes).map(|(header, _)| header),
                None => self.woken.recv().expect("the studio is there"),
            }
        }
    }

    fn frames(&self) -> u32 {
        self.timeline.as_ref().map_or(0, |timeline| timeline.frames)
    }

    fn is_at(&self, frame: u32) -> bool {
        self.frames() == frame + 1 && self.frame.as_ref().is_some_and(|header| header.frame == frame)
    }

    fn holds(&self) -> Vec<(String, u32)> {
        self.session.as_ref().map(|session| session.held.clone()).unwrap_or_default()
    }
}

fn to(z: f64) -> Request {
    Request::Target { constraint: "plug-B".into(), position: Some([0.6, 0.0, z]), orientation: None }
}

#[test]
fn two_tabs_see_the_same_and_a_closed_one_frees_what_it_held() {
    let studio = open(CABLE, wireloom::registry());
    let mut one = Tab::of(&studio);
    let mut other = Tab::of(&studio);
    for tab in [&mut one, &mut other] {
        tab.until(|tab| tab.scene.is_some() && tab.is_at(0));
    }
    assert_eq!(one.scene, other.scene);
    assert!(one.sheet.is_some() && one.sheet == other.sheet);
    studio.submit(one.number, to(0.01));
    other.until(|tab| tab.is_at(1) && tab.holds() == [("plug-B".to_owned(), one.number)]);
    studio.submit(other.number, to(0.02));
    other.until(|tab| matches!(tab.said.first(), Some(Notice::Refused { .. })));
    studio.detach(one.number);
    other.until(|tab| tab.holds().is_empty() && tab.session.as_ref().is_some_and(|session| session.tabs == 1));
    studio.submit(other.number, to(0.02));
    other.until(|tab| tab.is_at(2));
    let names: Vec<&str> = other.timeline.iter().flat_map(|t| &t.steps).map(|step| step.name.as_str()).collect();
    assert_eq!(names, ["start", "drag plug-B", "drag plug-B 2"]);
    // Requested frames are sent, as far as they exist.
    studio.submit(other.number, Request::Frames { from: 0, to: 9 });
    other.until(|tab| tab.frame.as_ref().is_some_and(|header| header.frame == 0));
    other.until(|tab| tab.is_at(2));
    assert!(studio.draft().is_some_and(|text| text.contains("drag plug-B")));
    assert_eq!(studio.result().map(|outcome| outcome.run.steps.len()), Some(2));
    studio.close();
}

#[test]
fn of_targets_that_wait_only_the_newest_counts() {
    let studio = open(CABLE, wireloom::registry());
    let mut tab = Tab::of(&studio);
    // The start is being computed, or has just been found: no request is lost, and little of the schedule is computed.
    studio.submit(tab.number, Request::Hold { branch: "nowhere".into(), s: 0.0, how: Holding::Pin });
    tab.until(|tab| tab.is_at(0) && tab.said.len() == 1);
    for k in 0..=1000 {
        studio.submit(tab.number, to(1e-5 * f64::from(k)));
    }
    tab.until(|tab| {
        tab.frame.as_ref().is_some_and(|header| {
            header
                .constraints
                .iter()
                .any(|constraint| constraint.name == "plug-B" && constraint.at.position == [0.6, 0.0, 1e-5 * 1000.0])
        })
    });
    assert!(tab.said.len() == 1, "{:?}", tab.said);
}

/// Newton, until it is told to panic.
struct Brittle {
    newton: Box<dyn Minimiser>,
    breaks: Arc<AtomicBool>,
}

impl Minimiser for Brittle {
    fn name(&self) -> &str {
        "brittle"
    }

    fn minimise(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report {
        assert!(!self.breaks.load(Ordering::Relaxed), "broken to pieces");
        self.newton.minimise(problem, state, stop)
    }

    fn forget(&mut self) {
        self.newton.forget();
    }
}

#[test]
fn a_solver_that_breaks_down_is_told_of_and_the_session_goes_on() {
    let breaks = Arc::new(AtomicBool::new(false));
    let told = breaks.clone();
    let mut registry = wireloom::registry();
    let kind = MinimiserKind {
        name: "brittle".into(),
        doc: "breaks down".into(),
        parameters: vec![],
        build: Box::new(move |(), parameters| {
            let newton = wireloom::registry().minimiser("newton").map(|kind| (kind.build)(&(), parameters));
            Ok(Box::new(Brittle { newton: newton.expect("built in")?, breaks: told.clone() }))
        }),
    };
    registry.add_minimiser(kind).unwrap_or_else(|_| panic!("there is no such kind"));
    let studio = open(&format!("{CABLE}[minimiser]\nkind = \"brittle\"\n"), registry);
    let mut tab = Tab::of(&studio);
    tab.until(|tab| tab.is_at(0));
    studio.submit(tab.number, to(0.01));
    tab.until(|tab| tab.is_at(1));
    breaks.store(true, Ordering::Relaxed);
    studio.submit(tab.number, to(0.02));
    tab.until(|tab| matches!(tab.said.last(), Some(Notice::Refused { message, .. }) if message.contains("to pieces")));
    breaks.store(false, Ordering::Relaxed);
    studio.submit(tab.number, to(0.03));
    tab.until(|tab| tab.is_at(2));
    studio.submit(tab.number, Request::Drop { constraint: "plug-B".into() });
    studio.submit(tab.number, Request::Undo);
    tab.until(|tab| tab.is_at(0));
}
