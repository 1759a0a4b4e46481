//! Computation, one increment at a time, of the schedule or of a drag, with a frame for each.

use super::snapshot::StepFrames;
use super::{Session, clearance};
use crate::frame::{self, Header, Violation, number};
use crate::protocol::Notice;
use std::rc::Rc;
use std::sync::Arc;
use wireloom::session::{Ended, Interruption};

impl Session {
    /// Whether there is something to compute.
    pub fn has_work(&self) -> bool {
        self.now.pending || self.drag.as_ref().is_some_and(|drag| drag.goal.is_some())
    }

    /// Whether the current drag must be finished before the next request.
    pub fn must_finish(&self) -> bool {
        self.drag.as_ref().is_some_and(|drag| drag.ends)
    }

    /// Whether the next computation is the initial equilibrium.
    pub fn is_finding_start(&self) -> bool {
        self.now.pending && self.now.at.is_none()
    }

    /// Computes one increment, or the initial equilibrium, until stopped.
    pub fn work(&mut self) {
        if self.drag.as_ref().is_some_and(|drag| drag.goal.is_some()) {
            self.advance_drag();
        } else if self.now.pending {
            self.advance_schedule();
        }
    }

    /// The next increment of the schedule.
    fn advance_schedule(&mut self) {
        let harness = self.now.harness.clone();
        let Some(at) = self.now.at.clone() else {
            match harness.start() {
                Ok(ended) => {
                    self.now.steps = vec![Rc::new(StepFrames::new("start", false, 1))];
                    self.show(&ended);
                    self.now.end();
                    if harness.schedule.steps.is_empty() {
                        self.end_run(true);
                    }
                }
                Err(interruption) => self.end_early(interruption),
            }
            self.changes.scene = true;
            return;
        };
        let (index, increment) = at.done();
        let Some(step) = harness.schedule.steps.get(index) else {
            self.now.pending = false;
            return;
        };
        let ended = harness.advance(step, &at);
        if increment == 0 && self.now.steps.len() == index + 1 {
            let by_hand = index >= self.now.own;
            self.now.steps.push(Rc::new(StepFrames::new(&step.name, by_hand, step.increments)));
        }
        match ended {
            Ok(ended) => {
                self.show(&ended);
                if ended.checkpoint.done().0 > index && ended.is_balanced() {
                    self.now.end();
                }
                let complete = ended.checkpoint.done().0 == harness.schedule.steps.len();
                if !ended.is_balanced() || complete {
                    self.end_run(complete);
                }
            }
            Err(interruption) => {
                if self.now.steps.last().is_some_and(|step| step.len() == 0) {
                    self.now.steps.pop();
                }
                self.end_early(interruption);
            }
        }
    }

    /// Ends the run of the schedule, or one of its trial runs; `complete`: it came to the end of the schedule.
    fn end_run(&mut self, complete: bool) {
        self.now.pending = false;
        self.end_trial(complete);
    }

    /// Ends the run of the schedule where no result was obtained. A trial run goes on with the next one.
    fn end_early(&mut self, interruption: Interruption) {
        match interruption {
            Interruption::Stopped => self.now.stop(),
            Interruption::Fault(_) if self.now.mesh.progress().is_some() => self.end_run(false),
            Interruption::Fault(fault) => {
                self.end_run(false);
                self.report_failure(fault.to_string());
            }
        }
    }

    /// Appends the frame of an increment; an increment in equilibrium becomes the current state.
    pub(super) fn show(&mut self, ended: &Ended) {
        let index = self.now.frames();
        let mut header = Header::of(number(index), &ended.end, self.now.last.as_deref());
        if let ([_, first], Some(start)) = (self.now.steps.as_slice(), &self.now.last)
            && first.len() == 0
        {
            // Results count the search for the initial equilibrium as part of the first step.
            header.iterations = header.iterations.saturating_sub(number(start.minimiser.iterations));
        }
        // Not during a drag, to save time.
        let rests = ended.checkpoint.done().1 == 0;
        let near = || clearance::of_nodes(&self.now.harness.network.obstacles, &ended.end);
        let nodes = frame::nodes(&ended.end.branches, &if rests { near() } else { Vec::new() });
        self.bytes_added += nodes.len() + ended.checkpoint.weight();
        self.now.push(header.encode(&nodes).into());
        self.now.place_events(ended.checkpoint.events(), &ended.end);
        let checkpoint = Rc::new(ended.checkpoint.clone());
        if ended.is_balanced() || self.now.at.is_none() {
            self.now.at = Some(checkpoint.clone());
            self.now.last = Some(Arc::new(ended.end.clone()));
            self.now.sheet = ended.requirements.clone().into();
        }
        self.shown = Some(checkpoint);
        self.shown_sheet = (ended.end.status, ended.requirements.clone().into());
        self.note_errors(ended);
        self.frames_changed(index);
    }

    /// Replaces the last frame by one with clearances and with the violations at the end of its step, if it differs.
    pub(super) fn show_end(&mut self) {
        let Some(end) = self.now.last.clone() else { return };
        let near = clearance::of_nodes(&self.now.harness.network.obstacles, &end);
        let index = self.now.frames() - 1;
        let newest = self.now.steps.last().and_then(|step| step.frames.borrow().last().cloned().flatten());
        let Some((mut header, _)) = newest.and_then(|frame| frame::decode(&frame)) else { return };
        let violations: Vec<_> = end.violations.iter().map(|own| Violation::of(own, &end)).collect();
        if near.is_empty() && header.violations == violations {
            return;
        }
        header.violations = violations;
        self.now.pop();
        self.now.push(header.encode(&frame::nodes(&end.branches, &near)).into());
        self.frames_changed(index);
    }

    /// Reports an error that no request caused.
    pub(super) fn report_failure(&mut self, message: String) {
        let help = "the session is unchanged; undo the last operation, or change a setting".to_owned();
        self.changes.said.push((None, Notice::Refused { message, help }));
        self.changes.timeline = true;
    }

    /// Recovers from a panic: continues from the last complete increment with a new solver.
    pub fn recover(&mut self, message: &str) {
        self.now.stop();
        if let Some(drag) = &mut self.drag {
            drag.goal = None;
            if drag.ends {
                self.end_drag();
            }
        }
        if let Ok(made) = self.load(&self.now) {
            self.now.harness.replace_solver(made);
        }
        self.report_failure(format!("the solver failed: {message}"));
    }
}
