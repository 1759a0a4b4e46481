//! A frame, the shape after an increment, as sent to pages and stored in pages that replay a run; little-endian:
//!
//! | bytes | what |
//! | --- | --- |
//! | 4 | length n of the header, a multiple of 4 |
//! | n | [`Header`] as JSON, padded with spaces |
//! | 4·[`FLOATS`] per node | quantities of every node of all branches: f32 |
//!
//! Quantities of a node: position x, y, z (m, world); d1 x, y, z; arc length (m); curvature (1/m); tension (N); bending
//! moment (N m); torque (N m); axial strain; bending strain at the surface; set, the curvature that would remain
//! without a moment (1/m; 0 of what keeps none); clearance (m; NaN if unknown).

use crate::protocol::{Place, Placed};
use serde::{Deserialize, Serialize};
#[cfg(test)]
use ts_rs::TS;
use wireloom::StepResult;
use wireloom::geometry::{Pose, Rotation, Vector, columns};
use wireloom::result::{BranchResult, ConstraintResult, JointResult, ObstacleResult};

/// Number of quantities per node.
pub const FLOATS: usize = 15;

/// Data of an increment, except its nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Header {
    /// Number of the frame.
    pub frame: u32,
    /// Name of the step.
    pub step: String,
    /// Number of the increment within the step, from 1; 0: the start.
    pub increment: u32,
    /// Status as in results: `converged`, `stalled`, `iteration-limit`...
    pub status: String,
    /// Whether the equilibrium is stable, if known.
    pub stable: Option<bool>,
    /// Iterations of this increment.
    pub iterations: u32,
    /// Computing time, s.
    pub seconds: f64,
    /// Relative residual of forces and moments.
    pub residual: f64,
    /// Joints, in the order of the scene.
    pub joints: Vec<Placed>,
    /// Active constraints.
    pub constraints: Vec<ConstraintFrame>,
    /// Obstacles, in the order of the scene.
    pub obstacles: Vec<ObstacleFrame>,
    /// Values of the joints of mechanisms, in the order of the scene, rad or m.
    pub mechanism_values: Vec<f64>,
    /// The bend nearest to its limit, or of smallest radius.
    pub tightest: Option<Tightest>,
    /// Requirements that are not kept at this equilibrium, one entry for each part of the harness.
    pub violations: Vec<Violation>,
    /// Energy by effect, J: total, stretch, shear, bend, twist, gravity, load, joint, constraint.
    pub energy: Vec<(String, f64)>,
}

/// An active constraint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct ConstraintFrame {
    /// Name.
    pub name: String,
    /// Pose of the held point.
    pub at: Placed,
    /// Force on the harness, N, world axes.
    pub force: [f64; 3],
    /// Moment on the harness, N m, world axes.
    pub moment: [f64; 3],
    /// Current arc length (m) at the constraint, if the cable slides through it.
    pub slid_to: Option<f64>,
}

/// An obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct ObstacleFrame {
    /// Pose.
    pub at: Placed,
    /// Force on the harness, N.
    pub force: [f64; 3],
    /// Number of contact points.
    pub contacts: u32,
}

/// A bend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Tightest {
    /// Branch.
    pub branch: String,
    /// Arc length, m.
    pub s: f64,
    /// Bend radius, m.
    pub radius: f64,
    /// Smallest allowed radius, m.
    pub limit: Option<f64>,
}

/// A requirement that is not kept at one equilibrium, with its worst place in one part of the harness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Violation {
    /// Name of the requirement.
    pub name: String,
    /// Measure, as in results: `bend_radius`, `tension`, `reach`...
    pub measure: String,
    /// SI unit of value and limit; empty for a pure number.
    pub unit: String,
    /// `must` or `should`.
    pub severity: String,
    /// The value farthest beyond the limit.
    pub value: f64,
    /// Its limit.
    pub limit: f64,
    /// Side of that limit: `min` or `max`.
    pub bound: String,
    /// Distance from the limit relative to it, negative. None for a limit of 0.
    pub margin: Option<f64>,
    /// Its place.
    pub place: Place,
    /// Parts of branches on which the cable is stretched, overloaded or in another one.
    pub stretches: Vec<Stretch>,
}

/// A part of a branch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Stretch {
    /// Name of the branch.
    pub branch: String,
    /// Arc length where it begins, m.
    pub from: f64,
    /// Arc length where it ends, m.
    pub to: f64,
}

impl Header {
    /// Header of an increment. `before`: the previous increment, whose work is subtracted if it belongs to the same
    /// step.
    pub fn of(frame: u32, end: &StepResult, before: Option<&StepResult>) -> Self {
        let before = before.filter(|before| before.name == end.name && before.increment < end.increment);
        let done = before.map_or((0, 0.0), |before| (before.minimiser.iterations, before.minimiser.seconds));
        let energy = &end.energy;
        let effects = [
            ("total", energy.total()),
            ("stretch", energy.stretch),
            ("shear", energy.shear),
            ("bend", energy.bend),
            ("twist", energy.twist),
            ("gravity", energy.gravity),
            ("load", energy.load),
            ("joint", energy.joint),
            ("constraint", energy.constraint),
        ];
        Self {
            frame,
            step: end.name.clone(),
            increment: number(end.increment),
            status: end.status.word().to_owned(),
            stable: end.stable,
            iterations: number(end.minimiser.iterations.saturating_sub(done.0)),
            seconds: (end.minimiser.seconds - done.1).max(0.0),
            residual: end.minimiser.force_residual,
            joints: end.joints.iter().map(Placed::joint).collect(),
            constraints: end.constraints.iter().map(ConstraintFrame::of).collect(),
            obstacles: end.obstacles.iter().map(ObstacleFrame::of).collect(),
            mechanism_values: mechanism_values(end),
            tightest: end.min_bend_radius.as_ref().map(|bend| Tightest {
                branch: bend.branch.clone(),
                s: bend.s,
                radius: bend.value,
                limit: bend.limit,
            }),
            violations: end.violations.iter().map(|own| Violation::of(own, end)).collect(),
            energy: effects.map(|(effect, joules)| (effect.to_owned(), joules)).into(),
        }
    }

    /// Encodes the frame: this header and the bytes of [`nodes`].
    pub fn encode(&self, nodes: &[u8]) -> Vec<u8> {
        let mut head = serde_json::to_vec(self).expect("strings, numbers and lists of them");
        head.resize(head.len().next_multiple_of(4), b' ');
        [&number(head.len()).to_le_bytes(), head.as_slice(), nodes].concat()
    }
}

/// Quantities of every node of all branches, as bytes. `clearance` (m): one value per node, or empty if unknown.
pub fn nodes(branches: &[BranchResult], clearance: &[f64]) -> Vec<u8> {
    let count: usize = branches.iter().map(|branch| branch.s.len()).sum();
    let mut bytes = Vec::with_capacity(4 * FLOATS * count);
    let all = branches.iter().flat_map(|branch| (0..branch.s.len()).map(move |node| values(branch, node)));
    for (node, mut values) in all.enumerate() {
        values[FLOATS - 1] = clearance.get(node).copied().unwrap_or(f64::NAN);
        bytes.extend(values.iter().flat_map(|value| (*value as f32).to_le_bytes()));
    }
    bytes
}

/// Header and nodes of an encoded frame; `None` if the bytes are invalid.
pub fn decode(bytes: &[u8]) -> Option<(Header, Vec<[f32; FLOATS]>)> {
    let (head, nodes) = parts(bytes)?;
    Some((serde_json::from_slice(head).ok()?, floats(nodes)?))
}

/// Header of an encoded frame; `None` if the bytes are invalid.
pub fn header(bytes: &[u8]) -> Option<Header> {
    serde_json::from_slice(parts(bytes)?.0).ok()
}

/// Header and nodes as bytes.
fn parts(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk::<4>()?;
    rest.split_at_checked(u32::from_le_bytes(*length) as usize)
}

/// Decodes the output of [`nodes`].
pub(crate) fn floats(nodes: &[u8]) -> Option<Vec<[f32; FLOATS]>> {
    let (all, rest) = nodes.as_chunks::<4>();
    let numbers: Vec<f32> = all.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    let (each, left) = numbers.as_chunks::<FLOATS>();
    (rest.is_empty() && left.is_empty()).then(|| each.to_vec())
}

/// Quantities of a node, except its clearance.
fn values(branch: &BranchResult, node: usize) -> [f64; FLOATS] {
    let (x, [d1, _, d3]) = (branch.position[node], columns(&branch.frame[node]));
    let (force, moment) = (branch.force[node], branch.moment[node]);
    let torque = moment.dot(&d3);
    [
        x.x,
        x.y,
        x.z,
        d1.x,
        d1.y,
        d1.z,
        branch.s[node],
        1.0 / branch.bend_radius[node],
        force.dot(&d3),
        (moment - d3 * torque).norm(),
        torque,
        branch.strain_at(node),
        0.5 * branch.diameter_at(node) / branch.bend_radius[node],
        branch.friction.as_ref().map_or(0.0, |friction| friction.set[node].xy().norm()),
        f64::NAN,
    ]
}

impl Placed {
    /// A position (m) and an orientation.
    pub fn at(position: &Vector, orientation: &Rotation) -> Self {
        let q = orientation;
        Self { position: (*position).into(), orientation: [q.w, q.i, q.j, q.k] }
    }

    /// The pose; `None` if a number is not finite, or the quaternion has the length 0.
    pub(crate) fn pose(&self) -> Option<Pose> {
        let orientation = wireloom::scenario::record::rotation(self.orientation)?;
        let numbers = self.position.iter().chain(&self.orientation);
        numbers.copied().all(f64::is_finite).then(|| Pose { position: self.position.into(), orientation })
    }

    fn joint(joint: &JointResult) -> Self {
        Self::at(&joint.position, &joint.orientation)
    }
}

impl ConstraintFrame {
    fn of(constraint: &ConstraintResult) -> Self {
        Self {
            name: constraint.name.clone(),
            at: Placed::at(&constraint.position, &constraint.orientation),
            force: constraint.force.into(),
            moment: constraint.moment.into(),
            slid_to: constraint.slide.as_ref().map(|slide| slide.arc_length),
        }
    }
}

impl ObstacleFrame {
    fn of(body: &ObstacleResult) -> Self {
        let at = Placed::at(&body.pose.position, &body.pose.orientation);
        Self { at, force: body.force.into(), contacts: number(body.contacts) }
    }
}

/// Values of the joints of mechanisms that have one.
pub(crate) fn mechanism_values(end: &StepResult) -> Vec<f64> {
    let joints = end.mechanisms.iter().flat_map(|own| &own.joints);
    joints.filter_map(|(_, values)| if let [value] = values[..] { Some(value) } else { None }).collect()
}

/// A count as the protocol has it.
pub(crate) fn number(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
