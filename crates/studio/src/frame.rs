//! A shape as it goes over the wire, and into pages that replay a run: little-endian,
//!
//! | bytes | what |
//! | --- | --- |
//! | 4 | length n of the header, a multiple of 4 |
//! | n | [`Header`] as JSON, padded with spaces |
//! | 4·[`FLOATS`] a node | what is known of every node, branch after branch: f32 |
//!
//! Of a node: position x, y, z (m, world); d1 x, y, z; arc length (m); curvature (1/m); tension (N); bending moment (N m); torque (N m);
//! clearance (m; NaN where it is not known).

use serde::{Deserialize, Serialize};
#[cfg(test)]
use ts_rs::TS;
use wireloom::core::equilibrium::{BranchResult, ConstraintResult, JointResult, ObstacleResult, StepResult};
use wireloom::core::rotation::columns;
use wireloom::core::{Rotation, Vector};

/// Numbers a node.
pub const FLOATS: usize = 12;

/// What is known of an increment's end beside its nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Header {
    /// Number of the frame.
    pub frame: u32,
    /// Name of the step.
    pub step: String,
    /// Which increment of it, from 1; 0: the start.
    pub increment: u32,
    /// As results call it: `converged`, `stalled`, `iteration-limit`...
    pub status: String,
    /// Whether the equilibrium is stable, where that is known.
    pub stable: Option<bool>,
    /// Iterations of this increment.
    pub iterations: u32,
    /// What it took to compute, s.
    pub seconds: f64,
    /// Relative residual of forces and moments.
    pub residual: f64,
    /// Joints, in the order of the scene.
    pub joints: Vec<Placed>,
    /// Constraints that act.
    pub constraints: Vec<ConstraintFrame>,
    /// Bodies, in the order of the scene.
    pub obstacles: Vec<ObstacleFrame>,
    /// The bend nearest to its limit, or of least radius.
    pub tightest: Option<Tightest>,
    /// Energy by effect, J: total, stretch, shear, bend, twist, gravity, load, joint, constraint.
    pub energy: Vec<(String, f64)>,
}

/// Where something is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct Placed {
    /// Position, m.
    pub position: [f64; 3],
    /// Orientation `[w, x, y, z]`.
    pub orientation: [f64; 4],
}

/// A constraint that acts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct ConstraintFrame {
    /// Name.
    pub name: String,
    /// Where the cable is held.
    pub at: Placed,
    /// Force on the harness, N, world axes.
    pub force: [f64; 3],
    /// Moment on the harness, N m, world axes.
    pub moment: [f64; 3],
    /// Arc length at it now (m), where the cable slides through.
    pub slid_to: Option<f64>,
}

/// A body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
pub struct ObstacleFrame {
    /// Where it stands.
    pub at: Placed,
    /// Force on the harness, N.
    pub force: [f64; 3],
    /// Number of places where it touches.
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
    /// Least allowed, m.
    pub limit: Option<f64>,
}

impl Header {
    /// Of an increment's end. `before`: the increment before it, whose work is no part of this one's if it belongs to the same step.
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
            tightest: end.min_bend_radius.as_ref().map(|bend| Tightest {
                branch: bend.branch.clone(),
                s: bend.s,
                radius: bend.value,
                limit: bend.limit,
            }),
            energy: effects.map(|(effect, joules)| (effect.to_owned(), joules)).into(),
        }
    }

    /// The frame's bytes: this and what [`nodes`] says of the branches.
    pub fn encode(&self, nodes: &[u8]) -> Vec<u8> {
        let mut head = serde_json::to_vec(self).expect("strings, numbers and lists of them");
        head.resize(head.len().next_multiple_of(4), b' ');
        [&number(head.len()).to_le_bytes(), head.as_slice(), nodes].concat()
    }
}

/// What is known of every node, branch after branch, as bytes. `clearance` (m): of every node; empty where it is not known.
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

/// Header and nodes of a frame's bytes; `None` where they are none.
pub fn decode(bytes: &[u8]) -> Option<(Header, Vec<[f32; FLOATS]>)> {
    let (head, nodes) = parts(bytes)?;
    Some((serde_json::from_slice(head).ok()?, floats(nodes)?))
}

/// Header of a frame's bytes; `None` where they are none.
pub fn header(bytes: &[u8]) -> Option<Header> {
    serde_json::from_slice(parts(bytes)?.0).ok()
}

/// Header and nodes as bytes.
fn parts(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk::<4>()?;
    rest.split_at_checked(u32::from_le_bytes(*length) as usize)
}

/// What [`nodes`] has made.
pub(crate) fn floats(nodes: &[u8]) -> Option<Vec<[f32; FLOATS]>> {
    let (all, rest) = nodes.as_chunks::<4>();
    let numbers: Vec<f32> = all.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    let (each, left) = numbers.as_chunks::<FLOATS>();
    (rest.is_empty() && left.is_empty()).then(|| each.to_vec())
}

/// What is known of a node but its clearance.
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
        f64::NAN,
    ]
}

impl Placed {
    /// A position (m) and an orientation.
    pub fn at(position: &Vector, orientation: &Rotation) -> Self {
        let q = orientation;
        Self { position: (*position).into(), orientation: [q.w, q.i, q.j, q.k] }
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

/// A count as pages have it.
pub(crate) fn number(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
