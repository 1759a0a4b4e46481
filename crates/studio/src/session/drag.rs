//! State of a drag: one step, whose increments follow the newest target.

use super::snapshot::Snapshot;
use wireloom::geometry::{Pose, Rotation, Vector, columns, shortest};
use wireloom::harness::AttachedConstraint;
use wireloom::parts::{Action, RotationHold};
use wireloom::scenario::record::{Passed, Turned, Way, Written, rotation};

/// Largest rotation in one increment, rad: as in the search for the initial equilibrium.
const MAX_ROTATION: f64 = 0.3;

/// Rotational degrees of freedom that a drag can prescribe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turning {
    /// The tangent only.
    Tangent,
    /// The whole frame.
    Frame,
}

/// Permitted rotation of a constraint, if any. A constraint that would have to hold more freedoms must be pinned first.
pub(super) fn turning(constraint: &AttachedConstraint) -> Option<Turning> {
    match constraint.model.action() {
        Action::Prescribed(hold) => match hold.rotation {
            RotationHold::All => Some(Turning::Frame),
            RotationHold::Tangent => Some(Turning::Tangent),
            RotationHold::Free | RotationHold::Twist | RotationHold::Hinge(_) => None,
        },
        Action::Potential(_) | Action::Equations(_) => None,
    }
}

/// Target pose of a drag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Goal {
    pub position: Option<[f64; 3]>,
    pub orientation: Option<[f64; 4]>,
}

/// A drag.
pub(super) struct Drag {
    /// Name of its step.
    pub step: String,
    pub constraint: String,
    pub index: usize,
    pub turning: Option<Turning>,
    /// Whether it has rotated so far.
    pub turned: bool,
    /// Poses that it has passed: as recorded, and as reached.
    pub passed: Vec<(Passed, Pose)>,
    /// The target not reached yet.
    pub goal: Option<Goal>,
    /// Whether the drag ends at the target.
    pub ends: bool,
    /// Whether the last frame is not in equilibrium.
    pub unbalanced: bool,
    /// The snapshot before the drag.
    pub before: Snapshot,
}

impl Drag {
    /// Whether any increment has been recorded.
    pub fn has_begun(&self) -> bool {
        !self.passed.is_empty()
    }

    /// The step as recorded in the scenario.
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
        let way = Way { constraint: self.constraint.clone(), places: self.passed.iter().map(place).collect() };
        Some(Written { name: self.step.clone(), way: Some(way), ..Written::default() })
    }
}

fn quaternion(rotation: &Rotation) -> [f64; 4] {
    let q = rotation.quaternion();
    [q.w, q.i, q.j, q.k]
}

/// The next pose on the way to a target, at most one increment away, and whether it is the target.
pub(super) fn approach(from: &Pose, goal: &Goal, turning: Option<Turning>, reach: f64) -> (Passed, bool) {
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
    use wireloom::harness::Turn;

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
