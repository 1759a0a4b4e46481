//! Turns of twist that a mesh cannot hold, and loses.
//!
//! Neighbouring frames are coupled by an energy that knows their relative rotation, but not by how many turns they came to it. Its moment is largest
//! at some 105°; beyond half a turn the shorter way leads on to where a whole turn is gone. No rod does that: the result would be a state that
//! nobody asked for. So frames are followed through every call of the minimiser. All of their steps are turns of less than half a turn, and multiply
//! the unit quaternion: its sign goes on continuously. The product `q_a · q_b = cos(φ/2)` of two neighbours changes its sign exactly when φ
//! passes half a turn.

use crate::report::Occurrence;
use crate::report::result;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use wireloom_core::conditions::Conditions;
use wireloom_core::constraint::{Action, RotationHold};
use wireloom_core::law::TurningLaw;
use wireloom_core::network::{AttachedConstraint, BranchEnd, Place};
use wireloom_core::problem::Problem;
use wireloom_core::rotation::nearer_sign;
use wireloom_core::{EventKind, EventPlace, Network, Rotation, State};

/// Turn of neighbouring frames (rad) up to which a mesh bends and twists as the rod does: the curvature is within 0.6 % of the rod's there.
pub(crate) const HELD_WELL: f64 = TAU / 6.0;

/// Two frames that something couples.
#[derive(Clone, Debug)]
enum Coupled {
    /// Frame c and the next one of a branch.
    Along { branch: usize, c: usize },
    /// Two arms of a joint: their branches, whether those start there, and their frames, each with the rotation at which they are alike at rest.
    Arms { arms: [(usize, bool); 2], s: f64, frames: [usize; 2], rest: [Rotation; 2] },
    /// A springy hand, which turns what it holds.
    Hand { constraint: usize },
}

/// One part of the harness, as seen from where it is cut: a branch to this side of frame c and the next one, and what is joined to it there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    pub branch: usize,
    pub c: usize,
    /// The side of the branch's start.
    pub start: bool,
}

/// Whether something holds the twist on a side; also where that leads around to the other side, for a closed loop holds its own.
pub(crate) fn holds_twist(problem: &Problem<'_>, side: Side) -> bool {
    let network = problem.network;
    let holding = |place: &dyn Fn(&Place) -> bool| {
        let mut acting = network.constraints.iter().zip(&problem.conditions().active).filter(|(_, active)| **active);
        acting.any(|(constraint, _)| constraint.places.iter().any(place) && turns_along(constraint))
    };
    let own = &network.branches[side.branch];
    let here = |node: usize| {
        let frame = own.rod.mesh().station_frame(node);
        frame.is_some_and(|frame| (frame <= side.c) == side.start)
    };
    if holding(&|place| matches!(place, Place::Node { branch, node } if *branch == side.branch && here(*node))) {
        return true;
    }
    let (mut open, mut seen) = (vec![if side.start { own.start } else { own.end }], vec![side.branch]);
    while let Some(end) = open.pop() {
        let BranchEnd::Joint { joint, .. } = end else { continue };
        if holding(&|place| *place == Place::Joint(joint)) {
            return true;
        }
        for &next in &network.joints[joint].branches {
            let branch = &network.branches[next];
            let other = if side.start { own.end } else { own.start };
            if next == side.branch && matches!(other, BranchEnd::Joint { joint: around, .. } if around == joint) {
                return true;
            }
            if seen.contains(&next) {
                continue;
            }
            seen.push(next);
            if holding(&|place| matches!(place, Place::Node { branch, .. } if *branch == next)) {
                return true;
            }
            open.extend([branch.start, branch.end]);
        }
    }
    false
}

/// Whether a constraint takes its station along when it makes turns about its tangent.
fn turns_along(constraint: &AttachedConstraint) -> bool {
    match constraint.model.action() {
        Action::Prescribed(hold) => !matches!(hold.rotation, RotationHold::Free | RotationHold::Tangent),
        Action::Potential(_) => constraint.model.law().is_none_or(|law| matches!(law.turning, TurningLaw::Frame(_))),
        Action::Equations(_) => true,
    }
}

/// Whether the twist between two frames is held on both sides: that of a part that hangs free nobody has asked for.
fn is_held(coupled: &Coupled, problem: &Problem<'_>) -> bool {
    match *coupled {
        Coupled::Along { branch, c } => {
            [true, false].iter().all(|&start| holds_twist(problem, Side { branch, c, start }))
        }
        Coupled::Arms { arms, .. } => arms.iter().all(|&(branch, starts_here)| {
            // All of the arm, and what is beyond it.
            let c = if starts_here { 0 } else { problem.network.branches[branch].frames.len() - 1 };
            holds_twist(problem, Side { branch, c, start: !starts_here })
        }),
        Coupled::Hand { .. } => {
            let acting =
                problem.network.constraints.iter().zip(&problem.conditions().active).filter(|(_, active)| **active);
            acting.filter(|(constraint, _)| turns_along(constraint)).count() > 1
        }
    }
}

/// Follows all that is coupled.
#[derive(Debug)]
pub(crate) struct LostTurns {
    coupled: Vec<Coupled>,
    /// Orientation of the target of each of the hands, its sign followed.
    targets: BTreeMap<usize, Rotation>,
    /// For all that is coupled whether the product was negative before.
    negative: Vec<bool>,
    /// Where turns were lost in the last call.
    lost: Vec<usize>,
}

impl LostTurns {
    /// Nothing is followed yet.
    pub fn new(network: &Network) -> Self {
        let mut coupled = Vec::new();
        for (branch, own) in network.branches.iter().enumerate() {
            coupled.extend((0..own.rod.mesh().coupling_lengths.len()).map(|c| Coupled::Along { branch, c }));
        }
        for joint in &network.joints {
            for pair in joint.model.law().into_iter().flat_map(|law| law.pairs) {
                let branch = joint.branches[pair.a];
                let s = if joint.arms[pair.a].starts_here { 0.0 } else { network.branches[branch].rod.mesh().length() };
                let frames = [joint.arm_frames[pair.a], joint.arm_frames[pair.b]];
                let arms = [pair.a, pair.b].map(|arm| (joint.branches[arm], joint.arms[arm].starts_here));
                coupled.push(Coupled::Arms { arms, s, frames, rest: [pair.alpha, pair.beta] });
            }
        }
        for (constraint, own) in network.constraints.iter().enumerate() {
            if matches!(own.model.law().map(|law| law.turning), Some(TurningLaw::Frame(_))) {
                coupled.push(Coupled::Hand { constraint });
            }
        }
        Self { negative: vec![false; coupled.len()], coupled, targets: BTreeMap::new(), lost: Vec::new() }
    }

    /// Before the minimiser works on `state`.
    pub fn begin(&mut self, problem: &Problem<'_>, state: &State) {
        self.lost.clear();
        let Conditions { targets, active, .. } = problem.conditions();
        for (k, coupled) in self.coupled.iter().enumerate() {
            let Coupled::Hand { constraint } = *coupled else { continue };
            let known = self.targets.remove(&constraint);
            if active[constraint] {
                // Its target has moved already; what counts is on which side the station was before.
                if known.is_none() {
                    self.negative[k] = false;
                }
                let from =
                    known.unwrap_or_else(|| state.pose(&problem.network.constraints[constraint].site).orientation);
                self.targets.insert(constraint, nearer_sign(targets[constraint].orientation, &from));
            }
        }
        for (k, coupled) in self.coupled.iter().enumerate() {
            if !matches!(coupled, Coupled::Hand { .. }) {
                self.negative[k] = self.product(coupled, problem, state) < 0.0;
            }
        }
    }

    /// After it. Returns whether turns were lost that something holds at both ends.
    pub fn end(&mut self, problem: &Problem<'_>, state: &State) -> bool {
        for (k, coupled) in self.coupled.iter().enumerate() {
            let product = self.product(coupled, problem, state);
            if product != 0.0 && (product < 0.0) != self.negative[k] && is_held(coupled, problem) {
                self.lost.push(k);
            }
        }
        !self.lost.is_empty()
    }

    /// `q_a · q_b`; 0 where nothing acts.
    fn product(&self, coupled: &Coupled, problem: &Problem<'_>, state: &State) -> f64 {
        let network = problem.network;
        match coupled {
            Coupled::Along { branch, c } => {
                let frames = &state.frames[network.branches[*branch].frames.start + c..];
                frames[0].coords.dot(&frames[1].coords)
            }
            Coupled::Arms { frames, rest, .. } => {
                let [a, b] = [0, 1].map(|k| state.frames[frames[k]] * rest[k]);
                a.coords.dot(&b.coords)
            }
            Coupled::Hand { constraint } => self.targets.get(constraint).map_or(0.0, |target| {
                state.pose(&network.constraints[*constraint].site).orientation.coords.dot(&target.coords)
            }),
        }
    }

    /// What was lost in the last call, if anything: where, and what would be right. `before` is the state that it began at, `asked` the most turns that a
    /// constraint makes in the step.
    pub fn occurrences(&self, problem: &Problem<'_>, before: &State, asked: f64) -> Vec<Occurrence> {
        let network = problem.network;
        // By branch or hand, with the first of them.
        let mut all: Vec<(EventPlace, &Coupled, usize)> = Vec::new();
        for &k in &self.lost {
            let coupled = &self.coupled[k];
            let place = match coupled {
                Coupled::Along { branch, c } => {
                    let own = &network.branches[*branch];
                    let node = own.rod.mesh().coupling_nodes[*c];
                    EventPlace::branch(&own.name, before.arc_lengths(network, *branch)[node])
                }
                Coupled::Arms { arms: [(branch, _), _], s, .. } => {
                    EventPlace::branch(&network.branches[*branch].name, *s)
                }
                Coupled::Hand { constraint } => EventPlace::constraint(&network.constraints[*constraint].name),
            };
            let thing = |place: &EventPlace| (place.branch.clone(), place.constraint.clone());
            match all.iter_mut().find(|(known, ..)| thing(known) == thing(&place)) {
                Some((_, _, count)) => *count += 1,
                None => all.push((place, coupled, 1)),
            }
        }
        let occurrence = |(place, coupled, count): (EventPlace, &Coupled, usize)| {
            let lost = if count == 1 { "a turn".to_owned() } else { format!("{count} turns") };
            let message = match *coupled {
                Coupled::Along { branch, .. } => {
                    let own = &network.branches[branch];
                    let (segments, twist) =
                        (own.rod.mesh().segments(), result::twist_turns(before.branch(network, branch).frames));
                    let needed = (twist.abs().max(asked) * TAU / HELD_WELL).ceil().max(2.0 * segments as f64);
                    format!(
                        "{lost} of its twist would be lost: neighbouring frames turned past half a turn; {segments} segments do not hold \
                         {twist:.1} turns and how it bends there, {needed:.0} may"
                    )
                }
                Coupled::Arms { arms: [_, (other, _)], .. } => format!(
                    "{lost} of twist would be lost at the joint with branch `{}`: the wires that run from one to the other turned past half a turn",
                    network.branches[other].name
                ),
                Coupled::Hand { .. } => format!(
                    "{lost} would be lost: its spring turned past half a turn, and cannot turn the cable as asked"
                ),
            };
            Occurrence { kind: EventKind::TwistLost, place, value: Some(count as f64), limit: None, message }
        };
        all.into_iter().map(occurrence).collect()
    }
}
