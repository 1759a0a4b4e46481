//! Monitor of twist that a mesh cannot hold, and loses.
//!
//! The energy of two coupled frames depends on their relative rotation, but not on full turns. Its moment is largest at
//! about 105°; beyond half a turn the energy decreases towards a state with one turn less. No rod does that: the
//! result would be a wrong equilibrium. So frames are monitored in every call of the minimiser. All steps of a frame
//! are less than half a turn and multiply its unit quaternion, whose sign so stays continuous. The product
//! `q_a · q_b = cos(φ/2)` of two neighbours changes its sign exactly when φ passes half a turn.

use crate::report::Occurrence;
use crate::report::result;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use wireloom_core::conditions::Conditions;
use wireloom_core::constraint::{Action, RotationHold};
use wireloom_core::law::TurningLaw;
use wireloom_core::network::{AttachedConstraint, BranchEnd, Joint, Place};
use wireloom_core::problem::Problem;
use wireloom_core::rotation::nearer_sign;
use wireloom_core::{EventKind, EventPlace, Network, Rotation, State};

/// Turn of neighbouring frames (rad) up to which a mesh resolves the rod: the error of the curvature is at most 0.6 %.
pub(crate) const RESOLVED_TURN: f64 = TAU / 6.0;

/// Two coupled frames.
#[derive(Clone, Debug)]
enum Coupled {
    /// Frame c and the next one of a branch.
    Along { branch: usize, c: usize },
    /// Two frames of a joint, each with the rotation that makes both equal at rest: that of an arm, at `s` of its
    /// branch, and that of another arm (its branch) or of the hub. With the parts of the harness on both sides.
    AtJoint { sides: [Side; 2], s: f64, other: Option<usize>, frames: [usize; 2], rest: [Rotation; 2] },
    /// Station and target of a constraint with a rotational spring.
    Spring { constraint: usize },
}

/// Part of the harness on one side of a cut between frame c of a branch and the next one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    pub branch: usize,
    pub c: usize,
    /// Whether it is the side of the branch's start.
    pub start: bool,
}

/// Whether the twist is held on a side of a cut; also if the side is connected to the other one, as a closed loop holds
/// its twist.
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

/// Whether a constraint turns its station about the tangent.
fn turns_along(constraint: &AttachedConstraint) -> bool {
    match constraint.model.action() {
        Action::Prescribed(hold) => !matches!(hold.rotation, RotationHold::Free | RotationHold::Tangent),
        Action::Potential(_) => constraint.model.law().is_none_or(|law| matches!(law.turning, TurningLaw::Frame(_))),
        Action::Equations(_) | Action::PotentialAndEquations(..) => true,
    }
}

/// Whether the twist between two frames is held on both sides; the twist of a free part is not prescribed.
fn is_held(coupled: &Coupled, problem: &Problem<'_>) -> bool {
    match *coupled {
        Coupled::Along { branch, c } => {
            [true, false].iter().all(|&start| holds_twist(problem, Side { branch, c, start }))
        }
        Coupled::AtJoint { sides, .. } => sides.iter().all(|&side| holds_twist(problem, side)),
        Coupled::Spring { .. } => {
            let acting =
                problem.network.constraints.iter().zip(&problem.conditions().active).filter(|(_, active)| **active);
            acting.filter(|(constraint, _)| turns_along(constraint)).count() > 1
        }
    }
}

/// An arm of a joint, and the parts beyond it.
fn whole_arm(network: &Network, joint: &Joint, arm: usize) -> Side {
    let (branch, start) = (joint.branches[arm], !joint.arms[arm].starts_here);
    Side { branch, c: if start { network.branches[branch].frames.len() - 1 } else { 0 }, start }
}

/// Monitor of the twist between all coupled frames.
#[derive(Clone, Debug)]
pub(crate) struct TwistMonitor {
    coupled: Vec<Coupled>,
    /// Orientation of the target of each spring, with a continuous sign.
    targets: BTreeMap<usize, Rotation>,
    /// For each coupling, whether the product was negative before.
    negative: Vec<bool>,
    /// Couplings that lost a turn in the last call.
    lost: Vec<usize>,
}

impl TwistMonitor {
    /// Monitor of all couplings of a network.
    pub fn new(network: &Network) -> Self {
        let mut coupled = Vec::new();
        for (branch, own) in network.branches.iter().enumerate() {
            coupled.extend((0..own.rod.mesh().coupling_lengths.len()).map(|c| Coupled::Along { branch, c }));
        }
        for joint in &network.joints {
            for pair in joint.model.law().into_iter().flat_map(|law| law.pairs) {
                let (branch, starts_here) = (joint.branches[pair.a], joint.arms[pair.a].starts_here);
                let s = if starts_here { 0.0 } else { network.branches[branch].rod.mesh().length() };
                let other = joint.branches.get(pair.b).copied();
                let sides = match other {
                    Some(_) => [pair.a, pair.b].map(|arm| whole_arm(network, joint, arm)),
                    None => {
                        // What attaches to the arm's end is on the hub.
                        let c = if starts_here { 0 } else { network.branches[branch].frames.len() - 2 };
                        [!starts_here, starts_here].map(|start| Side { branch, c, start })
                    }
                };
                let frames = [joint.coupled_frames[pair.a], joint.coupled_frames[pair.b]];
                coupled.push(Coupled::AtJoint { sides, s, other, frames, rest: [pair.alpha, pair.beta] });
            }
        }
        for (constraint, own) in network.constraints.iter().enumerate() {
            if matches!(own.model.law().map(|law| law.turning), Some(TurningLaw::Frame(_))) {
                coupled.push(Coupled::Spring { constraint });
            }
        }
        Self { negative: vec![false; coupled.len()], coupled, targets: BTreeMap::new(), lost: Vec::new() }
    }

    /// Begins before the minimiser changes `state`.
    pub fn begin(&mut self, problem: &Problem<'_>, state: &State) {
        self.lost.clear();
        let Conditions { targets, active, .. } = problem.conditions();
        for (k, coupled) in self.coupled.iter().enumerate() {
            let Coupled::Spring { constraint } = *coupled else { continue };
            let known = self.targets.remove(&constraint);
            if active[constraint] {
                // The target has moved already; its sign is that nearest to the station before.
                if known.is_none() {
                    self.negative[k] = false;
                }
                let from =
                    known.unwrap_or_else(|| state.pose(&problem.network.constraints[constraint].site).orientation);
                self.targets.insert(constraint, nearer_sign(targets[constraint].orientation, &from));
            }
        }
        for (k, coupled) in self.coupled.iter().enumerate() {
            if !matches!(coupled, Coupled::Spring { .. }) {
                self.negative[k] = self.product(coupled, problem, state) < 0.0;
            }
        }
    }

    /// Ends after the minimiser. Returns whether turns were lost that are held on both sides.
    pub fn end(&mut self, problem: &Problem<'_>, state: &State) -> bool {
        for (k, coupled) in self.coupled.iter().enumerate() {
            let product = self.product(coupled, problem, state);
            if product != 0.0 && (product < 0.0) != self.negative[k] && is_held(coupled, problem) {
                self.lost.push(k);
            }
        }
        !self.lost.is_empty()
    }

    /// `q_a · q_b`; 0 for an inactive spring.
    fn product(&self, coupled: &Coupled, problem: &Problem<'_>, state: &State) -> f64 {
        let network = problem.network;
        match coupled {
            Coupled::Along { branch, c } => {
                let frames = &state.frames[network.branches[*branch].frames.start + c..];
                frames[0].coords.dot(&frames[1].coords)
            }
            Coupled::AtJoint { frames, rest, .. } => {
                let [a, b] = [0, 1].map(|k| state.frames[frames[k]] * rest[k]);
                a.coords.dot(&b.coords)
            }
            Coupled::Spring { constraint } => self.targets.get(constraint).map_or(0.0, |target| {
                state.pose(&network.constraints[*constraint].site).orientation.coords.dot(&target.coords)
            }),
        }
    }

    /// Events of the turns lost in the last call, with a remedy. `before` is the state at its beginning, `prescribed`
    /// the largest number of turns that a constraint makes in the step.
    pub fn occurrences(&self, problem: &Problem<'_>, before: &State, prescribed: f64) -> Vec<Occurrence> {
        let network = problem.network;
        // By branch or constraint, with the first coupling.
        let mut all: Vec<(EventPlace, &Coupled, usize)> = Vec::new();
        for &k in &self.lost {
            let coupled = &self.coupled[k];
            let place = match coupled {
                Coupled::Along { branch, c } => {
                    let own = &network.branches[*branch];
                    let node = own.rod.mesh().coupling_nodes[*c];
                    EventPlace::branch(&own.name, before.arc_lengths(network, *branch)[node])
                }
                Coupled::AtJoint { sides: [arm, _], s, .. } => {
                    EventPlace::branch(&network.branches[arm.branch].name, *s)
                }
                Coupled::Spring { constraint } => EventPlace::constraint(&network.constraints[*constraint].name),
            };
            let part = |place: &EventPlace| (place.branch.clone(), place.constraint.clone());
            match all.iter_mut().find(|(known, ..)| part(known) == part(&place)) {
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
                    let needed = (twist.abs().max(prescribed) * TAU / RESOLVED_TURN).ceil().max(2.0 * segments as f64);
                    format!(
                        "{lost} of its twist would be lost: neighbouring frames turned past half a turn; {segments} \
                         segments do not hold {twist:.1} turns and how it bends there, {needed:.0} may"
                    )
                }
                Coupled::AtJoint { other: Some(other), .. } => format!(
                    "{lost} of twist would be lost at the joint with branch `{}`: the wires that run from one to \
                     the other turned past half a turn",
                    network.branches[other].name
                ),
                Coupled::AtJoint { other: None, .. } => format!(
                    "{lost} of twist would be lost at its joint: the spring that holds it to the hub turned past half \
                     a turn"
                ),
                Coupled::Spring { .. } => format!(
                    "{lost} would be lost: its spring turned past half a turn, and cannot turn the cable as asked"
                ),
            };
            Occurrence { kind: EventKind::TwistLost, place, value: Some(count as f64), limit: None, message }
        };
        all.into_iter().map(occurrence).collect()
    }
}
