//! Snapshots of a session for undo: text, steps, frames and checkpoints.

use super::known::SessionFiles;
use super::mesh::Mesh;
use crate::frame::number;
use crate::protocol::{Event, Timeline, TimelineStep};
use std::cell::RefCell;
use std::collections::HashSet;
use std::rc::Rc;
use std::sync::Arc;
use wireloom::result::{EventPlace, RequirementResult};
use wireloom::scenario::Fault;
use wireloom::scenario::record::{Written, with_steps};
use wireloom::session::{Checkpoint, DrivenHarness};
use wireloom::{Status, StepResult};

/// Limit for the memory of frames, bytes: a thousand frames of a harness of 4,000 nodes. Beyond it every second frame
/// within the oldest steps is dropped; pages that have received them keep them.
pub(super) const MAX_FRAME_BYTES: usize = 256 << 20;
/// Limit for the memory of checkpoints and results at step ends, bytes: also about a thousand. Dropped ones are
/// recomputed when needed.
pub(super) const MAX_STEP_END_BYTES: usize = 512 << 20;
/// Size of a node's result, bytes.
const NODE_BYTES: usize = 15 * size_of::<f64>();
/// Largest number of events sent to a page; the newest are sent.
const MAX_EVENTS: usize = 200;

/// An encoded frame.
pub(crate) type Frame = Arc<[u8]>;

/// A step of the timeline; the first one is the start.
#[derive(Clone)]
pub(super) struct StepFrames {
    pub name: String,
    pub by_hand: bool,
    pub planned: usize,
    /// Encoded frames; `None` if dropped to limit memory.
    pub frames: RefCell<Vec<Option<Frame>>>,
    /// The end of the step; `None` if the step has not ended, or if it was dropped to limit memory.
    pub end: RefCell<Option<Rc<StepEnd>>>,
    pub ended: bool,
}

/// Result and checkpoint at the end of a step.
pub(super) struct StepEnd {
    pub harness: Rc<DrivenHarness>,
    pub checkpoint: Rc<Checkpoint>,
    pub result: Arc<StepResult>,
    pub sheet: Arc<[RequirementResult]>,
}

impl StepEnd {
    fn weight(&self) -> usize {
        let nodes: usize = self.result.branches.iter().map(|branch| branch.s.len()).sum();
        self.checkpoint.weight() + NODE_BYTES * nodes
    }
}

impl StepFrames {
    pub fn new(name: &str, by_hand: bool, planned: usize) -> Self {
        let (frames, end) = (RefCell::default(), RefCell::default());
        Self { name: name.to_owned(), by_hand, planned, frames, end, ended: false }
    }

    pub fn len(&self) -> usize {
        self.frames.borrow().len()
    }
}

/// A state of the session.
#[derive(Clone)]
pub(super) struct Snapshot {
    /// The files that the text names.
    pub files: Arc<dyn SessionFiles>,
    /// The author's text, with changed settings.
    pub text: Rc<str>,
    /// Number of steps of that text that are in use.
    pub own: usize,
    /// Steps recorded interactively after them.
    pub by_hand: Vec<Rc<Written>>,
    pub harness: Rc<DrivenHarness>,
    pub mesh: Mesh,
    pub steps: Vec<Rc<StepFrames>>,
    /// The current checkpoint; `None` until an initial equilibrium is found.
    pub at: Option<Rc<Checkpoint>>,
    /// The result that the last frame shows.
    pub last: Option<Arc<StepResult>>,
    /// The sheet at that result.
    pub sheet: Arc<[RequirementResult]>,
    /// Whether the rest of the schedule is to be computed.
    pub pending: bool,
    /// Number of the run; frames of another run are invalid.
    pub run: u32,
    /// Positions of events, m.
    pub places: Vec<Option<[f64; 3]>>,
}

impl Snapshot {
    /// A snapshot without any computed step.
    pub fn new(
        files: Arc<dyn SessionFiles>,
        text: Rc<str>,
        own: usize,
        by_hand: Vec<Rc<Written>>,
        harness: Rc<DrivenHarness>,
        run: u32,
    ) -> Self {
        let (mesh, steps, places, sheet) = (Mesh::of(&harness), Vec::new(), Vec::new(), Arc::default());
        Self {
            files,
            text,
            own,
            by_hand,
            harness,
            mesh,
            steps,
            at: None,
            last: None,
            sheet,
            pending: true,
            run,
            places,
        }
    }

    /// This snapshot without any computed step, with another harness on the same mesh.
    pub fn restarted(self, harness: Rc<DrivenHarness>) -> Self {
        Self { mesh: self.mesh, ..Self::new(self.files, self.text, self.own, self.by_hand, harness, self.run + 1) }
    }

    /// Stops computing: the steps that are left are not computed.
    pub fn stop(&mut self) {
        self.pending = false;
        self.mesh.stop();
    }

    /// The current scenario.
    ///
    /// # Errors
    /// If the author's text is not valid TOML, which cannot happen.
    pub fn whole_text(&self) -> Result<String, Fault> {
        let further: Vec<Written> = self.by_hand.iter().map(|step| (**step).clone()).collect();
        with_steps(&self.text, self.own, &further)
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.steps.iter().map(|step| step.len()).sum()
    }

    /// Status and sheet of the last result.
    pub fn shown_sheet(&self) -> (Status, Arc<[RequirementResult]>) {
        (self.last.as_ref().map_or(Status::Converged, |last| last.status), self.sheet.clone())
    }

    /// Number of completed steps, including the start.
    pub fn ended(&self) -> usize {
        self.steps.iter().take_while(|step| step.ended).count()
    }

    /// The current step, mutable.
    pub fn newest(&mut self) -> Option<&mut StepFrames> {
        self.steps.last_mut().map(Rc::make_mut)
    }

    /// Appends a frame.
    pub fn push(&mut self, frame: Frame) {
        if let Some(step) = self.newest() {
            step.frames.get_mut().push(Some(frame));
        }
    }

    /// Removes the last frame.
    pub fn pop(&mut self) {
        if let Some(step) = self.newest() {
            step.frames.get_mut().pop();
        }
    }

    /// Completes the current step.
    pub fn end(&mut self) {
        let (harness, at, last, sheet) = (self.harness.clone(), self.at.clone(), self.last.clone(), self.sheet.clone());
        let Some(step) = self.newest() else { return };
        step.ended = true;
        step.planned = step.frames.get_mut().len();
        let end = at.zip(last);
        *step.end.get_mut() = end.map(|(checkpoint, result)| Rc::new(StepEnd { harness, checkpoint, result, sheet }));
    }

    /// Index of the step of a frame.
    pub fn step_of(&self, frame: usize) -> Option<usize> {
        let mut first = 0;
        self.steps.iter().position(|step| {
            first += step.len();
            frame < first
        })
    }

    /// Frame of an increment; step and increment as events count them.
    pub fn frame_of(&self, step: usize, increment: usize) -> usize {
        if increment == 0 {
            return 0;
        }
        let first: usize = self.steps.iter().take(step + 1).map(|step| step.len()).sum();
        (first + increment - 1).min(self.frames().saturating_sub(1))
    }

    /// Records the positions of new events.
    pub fn place_events(&mut self, events: &[wireloom::result::Event], end: &StepResult) {
        self.places.truncate(events.len());
        for event in &events[self.places.len()..] {
            self.places.push(place(&event.place, end));
        }
    }

    /// The timeline for pages; `events`: the events up to the last frame.
    pub fn timeline(&self, events: &[wireloom::result::Event]) -> Timeline {
        let mut first = 0;
        let step = |step: &Rc<StepFrames>| {
            let own = TimelineStep {
                name: step.name.clone(),
                first: number(first),
                frames: number(step.len()),
                planned: number(step.planned.max(step.len())),
                by_hand: step.by_hand,
            };
            first += step.len();
            own
        };
        let steps = self.steps.iter().map(step).collect();
        let event = |(k, event): (usize, &wireloom::result::Event)| Event {
            frame: number(self.frame_of(event.first.step_index, event.first.increment)),
            kind: event.kind.word().to_owned(),
            message: match event.place.to_string() {
                place if place.is_empty() => event.message.clone(),
                place => format!("{place}: {}", event.message),
            },
            position: self.places.get(k).copied().flatten(),
        };
        let events = events.iter().enumerate().skip(events.len().saturating_sub(MAX_EVENTS)).map(event).collect();
        Timeline { frames: number(self.frames()), steps, events }
    }
}

/// Position of an event, m.
fn place(place: &EventPlace, end: &StepResult) -> Option<[f64; 3]> {
    if let Some(constraint) = &place.constraint {
        return end.constraints.iter().find(|own| own.name == *constraint).map(|own| own.position.into());
    }
    let branch = end.branches.iter().find(|branch| Some(&branch.name) == place.branch.as_ref())?;
    let s = place.s.unwrap_or(0.5 * branch.s.last()?);
    let node = branch.s.partition_point(|node| *node < s).min(branch.s.len() - 1);
    Some(branch.position[node].into())
}

/// Limits the memory of frames and step ends of all these snapshots, bytes, oldest first. Returns whether frames were
/// dropped.
pub(super) fn limit_memory<'s>(all: impl Iterator<Item = &'s Snapshot>, most_frames: usize, most_ends: usize) -> bool {
    let mut known = HashSet::new();
    let steps: Vec<&Rc<StepFrames>> =
        all.flat_map(|snapshot| &snapshot.steps).filter(|step| known.insert(Rc::as_ptr(step))).collect();
    let weight = |step: &StepFrames| step.frames.borrow().iter().flatten().map(|frame| frame.len()).sum::<usize>();
    let mut frames: usize = steps.iter().map(|step| weight(step)).sum();
    let mut thinned = false;
    while frames > most_frames {
        let before = frames;
        for step in &steps {
            frames -= thin_frames(&mut step.frames.borrow_mut());
            if frames <= most_frames / 2 {
                break;
            }
        }
        thinned = true;
        if frames == before {
            break;
        }
    }
    let mut ends: usize = steps.iter().filter_map(|step| Some(step.end.borrow().as_ref()?.weight())).sum();
    let spare = steps.len().saturating_sub(1);
    for step in steps.iter().take(spare) {
        if ends <= most_ends {
            break;
        }
        ends -= step.end.borrow_mut().take().map_or(0, |end| end.weight());
    }
    thinned
}

/// Drops every second remaining frame of a step, but not the last. Returns the bytes freed.
fn thin_frames(frames: &mut [Option<Frame>]) -> usize {
    let Some((_, inside)) = frames.split_last_mut() else { return 0 };
    let left = inside.iter_mut().filter(|frame| frame.is_some());
    left.step_by(2).filter_map(Option::take).map(|frame| frame.len()).sum()
}
