//! Results of a run in SI units: shapes, internal forces, reactions, energies, events, and data on the solution
//! process.

mod deviation;

pub use crate::event::{Event, EventKind, EventPlace, Moment};
use crate::identity::Identities;
pub use crate::requirement::{RequirementResult, Violation};
use crate::requirement::{Verdict, verdict};
use crate::sections::{Bend, SectionResult};
use crate::status::Status;
use crate::{Pose, Rotation, Vector};
pub use deviation::{Deviation, DeviationCause};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

/// Result of a whole run.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Name of the scenario.
    pub scenario: String,
    /// How it ended.
    pub outcome: Outcome,
    /// Remarks on the harness and its initial equilibrium, for example wires that end in a joint.
    pub notes: Vec<String>,
    /// Events during the run, in the order in which they began.
    pub events: Vec<Event>,
    /// The last increment of each step, or all of them.
    pub steps: Vec<StepResult>,
    /// Least clearances of the cables over all increments.
    pub clearances: Vec<Clearance>,
    /// The sheet: whether each requirement is kept over all increments.
    pub requirements: Vec<RequirementResult>,
    /// Plugin libraries that were used.
    pub plugins: Vec<Library>,
    /// Part numbers and the like.
    pub identities: Arc<Identities>,
    /// Comparison of its end with the equilibrium from the drawn lines; `None` where the harness starts as it is drawn.
    pub drawn_start: Option<DrawnStart>,
    /// What lengths and places do to the requirements, if it was asked for.
    pub sensitivities: Vec<RequirementSensitivity>,
}

/// How a run ended. A run with a fault has no other status than failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// As the certificate graded its increments: the status of the first one that did not converge, otherwise
    /// converged; or interrupted.
    Graded(Status),
    /// By a fault of a rod, a joint, a constraint or the minimiser.
    Fault(PartFault),
}

impl Run {
    /// Status of the run; failed if a part has a fault.
    pub fn status(&self) -> Status {
        match self.outcome {
            Outcome::Graded(status) => status,
            Outcome::Fault(_) => Status::Failed,
        }
    }

    /// Fault of a rod, a joint, a constraint or the minimiser that ended the run early.
    pub fn fault(&self) -> Option<&PartFault> {
        match &self.outcome {
            Outcome::Graded(_) => None,
            Outcome::Fault(fault) => Some(fault),
        }
    }

    /// Verdict on the harness: pass, fail or unresolved. A run that did not converge never passes.
    pub fn verdict(&self) -> Verdict {
        match verdict(&self.requirements) {
            Verdict::Pass if self.status() != Status::Converged => Verdict::Unresolved,
            verdict => verdict,
        }
    }
}

/// Family of a part that a plugin may implement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartFamily {
    /// A constraint.
    Constraint,
    /// A joint.
    Joint,
    /// The rod of a branch, named by that.
    Rod,
    /// The minimiser, whose kind is its name.
    Minimiser,
}

impl PartFamily {
    /// Word used in results and scenarios.
    pub fn word(self) -> &'static str {
        match self {
            PartFamily::Constraint => "constraint",
            PartFamily::Joint => "joint",
            PartFamily::Rod => "rod",
            PartFamily::Minimiser => "minimiser",
        }
    }
}

/// Fatal fault of a constraint, joint, rod or minimiser: its results are invalid, and the increment in which it
/// occurred is not part of the result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartFault {
    /// Its family.
    pub family: PartFamily,
    /// Its name; of a rod that of its branch.
    pub name: String,
    /// Its kind or model.
    pub kind: String,
    /// Step.
    pub step: String,
    /// Index of the increment, from 1; 0: while the initial equilibrium was being found.
    pub increment: usize,
    /// Description of the fault.
    pub message: String,
}

/// "constraint `tie` (cable-tie) in step `pull`, increment 3: …".
impl fmt::Display for PartFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { family, name, kind, step, increment, message } = self;
        write!(f, "{} `{name}` ({kind}) in step `{step}`, ", family.word())?;
        match increment {
            0 => f.write_str("while the start was being found")?,
            increment => write!(f, "increment {increment}")?,
        }
        write!(f, ": {message}")
    }
}

/// A plugin library.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Library {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// Path of its file.
    pub file: String,
    /// SHA-256 of the file, hexadecimal.
    pub hash: String,
}

impl fmt::Display for Library {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "plugin `{}` {} from {} (SHA-256 {})", self.name, self.version, self.file, self.hash)
    }
}

/// Result at the end of one increment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepResult {
    /// Name of the step.
    pub name: String,
    /// Index of the increment, from 1.
    pub increment: usize,
    /// Increments of the step.
    pub increments: usize,
    /// Status.
    pub status: Status,
    /// Branches, in the order of the scenario.
    pub branches: Vec<BranchResult>,
    /// Joints.
    pub joints: Vec<JointResult>,
    /// Constraints that act.
    pub constraints: Vec<ConstraintResult>,
    /// Obstacles.
    pub obstacles: Vec<ObstacleResult>,
    /// Mechanisms.
    pub mechanisms: Vec<MechanismResult>,
    /// Markers.
    pub markers: Vec<MarkerResult>,
    /// Results of the operations of the step, in the order of the scenario: grasps, carries, mates, clips.
    pub operations: Vec<OperationResult>,
    /// Energy by effect.
    pub energy: Energy,
    /// Critical bend of the whole harness: the one nearest to its limit, or furthest beyond it; without limits, the one
    /// of least radius. `None` where everything is straight.
    pub min_bend_radius: Option<TightestBend>,
    /// Requirements that are not kept at this equilibrium, one entry for each part of the harness; empty where the
    /// increment did not end in an equilibrium.
    pub violations: Vec<Violation>,
    /// Whether the equilibrium is stable; `None` where that cannot be decided: an eigenvalue is zero to round-off, the
    /// state is not an equilibrium, or a load without a potential acts (then `Some(false)` where it
    /// certainly diverges, or `None`).
    pub stable: Option<bool>,
    /// Data on the solution process.
    pub minimiser: MinimiserResult,
}

/// Clearance: the least distance between the surfaces of a branch and of another object over a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clearance {
    /// Branch.
    pub branch: String,
    /// The other object.
    pub from: ClearanceFrom,
    /// Distance, m; negative where they overlap.
    pub distance: f64,
    /// Arc length of the nearest point of the branch, m.
    pub s: f64,
    /// Position of that point on the centre line, m.
    pub position: Vector,
    /// Required clearance, m.
    pub required: Option<f64>,
    /// The increment in which it occurred.
    pub moment: Moment,
}

impl Clearance {
    /// Whether it is less than required.
    pub fn is_short(&self) -> bool {
        self.required.is_some_and(|required| self.distance < required)
    }
}

/// Object that a branch is near to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ClearanceFrom {
    /// An obstacle, by name.
    Obstacle(String),
    /// Another branch.
    Branch {
        /// Its name.
        name: String,
        /// Arc length of its nearest point, m.
        s: f64,
    },
}

impl fmt::Display for ClearanceFrom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Obstacle(name) => write!(f, "obstacle `{name}`"),
            Self::Branch { name, s } => write!(f, "branch `{name}` at s = {:.1} mm", 1e3 * s),
        }
    }
}

/// An obstacle and its load on the harness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObstacleResult {
    /// Name.
    pub name: String,
    /// Its pose.
    pub pose: Pose,
    /// Force on the harness, N, world axes.
    pub force: Vector,
    /// Moment on the harness about the obstacle's position, N m, world axes.
    pub moment: Vector,
    /// Sum of the sizes of its contact forces, N: on both sides of a tube they add up.
    pub contact_force: f64,
    /// Number of contact points with a force.
    pub contacts: usize,
    /// Largest penetration depth of a contact point, m.
    pub depth: f64,
}

/// A mechanism.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MechanismResult {
    /// Name.
    pub name: String,
    /// Names of its joints, each with the values of its freedoms, rad and m.
    pub joints: Vec<(String, Vec<f64>)>,
}

/// A marker.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MarkerResult {
    /// Name.
    pub name: String,
    /// Position on the centre line, m.
    pub position: Vector,
}

/// One branch; vectors have one entry for each node. Where force, moment and curvature jump at a constraint inside the
/// branch, the values are those of the side that is bent more tightly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BranchResult {
    /// Name.
    pub name: String,
    /// Diameter, m; the greatest one where it changes.
    pub diameter: f64,
    /// Smallest bend radius allowed, m; the greatest one where it changes.
    pub bend_radius_limit: Option<f64>,
    /// Axial stiffness EA, N, at its start; with an axial law that of small tension.
    pub axial_stiffness: f64,
    /// Its parts with sections of their own, in the order of arc length; empty where its section does not change.
    pub sections: Vec<SectionResult>,
    /// Axial strain at each node, of a section that changes or has an axial law; `None`: it is the tension over EA.
    pub strain: Option<Vec<f64>>,
    /// Arc length, m.
    pub s: Vec<f64>,
    /// Position of the centre line, m, world; it differs from the node by ℓ² x″/24.
    pub position: Vec<Vector>,
    /// Frame; its columns are d1, d2, d3.
    pub frame: Vec<Rotation>,
    /// Internal force that the part with larger s exerts on the part with smaller s, N, world.
    pub force: Vec<Vector>,
    /// Internal moment, N m, world.
    pub moment: Vec<Vector>,
    /// Bend radius, m; infinite where straight.
    pub bend_radius: Vec<f64>,
    /// Both sides of the nodes within the branch at which something attaches, in their order: there force and moment
    /// jump, and the values above are those of the tighter bend. Results that are read from a file have none.
    pub sides: Vec<NodeSides>,
    /// Total material twist of the branch, turns.
    pub twist_turns: f64,
    /// Estimated discretisation error; `None` where there are no numbers to estimate it from.
    pub error: Option<BranchError>,
    /// Distance from the drawn centre line; `None` where none is drawn.
    pub deviation: Option<Deviation>,
    /// What has slipped, yielded or crept within its section; `None` for an elastic one.
    pub friction: Option<FrictionResult>,
}

/// Values before and after a node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodeSides {
    /// Index of the node.
    pub node: usize,
    /// Internal force, N, world.
    pub force: [Vector; 2],
    /// Internal moment, N m, world.
    pub moment: [Vector; 2],
    /// Bend radius, m.
    pub bend_radius: [f64; 2],
}

impl BranchResult {
    /// Tension at a node, N.
    pub fn tension_at(&self, node: usize) -> f64 {
        self.force[node].dot(&(self.frame[node] * Vector::z()))
    }

    /// Tensions before and behind a node, N; 0 beyond the ends.
    pub fn tensions_beside(&self, node: usize) -> [f64; 2] {
        let (along, own) = (self.frame[node] * Vector::z(), self.sides.iter().find(|own| own.node == node));
        let [before, behind] = own.map_or([self.force[node]; 2], |own| own.force).map(|force| force.dot(&along));
        [if node > 0 { before } else { 0.0 }, if node + 1 < self.s.len() { behind } else { 0.0 }]
    }

    /// Tensions at all nodes, of both sides where they differ, N.
    pub fn tensions(&self) -> impl Iterator<Item = f64> {
        let along = |node: usize, force: &Vector| force.dot(&(self.frame[node] * Vector::z()));
        let of_sides = self.sides.iter().flat_map(move |own| own.force.iter().map(move |force| along(own.node, force)));
        (0..self.s.len()).map(|node| self.tension_at(node)).chain(of_sides)
    }

    /// The part with a section of its own that a node is in; where two meet, the one that bends more tightly, and
    /// without [`Self::sides`] the one with the lesser limit.
    pub fn section_at(&self, node: usize) -> Option<&SectionResult> {
        if self.sections.is_empty() {
            return None;
        }
        let next = self.sections.partition_point(|part| part.to < self.s[node]);
        let sides = self.sides.iter().find(|own| own.node == node).map(|own| own.bend_radius);
        let here = self.sections.get(next);
        let beyond = self.sections.get(next + 1).filter(|part| part.from <= self.s[node]);
        let limit = |part: Option<&SectionResult>| part.and_then(|part| part.bend_radius_limit).unwrap_or(0.0);
        let counts = sides.map_or_else(|| limit(beyond) < limit(here), |[before, after]| after < before);
        beyond.filter(|_| counts).or(here)
    }

    /// Diameter along a segment, m.
    pub fn diameter_of(&self, segment: usize) -> f64 {
        let middle = 0.5 * (self.s[segment] + self.s[segment + 1]);
        self.sections.iter().find(|part| middle <= part.to).map_or(self.diameter, |part| part.diameter)
    }

    /// Diameter at a node, m.
    pub fn diameter_at(&self, node: usize) -> f64 {
        self.section_at(node).map_or(self.diameter, |part| part.diameter)
    }

    /// Smallest bend radius allowed at a node, m.
    pub fn bend_radius_limit_at(&self, node: usize) -> Option<f64> {
        self.section_at(node).map_or(self.bend_radius_limit, |part| part.bend_radius_limit)
    }

    /// The bend at each node; where two sections meet, on either side.
    pub fn bends(&self) -> impl Iterator<Item = Bend> {
        let at = move |node: usize| Bend {
            s: self.s[node],
            radius: self.bend_radius[node],
            limit: self.bend_radius_limit_at(node),
        };
        let meeting = self.sections.windows(2).filter_map(move |parts| {
            let own = self.sides.iter().find(|own| self.s[own.node] >= parts[0].to)?;
            let side =
                |k: usize| Bend { s: parts[0].to, radius: own.bend_radius[k], limit: parts[k].bend_radius_limit };
            (self.s[own.node] <= parts[1].from).then(|| [side(0), side(1)])
        });
        (0..self.s.len()).map(at).chain(meeting.flatten())
    }

    /// Axial strain at a node.
    pub fn strain_at(&self, node: usize) -> f64 {
        match &self.strain {
            Some(strain) => strain[node],
            None => self.tension_at(node) / self.axial_stiffness,
        }
    }
}

/// What lengths and places of the scenario do to the worst value of a requirement; SI units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RequirementSensitivity {
    /// Name of the requirement.
    pub requirement: String,
    /// Step of the worst value.
    pub step: String,
    /// Its increment, from 1.
    pub increment: usize,
    /// Unit of the value.
    pub unit: String,
    /// Whether friction, slip, or parts that remember have a history there, which is kept as it is: what a key does to
    /// the path up to there is left out.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub keeps_history: bool,
    /// The keys that change it, the one that does most first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by: Vec<KeySensitivity>,
    /// Why nothing is known about it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// What a number of the scenario, m, does to the worst value of a requirement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeySensitivity {
    /// Path to its key.
    pub key: String,
    /// Derivative of the value by it; none where the two sides differ.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub derivative: Option<f64>,
    /// Where there is none: the derivatives towards smaller and larger numbers, as far as they are known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sides: Option<[Option<f64>; 2]>,
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl KeySensitivity {
    /// Size of the largest derivative that is known.
    pub fn size(&self) -> f64 {
        let sides = self.sides.into_iter().flatten().flatten();
        self.derivative.into_iter().chain(sides).fold(0.0, |size, derivative| size.max(derivative.abs()))
    }
}

/// The equilibrium that the harness has under the constraints at the end of a run if it starts along its drawn lines,
/// compared with the end of the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrawnStart {
    /// Why there is none to compare with; the rest is then empty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_compared: Option<String>,
    /// Branches that end more than their diameter away from it, or with half a turn of twist more or less; the farthest
    /// first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub branches: Vec<EndsElsewhere>,
    /// Energy at the end of the run less that of the equilibrium from the drawn lines, J.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<f64>,
    /// Why it ends elsewhere: a sentence for each reason.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub why: Vec<String>,
}

impl DrawnStart {
    /// What it says, a sentence for each line; the first one says whether the harness ends elsewhere.
    pub fn lines(&self) -> Vec<String> {
        if let Some(why) = &self.not_compared {
            return vec![format!(
                "the end of the run was not compared with the equilibrium from the drawn start: {why}"
            )];
        }
        let Some(farthest) = self.branches.first() else {
            return vec!["the run ends where the harness comes to rest from the drawn start, too".to_owned()];
        };
        let count = match self.branches.len() {
            1 => "one branch".to_owned(),
            n => format!("{n} branches"),
        };
        let first = format!(
            "the run ends elsewhere than from the drawn start: {count} by more than the diameter or by half a turn of \
             twist, `{}` by {:.0} mm at s = {:.0} mm and {:+.1} turns",
            farthest.name,
            1e3 * farthest.distance,
            1e3 * farthest.s,
            farthest.turns
        );
        std::iter::once(first).chain(self.why.iter().cloned()).collect()
    }
}

/// A branch that ends elsewhere than from the drawn start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EndsElsewhere {
    /// Its name.
    pub name: String,
    /// Largest distance between both centre lines at equal arc lengths, m.
    pub distance: f64,
    /// Arc length where it is largest, m.
    pub s: f64,
    /// Material twist at the end of the run less that from the drawn start, turns.
    pub turns: f64,
}

/// What slips, yields and creeps within the section of a branch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrictionResult {
    /// Set at each node, 1/m: curvature about d1 and d2 and twist about d3, beyond those at rest, that would remain if
    /// the moment there were taken away.
    pub set: Vec<Vector>,
    /// Energy dissipated in the branch in the increment that ends here, J. Not in [`Energy`], which is stored.
    pub dissipated: f64,
    /// Energy dissipated in the branch since it was at rest, J: on the way to the initial equilibrium, too.
    pub dissipated_in_all: f64,
}

/// Estimate of the discretisation error of a branch: the largest at any of its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BranchError {
    /// Of positions, m.
    pub position: f64,
    /// Of internal forces, N.
    pub force: f64,
    /// Of internal moments, N m.
    pub moment: f64,
    /// Of the least bend radius, m: by so much it may be smaller. `None` where the branch is straight.
    pub bend_radius: Option<f64>,
    /// Order of the scheme, all along the branch, in the length of segments: 4, 2 where the mesh is coarse or graded,
    /// or where something touches or slips, 1 of springs.
    pub order: u32,
}

/// One joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointResult {
    /// Name of the vertex.
    pub name: String,
    /// Position, m.
    pub position: Vector,
    /// Orientation; for joints without a frame of their own the best fit to their arms.
    pub orientation: Rotation,
    /// What has slipped at its arms, of those at which something does.
    pub friction: Vec<ArmFriction>,
}

/// What slips between an arm and its hub.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmFriction {
    /// Name of the branch.
    pub branch: String,
    /// Whether the branch starts at the joint.
    pub starts_here: bool,
    /// Set: turn of the arm from its rest direction that would remain if nothing exerted a moment on it, about d1, d2
    /// and d3 of the branch there, rad.
    pub set: Vector,
    /// Energy dissipated there in the increment that ends here, J. Not in [`Energy`], which is stored.
    pub dissipated: f64,
    /// Energy dissipated there since the harness was at rest, J: on the way to the initial equilibrium, too.
    pub dissipated_in_all: f64,
}

/// One constraint: its pose, and its reaction on the harness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConstraintResult {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: String,
    /// Held point, m: the first station, or the first node of the span.
    pub position: Vector,
    /// Frame at the held point.
    pub orientation: Rotation,
    /// Force at the held point, N, world; where there is only a span, the resultant on it.
    pub force: Vector,
    /// Moment about the held point, N m, world.
    pub moment: Vector,
    /// All stations, if there are several.
    pub stations: Vec<StationResult>,
    /// The span, if it acts along one.
    pub span: Option<SpanResult>,
    /// Sliding of the cable through it, if it slides.
    pub slide: Option<SlideResult>,
    /// Outputs of its kind: names and values, SI.
    pub outputs: Vec<(String, f64)>,
}

impl ConstraintResult {
    /// The largest force at any station, or the resultant on the span, N.
    pub fn largest_force(&self) -> f64 {
        let others = self.stations.iter().map(|station| station.force.norm());
        others.chain(self.span.iter().map(|span| span.force.norm())).fold(self.force.norm(), f64::max)
    }

    /// The largest moment at any station, N m.
    pub fn largest_moment(&self) -> f64 {
        self.stations.iter().map(|station| station.moment.norm()).fold(self.moment.norm(), f64::max)
    }
}

/// One of several stations of a constraint, with the reaction there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StationResult {
    /// Position, m.
    pub position: Vector,
    /// Force, N, world.
    pub force: Vector,
    /// Moment about the station, N m, world.
    pub moment: Vector,
}

/// The span of a constraint, with the reaction along it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpanResult {
    /// Branch.
    pub branch: String,
    /// Unstressed arc lengths of its ends, m.
    pub range: (f64, f64),
    /// Resultant force on it, N, world.
    pub force: Vector,
    /// The largest force on one of its nodes, N, world.
    pub largest: Vector,
    /// Arc length of that node, m.
    pub largest_at: f64,
}

/// Sliding of a cable through a constraint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SlideResult {
    /// Branch.
    pub branch: String,
    /// Unstressed arc length at the constraint, m.
    pub arc_length: f64,
    /// Axial force of the constraint on the cable, positive towards larger s, N: friction, or the reaction of a stop.
    pub axial_force: f64,
    /// State of motion.
    pub motion: SlideMotion,
}

/// State of motion of a cable in a sliding constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SlideMotion {
    /// It slides without friction.
    Free,
    /// Friction holds it.
    Stick,
    /// It slides against friction.
    Slip,
    /// A joint or another constraint stops it.
    Stopped,
}

impl SlideMotion {
    /// Word used in results.
    pub fn word(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Stick => "stick",
            Self::Slip => "slip",
            Self::Stopped => "stopped",
        }
    }
}

/// Result of an operation of a step, so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum OperationResult {
    /// A grasp.
    Grasp {
        /// Name of the constraint.
        constraint: String,
        /// Branch and arc length (m) of the place; `None` at a joint.
        place: Option<(String, f64)>,
    },
    /// Constraints carried together.
    Carry {
        /// Names of the constraints.
        constraints: Vec<String>,
        /// Largest force of one of them during the motion, N.
        force: f64,
    },
    /// A connector was mated.
    Mate {
        /// Name of the constraint.
        constraint: String,
        /// Largest insertion force in the push, N: the reaction of the cable along the direction of insertion plus the
        /// insertion force of the connector itself; `None` before the push has begun.
        insertion_force: Option<f64>,
        /// The part of it that the connector itself needs without a cable, N; `None` where that is not given: then the
        /// insertion force is that of the cable alone.
        own: Option<f64>,
        /// Largest permitted insertion force, N.
        limit: Option<f64>,
    },
    /// A clip closed.
    Clip {
        /// Name of the constraint.
        constraint: String,
        /// Branch and arc length (m) of the place; `None` at a joint.
        place: Option<(String, f64)>,
        /// Distance of the cable from the seat when the clip closed, m.
        reach: f64,
    },
}

impl OperationResult {
    /// Name of the operation.
    pub fn word(&self) -> &'static str {
        match self {
            OperationResult::Grasp { .. } => "grasp",
            OperationResult::Carry { .. } => "carry",
            OperationResult::Mate { .. } => "mate",
            OperationResult::Clip { .. } => "clip",
        }
    }

    /// Names of the constraints involved.
    pub fn of(&self) -> &[String] {
        match self {
            OperationResult::Carry { constraints, .. } => constraints,
            OperationResult::Grasp { constraint, .. }
            | OperationResult::Mate { constraint, .. }
            | OperationResult::Clip { constraint, .. } => std::slice::from_ref(constraint),
        }
    }
}

/// Example: "insertion force 19.60 N (cable 4.60 N, connector 15 N), allowed 45 N".
impl fmt::Display for OperationResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = |f: &mut fmt::Formatter<'_>, place: &Option<(String, f64)>| match place {
            Some((branch, s)) => write!(f, "at s = {:.1} mm of {branch}", 1e3 * s),
            None => f.write_str("at a joint"),
        };
        match self {
            OperationResult::Grasp { place: at, .. } => place(f, at),
            OperationResult::Carry { force, .. } => write!(f, "largest force {force:.3} N"),
            OperationResult::Mate { insertion_force, own, limit, .. } => {
                match (insertion_force, own) {
                    (Some(force), Some(own)) => {
                        write!(f, "insertion force {force:.2} N (cable {:.2} N, connector {own} N)", force - own)?;
                    }
                    (Some(force), None) => {
                        write!(f, "insertion force {force:.2} N (cable alone: that of the connector is not given)")?;
                    }
                    (None, _) => f.write_str("not pushed home")?,
                }
                match (limit, insertion_force) {
                    (Some(limit), Some(force)) if force > limit => write!(f, ", TOO LARGE: allowed {limit} N"),
                    (Some(limit), _) => write!(f, ", allowed {limit} N"),
                    (None, _) => Ok(()),
                }
            }
            OperationResult::Clip { place: at, reach, .. } => {
                place(f, at)?;
                write!(f, ", {:.1} mm from its seat", 1e3 * reach)
            }
        }
    }
}

/// Energy by effect, J. The elastic parts are zero at rest; gravity is measured from the world origin; loads are
/// −F·x.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// Stretch of the branches.
    pub stretch: f64,
    /// Shear of the branches.
    pub shear: f64,
    /// Bending of the branches.
    pub bend: f64,
    /// Twist of the branches.
    pub twist: f64,
    /// Gravity.
    pub gravity: f64,
    /// Dead forces.
    pub load: f64,
    /// Joints.
    pub joint: f64,
    /// Constraints, contact and friction.
    pub constraint: f64,
}

impl Energy {
    /// The sum, J.
    pub fn total(&self) -> f64 {
        self.stretch + self.shear + self.bend + self.twist + self.gravity + self.load + self.joint + self.constraint
    }
}

/// The tightest bend.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TightestBend {
    /// Branch.
    pub branch: String,
    /// Arc length, m.
    pub s: f64,
    /// Bend radius, m.
    pub value: f64,
    /// Smallest bend radius allowed there, m.
    pub limit: Option<f64>,
}

/// Data on how an equilibrium was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MinimiserResult {
    /// Kind.
    pub kind: String,
    /// Device, if not the processor; see [`crate::Minimiser::device`].
    pub device: Option<String>,
    /// Iterations, over all increments of the step so far.
    pub iterations: usize,
    /// Number of these iterations made by another minimiser to finish; see [`crate::minimiser::Report::polish`].
    pub polish: usize,
    /// Factorisations, over all increments of the step so far.
    pub factorisations: usize,
    /// Time over all increments of the step so far, s.
    pub seconds: f64,
    /// Largest residual force (and moment) relative to its scale, from the certificate.
    pub force_residual: f64,
    /// Largest motion of a node in the next Newton step, m: an estimate of the distance of the shape from the
    /// equilibrium of the mesh; `None` where the second derivatives were not evaluated.
    pub shape_error: Option<f64>,
    /// Largest violation of an equation or inequality of a constraint, in units of its scale; `None` where there are
    /// none.
    pub constraint_residual: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_insertion_force_is_compared_with_what_is_allowed() {
        let mate = |insertion_force, own, limit| {
            OperationResult::Mate { constraint: "B".into(), insertion_force, own, limit }.to_string()
        };
        let parts = "(cable 31.00 N, connector 15 N)";
        let (large, own) = (Some(46.0), Some(15.0));
        assert_eq!(mate(large, own, Some(45.0)), format!("insertion force 46.00 N {parts}, TOO LARGE: allowed 45 N"));
        assert_eq!(mate(large, own, Some(47.0)), format!("insertion force 46.00 N {parts}, allowed 47 N"));
        let alone = "(cable alone: that of the connector is not given)";
        assert_eq!(mate(Some(44.0), None, None), format!("insertion force 44.00 N {alone}"));
        assert_eq!(mate(None, None, None), "not pushed home");
    }
}
