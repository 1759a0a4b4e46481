//! Assembly operations, with names resolved to indices of the network.

use crate::conditions::RotatingAxes;
use crate::identity::Identities;
use crate::mechanism::closure::Way;
use crate::mechanism::{Mechanism, Mount};
use crate::rotation::{columns, shortest};
use crate::{Pose, Rotation, Vector};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Rotation of a target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Turn {
    /// No rotation.
    Keep,
    /// Smallest rotation of d3 to this direction.
    Tangent(Vector),
    /// Smallest rotation to this orientation.
    Orientation(Rotation),
}

/// Track of a motion: positions and orientations at increasing fractions of the motion in (0, 1]. In between, positions
/// are interpolated linearly and orientations along the shortest rotation; after the last one they stay.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    /// Points, m.
    pub positions: Vec<(f64, Vector)>,
    /// Orientations.
    pub turns: Vec<(f64, Turn)>,
    /// Turns about the tangent, spread evenly over the motion.
    pub spin: f64,
}

impl Track {
    /// Course of the track from a start pose.
    pub fn from(&self, start: &Pose) -> Course {
        let mut orientations = vec![(0.0, start.orientation)];
        let mut now = start.orientation;
        for (t, turn) in &self.turns {
            now = match turn {
                Turn::Keep => now,
                Turn::Tangent(d) => shortest(&columns(&now)[2], d) * now,
                Turn::Orientation(end) => *end,
            };
            orientations.push((*t, now));
        }
        let positions = std::iter::once((0.0, start.position)).chain(self.positions.iter().copied()).collect();
        Course { positions, orientations, spin: self.spin }
    }
}

/// A [`Track`] with a known start pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Course {
    positions: Vec<(f64, Vector)>,
    orientations: Vec<(f64, Rotation)>,
    spin: f64,
}

impl Course {
    /// Pose at fraction `t` of the motion; exactly that of the track at the track's fractions.
    pub fn at(&self, t: f64) -> Pose {
        let position = along(&self.positions, t, |a, b, fraction| a + (b - a) * fraction);
        let turned = along(&self.orientations, t, |a, b, fraction| (b * a.inverse()).powf(fraction) * a);
        let spin = Rotation::from_axis_angle(&Vector::z_axis(), std::f64::consts::TAU * self.spin * t);
        Pose { position, orientation: turned * spin }
    }

    /// Fractions of the motion at which it has a corner, its start and end included.
    pub fn corners(&self) -> impl Iterator<Item = f64> {
        self.positions.iter().map(|knot| knot.0).chain(self.orientations.iter().map(|knot| knot.0))
    }

    /// Upper bound of the turns from fraction `a` of the motion to fraction `b`: about its axis, plus those between
    /// orientations.
    pub fn turned(&self, a: f64, b: f64) -> f64 {
        let between = self.orientations.windows(2).map(|pair| {
            let [(from, p), (to, q)] = [pair[0], pair[1]];
            let fraction = (b.min(to) - a.max(from)).max(0.0) / (to - from);
            if fraction > 0.0 { fraction * p.angle_to(&q) / std::f64::consts::TAU } else { 0.0 }
        });
        self.spin.abs() * (b - a) + between.sum::<f64>()
    }
}

/// Interpolated value at fraction `t` in a list of fractions and values that begins with fraction 0.
fn along<T: Copy>(knots: &[(f64, T)], t: f64, between: impl Fn(T, T, f64) -> T) -> T {
    let next = knots.partition_point(|knot| knot.0 <= t);
    let (from, a) = knots[next.saturating_sub(1)];
    match knots.get(next) {
        Some(&(to, b)) => between(a, b, ((t - from) / (to - from)).max(0.0)),
        None => a,
    }
}

/// A constraint that takes part in a motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Carried {
    /// Index of the constraint.
    pub constraint: usize,
    /// Fraction of the step after which it begins to move.
    pub delay: f64,
    /// Fraction of the step during which it moves.
    pub fraction: f64,
}

/// Motion of one constraint's target over a step, or of several together as one rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// The constraints that move; the track is that of the first, unless `origin` is given.
    pub carried: Vec<Carried>,
    /// Position (m) and orientation of the body at the start of the step; `None`: those of the first constraint.
    pub origin: (Option<Vector>, Option<Rotation>),
    /// Track of the body.
    pub track: Track,
}

impl Move {
    /// Motion of one constraint over the whole step.
    pub fn of(constraint: usize, track: Track) -> Self {
        Self { carried: vec![Carried { constraint, delay: 0.0, fraction: 1.0 }], origin: (None, None), track }
    }

    /// Journeys of all constraints involved, from their poses at the start of the step.
    pub fn journeys(&self, pose: impl Fn(usize) -> Pose) -> Vec<Journey> {
        let Some(first) = self.carried.first() else { return Vec::new() };
        let first = pose(first.constraint);
        let body = Pose {
            position: self.origin.0.unwrap_or(first.position),
            orientation: self.origin.1.unwrap_or(first.orientation),
        };
        let journey = |(k, carried): (usize, &Carried)| Journey {
            carried: *carried,
            body: self.track.from(&body),
            own: if k == 0 && self.origin == (None, None) {
                Pose::identity()
            } else {
                body.inverse().compose(&pose(carried.constraint))
            },
        };
        self.carried.iter().enumerate().map(journey).collect()
    }

    /// Fractions of the step, without its start and end, at which a motion starts, ends or has a corner.
    pub fn corners(&self) -> Vec<f64> {
        let knots = || self.track.positions.iter().map(|k| k.0).chain(self.track.turns.iter().map(|k| k.0));
        let of = |c: &Carried| {
            let c = *c;
            std::iter::once(c.delay).chain(knots().map(move |t| c.delay + c.fraction * t))
        };
        self.carried.iter().flat_map(of).filter(|t| 0.0 < *t && *t < 1.0).collect()
    }
}

/// Motion of one constraint over a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Journey {
    carried: Carried,
    body: Course,
    /// Its pose in the body.
    own: Pose,
}

impl Journey {
    /// Motion of one constraint from a pose, over the whole step.
    pub fn of(constraint: usize, track: &Track, from: &Pose) -> Self {
        let carried = Carried { constraint, delay: 0.0, fraction: 1.0 };
        Self { carried, body: track.from(from), own: Pose::identity() }
    }

    /// Index of the constraint.
    pub fn constraint(&self) -> usize {
        self.carried.constraint
    }

    /// Its pose at fraction `t` of the step.
    pub fn at(&self, t: f64) -> Pose {
        let Carried { delay, fraction, .. } = self.carried;
        // Exactly the end pose at the end.
        let own = if t >= delay + fraction { 1.0 } else { ((t - delay) / fraction).max(0.0) };
        self.body.at(own).compose(&self.own)
    }

    /// Turns about its tangent over a fraction of the step.
    pub fn turns(&self, fraction: f64) -> f64 {
        (self.body.spin / self.carried.fraction * fraction).abs()
    }

    /// Upper bound of the turns from fraction `a` of the step to fraction `b`: about its tangent, plus those between
    /// orientations.
    pub fn turned(&self, a: f64, b: f64) -> f64 {
        let own = |t: f64| ((t - self.carried.delay) / self.carried.fraction).clamp(0.0, 1.0);
        self.body.turned(own(a), own(b))
    }
}

/// Operation of a step in assembly terms, about which the run reports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Operation {
    /// A grasp.
    Grasp {
        /// Index of the constraint.
        constraint: usize,
    },
    /// Grasps or connectors are carried together.
    Carry {
        /// Indices of the constraints.
        constraints: Vec<usize>,
    },
    /// A connector is mated.
    Mate {
        /// Index of the constraint.
        constraint: usize,
        /// Direction of insertion; a unit vector.
        direction: Vector,
        /// Fraction of the step at which the push begins.
        push_from: f64,
        /// Largest permitted insertion force, N.
        limit: Option<f64>,
    },
    /// A clip closes around the cable.
    Clip {
        /// Index of the constraint.
        constraint: usize,
    },
}

/// Motion of an obstacle over a step.
#[derive(Clone, Debug, PartialEq)]
pub struct ObstacleMove {
    /// Index of the obstacle.
    pub obstacle: usize,
    /// Its track.
    pub track: Track,
}

/// Motion of a mechanism over a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// Index of the mechanism.
    pub mechanism: usize,
    /// Values of its joints.
    pub way: Way,
}

/// Bodies of mechanisms from step to step.
pub struct Bodies<'n> {
    mechanisms: &'n [Mechanism],
    /// Poses at the end of the last step, by mechanism.
    poses: Vec<Vec<Pose>>,
    /// Whether each mechanism moves in it.
    moving: Vec<bool>,
}

impl<'n> Bodies<'n> {
    /// Bodies as drawn: before the first step.
    pub fn drawn(mechanisms: &'n [Mechanism]) -> Self {
        let poses = mechanisms.iter().map(|own| vec![Pose::identity(); own.bodies.len()]).collect();
        Self { mechanisms, poses, moving: vec![false; mechanisms.len()] }
    }

    /// Goes on to the end of a step with these drives.
    pub fn drive(&mut self, drives: &[Drive]) {
        self.moving.fill(false);
        for drive in drives {
            self.poses[drive.mechanism] = self.mechanisms[drive.mechanism].poses(drive.way.end());
            self.moving[drive.mechanism] = true;
        }
    }

    /// Whether what has this mount moves in the step.
    pub fn moves(&self, mount: Option<Mount>) -> bool {
        mount.is_some_and(|mount| self.moving[mount.mechanism])
    }

    /// Pose of a body; the identity for no mount.
    pub fn under(&self, mount: Option<Mount>) -> Pose {
        mount.map_or_else(Pose::identity, |mount| self.poses[mount.mechanism][mount.body])
    }
}

/// One assembly operation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Step {
    /// Name.
    pub name: String,
    /// Number of increments; each ends in an equilibrium.
    pub increments: usize,
    /// Number of equal parts of the step of which the results keep the last increment; 0 is as 1. It divides
    /// [`Self::increments`].
    pub parts: usize,
    /// Time that the step takes, s: what creeps does so in it.
    pub duration: f64,
    /// Gravity reached at the end of the step, m/s².
    pub gravity: Option<Vector>,
    /// Angular velocity of the axes reached at the end of the step, rad/s.
    pub angular_velocity: Option<Vector>,
    /// Constraints that begin with this step.
    pub add: Vec<usize>,
    /// Constraints that end with this step.
    pub release: Vec<usize>,
    /// Motions of mechanisms; each is in one of them at most.
    pub drives: Vec<Drive>,
    /// Motions; each constraint is in one of them at most. Those of what is mounted on a body are relative to it: in
    /// coordinates of the drawn mechanism.
    pub moves: Vec<Move>,
    /// Motions of obstacles that are not mounted on a body; each obstacle is in one of them at most.
    pub obstacle_moves: Vec<ObstacleMove>,
    /// The operations that the step performs.
    pub operations: Vec<Operation>,
    /// Load index and the factor reached at the end of the step.
    pub loads: Vec<(usize, f64)>,
    /// Branch index and the temperature reached at the end of the step, less that of its rest shape, K.
    pub temperatures: Vec<(usize, f64)>,
}

impl Step {
    /// Whether the results keep an increment (from 1) though they do not keep all.
    pub fn keeps(&self, increment: usize) -> bool {
        increment.is_multiple_of(self.increments / self.parts.max(1))
    }
}

/// Initial placement of the rest shape: the start of this branch has this pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Initial {
    /// Index of the branch.
    pub branch: usize,
    /// Pose of its start.
    pub pose: Pose,
}

/// Schedule of a run: initial conditions and steps in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// Name of the scenario.
    pub scenario: String,
    /// Gravity at the start of the run, m/s².
    pub gravity: Vector,
    /// Rotation of the axes at the start of the run.
    pub rotation: RotatingAxes,
    /// Initial placement of the rest shape; `None`: the start is found from the drawn paths or the constraints.
    pub initial: Option<Initial>,
    /// The steps; empty: one equilibrium.
    pub steps: Vec<Step>,
    /// Whether the result keeps every increment, not only the last of each step.
    pub increments: bool,
    /// Whether all clearances of the cables are computed, not only the required ones.
    pub clearances: bool,
    /// Part numbers and the like, for the results.
    pub identities: Arc<Identities>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start() -> Pose {
        Pose { position: Vector::new(1.0, 0.0, 0.0), orientation: Rotation::identity() }
    }

    #[test]
    fn a_course_goes_through_its_knots_and_straight_between() {
        let quarter = Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::FRAC_PI_2);
        let (p, q) = (Vector::new(1.0, 2.0, 0.0), Vector::new(3.0, 2.0, 0.0));
        let track =
            Track { positions: vec![(0.25, p), (0.75, q)], turns: vec![(0.5, Turn::Orientation(quarter))], spin: 0.0 };
        let course = track.from(&start());
        assert_eq!((course.at(0.0), course.at(0.25).position, course.at(1.0).position), (start(), p, q));
        assert!((course.at(0.5).position - Vector::new(2.0, 2.0, 0.0)).norm() < 1e-15);
        assert_eq!(course.at(0.9).orientation, quarter);
        assert!((course.at(0.25).orientation.angle() - std::f64::consts::FRAC_PI_4).abs() < 1e-15);
    }

    #[test]
    fn what_turns_about_its_tangent_and_to_another_orientation_turns_by_both() {
        let quarter = Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::FRAC_PI_2);
        let track = Track { positions: vec![], turns: vec![(0.5, Turn::Orientation(quarter))], spin: -3.0 };
        let mut journey = Journey::of(0, &track, &start());
        assert_eq!((journey.turns(0.5), journey.turned(0.0, 1.0), journey.turned(0.5, 0.75)), (1.5, 3.25, 0.75));
        (journey.carried.delay, journey.carried.fraction) = (0.5, 0.25);
        assert!((journey.turned(0.25, 0.5625) - (0.75 + 0.125)).abs() < 1e-15);
        assert_eq!(journey.turned(0.75, 1.0), 0.0);
    }

    /// A quarter turn of two grasps about the first: the other one moves around it, with a delay if one is given.
    #[test]
    fn a_body_turns_rigidly_about_its_origin() {
        let quarter = Rotation::from_axis_angle(&Vector::z_axis(), std::f64::consts::FRAC_PI_2);
        let other = Pose { position: Vector::new(3.0, 0.0, 0.0), ..start() };
        let poses = [start(), other];
        let track = Track { positions: vec![], turns: vec![(1.0, Turn::Orientation(quarter))], spin: 0.0 };
        let mut together = Move::of(0, track);
        together.carried.push(Carried { constraint: 1, delay: 0.5, fraction: 0.25 });
        let journeys = together.journeys(|k| poses[k]);
        assert!((journeys[0].at(1.0).position - Vector::x()).norm() < 1e-15);
        assert_eq!(journeys[1].at(0.5), other);
        for t in [0.75, 1.0] {
            assert!((journeys[1].at(t).position - Vector::new(1.0, 2.0, 0.0)).norm() < 1e-15);
        }
        assert_eq!(together.corners(), [0.5, 0.75]);
        together.origin.0 = Some(Vector::new(2.0, 0.0, 0.0));
        let journeys = together.journeys(|k| poses[k]);
        assert!((journeys[0].at(1.0).position - Vector::new(2.0, -1.0, 0.0)).norm() < 1e-15);
        assert!((journeys[1].at(1.0).position - Vector::new(2.0, 1.0, 0.0)).norm() < 1e-15);
    }
}
