//! Whether a cable may come nearer to an obstacle between two equilibria than at both of them.
//!
//! Points of the cable, and points that constraints hold, are taken to move on arcs of circles in the axes of the
//! obstacle, which turn as much as the frame there. A chord of the length D with the turn φ belongs to an arc of the
//! length `D φ/2 / sin(φ/2)`, which rises `D/2 tan(φ/4)` above it.

use wireloom_core::requirement::{Part, Requirement};
use wireloom_core::{Network, Pose, State, Vector};

/// Motion below which nothing happens unseen, as a fraction of the clearance or of the cable's radius.
const SHORT: f64 = 0.25;
/// Depth below the clearances at both ends that counts, as a fraction of the clearance or of the cable's radius.
const DEEPER: f64 = 0.02;
/// Largest number of places at which a chord is looked at.
const MOST_PLACES: f64 = 64.0;

/// Two equilibria that follow each other, each with the poses of all obstacles.
pub(crate) struct Passage<'a> {
    pub network: &'a Network,
    pub before: (&'a State, &'a [Pose]),
    pub after: (&'a State, &'a [Pose]),
}

impl Passage<'_> {
    /// Whether a clearance from an obstacle may be less than required in between, and less than at both ends.
    pub fn may_break(&self, requirement: &Requirement) -> bool {
        let Some(limit) = requirement.min else { return false };
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
        (first..=last).any(|i| {
            let point = branch.points.start + i;
            let frame = branch.frames.start + mesh.segment_frames[i.min(s.len() - 2)];
            let pose = |state: &State| Pose { position: state.points[point], orientation: state.frames[frame] };
            self.point(&pose, obstacle, 0.5 * branch.section.diameter, limit)
        })
    }

    fn constraint(&self, f: usize, obstacle: usize, limit: f64) -> bool {
        let constraint = &self.network.constraints[f];
        let radius = 0.5 * self.network.diameter_at(constraint.place);
        let station = constraint.stations.first();
        station.is_some_and(|site| self.point(&|state: &State| state.pose(site), obstacle, radius, limit))
    }

    /// The same for a point of a cable.
    fn point(&self, pose: &dyn Fn(&State) -> Pose, obstacle: usize, radius: f64, limit: f64) -> bool {
        let [p, q] = [self.before, self.after].map(|(state, poses)| poses[obstacle].inverse().compose(&pose(state)));
        let (x, y) = (p.position, q.position);
        let (chord, scale) = ((y - x).norm(), limit.max(radius));
        if chord <= SHORT * scale {
            return false;
        }
        let turn = p.orientation.angle_to(&q.orientation);
        let arc = if turn > 0.0 { chord * 0.5 * turn / (0.5 * turn).sin() } else { chord };
        let rise = 0.5 * chord * (0.25 * turn).tan();
        let shape = &self.network.obstacles[obstacle].shape;
        let clearance = |x: &Vector| shape.distance(x, arc + limit + radius) - radius;
        let [from, to] = [clearance(&x), clearance(&y)];
        if 0.5 * (from + to - arc) >= limit {
            return false;
        }
        let places = (chord / (SHORT * scale)).ceil().min(MOST_PLACES) as usize;
        let between = (1..places).map(|k| clearance(&x.lerp(&y, k as f64 / places as f64)));
        let least = between.fold(f64::INFINITY, f64::min) - rise;
        least < limit.min(from.min(to) - DEEPER * scale)
    }
}
