//! Dragging: one step, whose increments come one by one, each as far towards the newest target as one increment may go.

use super::standing::{Standing, Stretch};
use super::{Refusal, Session, is_balanced};
use std::rc::Rc;
use wireloom::core::constraint::{Action, RotationHold};
use wireloom::core::network::Fixing;
use wireloom::core::rotation::{columns, shortest};
use wireloom::core::steps::{Move, Operation, Step, Track};
use wireloom::core::{Pose, Rotation, Vector};
use wireloom::scenario::record::{Passed, Turned, Way, Written, rotation};
use wireloom::solve::hands::Trouble;

/// Farthest that an increment brings something, in lengths of the longest branch: as far as the search for a start goes at once.
const REACH: f64 = 0.1;
/// Farthest that it turns something, rad; likewise.
const TURN: f64 = 0.3;
/// Farthest from the harness that something may be brought, in lengths of all its branches: nobody means more.
const FAR: f64 = 10.0;

/// How a fixing can be turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turning {
    /// Its tangent alone.
    Tangent,
    /// The whole frame.
    Frame,
}

/// How a fixing can be turned, if it can: one that would hold more by being turned must be pinned first.
pub(super) fn turning(fixing: &Fixing) -> Option<Turning> {
    match fixing.constraint.action() {
        Action::Prescribed(hold) => match hold.rotation {
            RotationHold::All => Some(Turning::Frame),
            RotationHold::Tangent => Some(Turning::Tangent),
            RotationHold::Free | RotationHold::Twist | RotationHold::Hinge(_) => None,
        },
        Action::Potential(_) | Action::Equations(_) => None,
    }
}

/// Where something is to be brought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Goal {
    position: Option<[f64; 3]>,
    orientation: Option<[f64; 4]>,
}

/// A drag.
pub(super) struct Drag {
    /// Name of its step.
    pub step: String,
    fixing: String,
    index: usize,
    turning: Option<Turning>,
    /// Whether it has turned so far.
    turned: bool,
    /// Where it has passed, and how it stood there.
    passed: Vec<(Passed, Pose)>,
    /// Where it is to go yet.
    pub goal: Option<Goal>,
    /// Whether it ends there.
    pub ends: bool,
    /// Whether the last frame is one that was not in balance.
    lost: bool,
    /// How the session stood before.
    before: Standing,
}

impl Drag {
    /// Whether there is anything to be kept of it.
    pub fn has_begun(&self) -> bool {
        !self.passed.is_empty()
    }

    /// The step.
    pub fn written(&self) -> Option<Written> {
        if self.passed.is_empty() {
            return None;
        }
        let place = |(passed, stood): &(Passed, Pose)| {
            let turn = || match self.turning? {
                Turning::Frame => Some(Turned::Orientation(quaternion(&stood.orientation))),
                Turning::Tangent => Some(Turned::Tangent(columns(&stood.orientation)[2].into())),
            };
            let turn = if self.turned { passed.turn.or_else(turn) } else { None };
            Passed { turn, ..*passed }
        };
        let way = Way { constraint: self.fixing.clone(), places: self.passed.iter().map(place).collect() };
        Some(Written { name: self.step.clone(), way: Some(way), ..Written::default() })
    }
}

fn quaternion(rotation: &Rotation) -> [f64; 4] {
    let q = rotation.quaternion();
    [q.w, q.i, q.j, q.k]
}

impl Session {
    /// Brings a fixing towards a place from now on.
    pub(super) fn target(
        &mut self,
        tab: u32,
        name: &str,
        position: Option<[f64; 3]>,
        orientation: Option<[f64; 4]>,
    ) -> Result<(), Refusal> {
        if let Some(other) = self.held.get(name).filter(|other| **other != tab) {
            return Err(Refusal::new(format!("\"{name}\" is held by tab {other}"), "wait until it is let go there"));
        }
        if self.drag.as_ref().is_some_and(|drag| drag.fixing != name) {
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

    /// Refuses what is no place.
    fn check(&self, drag: &Drag, position: Option<[f64; 3]>, orientation: Option<[f64; 4]>) -> Result<(), Refusal> {
        let name = &drag.fixing;
        if position.is_none() && orientation.is_none() {
            return Err(Refusal::new(
                format!("\"{name}\" is to go nowhere"),
                "give a position, an orientation, or both",
            ));
        }
        let far = FAR * self.now.harness.total_length();
        if let (Some(to), Some(at)) = (position, &self.now.at) {
            let from = at.target(drag.index).map_or_else(Vector::zeros, |pose| pose.position);
            let distance = (Vector::from(to) - from).norm();
            if distance.is_nan() || distance > far {
                let message = format!("{to:?} is no place to bring \"{name}\" to");
                return Err(Refusal::new(message, format!("give a position within {far:.1} m of where it is")));
            }
        }
        if let Some(q) = orientation {
            if drag.turning.is_none() {
                let message = format!("\"{name}\" does not hold how the cable stands, so it cannot be turned");
                return Err(Refusal::new(message, "pin it first: then it holds position, tangent and twist"));
            }
            if !q.iter().all(|x| x.is_finite()) || rotation(q).is_none_or(|q| !q.coords.iter().all(|x| x.is_finite())) {
                let message = format!("{q:?} is no orientation");
                return Err(Refusal::new(message, "give a quaternion [w, x, y, z] that is not zero"));
            }
        }
        Ok(())
    }

    fn begin_drag(&mut self, name: &str) -> Result<Drag, Refusal> {
        let before = self.now.clone();
        let standing = self.at_hand()?;
        let at = standing.at.as_ref().ok_or_else(super::no_start)?;
        let index = standing.harness.acting(name, at)?;
        let fixing = &standing.harness.network.fixings[index];
        if fixing.stations.is_empty() {
            let message = format!("\"{name}\" acts along a part of a branch and cannot be brought anywhere");
            return Err(Refusal::new(message, "take hold of the cable, or of another fixing"));
        }
        let turning = turning(fixing);
        let step = standing.free_step(&format!("drag {name}"));
        if standing.steps.len() < self.now.steps.len() || !Rc::ptr_eq(&standing.harness, &self.now.harness) {
            self.become_(standing);
        }
        self.now.steps.push(Rc::new(Stretch::new(&step, true, 0)));
        self.news.timeline = true;
        let (passed, fixing) = (Vec::new(), name.to_owned());
        Ok(Drag { step, fixing, index, turning, turned: false, passed, goal: None, ends: false, lost: false, before })
    }

    /// One increment towards the goal.
    pub(super) fn drag_on(&mut self) {
        // It stays where it is until that is computed: the solver may break down.
        let Some(drag) = &self.drag else { return };
        let (Some(goal), Some(at)) = (drag.goal, self.now.at.clone()) else { return };
        let harness = self.now.harness.clone();
        let Some(from) = at.target(drag.index) else { return };
        let (passed, reached) = approach(&from, &goal, drag.turning, REACH * harness.longest());
        let turn = passed.turn.as_ref().and_then(Turned::turn);
        let track = Track {
            positions: vec![(1.0, Vector::from(passed.position))],
            turns: turn.into_iter().map(|turn| (1.0, turn)).collect(),
            spin: 0.0,
        };
        let operations = turn.map(|_| Operation::Carry { fixings: vec![drag.index] }).into_iter().collect();
        let moves = vec![Move::of(drag.index, track)];
        let step = Step { name: drag.step.clone(), increments: 1, moves, operations, ..Step::default() };
        let ended = harness.follow(&step, &at);
        let Some(mut drag) = self.drag.take() else { return };
        if std::mem::take(&mut drag.lost) {
            self.now.pop();
            self.frames_changed(self.now.frames());
        }
        match ended {
            Ok(ended) => {
                self.show(&ended);
                if is_balanced(&ended) {
                    drag.turned |= passed.turn.is_some();
                    drag.passed.push((passed, ended.checkpoint.target(drag.index).unwrap_or(from)));
                } else {
                    drag.lost = true;
                }
                if reached || drag.lost {
                    drag.goal = None;
                }
            }
            Err(trouble) => {
                drag.goal = None;
                if let Trouble::Fault(fault) = trouble {
                    self.trouble(fault.to_string());
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

    /// Ends a drag, once it is where it is to go.
    pub(super) fn let_go(&mut self, tab: u32, name: &str) {
        if self.held.get(name).is_some_and(|by| *by != tab) {
            return;
        }
        self.held.remove(name);
        match self.drag.as_mut().filter(|drag| drag.fixing == name) {
            Some(drag) if drag.goal.is_some() => drag.ends = true,
            Some(_) => self.end_drag(),
            None => {}
        }
    }

    /// The step of a drag ends here; where nothing came of it, there is no step.
    pub(super) fn end_drag(&mut self) {
        let Some(drag) = self.drag.take() else { return };
        let Some(written) = drag.written() else {
            let unsaved = self.unsaved;
            self.become_(drag.before);
            self.unsaved = unsaved;
            return;
        };
        if drag.lost {
            self.now.pop();
            self.frames_changed(self.now.frames());
        }
        self.now.at = self.now.at.take().map(|at| Rc::new(Rc::unwrap_or_clone(at).with_step_ended()));
        self.now.by_hand.push(Rc::new(written));
        self.show_at_rest();
        self.now.end();
        self.shown.clone_from(&self.now.at);
        self.news.timeline = true;
        self.remember(drag.step, drag.before);
    }
}

/// As far towards a goal as one increment goes, and whether that is all the way.
fn approach(from: &Pose, goal: &Goal, turning: Option<Turning>, reach: f64) -> (Passed, bool) {
    let to = goal.position.map_or(from.position, Vector::from);
    let facing = turning.zip(goal.orientation).and_then(|(how, given)| Some((how, given, rotation(given)?)));
    let tangents = |q: &Rotation| [columns(&from.orientation)[2], columns(q)[2]];
    let distance = (to - from.position).norm();
    let angle = facing.map_or(0.0, |(how, _, q)| match how {
        Turning::Frame => q.angle_to(&from.orientation),
        Turning::Tangent => {
            let [d, end] = tangents(&q);
            d.angle(&end)
        }
    });
    let share = 1.0_f64.min(reach / distance).min(TURN / angle);
    let reached = share >= 1.0;
    let position = if reached { to } else { from.position + (to - from.position) * share };
    let turn = facing.map(|(how, given, q)| match how {
        Turning::Frame if reached => Turned::Orientation(given),
        Turning::Frame => Turned::Orientation(quaternion(&from.orientation.slerp(&q, share))),
        Turning::Tangent => {
            let [d, end] = tangents(&q);
            Turned::Tangent((shortest(&d, &end).powf(share) * d).into())
        }
    });
    (Passed { position: position.into(), turn }, reached)
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom::core::steps::Turn;

    /// However far it is, so many increments get there; the last one exactly.
    #[test]
    fn a_goal_is_reached_in_steps() {
        let start = Pose { position: Vector::new(1.0, 0.0, 0.0), orientation: Rotation::identity() };
        let q = [-0.3, 0.4, 0.5, -0.9];
        let goal = Goal { position: Some([1.0, 0.35, 0.0]), orientation: Some(q) };
        for how in [Turning::Frame, Turning::Tangent] {
            let (mut at, mut count) = (start, 0);
            loop {
                let (passed, reached) = approach(&at, &goal, Some(how), 0.1);
                assert!((Vector::from(passed.position) - at.position).norm() < 0.1 + 1e-12);
                at.position = passed.position.into();
                match passed.turn.and_then(|turn| turn.turn()) {
                    Some(Turn::Orientation(q)) => at.orientation = q,
                    Some(Turn::Tangent(d)) => {
                        at.orientation = shortest(&columns(&at.orientation)[2], &d) * at.orientation
                    }
                    other => panic!("{other:?}"),
                }
                count += 1;
                if reached {
                    break;
                }
                assert!(count < 20, "{how:?}");
            }
            assert_eq!(at.position, Vector::new(1.0, 0.35, 0.0));
            let end = rotation(q).expect("a rotation");
            let off = match how {
                Turning::Frame => at.orientation.angle_to(&end),
                Turning::Tangent => (columns(&at.orientation)[2] - columns(&end)[2]).norm(),
            };
            assert!(off < 1e-12, "{how:?}: {off:e}");
        }
    }
}
