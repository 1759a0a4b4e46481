//! Requests of a drag, and its increments. An increment moves at most a limited distance towards the newest target.

use super::Session;
use super::drag::Drag;
use super::refusal::no_start;
use super::snapshot::StepFrames;
use std::rc::Rc;
use std::sync::Arc;
use wireloom::session::drag::{self, Goal};
use wireloom::session::{Interruption, Refusal};

impl Session {
    /// Sets the target of a constraint.
    pub(super) fn target(
        &mut self,
        tab: u32,
        name: &str,
        position: Option<[f64; 3]>,
        orientation: Option<[f64; 4]>,
    ) -> Result<(), Refusal> {
        if let Some(other) = self.held.get(name).filter(|other| **other != tab) {
            return Err(Refusal::new(format!("\"{name}\" is held by tab {other}"), "wait until it is released there"));
        }
        if self.drag.as_ref().is_some_and(|drag| drag.motion.name() != name) {
            self.end_drag();
        }
        let drag = match self.drag.take() {
            Some(drag) => drag,
            None => self.begin_drag(name)?,
        };
        let goal = Goal { position, orientation };
        let checked = self.check(&drag.motion, &goal);
        let drag = self.drag.insert(drag);
        if let Err(refusal) = checked {
            if !drag.motion.has_begun() {
                self.end_drag();
            }
            return Err(refusal);
        }
        drag.goal = Some(goal);
        drag.ends = false;
        self.held.insert(name.to_owned(), tab);
        Ok(())
    }

    /// Refuses an invalid target.
    fn check(&self, motion: &drag::Drag, goal: &Goal) -> Result<(), Refusal> {
        if goal.orientation.is_some() && !motion.turns() {
            let name = motion.name();
            let message = format!("\"{name}\" does not hold the orientation of the cable, so it cannot be rotated");
            return Err(Refusal::new(message, "pin it first: it then holds position, tangent and twist"));
        }
        let at = self.now.at.as_ref().ok_or_else(no_start)?;
        Ok(motion.check(goal, &self.now.harness, at)?)
    }

    fn begin_drag(&mut self, name: &str) -> Result<Drag, Refusal> {
        let before = self.now.clone();
        let snapshot = self.editable_snapshot()?;
        let at = snapshot.at.as_ref().ok_or_else(no_start)?;
        let step = snapshot.unused_step_name(&format!("drag {name}"));
        let motion = drag::Drag::of(step.clone(), name, &snapshot.harness, at)?;
        if snapshot.steps.len() < self.now.steps.len() || !Rc::ptr_eq(&snapshot.harness, &self.now.harness) {
            self.switch_to(snapshot);
        }
        self.now.steps.push(Rc::new(StepFrames::new(&step, true, 0)));
        self.changes.timeline = true;
        Ok(Drag { motion, goal: None, ends: false, unbalanced: false, before })
    }

    /// One increment towards the target.
    pub(super) fn advance_drag(&mut self) {
        // The drag stays in place until the increment is computed, because the solver may panic.
        let Some(drag) = &mut self.drag else { return };
        let (Some(goal), Some(at)) = (drag.goal, self.now.at.clone()) else { return };
        let advanced = drag.motion.advance(&goal, &self.now.harness, &at);
        let Some(mut drag) = self.drag.take() else { return };
        if std::mem::take(&mut drag.unbalanced) {
            self.now.pop();
            self.frames_changed(self.now.frames());
        }
        match advanced {
            Ok((ended, reached)) => {
                self.show(&ended);
                drag.unbalanced = !ended.is_balanced();
                if reached || drag.unbalanced {
                    drag.goal = None;
                }
            }
            Err(interruption) => {
                drag.goal = None;
                if let Interruption::Fault(fault) = interruption {
                    self.report_failure(fault.to_string());
                }
            }
        }
        let over = drag.goal.is_none() && drag.ends;
        self.drag = Some(drag);
        self.unsaved = true;
        if over {
            self.end_drag();
        }
    }

    /// Ends a drag as soon as it has reached its target.
    pub(super) fn drop_held(&mut self, tab: u32, name: &str) {
        if self.held.get(name).is_some_and(|by| *by != tab) {
            return;
        }
        self.held.remove(name);
        match self.drag.as_mut().filter(|drag| drag.motion.name() == name) {
            Some(drag) if drag.goal.is_some() => drag.ends = true,
            Some(_) => self.end_drag(),
            None => {}
        }
    }

    /// Completes the step of a drag; a drag without increments leaves no step.
    pub(super) fn end_drag(&mut self) {
        let Some(drag) = self.drag.take() else { return };
        let Some(written) = drag.motion.written() else {
            let unsaved = self.unsaved;
            self.switch_to(drag.before);
            self.unsaved = unsaved;
            return;
        };
        if drag.unbalanced {
            self.now.pop();
            self.frames_changed(self.now.frames());
        }
        if let Some((at, last)) = self.now.at.take().zip(self.now.last.take()) {
            let mut end = Arc::unwrap_or_clone(last);
            let (at, sheet) = self.now.harness.end_step(Rc::unwrap_or_clone(at), &mut end);
            (self.now.at, self.now.last, self.now.sheet) = (Some(Rc::new(at)), Some(Arc::new(end)), sheet.into());
        }
        self.now.by_hand.push(Rc::new(written));
        self.show_end();
        self.now.end();
        self.shown.clone_from(&self.now.at);
        self.shown_sheet = self.now.shown_sheet();
        self.changes.timeline = true;
        self.push_undo(drag.motion.step, drag.before);
    }
}
