//! Data of everything that acts on a harness at one moment: targets, memories, multipliers, contact, friction, sliding.

use crate::load::LoadAction;
use crate::mechanism::{Mechanism, Mount};
use crate::network::{AttachedConstraint, Joint};
use crate::{Matrix, Network, Pose, State, Vector};
use serde::{Deserialize, Serialize};

/// First penalty of a constraint's equations, in units of (force scale × length scale) / (scale of the residual)²:
/// far stiffer than a cable in bending, so that every update of the multipliers reduces the residual by three or four
/// orders of magnitude. In a taut cable the penalty is raised.
const FIRST_PENALTY: f64 = 1e4;

/// Everything that acts on the harness at one moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Conditions {
    /// Gravity, m/s².
    pub gravity: Vector,
    /// Rotation of the axes in which the harness is at rest.
    pub rotation: RotatingAxes,
    /// Factor of each load.
    pub load_factors: Vec<f64>,
    /// Temperature of each branch, less that at which it has its rest shape, K.
    pub temperatures: Vec<f64>,
    /// Whether each constraint acts.
    pub active: Vec<bool>,
    /// Target pose of the first station of each constraint.
    pub targets: Vec<Pose>,
    /// State of each constraint.
    pub constraints: Vec<ConstraintState>,
    /// State of each rod, by branch.
    pub rods: Vec<RodState>,
    /// State of each joint.
    pub joints: Vec<JointState>,
    /// Time since the beginning of the run, s; the initial equilibrium is at 0.
    pub time: f64,
    /// Time at which the memories of rods and joints were last updated, s.
    pub committed_time: f64,
    /// State of each sliding constraint of [`Network::slides`]; used while it acts.
    pub sliding: Vec<Sliding>,
    /// Poses of obstacles, and contact records.
    pub contact: ContactState,
    /// Values of the joints of each mechanism, rad and m.
    pub mechanisms: Vec<Vec<f64>>,
}

impl Conditions {
    /// Conditions at the start of a run: the target of every constraint is the pose of its station at `state`, and
    /// nothing slides.
    pub fn new(network: &Network, gravity: Vector, state: &State) -> Self {
        let constraints: Vec<ConstraintState> =
            network.constraints.iter().map(|c| ConstraintState::begin(c, state)).collect();
        let with_states = network.constraints.iter().zip(&constraints);
        Self {
            gravity,
            rotation: RotatingAxes::default(),
            load_factors: network.loads.iter().map(|load| load.factor).collect(),
            temperatures: vec![0.0; network.branches.len()],
            active: network.constraints.iter().map(|c| c.from_start).collect(),
            targets: with_states.map(|(c, own)| c.model.target(&own.base, 0.0)).collect(),
            constraints,
            rods: network.branches.iter().map(|b| RodState { memory: b.rod.memory(), dissipated: [0.0; 2] }).collect(),
            joints: network.joints.iter().map(JointState::at_rest).collect(),
            time: 0.0,
            committed_time: 0.0,
            sliding: vec![Sliding::Stuck; network.slides.len()],
            contact: ContactState::new(network),
            mechanisms: network.mechanisms.iter().map(Mechanism::drawn).collect(),
        }
    }

    /// Pose of the body on which something is mounted; the identity for what is mounted on none.
    pub fn body(&self, network: &Network, mount: Option<Mount>) -> Pose {
        let of =
            |mount: Mount| network.mechanisms[mount.mechanism].poses(&self.mechanisms[mount.mechanism])[mount.body];
        mount.map_or_else(Pose::identity, of)
    }

    /// Position that the scenario gives a constraint, in the world, with its body where it is now, m.
    pub fn given_position(&self, network: &Network, constraint: usize) -> Option<Vector> {
        let own = &network.constraints[constraint];
        Some(self.body(network, own.mount).world(&own.position?))
    }
}

/// Axes that rotate steadily about a fixed line. In them every mass is pulled away from the line: `E = −½ m |ω × r|²`
/// with r from a point of the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RotatingAxes {
    /// A point of the line, m.
    pub point: Vector,
    /// ω, rad/s, along the line.
    pub velocity: Vector,
}

impl RotatingAxes {
    /// Whether they rotate.
    pub fn is_moving(&self) -> bool {
        self.velocity != Vector::zeros()
    }

    /// Potential per mass at x, m²/s².
    pub fn potential(&self, x: &Vector) -> f64 {
        -0.5 * self.velocity.cross(&(x - self.point)).norm_squared()
    }

    /// Centrifugal acceleration at x, `−ω × (ω × r)`, m/s².
    pub fn pull(&self, x: &Vector) -> Vector {
        -self.velocity.cross(&self.velocity.cross(&(x - self.point)))
    }

    /// Second derivative of the potential, `ω ωᵀ − |ω|² I`, 1/s²: nowhere positive.
    pub fn hessian(&self) -> Matrix {
        self.velocity * self.velocity.transpose() - Matrix::identity() * self.velocity.norm_squared()
    }
}

/// State of a constraint from one equilibrium to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConstraintState {
    /// Target of its first station as the scenario gives it, before [`crate::Constraint::target`] is applied.
    pub base: Pose,
    /// Poses of its further stations relative to the first when it began to act.
    pub beside: Vec<Pose>,
    /// See [`crate::ConstraintView::progress`].
    pub progress: f64,
    /// See [`crate::Constraint::memory`].
    pub memory: Vec<f64>,
    /// λ of each residual.
    pub multipliers: Vec<f64>,
    /// ρ of each residual, in units of (force scale × length scale) / (scale of the residual)².
    pub penalties: Vec<f64>,
}

impl ConstraintState {
    /// State of a constraint that begins to act at `state`, with the pose of its first station as the target.
    pub fn begin(constraint: &AttachedConstraint, state: &State) -> Self {
        let base = state.pose(&constraint.site);
        let further = constraint.stations.iter().skip(1);
        Self {
            base,
            beside: further.map(|site| base.inverse().compose(&state.pose(site))).collect(),
            progress: 0.0,
            memory: constraint.model.memory(),
            multipliers: vec![0.0; constraint.residuals.len()],
            penalties: vec![FIRST_PENALTY; constraint.residuals.len()],
        }
    }
}

/// State of a rod from one equilibrium to the next.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RodState {
    /// See [`crate::RodSegment::memory`]; empty for an elastic rod.
    pub memory: Vec<f64>,
    /// Energy dissipated in the last increment, and since the beginning of the run, J.
    pub dissipated: [f64; 2],
}

/// State of a joint from one equilibrium to the next.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// See [`crate::JointModel::memory`]; empty for an elastic joint.
    pub memory: Vec<f64>,
    /// Energy dissipated at each arm in the last increment, and since the beginning of the run, J; empty for an elastic
    /// joint.
    pub dissipated: Vec<[f64; 2]>,
}

impl JointState {
    /// State of a joint at rest.
    pub fn at_rest(joint: &Joint) -> Self {
        let memory = joint.model.memory();
        let arms = if memory.is_empty() { 0 } else { joint.arms.len() };
        Self { memory, dissipated: vec![[0.0; 2]; arms] }
    }

    /// Whether its lengths are those of the state of this joint.
    pub fn fits(&self, joint: &Joint) -> bool {
        let other = Self::at_rest(joint);
        (self.memory.len(), self.dissipated.len()) == (other.memory.len(), other.dissipated.len())
    }
}

/// State of a sliding constraint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Sliding {
    /// Its arc length is fixed; the axial force is a reaction.
    Stuck,
    /// The cable slides through. `force` (N) acts on the arc length against the motion: friction, or 0.
    Running {
        /// Constant generalised force on the arc length: `∂E/∂s + force = 0` at rest, N.
        force: f64,
    },
}

/// What a cable touches, by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Against {
    /// An obstacle.
    Obstacle(usize),
    /// A branch, which may be itself.
    Branch(usize),
}

/// Contact point: a place of a cable, between nodes `segment` and `segment + 1` of a branch, where contact is
/// evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactPoint {
    /// Index of the branch.
    pub branch: usize,
    /// Index of the segment.
    pub segment: usize,
    /// Position on the segment as a fraction of its length: 0 at its first node, 1 at its second.
    pub fraction: f64,
    /// Along what it follows the nearest place; it touches nothing else.
    pub follows: Option<Against>,
}

impl ContactPoint {
    /// One that stays in the material.
    pub fn new(branch: usize, segment: usize, fraction: f64) -> Self {
        Self { branch, segment, fraction, follows: None }
    }

    /// Position at `state`, m.
    pub fn position(&self, network: &Network, state: &State) -> Vector {
        let i = network.branches[self.branch].points.start + self.segment;
        let (a, b) = (state.points[i] + state.compensation[i], state.points[i + 1] + state.compensation[i + 1]);
        a + (b - a) * self.fraction
    }

    /// Arc length at `state`, m.
    pub fn arc_length(&self, network: &Network, state: &State) -> f64 {
        let lengths = &state.rest_lengths[network.branches[self.branch].points.start..];
        lengths[..self.segment].iter().sum::<f64>() + lengths[self.segment] * self.fraction
    }
}

/// Partner of a contact point: the surface that it touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Partner {
    /// An obstacle.
    Obstacle {
        /// Index of the obstacle.
        obstacle: u32,
        /// Part of its surface.
        part: u32,
    },
    /// A cable.
    Cable {
        /// Index of the branch.
        branch: u32,
        /// Index of the segment.
        segment: u32,
    },
}

impl Partner {
    /// Index of the obstacle, if it is one.
    pub fn obstacle(self) -> Option<u32> {
        match self {
            Partner::Obstacle { obstacle, .. } => Some(obstacle),
            Partner::Cable { .. } => None,
        }
    }

    /// Index of the branch, if it is a cable.
    pub fn branch(self) -> Option<usize> {
        match self {
            Partner::Obstacle { .. } => None,
            Partner::Cable { branch, .. } => Some(branch as usize),
        }
    }
}

/// Contact record: multiplier, penalty and friction of a contact point and its partner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactRecord {
    /// Index of the contact point.
    pub point: u32,
    /// Its partner.
    pub partner: Partner,
    /// λ, N.
    pub multiplier: f64,
    /// ρ in units of the initial penalty of the branch.
    pub penalty: f64,
    /// Friction anchor; `None` where the partner is smooth.
    pub anchor: Option<FrictionAnchor>,
}

/// Friction anchor: the place of an obstacle or of another cable to which a tangential spring connects a contact point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrictionAnchor {
    /// Position, m: in the axes of the obstacle; on a cable relative to the centre line, in the axes of the segment's
    /// frame.
    pub(crate) position: Vector,
    /// Unit normal n, in the same axes.
    pub(crate) normal: Vector,
    /// Normal force N, N.
    pub force: f64,
    /// Contact places of two cables; `None` on an obstacle.
    pub(crate) bond: Option<Bond>,
}

/// Contact places of two cables between which friction acts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Bond {
    /// Position on the segment of the partner, as a fraction of its length.
    pub(crate) fraction: f64,
    /// Vector from the contact point to the surface of its own cable, in the axes of its segment's frame, m.
    pub(crate) lever: Vector,
}

/// Permitted overlap of two cables that overlapped at the start of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Overlap {
    /// Index of the contact point.
    pub point: u32,
    /// Index of the other branch.
    pub branch: u32,
    /// Least permitted distance of the centre lines, m.
    pub distance: f64,
    /// Sum of both radii there, m: where that is another one, as deep an overlap is permitted.
    pub both: f64,
}

/// Two segments of cables that cross: they touch on arcs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Crossing {
    /// The segments (branch, segment), the lower one first.
    pub segments: [(usize, usize); 2],
    /// Whether they still cross; if not, they touch on chords until the end of the increment, so that they do not go to
    /// and fro between both.
    pub acts: bool,
}

/// State of contact from one equilibrium to the next.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactState {
    /// Pose of each obstacle.
    pub poses: Vec<Pose>,
    /// Whether friction acts: not while the initial equilibrium is being found.
    pub friction: bool,
    /// Contact points added to the permanent ones of the network.
    pub extra: Vec<ContactPoint>,
    /// Sorted by contact point, then by partner.
    pub records: Vec<ContactRecord>,
    /// Sorted by contact point and branch.
    pub overlaps: Vec<Overlap>,
    /// x″ of the centre line at each point, 1/m, by which it is beside its chords where it touches something; empty
    /// before the first update.
    pub bends: Vec<Vector>,
    /// Crossing segments of cables, in order.
    pub crossings: Vec<Crossing>,
}

impl ContactState {
    /// Initial state: nothing touches.
    pub fn new(network: &Network) -> Self {
        Self { poses: network.obstacles.iter().map(|o| o.pose).collect(), ..Self::default() }
    }

    /// Records of a contact point.
    pub fn records_of(&self, point: u32) -> &[ContactRecord] {
        let from = self.records.partition_point(|record| record.point < point);
        let records = &self.records[from..];
        &records[..records.partition_point(|record| record.point == point)]
    }

    /// Record of a contact point and a partner.
    pub fn record_of(&self, point: u32, partner: Partner) -> Option<&ContactRecord> {
        self.records_of(point).iter().find(|record| record.partner == partner)
    }

    /// Crossing of two segments (branch, segment).
    pub fn crossing(&self, a: (usize, usize), b: (usize, usize)) -> Option<&Crossing> {
        let at = self.crossings.binary_search_by(|crossing| crossing.segments.cmp(&[a.min(b), a.max(b)]));
        Some(&self.crossings[at.ok()?])
    }

    /// Whether two segments (branch, segment) touch on arcs.
    pub fn cross(&self, a: (usize, usize), b: (usize, usize)) -> bool {
        self.crossing(a, b).is_some_and(|crossing| crossing.acts)
    }

    /// Records with friction against another cable, each with the branch and the segment of that cable.
    pub(crate) fn bound_cables(&self) -> impl Iterator<Item = (&ContactRecord, [usize; 2])> {
        self.records.iter().filter_map(|record| match record.partner {
            Partner::Cable { branch, segment } if record.anchor.is_some() => {
                Some((record, [branch as usize, segment as usize]))
            }
            _ => None,
        })
    }
}

/// Network and conditions: everything besides the state that a term of the energy reads.
#[derive(Clone, Copy)]
pub struct System<'a> {
    /// The harness.
    pub network: &'a Network,
    /// The conditions.
    pub conditions: &'a Conditions,
}

impl<'a> System<'a> {
    /// Coefficient of friction of a partner, where friction acts.
    pub fn friction_coefficient(&self, partner: Partner) -> f64 {
        match partner {
            _ if !self.conditions.contact.friction => 0.0,
            Partner::Obstacle { obstacle, .. } => self.network.obstacles[obstacle as usize].friction,
            Partner::Cable { .. } => self.network.contact.friction,
        }
    }

    /// Constraints that act, with their indices.
    pub fn acting(self) -> impl Iterator<Item = (usize, &'a AttachedConstraint)> {
        self.network.constraints.iter().enumerate().filter(move |(c, _)| self.conditions.active[*c])
    }

    /// Joints with their states.
    pub fn joints(self) -> impl Iterator<Item = (&'a Joint, &'a JointState)> {
        self.network.joints.iter().zip(&self.conditions.joints)
    }

    /// Nodes of a branch that are fixed in the material or in space, in increasing order: ends, constraints that act,
    /// loads.
    pub fn knots(self, branch: usize) -> Vec<usize> {
        let points = &self.network.branches[branch].points;
        let of_constraints =
            self.acting().flat_map(|(_, constraint)| &constraint.places).filter_map(|place| match place {
                crate::network::Place::Node { branch: b, node } if *b == branch => Some(*node),
                _ => None,
            });
        let of_loads = self.network.loads.iter().filter_map(|load| match &load.action {
            LoadAction::At { place, .. } if points.contains(&place.point) => Some(place.point - points.start),
            _ => None,
        });
        let changes = self.network.branches[branch].sections.changes();
        let mut knots: Vec<usize> =
            of_constraints.chain(of_loads).chain(changes).chain([0, points.len() - 1]).collect();
        knots.sort_unstable();
        knots.dedup();
        knots
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The potential is a quadratic function: central differences are exact to round-off.
    #[test]
    fn the_pull_of_axes_that_rotate_is_the_slope_of_its_potential() {
        let axes = RotatingAxes { point: Vector::new(0.3, -0.2, 0.5), velocity: Vector::new(3.0, -5.0, 7.0) };
        let x = Vector::new(-0.4, 0.8, 0.1);
        for k in 0..3 {
            let step = Vector::ith(k, 0.5);
            let slope = axes.potential(&(x + step)) - axes.potential(&(x - step));
            assert!((slope + axes.pull(&x)[k]).abs() < 1e-12, "{slope}");
            let change = axes.pull(&(x + step)) - axes.pull(&(x - step));
            assert!((change + axes.hessian().column(k)).norm() < 1e-12, "{change}");
        }
        // Nothing along the axis; ω² r away from it.
        assert!(axes.pull(&(axes.point + axes.velocity)).norm() < 1e-12);
        let away = axes.velocity.cross(&Vector::x());
        assert!((axes.pull(&(axes.point + away)) - away * axes.velocity.norm_squared()).norm() < 1e-9);
    }
}
