//! An interactive session: a scenario that is being recorded. Interactive operations become steps of its text, and
//! every solved target becomes an increment of a step. `run` passes through the same equilibria when it carries out the
//! text.
//!
//! The session sends nothing and opens no files; [`crate::worker`] passes requests in and messages out.

mod clearance;
mod drag;
mod dragging;
mod edits;
mod file;
#[cfg(test)]
mod fuzz;
mod harness;
mod hold;
mod known;
mod mesh;
mod refusal;
mod settings;
mod snapshot;
#[cfg(test)]
mod tests;
mod trial;
mod work;

use crate::protocol::{Document, Notice, Request, Scene, Sensitivities, Sheet, Timeline};
use crate::{frame, scene, sheet};
use drag::Drag;
use mesh::Mesh;
use refusal::no_start;
use serde_json::Value as Json;
use snapshot::{MAX_FRAME_BYTES, MAX_STEP_END_BYTES, Snapshot, limit_memory};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;
use wireloom::harness::Obstacle;
use wireloom::result::{Identities, Moment, RequirementResult};
use wireloom::scenario::Fault;
use wireloom::scenario::adjust::adjustable;
use wireloom::scenario::record::with_value;
use wireloom::sensitivity::{OfMove, of_move};
use wireloom::session::{Checkpoint, DrivenHarness, Monitor, Refusal};
use wireloom::{Registry, Status, StepResult};

pub use file::{Storage, StoreError};
pub(crate) use known::{Known, MAX_TEXT, text_faults};
pub use known::{MAX_FILE, SessionFiles};
pub(crate) use snapshot::Frame;

/// Name and version of this program.
pub const PROGRAM: &str = concat!("wireloom ", env!("CARGO_PKG_VERSION"));
/// Largest number of undo steps.
const MAX_UNDO: usize = 100;

/// Input of a session.
pub struct SessionInput {
    /// Text of the scenario.
    pub text: String,
    /// File name for saving.
    pub name: String,
    /// Provides the files that the scenario names.
    pub files: Arc<dyn SessionFiles>,
    /// Kinds that the scenario can use.
    pub registry: Registry,
    /// Whether the text has unsaved changes: true for a restored draft.
    pub unsaved: bool,
    /// Writes into the scenario's file; `None`: there is none.
    pub storage: Option<Box<dyn Storage>>,
}

/// Changes since the last query.
#[derive(Default)]
pub(crate) struct Changes {
    pub scene: bool,
    pub timeline: bool,
    /// The first new frame.
    pub from: Option<usize>,
    /// Whether frames were dropped to limit memory.
    pub thinned: bool,
    /// Whether the scenario was changed or saved.
    pub edited: bool,
    /// A text for pages that differs from the last one sent.
    pub document: Option<Document>,
    /// Notices, each for a tab, or for all (`None`).
    pub said: Vec<(Option<u32>, Notice)>,
}

/// The run so far, and its origin.
#[derive(Clone)]
pub(crate) struct Record {
    pub scenario: String,
    pub ends: Vec<Arc<StepResult>>,
    pub events: Vec<wireloom::result::Event>,
    pub notes: Vec<String>,
    pub status: Status,
    pub requirements: Arc<[RequirementResult]>,
    pub obstacles: Arc<Vec<Obstacle>>,
    pub identities: Arc<Identities>,
}

/// A session.
pub(crate) struct Session {
    name: String,
    known: Arc<Known>,
    storage: Option<Box<dyn Storage>>,
    monitor: Monitor,
    /// Version and text of the document that pages have.
    document: (u32, String),
    now: Snapshot,
    undo: Vec<(String, Snapshot)>,
    redo: Vec<(String, Snapshot)>,
    drag: Option<Drag>,
    /// The tab that holds each constraint.
    held: BTreeMap<String, u32>,
    unsaved: bool,
    /// The checkpoint of the last frame, which need not be in equilibrium.
    shown: Option<Rc<Checkpoint>>,
    /// The status of that frame, and the sheet there.
    shown_sheet: (Status, Arc<[RequirementResult]>),
    changes: Changes,
    /// Bytes added since memory was last limited.
    bytes_added: usize,
}

impl Session {
    /// Opens a scenario without computing anything; `monitor` stops later computations.
    ///
    /// # Errors
    /// All faults of the text.
    pub fn open(opened: SessionInput, monitor: Monitor) -> Result<Self, Vec<Fault>> {
        let SessionInput { text, name, files, registry, unsaved, storage } = opened;
        let known = Arc::new(Known::new(files.clone(), registry));
        let (text, harness) = known.load(&text, &*files, &monitor)?;
        let harness = Rc::new(harness);
        let own = harness.schedule.steps.len();
        let now = Snapshot::new(files, text.into(), own, Vec::new(), harness, 0);
        let changes = Changes { scene: true, timeline: true, edited: true, ..Changes::default() };
        Ok(Self {
            name,
            known,
            storage,
            monitor,
            document: (0, String::new()),
            now,
            undo: Vec::new(),
            redo: Vec::new(),
            drag: None,
            held: BTreeMap::new(),
            unsaved,
            shown: None,
            shown_sheet: (Status::Converged, Arc::default()),
            changes,
            bytes_added: 0,
        })
    }

    // ---- published state ------------------------------------------------------------------------------------------

    /// What is needed to check a text for this session.
    pub fn known(&self) -> Arc<Known> {
        self.known.clone()
    }

    /// Takes the changes.
    pub fn take_changes(&mut self) -> Changes {
        if self.bytes_added > MAX_FRAME_BYTES / 16 {
            self.limit_memory(MAX_FRAME_BYTES, MAX_STEP_END_BYTES);
        }
        std::mem::take(&mut self.changes)
    }

    /// Limits the memory of frames and of step ends, bytes.
    fn limit_memory(&mut self, frames: usize, ends: usize) {
        let Self { now, undo, redo, .. } = &*self;
        let all = undo.iter().chain(redo).map(|(_, snapshot)| snapshot).chain([now]);
        self.changes.thinned |= limit_memory(all, frames, ends);
        self.bytes_added = 0;
    }

    /// The scene for pages.
    pub fn scene(&self) -> Scene {
        let Snapshot { harness, by_hand, run, .. } = &self.now;
        let schedule = &harness.schedule;
        let mut scene = scene::of(schedule, PROGRAM, &harness.network);
        let begun: Vec<&str> =
            by_hand.iter().flat_map(|step| &step.begins).map(|begins| begins.name.as_str()).collect();
        for constraint in &mut scene.constraints {
            constraint.by_hand = begun.contains(&constraint.name.as_str());
        }
        for (constraint, own) in scene.constraints.iter_mut().zip(&harness.network.constraints) {
            constraint.turns = wireloom::session::drag::turning(own).is_some();
            constraint.moves &= own.span.is_none() || !own.stations.is_empty();
        }
        scene.live = true;
        scene.run = *run;
        scene.settings = settings::all(&harness.scenario, &self.known.registry);
        scene.notes.clone_from(&harness.notes);
        scene.notes.extend(self.now.mesh.note());
        scene.notes.extend(self.now.at.iter().flat_map(|at| at.notes().iter().cloned()));
        scene
    }

    /// The timeline of steps and increments.
    pub fn timeline(&self) -> Timeline {
        self.now.timeline(self.shown.as_ref().map_or(&[], |at| at.events()))
    }

    /// The sheet of requirements so far.
    pub fn sheet(&self) -> Sheet {
        let Snapshot { harness, at, .. } = &self.now;
        let steps = harness.schedule.steps.len();
        let done = at.as_ref().map_or(0, |at| at.done().0.min(steps));
        let frame = |moment: &Moment| {
            let number = self.now.frame_of(moment.step_index, moment.increment);
            (number < self.now.frames()).then(|| frame::number(number))
        };
        sheet::sheet(&self.shown_sheet.1, self.status(), (done, steps), frame)
    }

    /// Status of the run so far: that of its first increment that did not converge, otherwise converged.
    fn status(&self) -> Status {
        let ends = self.ends();
        ends.iter().map(|end| end.status).find(|status| *status != Status::Converged).unwrap_or(self.shown_sheet.0)
    }

    /// Frames from a number on.
    pub fn frames_from(&self, from: usize) -> Vec<Option<Frame>> {
        let mut first = 0;
        let mut frames = Vec::new();
        for step in &self.now.steps {
            let own = step.frames.borrow();
            frames.extend(own.iter().skip(from.saturating_sub(first)).cloned());
            first += own.len();
        }
        frames
    }

    /// Description of the current computation.
    pub fn busy(&self) -> Option<String> {
        if !self.now.pending {
            return None;
        }
        let what = match &self.now.at {
            None => "the start".to_owned(),
            Some(at) => format!("step {}", self.now.harness.schedule.steps.get(at.done().0)?.name),
        };
        Some(self.now.mesh.progress().map_or(what.clone(), |progress| format!("{what} ({progress})")))
    }

    /// Labels of the next undo and the next redo.
    pub fn undo_labels(&self) -> [Option<String>; 2] {
        let last = |list: &[(String, Snapshot)]| list.last().map(|(label, _)| label.clone());
        let dragged = self.drag.as_ref().filter(|drag| drag.motion.has_begun()).map(|drag| drag.motion.step.clone());
        let redo = if dragged.is_some() { None } else { last(&self.redo) };
        [dragged.or_else(|| last(&self.undo)), redo]
    }

    /// Constraints that are held, with their tabs.
    pub fn held(&self) -> Vec<(String, u32)> {
        self.held.iter().map(|(name, tab)| (name.clone(), *tab)).collect()
    }

    /// Whether there are unsaved changes.
    pub fn unsaved(&self) -> bool {
        self.unsaved
    }

    /// The run so far.
    pub fn record(&self) -> Record {
        let harness = &self.now.harness;
        let (events, noted) = self.shown.as_ref().map_or((&[][..], &[][..]), |at| (at.events(), at.notes()));
        Record {
            scenario: harness.schedule.scenario.clone(),
            ends: self.ends(),
            events: events.to_vec(),
            notes: harness.notes.iter().cloned().chain(self.now.mesh.note()).chain(noted.iter().cloned()).collect(),
            status: self.status(),
            requirements: self.shown_sheet.1.clone(),
            obstacles: Arc::new(harness.network.obstacles.clone()),
            identities: harness.schedule.identities.clone(),
        }
    }

    /// Results at the ends of steps, and of the newest increment.
    fn ends(&self) -> Vec<Arc<StepResult>> {
        let Snapshot { steps, last, .. } = &self.now;
        let mut ends: Vec<Arc<StepResult>> =
            steps.iter().skip(1).filter_map(|step| Some(step.end.borrow().as_ref()?.result.clone())).collect();
        if steps.last().is_none_or(|step| !step.ended || steps.len() == 1) {
            ends.extend(last.clone());
        }
        ends
    }

    // ---- requests -------------------------------------------------------------------------------------------------

    /// Carries out a request of a tab, or refuses it.
    pub fn handle(&mut self, tab: u32, request: Request) {
        let done = match request {
            Request::Hold { branch, s, how } => self.hold(tab, &branch, s, how),
            Request::Target { constraint, position, orientation } => {
                self.target(tab, &constraint, position, orientation)
            }
            Request::Drop { constraint } => {
                self.drop_held(tab, &constraint);
                Ok(())
            }
            Request::Release { constraint } => self.release(tab, &constraint),
            Request::Pin { constraint } => self.pin(tab, &constraint),
            Request::Drive { joint, value } => self.drive(&joint, value),
            Request::Sensitivities { constraint } => {
                let found = Notice::Sensitivities(self.sensitivities(constraint));
                self.changes.said.push((Some(tab), found));
                Ok(())
            }
            Request::Undo => self.undo_last(),
            Request::Redo => self.redo_last(),
            Request::Go { frame } => self.go(frame),
            Request::Set { key, value } => self.set(&key, &value),
            Request::Save => self.save(tab),
            Request::Store { name, replace } => self.store(tab, name.as_deref(), replace),
            Request::Reload => self.reload(tab),
            Request::Edit { edit } => self.edit(&edit),
            Request::Apply { text, base } => self.apply(tab, &text, base),
            Request::Stop => {
                self.stop();
                Ok(())
            }
            // Handled by the worker.
            _ => Ok(()),
        };
        if let Err(Refusal { message, help }) = done {
            self.changes.said.push((Some(tab), Notice::Refused { message, help }));
        }
    }

    /// Releases the constraints of a tab that has gone.
    pub fn detach(&mut self, tab: u32) {
        let own: Vec<String> = self.held.iter().filter(|(_, by)| **by == tab).map(|(name, _)| name.clone()).collect();
        for constraint in own {
            self.drop_held(tab, &constraint);
            self.held.remove(&constraint);
        }
    }

    /// Stops the current step or drag.
    pub fn stop(&mut self) {
        self.changes.scene |= self.now.mesh.progress().is_some();
        self.now.stop();
        if let Some(drag) = &mut self.drag {
            drag.goal = None;
            if drag.ends {
                self.end_drag();
            }
        }
    }

    /// What it does to the requirements to move a constraint from where it is.
    fn sensitivities(&self, constraint: String) -> Sensitivities {
        let found = match (&self.now.at, &self.now.last, &self.shown) {
            _ if self.has_work() => Err("the harness is being computed".to_owned()),
            (Some(at), Some(end), Some(shown)) if Rc::ptr_eq(at, shown) => {
                of_move(&self.now.harness, (at, end), &constraint, &self.monitor).map_err(|none| none.to_string())
            }
            _ => Err("the harness is not in equilibrium".to_owned()),
        };
        match found {
            Ok(OfMove { keeps_history, lines }) => {
                Sensitivities { constraint, reason: None, keeps_history, lines: sheet::sensitivities(lines) }
            }
            Err(reason) => Sensitivities { constraint, reason: Some(reason), keeps_history: false, lines: Vec::new() },
        }
    }

    fn save(&mut self, tab: u32) -> Result<(), Refusal> {
        let text = self.text()?;
        // The text is checked, because a draft may not be valid.
        let checked = DrivenHarness::load(&text, &*self.now.files, &self.known.registry, &self.monitor);
        if self.storage.is_none() {
            // Where there is no file, the copy is what is kept.
            (self.unsaved, self.changes.edited) = (false, true);
        }
        self.changes.said.push((Some(tab), Notice::Saved { name: self.name.clone(), text }));
        checked.map(|_| ()).map_err(Refusal::from)
    }

    /// The scenario, including the current drag.
    pub fn text(&self) -> Result<String, Fault> {
        let mut now = self.now.clone();
        now.by_hand.extend(self.drag.as_ref().and_then(|drag| drag.motion.written()).map(Rc::new));
        now.whole_text()
    }

    /// Changes a value of the scenario's text and restarts the run.
    fn set(&mut self, key: &str, given: &Json) -> Result<(), Refusal> {
        self.end_drag();
        let Snapshot { files, text, own, by_hand, harness, run, .. } = &self.now;
        let all = adjustable(&harness.scenario, &self.known.registry);
        let known = all.iter().find(|own| own.key == key);
        let known = known.ok_or_else(|| {
            Refusal::new(format!("`{key:.80}` cannot be set here"), "set one of the scene's settings")
        })?;
        let value = settings::value(known, given)?;
        if known.value.as_ref() == Some(&value) {
            return Ok(());
        }
        let text = with_value(text, key, &value, &self.known.registry)?;
        let mut next = Snapshot::new(files.clone(), text.into(), *own, by_hand.clone(), harness.clone(), run + 1);
        next.harness = Rc::new(self.load_anew(&next)?);
        next.mesh = Mesh::of(&next.harness);
        let label = format!("{} of {}", known.label, known.group);
        self.commit(label, next);
        Ok(())
    }

    fn undo_last(&mut self) -> Result<(), Refusal> {
        self.end_drag();
        let (label, snapshot) = self
            .undo
            .pop()
            .ok_or_else(|| Refusal::new("there is nothing to undo", "the session is as it was opened"))?;
        let now = self.switch_to(snapshot);
        self.redo.push((label, now));
        Ok(())
    }

    fn redo_last(&mut self) -> Result<(), Refusal> {
        self.end_drag();
        let (label, snapshot) = self
            .redo
            .pop()
            .ok_or_else(|| Refusal::new("there is nothing to redo", "only what was undone can be redone"))?;
        let now = self.switch_to(snapshot);
        self.undo.push((label, now));
        Ok(())
    }

    fn go(&mut self, frame: u32) -> Result<(), Refusal> {
        self.end_drag();
        let frames = self.now.frames();
        let step = self.now.step_of(frame as usize).ok_or_else(|| {
            Refusal::new(format!("there is no frame {frame}"), format!("frames go from 0 to {}", frames.max(1) - 1))
        })?;
        let whole = self.now.ended();
        if whole == 0 {
            return Err(no_start());
        }
        let next = self.cut_behind(step.min(whole - 1))?;
        if let Some(next) = next {
            let label = format!("go to the end of {}", self.now.steps[step.min(whole - 1)].name);
            self.commit(label, next);
        }
        Ok(())
    }

    // ---- snapshots ------------------------------------------------------------------------------------------------

    /// Switches to a snapshot; returns the previous one.
    fn switch_to(&mut self, snapshot: Snapshot) -> Snapshot {
        self.known.check_with(&snapshot.files);
        self.shown.clone_from(&snapshot.at);
        self.shown_sheet = snapshot.shown_sheet();
        let changed = !Rc::ptr_eq(&self.now.harness, &snapshot.harness) || self.now.run != snapshot.run;
        let kept = self.now.steps.iter().zip(&snapshot.steps).take_while(|(a, b)| Rc::ptr_eq(a, b));
        let from = if self.now.run == snapshot.run { kept.map(|(step, _)| step.len()).sum() } else { 0 };
        self.frames_changed(from);
        self.changes.scene |= changed;
        (self.unsaved, self.changes.edited) = (true, true);
        let before = std::mem::replace(&mut self.now, snapshot);
        let now = &self.now;
        self.held.retain(|name, _| now.at.as_ref().is_some_and(|at| now.harness.active_constraint(name, at).is_ok()));
        before
    }

    /// Switches to a new snapshot, with an entry for undo.
    fn commit(&mut self, label: String, next: Snapshot) {
        let before = self.switch_to(next);
        self.push_undo(label, before);
    }

    fn push_undo(&mut self, label: String, before: Snapshot) {
        self.undo.push((label, before));
        if self.undo.len() > MAX_UNDO {
            self.undo.remove(0);
        }
        self.redo.clear();
        (self.unsaved, self.changes.edited) = (true, true);
    }

    fn frames_changed(&mut self, from: usize) {
        self.changes.from = Some(self.changes.from.map_or(from, |before| before.min(from)));
        self.changes.timeline = true;
    }

    /// The session truncated after a completed step; `None` if nothing follows it. Step 0 is the start.
    fn cut_behind(&self, step: usize) -> Result<Option<Snapshot>, Refusal> {
        if step + 1 == self.now.steps.len() && self.now.own + self.now.by_hand.len() == step {
            return Ok(None);
        }
        let mut next = self.now.clone();
        next.steps.truncate(step + 1);
        next.own = next.own.min(step);
        next.by_hand.truncate(step - next.own);
        next.stop();
        let end = next.steps[step].end.borrow().clone();
        if let Some(end) = &end
            && end.harness.schedule.steps.len() <= step
            && next.own == self.now.own
        {
            next.harness = end.harness.clone();
            next.at = Some(end.checkpoint.clone());
        } else {
            let harness = Rc::new(self.load(&next)?);
            let at = end.as_ref().and_then(|end| harness.transferred(&end.harness, &end.checkpoint));
            let Some(at) = at else {
                return Ok(Some(next.restarted(harness)));
            };
            (next.harness, next.at) = (harness, Some(Rc::new(at)));
        }
        next.sheet = end.as_ref().map(|end| end.sheet.clone()).unwrap_or_default();
        next.last = end.map(|end| end.result.clone());
        Ok(Some(next))
    }

    /// Builds the harness of a snapshot's text.
    fn load_anew(&self, snapshot: &Snapshot) -> Result<DrivenHarness, Refusal> {
        let text = snapshot.whole_text()?;
        Ok(DrivenHarness::load(&text, &*snapshot.files, &self.known.registry, &self.monitor)?)
    }

    /// Builds the harness of a snapshot's text, on the mesh that the snapshot has.
    fn load(&self, snapshot: &Snapshot) -> Result<DrivenHarness, Refusal> {
        let harness = self.load_anew(snapshot)?;
        Ok(harness.on_mesh_of(&snapshot.harness.network, &self.known.registry, &self.monitor)?)
    }

    /// The snapshot that an operation may extend: it ends with a completed step.
    fn editable_snapshot(&self) -> Result<Snapshot, Refusal> {
        if self.now.pending {
            let what = self.busy().unwrap_or_else(|| "a step".to_owned());
            return Err(Refusal::new(format!("{what} is being computed"), "wait until it is finished, or stop it"));
        }
        let whole = self.now.ended();
        if whole == 0 {
            return Err(no_start());
        }
        let cut = self.cut_behind(whole - 1)?.unwrap_or_else(|| self.now.clone());
        if cut.pending {
            // The steps must be recomputed first.
            return Err(Refusal::new("the steps must be recomputed first", "go to a frame first"));
        }
        Ok(cut)
    }
}
