//! Whether a cable may come nearer to an obstacle between two equilibria than at both of them, or touch it only in
//! between.
//!
//! Points of the cable, and points that constraints hold, are taken to move on arcs of circles in the axes of the
//! obstacle, which turn as much as the frame there. A chord of the length D with the turn φ belongs to an arc of the
//! length `D φ/2 / sin(φ/2)`, which rises `D/2 tan(φ/4)` above it.
//!
//! An obstacle that moves by itself goes straight and turns by ψ about its own point, R away: in its axes a point at
//! rest has a velocity of at most `D + 2 ψ R` and an acceleration of at most `ψ (2 D + 3 ψ R)`, with the part of the
//! step as the unit of time. A curve of the acceleration a rises `a/8` above its chord.

use wireloom_core::requirement::{Measure, Part, Requirement};
use wireloom_core::{Network, Pose, State, Vector};

/// Motion below which nothing happens unseen, and length of a piece of cable that moves as one point, as fractions of
/// the clearance or of the cable's radius.
const SHORT: f64 = 0.25;
/// Depth below the clearances at both ends that counts, as a fraction of the clearance or of the cable's radius.
const DEEPER: f64 = 0.002;

/// Two equilibria that follow each other, each with the poses of all obstacles.
pub(crate) struct Passage<'a> {
    pub network: &'a Network,
    pub before: (&'a State, &'a [Pose]),
    pub after: (&'a State, &'a [Pose]),
}

impl Passage<'_> {
    /// Whether a clearance from an obstacle may be less than required in between, and less than at both ends; or for a
    /// limit of contact, whether there may be a force in between alone.
    pub fn may_break(&self, requirement: &Requirement) -> bool {
        let limit = match requirement.measure {
            Measure::Clearance => requirement.min,
            Measure::ContactForce => requirement.max.and(Some(0.0)),
            _ => None,
        };
        let Some(limit) = limit else { return false };
        let obstacles = || {
            let obstacle = |part: &Part| if let Part::Obstacle(o) = *part { Some(o) } else { None };
            requirement.against.iter().filter_map(obstacle)
        };
        requirement.of.iter().any(|part| match *part {
            Part::Branch { branch, from, to } => obstacles().any(|o| self.branch(branch, (from, to), o, limit)),
            Part::Constraint(f) => obstacles().any(|o| self.constraint(f, o, limit)),
            Part::Obstacle(o) => {
                (0..self.network.branches.len()).any(|b| self.branch(b, (0.0, f64::INFINITY), o, limit))
            }
        })
    }

    fn branch(&self, b: usize, (from, to): (f64, f64), obstacle: usize, limit: f64) -> bool {
        let branch = &self.network.branches[b];
        let mesh = branch.rod.mesh();
        let s = mesh.arc_lengths();
        let first = s.partition_point(|s| *s <= from).saturating_sub(1);
        let last = s.partition_point(|s| *s < to).min(s.len() - 1);
        // The ends of a segment, as far as it belongs to the part.
        let ends = |i: usize, (state, poses): (&State, &[Pose])| {
            let [x, y] = [i, i + 1].map(|node| state.points[branch.points.start + node]);
            let orientation = state.frames[branch.frames.start + mesh.segment_frames[i]];
            [from, to].map(|end| {
                let position = x.lerp(&y, ((end - s[i]) / (s[i + 1] - s[i])).clamp(0.0, 1.0));
                poses[obstacle].inverse().compose(&Pose { position, orientation })
            })
        };
        (first..last).any(|i| {
            let [before, after] = [self.before, self.after].map(|at| ends(i, at));
            let radius = self.network.radius(b, i);
            self.piece([[before[0], after[0]], [before[1], after[1]]], (obstacle, radius, limit))
        })
    }

    /// The same for a straight piece of cable, whose two ends move from the one pose to the other in the axes of the
    /// obstacle.
    fn piece(&self, ends: [[Pose; 2]; 2], to: (usize, f64, f64)) -> bool {
        let (_, radius, limit) = to;
        let middle = [0, 1].map(|k| Pose {
            position: 0.5 * (ends[0][k].position + ends[1][k].position),
            orientation: ends[0][k].orientation,
        });
        let longest = |k: usize| 0.5 * (ends[1][k].position - ends[0][k].position).norm();
        let half = longest(0).max(longest(1));
        // No point of it is nearer than its middle less this.
        if !self.may_come_below(&middle, to, limit + half) {
            return false;
        }
        if half <= SHORT * limit.max(radius) {
            return self.point(&middle, to) || ends.iter().any(|end| self.point(end, to));
        }
        self.piece([ends[0], middle], to) || self.piece([middle, ends[1]], to)
    }

    fn constraint(&self, f: usize, obstacle: usize, limit: f64) -> bool {
        let constraint = &self.network.constraints[f];
        let radius = 0.5 * self.network.diameter_at(constraint.place);
        constraint.stations.first().is_some_and(|site| {
            let way =
                [self.before, self.after].map(|(state, poses)| poses[obstacle].inverse().compose(&state.pose(site)));
            self.point(&way, (obstacle, radius, limit))
        })
    }

    /// Clearance of a point of a cable from an obstacle, in its axes, m; where it is above `reach`, any number above.
    fn clearance(&self, x: &Vector, (obstacle, radius): (usize, f64), reach: f64) -> f64 {
        self.network.obstacles[obstacle].shape.distance(x, reach + radius) - radius
    }

    fn arc(&self, way: &[Pose; 2], obstacle: usize) -> Arc {
        let chord = (way[1].position - way[0].position).norm();
        let turn = way[0].orientation.angle_to(&way[1].orientation);
        let length = if turn > 0.0 { chord * 0.5 * turn / (0.5 * turn).sin() } else { chord };
        let rise = 0.5 * chord * (0.25 * turn).tan();
        if self.network.obstacles[obstacle].mount.is_some() {
            return Arc { chord, length, rise };
        }
        let [before, after] = [self.before.1, self.after.1].map(|poses| poses[obstacle].orientation);
        let own = before.angle_to(&after);
        let far = way[0].position.norm().max(way[1].position.norm());
        Arc {
            chord,
            length: length.max(chord + 2.0 * own * far),
            rise: rise.max(own * (2.0 * chord + 3.0 * own * far) / 8.0),
        }
    }

    /// Whether a point of a cable may come below a clearance on its way.
    fn may_come_below(&self, way: &[Pose; 2], (obstacle, radius, _): (usize, f64, f64), clearance: f64) -> bool {
        let arc = self.arc(way, obstacle);
        let reach = clearance + arc.length;
        let [from, to] = way.map(|pose| self.clearance(&pose.position, (obstacle, radius), reach));
        0.5 * (from + to - arc.length) < clearance
    }

    /// Whether a point of a cable may come below the limit and below the clearances at both ends of its way.
    fn point(&self, way: &[Pose; 2], to: (usize, f64, f64)) -> bool {
        let (obstacle, radius, limit) = to;
        let (arc, scale) = (self.arc(way, obstacle), limit.max(radius));
        if arc.chord <= SHORT * scale || !self.may_come_below(way, to, limit) {
            return false;
        }
        let clearance = |x: &Vector| self.clearance(x, (obstacle, radius), limit + arc.length);
        let ends = way.map(|pose| (pose.position, clearance(&pose.position)));
        let least = ends[0].1.min(ends[1].1);
        if limit == 0.0 && least <= DEEPER * scale {
            // What touches at one end is known there, and contact keeps it from coming nearer.
            return false;
        }
        let below = limit.min(least - DEEPER * scale) + arc.rise;
        dips(&clearance, ends, below, DEEPER * scale)
    }
}

/// The arc of a point.
struct Arc {
    chord: f64,
    length: f64,
    /// Largest height above the chord.
    rise: f64,
}

/// Whether a distance is below a value somewhere on a straight way, of whose ends the places and distances are given.
/// It changes by no more than the way; parts that are `short` are not divided.
fn dips(distance: &dyn Fn(&Vector) -> f64, ends: [(Vector, f64); 2], below: f64, short: f64) -> bool {
    let [(x, from), (y, to)] = ends;
    let way = (y - x).norm();
    if way <= short || 0.5 * (from + to - way) >= below {
        return false;
    }
    let middle = 0.5 * (x + y);
    let half = (middle, distance(&middle));
    half.1 < below || dips(distance, [ends[0], half], below, short) || dips(distance, [half, ends[1]], below, short)
}
