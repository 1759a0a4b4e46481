//! Motion of a constraint by hand: increments of limited size towards a target.

use super::error::SessionError;
use super::harness::DrivenHarness;
use crate::load::targets::too_deep;
use wireloom_core::constraint::{Action, RotationHold};
use wireloom_core::network::AttachedConstraint;
use wireloom_core::rotation::{columns, shortest};
use wireloom_core::steps::{Move, Operation, Step, Track};
use wireloom_core::{Pose, Rotation, Vector};
use wireloom_scenario::record::{Passed, Turned, Way, Written, rotation};
use wireloom_solve::steps::Interruption;
use wireloom_solve::steps::checkpoint::Checkpoint;
use wireloom_solve::steps::interactive::Ended;

/// Largest displacement in one increment, in lengths of the longest branch: as in the search for the initial
/// equilibrium.
pub(super) const MAX_MOTION: f64 = 0.1;
/// Largest rotation in one increment, rad: as in the search for the initial equilibrium.
pub(super) const MAX_ROTATION: f64 = 0.3;
/// Largest distance of a target from where it is, in total lengths of all branches.
const MAX_DISTANCE: f64 = 10.0;

/// Rotational degrees of freedom that a motion can prescribe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turning {
    /// The tangent only.
    Tangent,
    /// The whole frame.
    Frame,
}

/// Permitted rotation of a constraint, if any. A constraint that would have to hold more freedoms must be pinned first.
pub fn turning(constraint: &AttachedConstraint) -> Option<Turning> {
    match constraint.model.action() {
        Action::Prescribed(hold) => match hold.rotation {
            RotationHold::All => Some(Turning::Frame),
            RotationHold::Tangent => Some(Turning::Tangent),
            RotationHold::Free | RotationHold::Twist | RotationHold::Hinge(_) => None,
        },
        _ => None,
    }
}

/// Target pose of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Position, m; `None`: where it is.
    pub position: Option<[f64; 3]>,
    /// Quaternion `[w, x, y, z]` of any length but zero; `None`: as it is.
    pub orientation: Option<[f64; 4]>,
}

impl Goal {
    /// Refuses a target that is empty, far from where the thing of this name is, or no pose.
    ///
    /// # Errors
    /// If it is.
    pub(super) fn check(&self, name: &str, from: &Vector, harness: &DrivenHarness) -> Result<(), SessionError> {
        if self.position.is_none() && self.orientation.is_none() {
            let message = format!("the target of \"{name}\" is empty");
            return Err(SessionError::value(message, "give a position, an orientation, or both"));
        }
        let far = MAX_DISTANCE * harness.total_length();
        let is_near = |to: &[f64; 3]| (Vector::from(*to) - from).norm() <= far;
        if let Some(to) = self.position.filter(|to| !is_near(to)) {
            let message = format!("{to:?} is not a valid position for \"{name}\"");
            return Err(SessionError::value(message, format!("give a position within {far:.1} m of where it is")));
        }
        let is_rotation = |q: &[f64; 4]| rotation(*q).is_some_and(|q| q.coords.iter().all(|x| x.is_finite()));
        if let Some(q) = self.orientation.filter(|q| !is_rotation(q)) {
            let help = "give a quaternion [w, x, y, z] that is not zero";
            return Err(SessionError::value(format!("{q:?} is not an orientation"), help));
        }
        Ok(())
    }

    /// The same target in the axes of a body.
    fn on(&self, body: &Pose) -> Self {
        if *body == Pose::identity() {
            return *self;
        }
        let turned = |q: [f64; 4]| rotation(q).map_or(q, |q| quaternion(&(body.orientation.inverse() * q)));
        Self {
            position: self.position.map(|x| body.local(&x.into()).into()),
            orientation: self.orientation.map(turned),
        }
    }
}

/// A constraint that is moved by hand. Its motion is one step of the scenario; each target is an increment, or some.
#[derive(Clone, Debug)]
pub struct Drag {
    /// Name of the step.
    pub step: String,
    constraint: usize,
    name: String,
    turning: Option<Turning>,
    /// Whether it has turned so far.
    turned: bool,
    /// Poses that it has passed: as recorded, and as reached.
    passed: Vec<(Passed, Pose)>,
}

impl Drag {
    /// A motion of an active constraint that has not begun.
    ///
    /// # Errors
    /// If there is no such constraint, or it has no place that could be moved.
    pub fn of(step: String, name: &str, harness: &DrivenHarness, at: &Checkpoint) -> Result<Self, SessionError> {
        let constraint = movable(name, harness, at)?;
        let turning = turning(&harness.network.constraints[constraint]);
        Ok(Self { step, constraint, name: name.to_owned(), turning, turned: false, passed: Vec::new() })
    }

    /// Name of the constraint.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it can be turned.
    pub fn turns(&self) -> bool {
        self.turning.is_some()
    }

    /// Whether any increment has been recorded.
    pub fn has_begun(&self) -> bool {
        !self.passed.is_empty()
    }

    /// Refuses a target that is empty, far away, inside a body, or not one of the constraint.
    ///
    /// # Errors
    /// If it is.
    pub fn check(&self, goal: &Goal, harness: &DrivenHarness, at: &Checkpoint) -> Result<(), SessionError> {
        let stands = at.target(self.constraint).unwrap_or_else(Pose::identity);
        goal.check(&self.name, &stands.position, harness)?;
        let network = &harness.network;
        let inside = |to: [f64; 3]| too_deep(network, self.constraint, &to.into(), at.obstacle_poses());
        if let Some((obstacle, depth)) = goal.position.and_then(inside) {
            let message = format!(
                "this takes \"{}\" {:.1} mm inside obstacle \"{obstacle}\", where it would hold the cable",
                self.name,
                1e3 * depth
            );
            return Err(SessionError::value(message, "keep its centre line outside"));
        }
        if goal.orientation.is_some() && self.turning.is_none() {
            let name = &self.name;
            let message = format!("\"{name}\" does not hold the orientation of the cable, so it cannot be turned");
            return Err(SessionError::request(message, "use a constraint that holds position, tangent and twist"));
        }
        Ok(())
    }

    /// Computes one increment towards a target, and whether it ends there. It is recorded if it ends in balance.
    ///
    /// # Errors
    /// If no result is obtained.
    pub fn advance(
        &mut self,
        goal: &Goal,
        harness: &DrivenHarness,
        at: &Checkpoint,
    ) -> Result<(Ended, bool), Interruption> {
        let target = |at: &Checkpoint| at.drawn_target(&harness.network, self.constraint);
        let from = target(at).unwrap_or_else(Pose::identity);
        let goal = goal.on(&at.body_under(&harness.network, self.constraint));
        let (passed, reached) = approach(&from, &goal, self.turning, MAX_MOTION * harness.longest());
        let ended = harness.advance_open(&step_to(&self.step, self.constraint, &passed), at)?;
        if ended.is_balanced() {
            let stands = target(&ended.checkpoint).unwrap_or(from);
            self.turned |= passed.turn.is_some();
            self.passed.push((passed, stands));
        }
        Ok((ended, reached))
    }

    /// The step as the scenario has it; `None` if nothing was recorded.
    pub fn written(&self) -> Option<Written> {
        if self.passed.is_empty() {
            return None;
        }
        let place = |(passed, stood): &(Passed, Pose)| {
            let turn = || match self.turning? {
                Turning::Frame => Some(Turned::Orientation(quaternion(&stood.orientation))),
                Turning::Tangent => Some(Turned::Tangent(columns(&stood.orientation)[2].into())),
            };
            Passed { turn: if self.turned { passed.turn.or_else(turn) } else { None }, ..*passed }
        };
        let way = Way { constraint: self.name.clone(), places: self.passed.iter().map(place).collect() };
        Some(Written { name: self.step.clone(), way: Some(way), ..Written::default() })
    }
}

/// Index of the active constraint of this name, which can be moved.
///
/// # Errors
/// If there is none, or it has no place that could be moved.
pub(crate) fn movable(name: &str, harness: &DrivenHarness, at: &Checkpoint) -> Result<usize, SessionError> {
    let constraint = harness.active_constraint(name, at)?;
    if harness.network.constraints[constraint].stations.is_empty() {
        let message = format!("\"{name}\" acts along a part of a branch and cannot be moved");
        return Err(SessionError::request(message, "hold the cable, or move another constraint"));
    }
    Ok(constraint)
}

/// A step of one increment, in which a constraint moves to a pose.
fn step_to(name: &str, constraint: usize, passed: &Passed) -> Step {
    let turn = passed.turn.as_ref().and_then(Turned::turn);
    let track = Track {
        positions: vec![(1.0, Vector::from(passed.position))],
        turns: turn.into_iter().map(|turn| (1.0, turn)).collect(),
        spin: 0.0,
    };
    let operations = turn.map(|_| Operation::Carry { constraints: vec![constraint] }).into_iter().collect();
    Step {
        name: name.to_owned(),
        increments: 1,
        moves: vec![Move::of(constraint, track)],
        operations,
        ..Step::default()
    }
}

/// Quaternion `[w, x, y, z]` of a rotation.
pub fn quaternion(rotation: &Rotation) -> [f64; 4] {
    let q = rotation.quaternion();
    [q.w, q.i, q.j, q.k]
}

/// The next pose on the way to a target, both as the mechanism that carries the constraint is drawn
/// ([`Checkpoint::drawn_target`]), at most one increment away (`reach`, m, and a fixed angle), and whether it is the
/// target.
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
    let fraction = 1.0_f64.min(reach / distance).min(MAX_ROTATION / angle);
    let reached = fraction >= 1.0;
    let position = if reached { to } else { from.position + (to - from.position) * fraction };
    let turn = facing.map(|(how, given, q)| match how {
        Turning::Frame if reached => Turned::Orientation(given),
        Turning::Frame => Turned::Orientation(quaternion(&from.orientation.slerp(&q, fraction))),
        Turning::Tangent => {
            let [d, end] = tangents(&q);
            Turned::Tangent((shortest(&d, &end).powf(fraction) * d).into())
        }
    });
    (Passed { position: position.into(), turn }, reached)
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom_core::steps::Turn;

    /// A distant target is reached exactly, in several increments.
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
