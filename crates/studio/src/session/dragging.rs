//! Requests of a drag, and its increments. An increment moves at most a limited distance towards the newest target.

use super::Session;
use super::drag::Drag;
use super::harness::is_balanced;
use super::refusal::{Refusal, no_start};
use super::snapshot::StepFrames;
use std::rc::Rc;
use std::sync::Arc;
use wireloom::geometry::Vector;
use wireloom::scenario::record::rotation;
use wireloom::session::Interruption;
use wireloom::session::drag::{Goal, MAX_DISTANCE, MAX_MOTION, approach, step_to, turning};

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
        if self.drag.as_ref().is_some_and(|drag| drag.constraint != name) {
            self.end_drag();
        }
        let drag = match self.drag.take() {
            Some(drag) => drag,
            None => self.begin_drag(name)?,
        };
        let checked = self.check(&drag, position, orientation);
        let drag = self.drag.insert(drag);
        if let Err(refusal) = checked {
            if !drag.has_begun() {
                self.end_drag();
            }
            return Err(refusal);
        }
        drag.goal = Some(Goal { position, orientation });
        drag.ends = false;
        self.held.insert(name.to_owned(), tab);
        Ok(())
    }

    /// Refuses an invalid target.
    fn check(&self, drag: &Drag, position: Option<[f64; 3]>, orientation: Option<[f64; 4]>) -> Result<(), Refusal> {
        let name = &drag.constraint;
        if position.is_none() && orientation.is_none() {
            return Err(Refusal::new(
                format!("the target of \"{name}\" is empty"),
                "give a position, an orientation, or both",
            ));
        }
        let far = MAX_DISTANCE * self.now.harness.total_length();
        if let (Some(to), Some(at)) = (position, &self.now.at) {
            let from = at.target(drag.index).map_or_else(Vector::zeros, |pose| pose.position);
            let distance = (Vector::from(to) - from).norm();
            if distance.is_nan() || distance > far {
                let message = format!("{to:?} is not a valid position for \"{name}\"");
                return Err(Refusal::new(message, format!("give a position within {far:.1} m of where it is")));
            }
        }
        if let Some(q) = orientation {
            if drag.turning.is_none() {
                let message = format!("\"{name}\" does not hold the orientation of the cable, so it cannot be rotated");
                return Err(Refusal::new(message, "pin it first: it then holds position, tangent and twist"));
            }
            if !q.iter().all(|x| x.is_finite()) || rotation(q).is_none_or(|q| !q.coords.iter().all(|x| x.is_finite())) {
                let message = format!("{q:?} is not an orientation");
                return Err(Refusal::new(message, "give a quaternion [w, x, y, z] that is not zero"));
            }
        }
        Ok(())
    }

    fn begin_drag(&mut self, name: &str) -> Result<Drag, Refusal> {
        let before = self.now.clone();
        let snapshot = self.editable_snapshot()?;
        let at = snapshot.at.as_ref().ok_or_else(no_start)?;
        let index = snapshot.harness.active_constraint(name, at)?;
        let constraint = &snapshot.harness.network.constraints[index];
        if constraint.stations.is_empty() {
            let message = format!("\"{name}\" acts along a part of a branch and cannot be moved");
            return Err(Refusal::new(message, "hold the cable, or move another constraint"));
        }
        let turning = turning(constraint);
        let step = snapshot.unused_step_name(&format!("drag {name}"));
        if snapshot.steps.len() < self.now.steps.len() || !Rc::ptr_eq(&snapshot.harness, &self.now.harness) {
            self.switch_to(snapshot);
        }
        self.now.steps.push(Rc::new(StepFrames::new(&step, true, 0)));
        self.changes.timeline = true;
        let (passed, constraint) = (Vec::new(), name.to_owned());
        Ok(Drag {
            step,
            constraint,
            index,
            turning,
            turned: false,
            passed,
            goal: None,
            ends: false,
            unbalanced: false,
            before,
        })
    }

    /// One increment towards the target.
    pub(super) fn advance_drag(&mut self) {
        // The drag stays in place until the increment is computed, because the solver may panic.
        let Some(drag) = &self.drag else { return };
        let (Some(goal), Some(at)) = (drag.goal, self.now.at.clone()) else { return };
        let harness = self.now.harness.clone();
        let network = &harness.network;
        let Some(from) = at.drawn_target(network, drag.index) else { return };
        let goal = goal.on(&at.body_under(network, drag.index));
        let (passed, reached) = approach(&from, &goal, drag.turning, MAX_MOTION * harness.longest());
        let step = step_to(&drag.step, drag.index, &passed);
        let ended = harness.advance_drag(&step, &at);
        let Some(mut drag) = self.drag.take() else { return };
        if std::mem::take(&mut drag.unbalanced) {
            self.now.pop();
            self.frames_changed(self.now.frames());
        }
        match ended {
            Ok(ended) => {
                self.show(&ended);
                if is_balanced(&ended) {
                    drag.turned |= passed.turn.is_some();
                    drag.passed.push((passed, ended.checkpoint.drawn_target(network, drag.index).unwrap_or(from)));
                } else {
                    drag.unbalanced = true;
                }
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
        match self.drag.as_mut().filter(|drag| drag.constraint == name) {
            Some(drag) if drag.goal.is_some() => drag.ends = true,
            Some(_) => self.end_drag(),
            None => {}
        }
    }

    /// Completes the step of a drag; a drag without increments leaves no step.
    pub(super) fn end_drag(&mut self) {
        let Some(drag) = self.drag.take() else { return };
        let Some(written) = drag.written() else {
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
        self.push_undo(drag.step, drag.before);
    }
}
