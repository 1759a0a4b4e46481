//! Approximate poses of the unstressed parts of a harness, for checks of its constraints.

use crate::attachment::At;
use crate::scenario::{Branch, Facing, Scenario};
use std::collections::VecDeque;
use wireloom_core::rotation::{columns, shortest};
use wireloom_core::{Pose, Rotation, Vector};

/// The unstressed harness, each connected piece placed by `[initial]` or by its first given position. Loops are not
/// closed, and drawn paths replace the rest shape.
pub(crate) struct Placement<'s> {
    scenario: &'s Scenario,
    starts: Vec<Pose>,
    joints: Vec<Pose>,
}

impl<'s> Placement<'s> {
    /// Places a scenario whose branches belong to these `pieces`.
    pub fn new(scenario: &'s Scenario, pieces: &[usize]) -> Self {
        let mut joints_at = vec![Vec::new(); scenario.branches.len()];
        for (index, joint) in scenario.joints.iter().enumerate() {
            joint.arms.iter().for_each(|arm| joints_at[arm.branch].push(index));
        }
        let mut placed = Placing {
            scenario,
            joints_at,
            starts: vec![None; scenario.branches.len()],
            joints: vec![None; scenario.joints.len()],
        };
        if let Some(initial) = scenario.initial {
            placed.spread(initial.branch, initial.pose);
        }
        for branch in 0..scenario.branches.len() {
            placed.spread(branch, Pose::identity());
        }
        let or_origin = |pose: Option<Pose>| pose.unwrap_or(Pose::identity());
        let mut placement = Self {
            scenario,
            starts: placed.starts.into_iter().map(or_origin).collect(),
            joints: placed.joints.into_iter().map(or_origin).collect(),
        };
        let laid = scenario.initial.map(|initial| pieces[initial.branch]);
        let mut anchored: Vec<usize> = laid.into_iter().collect();
        for constraint in scenario.constraints.iter().filter(|constraint| constraint.from_start) {
            let piece = pieces[branch_of(scenario, constraint.place())];
            let Some(position) = constraint.position.filter(|_| !anchored.contains(&piece)) else { continue };
            anchored.push(piece);
            let now = placement.pose(constraint.place());
            let turn = match constraint.facing {
                Facing::Left => Rotation::identity(),
                Facing::Tangent(tangent) => shortest(&columns(&now.orientation)[2], &tangent),
                Facing::Orientation(orientation) => orientation * now.orientation.inverse(),
            };
            let motion = Pose { position: position - turn * now.position, orientation: turn };
            let starts = placement.starts.iter_mut().zip(pieces);
            let hubs = placement.joints.iter_mut().zip(scenario.joints.iter().map(|own| &pieces[own.arms[0].branch]));
            for (pose, _) in starts.chain(hubs).filter(|(_, own)| **own == piece) {
                *pose = motion.compose(pose);
            }
        }
        placement
    }

    /// Pose of an attachment.
    pub fn pose(&self, at: At) -> Pose {
        match at {
            At::Joint(joint) => self.joints[joint],
            At::Branch { branch, s } => {
                let own = &self.scenario.branches[branch];
                along_path(own, s).unwrap_or_else(|| self.starts[branch].compose(&rest_pose(own, s)))
            }
        }
    }
}

/// A branch to which an attachment belongs.
pub(crate) fn branch_of(scenario: &Scenario, at: At) -> usize {
    match at {
        At::Branch { branch, .. } => branch,
        At::Joint(joint) => scenario.joints[joint].arms[0].branch,
    }
}

struct Placing<'s> {
    scenario: &'s Scenario,
    /// The joints at each branch.
    joints_at: Vec<Vec<usize>>,
    starts: Vec<Option<Pose>>,
    joints: Vec<Option<Pose>>,
}

impl Placing<'_> {
    /// Places the start of a branch, and everything that joints connect to it.
    fn spread(&mut self, branch: usize, start: Pose) {
        let mut open = VecDeque::from([(branch, start)]);
        while let Some((branch, start)) = open.pop_front() {
            if self.starts[branch].is_some() {
                continue;
            }
            self.starts[branch] = Some(start);
            let own = &self.scenario.branches[branch];
            for &index in &self.joints_at[branch] {
                let joint = &self.scenario.joints[index];
                if self.joints[index].is_some() {
                    continue;
                }
                let Some(arm) = joint.arms.iter().find(|arm| arm.branch == branch) else { continue };
                let end = if arm.starts_here { start } else { start.compose(&rest_pose(own, own.length)) };
                let hub = end.compose(&Pose { position: arm.offset, orientation: arm.rest }.inverse());
                self.joints[index] = Some(hub);
                for arm in &joint.arms {
                    let other = &self.scenario.branches[arm.branch];
                    let end = hub.compose(&Pose { position: arm.offset, orientation: arm.rest });
                    let back = rest_pose(other, other.length).inverse();
                    open.push_back((arm.branch, if arm.starts_here { end } else { end.compose(&back) }));
                }
            }
        }
    }
}

/// Pose at arc length `s` of a branch at rest relative to its start: with κ constant and `k = |κ|`,
/// `R(s) = exp(s [κ]ₓ)` and `x(s) = s e3 + (1 − cos ks)/k² κ × e3 + (ks − sin ks)/k³ κ × (κ × e3)`.
fn rest_pose(branch: &Branch, s: f64) -> Pose {
    let kappa = branch.curvature;
    let k = kappa.norm();
    let angle = k * s;
    // The second term loses half the digits below 1e-4 rad; there the bend itself is below 1e-4.
    let (a, b) = if angle < 1e-4 {
        (0.5 * s * s, s * s * s / 6.0)
    } else {
        ((1.0 - angle.cos()) / (k * k), (angle - angle.sin()) / (k * k * k))
    };
    let across = kappa.cross(&Vector::z());
    Pose {
        position: Vector::z() * s + across * a + kappa.cross(&across) * b,
        orientation: Rotation::from_scaled_axis(kappa * s),
    }
}

/// Pose at the arc length of a drawn path that corresponds to `s`; `None` if none is drawn.
fn along_path(branch: &Branch, s: f64) -> Option<Pose> {
    let edges = || branch.path.windows(2).map(|pair| (pair[0], pair[1] - pair[0]));
    let drawn: f64 = edges().map(|(_, edge)| edge.norm()).sum();
    let mut left = drawn * s / branch.length;
    let mut last = None;
    for (from, edge) in edges() {
        let length = edge.norm();
        let orientation = shortest(&Vector::z(), &edge);
        last = Some(Pose { position: from + edge * (left / length).min(1.0), orientation });
        if left <= length {
            break;
        }
        left -= length;
    }
    last
}
