//! Operations between drags: grab, release, pin and clip, steps of one increment each; joints of mechanisms.

use super::Session;
use super::refusal::no_start;
use super::snapshot::{Snapshot, StepFrames};
use crate::protocol::Holding;
use std::rc::Rc;
use wireloom::scenario::At;
use wireloom::scenario::record::{Attachment, Begins, Written};
use wireloom::session::{Ended, Refusal, attachment, joint_motion, unused_name};

impl Snapshot {
    /// An unused name for a step.
    pub(super) fn unused_step_name(&self, wanted: &str) -> String {
        let own = self.harness.schedule.steps.iter().take(self.own).map(|step| step.name.as_str());
        unused_name(wanted, own.chain(self.by_hand.iter().map(|step| step.name.as_str())))
    }

    /// An unused name for a constraint.
    fn unused_constraint_name(&self, word: &str) -> String {
        let constraints = &self.harness.network.constraints;
        let begun = || self.by_hand.iter().flat_map(|step| &step.begins);
        let free = |name: &String| {
            constraints.iter().all(|constraint| constraint.name != *name) && begun().all(|begins| begins.name != *name)
        };
        (1..).map(|k| format!("{word} {k}")).find(free).unwrap_or_default()
    }
}

impl Session {
    /// Adds a handle, a pin or a clip at the node nearest to an arc length.
    pub(super) fn hold(&mut self, tab: u32, branch: &str, s: f64, how: Holding) -> Result<(), Refusal> {
        self.end_drag();
        let snapshot = self.editable_snapshot()?;
        let last = snapshot.last.as_ref().ok_or_else(no_start)?;
        let line = last.branches.iter().find(|line| line.name == branch);
        let length = line.and_then(|line| line.s.last()).copied().unwrap_or(0.0);
        // A click at an end may be slightly beyond it.
        let near = s >= -0.01 * length && s <= 1.01 * length;
        let at = attachment(last, branch, if near { s.clamp(0.0, length) } else { s })?;
        let (word, kind) = match how {
            Holding::Handle => ("handle", None),
            Holding::Pin => ("pin", Some("connector")),
            Holding::Collar => ("clip", Some("collar")),
        };
        let name = snapshot.unused_constraint_name(word);
        let begins = vec![Begins { name: name.clone(), kind: kind.map(str::to_owned), at }];
        let step = snapshot.unused_step_name(&format!("add {name}"));
        self.apply_step(snapshot, Written { name: step, begins, ..Written::default() })?;
        if how == Holding::Handle {
            self.held.insert(name, tab);
        }
        Ok(())
    }

    /// Releases a constraint.
    pub(super) fn release(&mut self, tab: u32, name: &str) -> Result<(), Refusal> {
        let snapshot = self.snapshot_with_active(tab, name)?;
        let step = snapshot.unused_step_name(&format!("release {name}"));
        self.apply_step(snapshot, Written { name: step, release: vec![name.to_owned()], ..Written::default() })?;
        self.held.remove(name);
        Ok(())
    }

    /// Replaces a constraint by one that holds the current pose completely.
    pub(super) fn pin(&mut self, tab: u32, name: &str) -> Result<(), Refusal> {
        let snapshot = self.snapshot_with_active(tab, name)?;
        let Snapshot { harness, at, .. } = &snapshot;
        let index = harness.active_constraint(name, at.as_ref().ok_or_else(no_start)?)?;
        let own = &harness.scenario.constraints[index];
        let at = match (own.at.as_slice(), own.span) {
            ([At::Branch { branch, s }], None) => {
                Attachment::Branch(harness.scenario.branches[*branch].name.clone(), *s)
            }
            ([At::Joint(joint)], None) => Attachment::Joint(harness.scenario.joints[*joint].name.clone()),
            _ => {
                let message = format!("\"{name}\" does not act at a single place");
                return Err(Refusal::new(message, "pin the cable beside it"));
            }
        };
        let begins = vec![Begins { name: name.to_owned(), kind: Some("connector".to_owned()), at }];
        let step = snapshot.unused_step_name(&format!("pin {name}"));
        self.apply_step(snapshot, Written { name: step, release: vec![name.to_owned()], begins, ..Written::default() })
    }

    /// The snapshot to extend, if this constraint is active and no other tab holds it.
    fn snapshot_with_active(&mut self, tab: u32, name: &str) -> Result<Snapshot, Refusal> {
        self.end_drag();
        if let Some(other) = self.held.get(name).filter(|other| **other != tab) {
            return Err(Refusal::new(format!("\"{name}\" is held by tab {other}"), "wait until it is released there"));
        }
        let snapshot = self.editable_snapshot()?;
        snapshot.harness.active_constraint(name, snapshot.at.as_ref().ok_or_else(no_start)?)?;
        Ok(snapshot)
    }

    /// Appends a step and computes it, if the scenario stays valid and an equilibrium is found.
    fn apply_step(&mut self, snapshot: Snapshot, written: Written) -> Result<(), Refusal> {
        let label = written.name.clone();
        let mut next = snapshot;
        let (other, at) = (next.harness.clone(), next.at.clone().ok_or_else(no_start)?);
        next.by_hand.push(Rc::new(written));
        let harness = Rc::new(self.load(&next)?);
        let transferred = harness.transferred(&other, &at);
        let again = "undo the last operation, or hold another place first";
        if self.monitor.is_stopped() {
            return Err(Refusal::new(format!("\"{label}\" was stopped"), "repeat it"));
        }
        let (Some(at), Some(step)) = (transferred, harness.schedule.steps.last()) else {
            // Recomputes everything: slow, but correct.
            self.commit(label, next.restarted(harness));
            return Ok(());
        };
        let mut all: Vec<Ended> = Vec::new();
        for _ in 0..step.increments {
            let from = all.last().map_or(&at, |ended| &ended.checkpoint);
            let ended = harness.advance(step, from).map_err(|trouble| Refusal::new(trouble.to_string(), again))?;
            if !ended.is_balanced() {
                let message = format!("no equilibrium found after \"{label}\": {}", ended.end.status.word());
                return Err(Refusal::new(message, again));
            }
            all.push(ended);
        }
        next.harness = harness.clone();
        next.steps.push(Rc::new(StepFrames::new(&step.name, true, step.increments)));
        self.commit(label, next);
        all.iter().for_each(|ended| self.show(ended));
        self.now.end();
        Ok(())
    }

    /// Drives a joint of a mechanism to a value.
    pub(super) fn drive(&mut self, joint: &str, value: f64) -> Result<(), Refusal> {
        self.end_drag();
        let snapshot = self.editable_snapshot()?;
        let last = snapshot.last.as_ref().ok_or_else(no_start)?;
        let drive = Some(joint_motion(&snapshot.harness, last, joint, value)?);
        let name = snapshot.unused_step_name(&format!("drive {joint}"));
        self.apply_step(snapshot, Written { name, drive, ..Written::default() })
    }
}
