//! Motion of a constraint by hand: increments of limited size towards a target.

use wireloom_core::constraint::{Action, RotationHold};
use wireloom_core::network::AttachedConstraint;
use wireloom_core::rotation::{columns, shortest};
use wireloom_core::steps::{Move, Operation, Step, Track};
use wireloom_core::{Pose, Rotation, Vector};
use wireloom_scenario::record::{Passed, Turned, rotation};

/// Largest displacement in one increment, in lengths of the longest branch: as in the search for the initial
/// equilibrium.
pub const MAX_MOTION: f64 = 0.1;
/// Largest rotation in one increment, rad: as in the search for the initial equilibrium.
pub const MAX_ROTATION: f64 = 0.3;
/// Largest distance of a target from where it is, in total lengths of all branches.
pub const MAX_DISTANCE: f64 = 10.0;

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
        Action::Potential(_) | Action::Equations(_) => None,
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
    /// The same target in the axes of a body.
    pub fn on(&self, body: &Pose) -> Self {
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

/// A step of one increment, in which a constraint moves to a pose that [`approach`] has found.
pub fn step_to(name: &str, constraint: usize, passed: &Passed) -> Step {
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

/// The next pose on the way to a target, both in the axes of the body that carries the constraint
/// ([`Checkpoint::drawn_target`](crate::session::Checkpoint::drawn_target)), at most one increment away (`reach`, m,
/// and a fixed angle), and whether it is
/// the target.
pub fn approach(from: &Pose, goal: &Goal, turning: Option<Turning>, reach: f64) -> (Passed, bool) {
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
