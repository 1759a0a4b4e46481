//! What comes out: shapes, internal forces, reactions, energies, and how it was found. SI units.

pub use crate::event::{Event, EventKind, EventPlace, Moment};
use crate::status::Status;
use crate::{Pose, Rotation, Vector};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A whole run.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Name of the scenario.
    pub scenario: String,
    /// Status of the run: that of its first increment that did not converge, or converged.
    pub status: Status,
    /// Remarks on the harness and its start: wires that end in a joint and the like.
    pub notes: Vec<String>,
    /// What happened on the way, in the order in which it began.
    pub events: Vec<Event>,
    /// The last increment of each step, or all of them.
    pub steps: Vec<StepResult>,
    /// How near cables came to what is about them, over all increments.
    pub clearances: Vec<Clearance>,
    /// What ended the run before its time, where a constraint, a joint or the minimiser did.
    pub fault: Option<PartFault>,
    /// Libraries that brought kinds of their own.
    pub plugins: Vec<Library>,
}

/// A part of the harness that may have functions of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartFamily {
    /// A constraint.
    Constraint,
    /// A joint.
    Joint,
    /// The minimiser, whose kind is its name.
    Minimiser,
}

impl PartFamily {
    /// As results and scenarios call it.
    pub fn word(self) -> &'static str {
        match self {
            PartFamily::Constraint => "constraint",
            PartFamily::Joint => "joint",
            PartFamily::Minimiser => "minimiser",
        }
    }
}

/// A constraint, joint or minimiser of which nothing may be relied on any more: the increment that it happened in is not part of the result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartFault {
    /// Which it is.
    pub family: PartFamily,
    /// Its name.
    pub name: String,
    /// Its kind, or its model.
    pub kind: String,
    /// Step.
    pub step: String,
    /// Which increment of it, from 1; 0: while the start was being found.
    pub increment: usize,
    /// What happened.
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

/// A library that brought kinds of its own.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Library {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// Where it was.
    pub file: String,
    /// SHA-256 of the file, hexadecimal.
    pub hash: String,
}

impl fmt::Display for Library {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "plugin `{}` {} from {} (SHA-256 {})", self.name, self.version, self.file, self.hash)
    }
}

/// One increment's end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepResult {
    /// Name of the step.
    pub name: String,
    /// Which increment this is, from 1.
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
    /// What the operations of the step came to, in the order of the scenario: grasps, carries, mates, clips.
    pub operations: Vec<OperationResult>,
    /// Energy by effect.
    pub energy: Energy,
    /// Of the whole harness, the bend nearest to its limit, or furthest beyond it; where no branch has a limit, the one of least
    /// radius. `None` where everything is straight.
    pub min_bend_radius: Option<TightestBend>,
    /// Whether the equilibrium is stable; `None` where that cannot be told: a motion of it costs nothing (or nothing above round-off), it is not
    /// one, or a dead moment acts, which has no potential: then it is `Some(false)` or `None`.
    pub stable: Option<bool>,
    /// How it was found.
    pub minimiser: MinimiserResult,
}

/// The least distance between a branch and something else over a run, from surface to surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clearance {
    /// Branch.
    pub branch: String,
    /// What it is the distance from.
    pub from: ClearanceFrom,
    /// Distance, m; negative where they overlap.
    pub distance: f64,
    /// Arc length of the nearest place of the branch, m.
    pub s: f64,
    /// That place, m: of the centre line.
    pub position: Vector,
    /// What is asked for at least, m.
    pub required: Option<f64>,
    /// In which increment it was.
    pub moment: Moment,
}

impl Clearance {
    /// Whether it is less than required.
    pub fn is_short(&self) -> bool {
        self.required.is_some_and(|required| self.distance < required)
    }
}

/// What a branch is near to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ClearanceFrom {
    /// An obstacle, by name.
    Obstacle(String),
    /// Another branch.
    Branch {
        /// Its name.
        name: String,
        /// Arc length of its nearest place, m.
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

/// An obstacle, and what it exerts on the harness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObstacleResult {
    /// Name.
    pub name: String,
    /// Where it stands.
    pub pose: Pose,
    /// Force on the harness, N, world axes.
    pub force: Vector,
    /// Moment on the harness about the obstacle's position, N m, world axes.
    pub moment: Vector,
    /// Number of places of the cables that it pushes.
    pub contacts: usize,
    /// How deep the deepest of them is, m.
    pub depth: f64,
}

/// One branch; vectors have one entry for each node. Where a constraint inside the branch makes force, moment and curvature
/// jump, they are those of the side that is bent more tightly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BranchResult {
    /// Name.
    pub name: String,
    /// Diameter, m.
    pub diameter: f64,
    /// Smallest bend radius allowed, m.
    pub bend_radius_limit: Option<f64>,
    /// Axial stiffness EA, N.
    pub axial_stiffness: f64,
    /// Arc length, m.
    pub s: Vec<f64>,
    /// Position, m, world: of the centre line, beside the corner of the polygon by ℓ² x″/24.
    pub position: Vec<Vector>,
    /// Frame; its columns are d1, d2, d3.
    pub frame: Vec<Rotation>,
    /// Internal force, N, world: what the part with larger s exerts on the part with smaller s.
    pub force: Vec<Vector>,
    /// Internal moment, N m, world.
    pub moment: Vec<Vector>,
    /// Bend radius, m; infinite where straight.
    pub bend_radius: Vec<f64>,
    /// Total material twist of the branch, turns.
    pub twist_turns: f64,
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
}

/// One constraint: where it holds, and what it exerts on the harness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConstraintResult {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: String,
    /// Held point, m: the first station, or where the span begins.
    pub position: Vector,
    /// Frame at the held point.
    pub orientation: Rotation,
    /// Force at the held point, N, world; where there is only a span, all that acts on it.
    pub force: Vector,
    /// Moment about the held point, N m, world.
    pub moment: Vector,
    /// Every station, the first one included, where there are several.
    pub stations: Vec<StationResult>,
    /// The span, where it acts along one.
    pub span: Option<SpanResult>,
    /// How the cable runs through it, where it slides.
    pub slide: Option<SlideResult>,
}

impl ConstraintResult {
    /// The largest force at any station, or all that acts on the span, N.
    pub fn largest_force(&self) -> f64 {
        let others = self.stations.iter().map(|station| station.force.norm());
        others.chain(self.span.iter().map(|span| span.force.norm())).fold(self.force.norm(), f64::max)
    }

    /// The largest moment at any station, N m.
    pub fn largest_moment(&self) -> f64 {
        self.stations.iter().map(|station| station.moment.norm()).fold(self.moment.norm(), f64::max)
    }
}

/// One of several stations of a constraint, and what it exerts there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StationResult {
    /// Where it is, m.
    pub position: Vector,
    /// Force, N, world.
    pub force: Vector,
    /// Moment about the station, N m, world.
    pub moment: Vector,
}

/// The span of a constraint, and what it exerts along it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpanResult {
    /// Branch.
    pub branch: String,
    /// Unstressed arc lengths where it begins and ends, m.
    pub range: (f64, f64),
    /// All that acts on it, N, world.
    pub force: Vector,
    /// The largest force on one of its nodes, N, world.
    pub largest: Vector,
    /// Arc length of that node, m.
    pub largest_at: f64,
}

/// How the cable runs through a constraint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SlideResult {
    /// Branch.
    pub branch: String,
    /// Unstressed arc length at the constraint, m.
    pub arc_length: f64,
    /// What the constraint exerts on the cable along it, towards larger s, N: friction, or a stop.
    pub axial_force: f64,
    /// What the cable does.
    pub motion: SlideMotion,
}

/// What a cable does in a constraint that slides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SlideMotion {
    /// It runs without friction.
    Free,
    /// Friction holds it.
    Stick,
    /// It runs against friction.
    Slip,
    /// A joint or another constraint has come up against it.
    Stopped,
}

impl SlideMotion {
    /// The word of results.
    pub fn word(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Stick => "stick",
            Self::Slip => "slip",
            Self::Stopped => "stopped",
        }
    }
}

/// What an operation of a step came to, so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum OperationResult {
    /// A hand took hold.
    Grasp {
        /// Name of the constraint.
        constraint: String,
        /// Branch and arc length (m) where it did; none at a joint.
        place: Option<(String, f64)>,
    },
    /// Things were carried together.
    Carry {
        /// Names of the constraints.
        constraints: Vec<String>,
        /// Largest force that one of them took on the way, N.
        force: f64,
    },
    /// A connector was pushed home.
    Mate {
        /// Name of the constraint.
        constraint: String,
        /// Largest force along the direction of insertion that the hand needed in the push: what the cable held against it and
        /// what the connector itself takes, N; none before the push has begun.
        insertion_force: Option<f64>,
        /// Most that the hand may push, N.
        limit: Option<f64>,
    },
    /// A clip closed.
    Clip {
        /// Name of the constraint.
        constraint: String,
        /// Branch and arc length (m) where it did; none at a joint.
        place: Option<(String, f64)>,
        /// How far from its seat it did, m.
        reach: f64,
    },
}

impl OperationResult {
    /// What it is called.
    pub fn word(&self) -> &'static str {
        match self {
            OperationResult::Grasp { .. } => "grasp",
            OperationResult::Carry { .. } => "carry",
            OperationResult::Mate { .. } => "mate",
            OperationResult::Clip { .. } => "clip",
        }
    }

    /// Names of the constraints that take part.
    pub fn of(&self) -> &[String] {
        match self {
            OperationResult::Carry { constraints, .. } => constraints,
            OperationResult::Grasp { constraint, .. }
            | OperationResult::Mate { constraint, .. }
            | OperationResult::Clip { constraint, .. } => std::slice::from_ref(constraint),
        }
    }
}

/// What it came to: "insertion force 19.60 N, allowed 45 N".
impl fmt::Display for OperationResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = |f: &mut fmt::Formatter<'_>, place: &Option<(String, f64)>| match place {
            Some((branch, s)) => write!(f, "at s = {:.1} mm of {branch}", 1e3 * s),
            None => f.write_str("at a joint"),
        };
        match self {
            OperationResult::Grasp { place: at, .. } => place(f, at),
            OperationResult::Carry { force, .. } => write!(f, "largest force {force:.3} N"),
            OperationResult::Mate { insertion_force, limit, .. } => {
                match insertion_force {
                    Some(force) => write!(f, "insertion force {force:.2} N")?,
                    None => f.write_str("not pushed home")?,
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

/// Energy by effect, J. Zero at rest; gravity measured from the world origin; loads −F·x.
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
    /// Constraints that are potentials.
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

/// How an equilibrium was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MinimiserResult {
    /// Kind.
    pub kind: String,
    /// What it computed on, where that was not the processor; see [`crate::Minimiser::device`].
    pub device: Option<String>,
    /// Iterations, over all increments of the step so far.
    pub iterations: usize,
    /// How many of them another minimiser made to finish; see [`crate::minimiser::Report::polish`].
    pub polish: usize,
    /// Factorisations, likewise.
    pub factorisations: usize,
    /// Time, s, likewise.
    pub seconds: f64,
    /// Largest residual force (and moment) relative to its scale, from the certificate.
    pub force_residual: f64,
    /// By how much the next Newton step would move a node at most, m: an estimate of how far the shape is from the equilibrium of the mesh;
    /// none where the second derivatives were not looked at.
    pub shape_error: Option<f64>,
    /// How far equations and inequalities of constraints are from being met at most, in units of their scales; none where there are none.
    pub constraint_residual: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_insertion_force_is_compared_with_what_is_allowed() {
        let mate = |insertion_force, limit| {
            OperationResult::Mate { constraint: "B".into(), insertion_force, limit }.to_string()
        };
        assert_eq!(mate(Some(46.0), Some(45.0)), "insertion force 46.00 N, TOO LARGE: allowed 45 N");
        assert_eq!(mate(Some(44.0), Some(45.0)), "insertion force 44.00 N, allowed 45 N");
        assert_eq!(mate(Some(44.0), None), "insertion force 44.00 N");
        assert_eq!(mate(None, None), "not pushed home");
    }
}
