//! Changes of the scenario's text: by commands, by a text that replaces it. Each is one operation of undo.
//! What the change leaves as it was stays computed: the steps before the first one that differs.

use super::Session;
use super::known::{MAX_TEXT, SessionFiles, text_faults, too_large};
use super::mesh::Mesh;
use super::snapshot::{Snapshot, StepEnd, StepFrames};
use crate::protocol::{Document, Edit, List, Notice, PartKind, Placed, Start};
use serde_json::Value as Json;
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use wireloom::scenario::record::{Attachment, as_json, with_json};
use wireloom::scenario::structure::{self, NewBranch, Part};
use wireloom::scenario::{Fault, shipped_fixings};
use wireloom::session::{DrivenHarness, Refusal};

/// Keys at the top level that no equilibrium before a changed step depends on.
const WITHOUT_EFFECT: [&str; 4] = ["steps", "name", "sweep", "optimise"];

/// Poses of an obstacle that differ by less are the same one, m and rad.
const SAME_PLACE: f64 = 1e-6;
const SAME_DIRECTION: f64 = 1e-6;

impl Session {
    /// The text for pages, if it has changed since the last call.
    pub fn changed_document(&mut self) -> Option<Document> {
        let text = self.text().ok()?;
        if self.document.1 == text {
            return None;
        }
        self.document = (self.document.0 + 1, text);
        Some(self.document())
    }

    pub(super) fn document(&self) -> Document {
        let (version, text) = &self.document;
        let own = self.known.registry.constraints().map(|own| (own.name.clone(), own.doc.clone()));
        let shipped = shipped_fixings(&self.known.registry);
        Document {
            version: *version,
            name: self.name.clone(),
            can_store: self.storage.is_some(),
            is_new: self.storage.as_ref().is_some_and(|storage| storage.is_new()),
            text: text.clone(),
            entries: as_json(text).unwrap_or(Json::Null),
            constraint_kinds: own.chain(shipped).collect(),
            quantities: structure::required_quantities().iter().map(|word| (*word).to_owned()).collect(),
        }
    }

    /// Replaces the text by one that a page has made from a version of the document.
    pub(super) fn apply(&mut self, tab: u32, text: &str, base: u32) -> Result<(), Refusal> {
        self.end_drag();
        if let Some(document) = self.changed_document() {
            self.changes.document = Some(document);
        }
        if base != self.document.0 {
            let message = "the scenario was changed while this text was edited";
            return Err(Refusal::new(message, "the page shows both: take over what is to stay, and apply it again"));
        }
        if text == self.document.1 {
            return Ok(());
        }
        let made = self.become_text("edit the text".to_owned(), text, &self.now.files.clone());
        made.map_err(|faults| self.refuse_text(tab, text, &faults))
    }

    /// Sends the faults of a text to the tab that gave it; returns them in a sentence.
    pub(super) fn refuse_text(&mut self, tab: u32, text: &str, faults: &[Fault]) -> Refusal {
        let found = text_faults(text, faults);
        self.changes.said.push((Some(tab), Notice::Checked { number: None, faults: found }));
        told(text, faults)
    }

    /// Changes the text by a command.
    pub(super) fn edit(&mut self, edit: &Edit) -> Result<(), Refusal> {
        self.end_drag();
        let before = self.text()?;
        let (label, text) = self.edited(&before, edit)?;
        if text == before {
            return Ok(());
        }
        self.become_text(label, &text, &self.now.files.clone()).map_err(|faults| told(&text, &faults))
    }

    fn edited(&self, text: &str, edit: &Edit) -> Result<(String, String), Refusal> {
        Ok(match edit {
            Edit::Put { key, value } => (described(key), with_json(text, key, value, &self.known.registry)?),
            Edit::Remove { key } => (format!("remove {}", described(key)), structure::without_key(text, key)?),
            Edit::Add { list, entry } => {
                let (list, word) = named(*list);
                let name = entry.get("name").and_then(Json::as_str).unwrap_or_default();
                (format!("add {word} {name}"), structure::with_entry(text, list, entry)?)
            }
            Edit::Rename { part, name, to } => {
                let part = kind(*part);
                let label = format!("rename {} {name} to {to}", part.word());
                (label, structure::renamed(text, part, name, to)?)
            }
            Edit::Delete { part, name } => {
                let part = kind(*part);
                (format!("delete {} {name}", part.word()), structure::without_part(text, part, name)?)
            }
            Edit::DeleteAll { parts } => without_all(text, parts)?,
            Edit::Move { obstacle, from, to } => self.moved(text, obstacle, from, to)?,
            Edit::Split { branch, s } => {
                let second = structure::unused_name(text, Part::Branch, &format!("{branch} 2"))?;
                let joint = structure::unused_name(text, Part::Vertex, &format!("{branch} joint"))?;
                (format!("split branch {branch}"), structure::with_split(text, branch, *s, &second, &joint)?)
            }
            Edit::Branch { name, from, section, length } => {
                let from = match from {
                    Start::Joint(joint) => Attachment::Joint(joint.clone()),
                    Start::End(end) => Attachment::End(end.clone()),
                    Start::Point { branch, s } => Attachment::Branch(branch.clone(), *s),
                };
                let to = structure::unused_name(text, Part::Vertex, &format!("{name} end"))?;
                let (name, section, length) = (name.clone(), section.clone(), length.clone());
                let new = NewBranch { name, from, to, section, length };
                (format!("add branch {}", new.name), structure::with_branch(text, &new)?)
            }
        })
    }

    /// The command by which an obstacle that is at one pose in a frame would be at another one there. A mechanism may
    /// have carried it to the first one, from where the text has it.
    fn moved(&self, text: &str, name: &str, from: &Placed, to: &Placed) -> Result<(String, String), Refusal> {
        let [from, to] = [from, to].map(Placed::pose);
        let (Some(from), Some(to)) = (from, to) else {
            return Err(Refusal::new("a pose has a quaternion of length 0 or a number that is not finite", ""));
        };
        let own = self.now.harness.network.obstacles.iter().find(|own| own.name == name);
        let own = own.ok_or_else(|| Refusal::new(format!("there is no obstacle {name:?}"), "choose another one"))?;
        let pose = own.pose.compose(&from.inverse().compose(&to));
        let moves = (pose.position - own.pose.position).norm() > SAME_PLACE;
        let turns = pose.orientation.angle_to(&own.pose.orientation) > SAME_DIRECTION;
        let label = format!("{} obstacle {name}", if turns { "turn" } else { "move" });
        // As a person would write it, to a hundredth of a millimetre.
        let place = pose.position.map(|x| (x * 1e5).round() / 1e5);
        let (position, orientation) = (moves.then_some(&place), turns.then_some(&pose.orientation));
        Ok((label, structure::with_pose(text, name, position, orientation)?))
    }

    /// Carries out another text, from the first step that differs if nothing before it does, else from the start.
    pub(super) fn become_text(
        &mut self,
        label: String,
        text: &str,
        files: &Arc<dyn SessionFiles>,
    ) -> Result<(), Vec<Fault>> {
        if text.len() > MAX_TEXT {
            return Err(vec![too_large(text)]);
        }
        let (text, harness) = self.known.load(text, &**files, &self.monitor)?;
        let harness = Rc::new(harness);
        let own = harness.schedule.steps.len();
        let run = self.now.run + 1;
        let mut next = Snapshot::new(files.clone(), text.as_str().into(), own, Vec::new(), harness.clone(), run);
        // With files that were read anew nothing computed is certain to be the same.
        let same_files = Arc::ptr_eq(files, &self.now.files);
        if let Some(kept) = self.kept(&text, &harness).filter(|_| same_files) {
            next.run = self.now.run;
            next.pending = kept.steps.len() <= own;
            let Kept { steps, end, places } = kept;
            (next.steps, next.places) = (steps, places);
            (next.at, next.last) = (Some(end.checkpoint.clone()), Some(end.result.clone()));
            next.sheet = end.sheet.clone();
        }
        self.commit(label, next);
        Ok(())
    }

    /// What stays of the steps that were computed, if the texts differ in later ones alone.
    fn kept(&self, text: &str, harness: &Rc<DrivenHarness>) -> Option<Kept> {
        let now = &self.now;
        if !matches!((&now.mesh, Mesh::of(harness)), (Mesh::Given, Mesh::Given)) {
            return None;
        }
        let [before, after] = [as_json(&now.whole_text().ok()?).ok()?, as_json(text).ok()?];
        let same = |key: &String| WITHOUT_EFFECT.contains(&key.as_str()) || before.get(key) == after.get(key);
        if !before.as_object()?.keys().chain(after.as_object()?.keys()).all(same) {
            return None;
        }
        let steps = |json: &Json| json.get("steps").and_then(Json::as_array).cloned().unwrap_or_default();
        let (old, new) = (steps(&before), steps(&after));
        let alike = old.iter().zip(&new).take_while(|(a, b)| a == b).count();
        // The newest end that is still kept in memory and can be continued.
        (0..=alike.min(now.ended().checked_sub(1)?)).rev().find_map(|step| {
            let end = now.steps[step].end.borrow().clone()?;
            let checkpoint = Rc::new(harness.transferred(&end.harness, &end.checkpoint)?);
            let end = Rc::new(StepEnd {
                harness: harness.clone(),
                checkpoint,
                result: end.result.clone(),
                sheet: end.sheet.clone(),
            });
            let mut steps = now.steps[..=step].to_vec();
            let last = StepFrames { end: RefCell::new(Some(end.clone())), ..(*steps[step]).clone() };
            steps[step] = Rc::new(last);
            let places = now.places[..end.checkpoint.events().len().min(now.places.len())].to_vec();
            Some(Kept { steps, end, places })
        })
    }
}

/// What stays of the steps that were computed.
struct Kept {
    steps: Vec<Rc<StepFrames>>,
    end: Rc<StepEnd>,
    places: Vec<Option<[f64; 3]>>,
}

/// A refusal of a text with faults.
fn told(text: &str, faults: &[Fault]) -> Refusal {
    let Some(first) = faults.first() else { return Refusal::new("the text is refused", "") };
    let (line, column) = first.position(text);
    let more = if faults.len() > 1 { format!(" (and {} more faults)", faults.len() - 1) } else { String::new() };
    Refusal::new(format!("line {line}, column {column}: {}{more}", first.message), first.help.clone())
}

/// The command that deletes parts. Branches go last: with them go their constraints, which may be among the others.
fn without_all(text: &str, parts: &[(PartKind, String)]) -> Result<(String, String), Refusal> {
    let mut given: Vec<&(PartKind, String)> = parts.iter().collect();
    given.sort_by_key(|(part, name)| (*part == PartKind::Branch, *part, name));
    given.dedup();
    let [first, rest @ ..] = &given[..] else {
        return Err(Refusal::new("there is nothing to delete", "choose parts first"));
    };
    let label = match rest.len() {
        0 => format!("delete {} {}", kind(first.0).word(), first.1),
        more => format!("delete {} parts", more + 1),
    };
    let delete = |text: String, (part, name): &(PartKind, String)| structure::without_part(&text, kind(*part), name);
    Ok((label, given.into_iter().try_fold(text.to_owned(), delete)?))
}

fn kind(part: PartKind) -> Part {
    match part {
        PartKind::Branch => Part::Branch,
        PartKind::Constraint => Part::Constraint,
        PartKind::Obstacle => Part::Obstacle,
        PartKind::Requirement => Part::Requirement,
    }
}

/// Key of a list, and the word for one of its entries.
fn named(list: List) -> (&'static str, &'static str) {
    match list {
        List::Constraints => ("constraints", "constraint"),
        List::Obstacles => ("obstacles", "obstacle"),
        List::Requirements => ("requirements", "requirement"),
    }
}

/// A key in words: "length of branches.trunk".
fn described(key: &str) -> String {
    match key.rsplit_once('.') {
        Some((entry, last)) => format!("{last} of {entry}"),
        None => key.to_owned(),
    }
}

#[cfg(test)]
mod tests;
#[cfg(test)]
pub(super) use tests::Memory;
