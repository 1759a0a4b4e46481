//! The form of `result.json`. It is written and read through these types alone; [`super::convert`] leads from and to
//! the results of `wireloom-core`.
//!
//! Fields without value are null where they say `nullable`, and left out where they say `default`. Any other missing
//! field and any field that is not known here is refused: a result of another version of this program is not read by
//! halves.

use super::provenance::Provenance;
use super::values::{Entries, FieldsFile, Number, Quaternion, Schema, Vector3, Word, is_zero, nullable};
use serde::de::{Deserializer, Error};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use wireloom_core::equilibrium::{DrawnStart, RequirementSensitivity, SlideMotion};
use wireloom_core::identity::Identities;
use wireloom_core::requirement::{Bound, Measure, Origin, Severity, Verdict};
use wireloom_core::{EventKind, Status};

/// The whole file. `S`: the list of steps, which writers and readers take one by one.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Document<S> {
    pub schema: Schema,
    pub scenario: String,
    pub status: Word<Status>,
    pub verdict: Word<Verdict>,
    pub requirements: Vec<Requirement>,
    pub provenance: Provenance,
    pub notes: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub plugins: Vec<Plugin>,
    #[serde(default, skip_serializing_if = "Identities::is_empty")]
    pub identities: Identities,
    pub events: Vec<Event>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fields: Option<FieldsFile>,
    pub steps: S,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub clearance: Vec<Clearance>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drawn_start: Option<DrawnStart>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensitivities: Vec<RequirementSensitivity>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<Fault>,
}

/// The sheet alone.
#[derive(Serialize)]
pub struct Sheet {
    pub schema: Schema,
    pub scenario: String,
    pub status: Word<Status>,
    pub verdict: Word<Verdict>,
    pub requirements: Vec<Requirement>,
}

/// A line of the sheet. Values are in SI; `margin` is relative to the limit. `worst` is null where nothing was checked,
/// then without a step, and where it is infinite: the bend radius of a straight cable.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Requirement {
    pub name: String,
    pub quantity: Word<Measure>,
    pub severity: Word<Severity>,
    pub verdict: Word<Verdict>,
    #[serde(deserialize_with = "nullable")]
    pub worst: Option<Number>,
    pub limit: Number,
    pub bound: Word<Bound>,
    #[serde(deserialize_with = "nullable")]
    pub margin: Option<Number>,
    #[serde(deserialize_with = "nullable")]
    pub error: Option<Number>,
    #[serde(deserialize_with = "nullable")]
    pub step: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_index: Option<usize>,
    #[serde(deserialize_with = "nullable")]
    pub increment: Option<usize>,
    #[serde(rename = "where")]
    pub place: Place,
    pub origin: Word<Origin>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub because: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// A library that brought kinds of its own.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plugin {
    pub name: String,
    pub version: String,
    pub file: String,
    pub hash: String,
}

/// An event; `first`, `worst` and `last` are increments.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Event {
    pub kind: Word<EventKind>,
    pub place: Place,
    pub first: Increment,
    pub worst: Increment,
    pub last: Increment,
    pub increments: usize,
    #[serde(deserialize_with = "nullable")]
    pub value: Option<Number>,
    #[serde(deserialize_with = "nullable")]
    pub limit: Option<Number>,
    pub message: String,
}

/// Place of an event or of a value of a requirement: the keys that apply; none: the harness. Events call a constraint
/// `fixing`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixing: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constraint: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obstacle: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub branch: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub s: Option<Number>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other_branch: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other_s: Option<Number>,
}

/// An increment of the run.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Increment {
    pub step: String,
    pub step_index: usize,
    pub increment: usize,
}

/// An equilibrium. `V`: lists of vectors that not every reader needs.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step<V = Vec<Vector3>> {
    pub name: String,
    pub increment: usize,
    pub increments: usize,
    pub status: Word<Status>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fields_sha256: Option<String>,
    pub branches: Entries<Branch<V>>,
    pub joints: Entries<Joint>,
    pub constraints: Entries<Constraint>,
    #[serde(default, skip_serializing_if = "Entries::is_empty")]
    pub obstacles: Entries<Obstacle>,
    #[serde(default, skip_serializing_if = "Entries::is_empty")]
    pub mechanisms: Entries<Entries<Vec<Number>>>,
    #[serde(default, skip_serializing_if = "Entries::is_empty")]
    pub markers: Entries<Marker>,
    #[serde(default, skip_serializing_if = "Entries::is_empty")]
    pub sliding: Entries<Slide>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub operations: Vec<Operation>,
    pub energy: Energy,
    #[serde(deserialize_with = "nullable")]
    pub min_bend_radius: Option<TightestBend>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub violations: Vec<Violation>,
    #[serde(deserialize_with = "nullable")]
    pub stable: Option<bool>,
    pub minimiser: Minimiser,
}

/// A requirement that is not kept at this equilibrium. Values are in SI.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Violation {
    pub name: String,
    pub quantity: Word<Measure>,
    pub severity: Word<Severity>,
    pub value: Number,
    pub limit: Number,
    pub bound: Word<Bound>,
    #[serde(rename = "where")]
    pub place: Place,
}

/// A marker.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Marker {
    pub position: Vector3,
}

/// A branch; lists have one entry for each node. Where they are in another file, `nodes` is their length.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Self", deny_unknown_fields)]
pub struct Branch<V> {
    pub diameter: Number,
    #[serde(deserialize_with = "nullable")]
    pub bend_radius_limit: Option<Number>,
    pub axial_stiffness: Number,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sections: Vec<SectionPart>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strain: Option<Vec<Number>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nodes: Option<usize>,
    #[serde(default = "none", skip_serializing_if = "Option::is_none")]
    pub s: Option<Vec<Number>>,
    #[serde(default = "none", skip_serializing_if = "Option::is_none")]
    pub position: Option<Vec<Vector3>>,
    #[serde(default = "none", skip_serializing_if = "Option::is_none")]
    pub d3: Option<Vec<Vector3>>,
    #[serde(default = "none", skip_serializing_if = "Option::is_none")]
    pub d1: Option<V>,
    #[serde(default = "none", skip_serializing_if = "Option::is_none")]
    pub force: Option<V>,
    #[serde(default = "none", skip_serializing_if = "Option::is_none")]
    pub moment: Option<V>,
    #[serde(default = "none", skip_serializing_if = "Option::is_none")]
    pub bend_radius: Option<Vec<Number>>,
    pub twist_turns: Number,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<BranchError>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviation: Option<Deviation>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
}

/// A part of a branch with a section of its own; m, N.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SectionPart {
    pub section: String,
    pub from: Number,
    pub to: Number,
    pub diameter: Number,
    #[serde(deserialize_with = "nullable")]
    pub bend_radius_limit: Option<Number>,
    pub axial_stiffness: Number,
}

/// Distance of a branch from its drawn centre line, m; `s` and `cause`: where it is largest, and why.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Deviation {
    pub median: Number,
    pub max: Number,
    pub s: Number,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cause: Option<DeviationCause>,
}

/// `{ "kind": "few constraints", "between": ["clip-1", "plug-B"], "free_length": 0.8, "room": 0.2 }` and the like: m.
#[derive(Serialize, Deserialize)]
#[serde(tag = "kind", deny_unknown_fields)]
pub enum DeviationCause {
    #[serde(rename = "held elsewhere")]
    HeldElsewhere { constraint: String },
    #[serde(rename = "few constraints")]
    FewConstraints { between: [String; 2], free_length: Number, room: Number },
    #[serde(rename = "free end")]
    FreeEnd {
        #[serde(deserialize_with = "nullable")]
        from: Option<String>,
        free_length: Number,
    },
}

/// No list: unlike that of `default`, its type may be any.
fn none<T>() -> Option<T> {
    None
}

impl<V> Branch<V> {
    /// Names of its lists, and whether they are there.
    fn lists(&self) -> impl Iterator<Item = (&'static str, bool)> + use<V> {
        let set = self.friction.as_ref().map(|friction| ("set", friction.set.is_some()));
        let lists = [
            ("s", self.s.is_some()),
            ("position", self.position.is_some()),
            ("d3", self.d3.is_some()),
            ("d1", self.d1.is_some()),
            ("force", self.force.is_some()),
            ("moment", self.moment.is_some()),
            ("bend_radius", self.bend_radius.is_some()),
        ];
        lists.into_iter().chain(set)
    }
}

impl<V: Serialize> Serialize for Branch<V> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

impl<'de, V: Deserialize<'de>> Deserialize<'de> for Branch<V> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let branch = Self::deserialize(deserializer)?;
        let apart = branch.nodes.is_some();
        match branch.lists().find(|(_, there)| *there == apart) {
            None => Ok(branch),
            Some((list, _)) if apart => {
                Err(D::Error::custom(format_args!("both `nodes`, for lists in another file, and the list `{list}`")))
            }
            Some((list, _)) => Err(D::Error::missing_field(list)),
        }
    }
}

/// Friction within the section of a branch: set at each node (about d1, d2, d3), 1/m; energies, J.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub set: Option<Vec<Vector3>>,
    pub dissipated: Number,
    pub dissipated_in_all: Number,
}

/// Estimated discretisation error of a branch: N, N m, m; and the order of the scheme.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BranchError {
    pub position: Number,
    pub force: Number,
    pub moment: Number,
    #[serde(deserialize_with = "nullable")]
    pub bend_radius: Option<Number>,
    pub order: u32,
}

/// A joint.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Joint {
    pub position: Vector3,
    pub orientation: Quaternion,
    /// By the branch of the arm.
    #[serde(default, skip_serializing_if = "Entries::is_empty")]
    pub friction: Entries<ArmFriction>,
}

/// What slips between an arm and its hub: whether its branch starts there; set (about d1, d2, d3), rad; energies, J.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmFriction {
    pub starts_here: bool,
    pub set: Vector3,
    pub dissipated: Number,
    pub dissipated_in_all: Number,
}

/// A constraint: where it holds, what it exerts on the harness, and the outputs of its kind (SI).
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Constraint {
    pub kind: String,
    pub position: Vector3,
    pub orientation: Quaternion,
    pub force: Vector3,
    pub moment: Vector3,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stations: Vec<Station>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub span: Option<Span>,
    #[serde(default, skip_serializing_if = "Entries::is_empty")]
    pub outputs: Entries<Number>,
}

/// One of several stations of a constraint.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Station {
    pub position: Vector3,
    pub force: Vector3,
    pub moment: Vector3,
}

/// The span of a constraint, and what it exerts along it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Span {
    pub branch: String,
    pub from: Number,
    pub to: Number,
    pub force: Vector3,
    pub largest: Vector3,
    pub largest_at: Number,
}

/// An obstacle: where it is, and what it exerts on the harness.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    pub position: Vector3,
    pub orientation: Quaternion,
    pub force: Vector3,
    pub moment: Vector3,
    pub contact_force: Number,
    pub contacts: usize,
    pub depth: Number,
}

/// Motion of the cable through a constraint that slides.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slide {
    pub branch: String,
    pub contact_arclength: Number,
    pub axial_force: Number,
    pub motion: Word<SlideMotion>,
}

/// `{ "operation": "mate", "constraint": "plug-B", "insertion_force": 31.2, "own": 15.0, "limit": 45.0 }` and the like:
/// N, m. `own`, the part of the connector itself, is there where it is given.
#[derive(Serialize, Deserialize)]
#[serde(tag = "operation", rename_all = "lowercase", deny_unknown_fields)]
pub enum Operation {
    Grasp {
        constraint: String,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        branch: Option<String>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        s: Option<Number>,
    },
    Carry {
        constraints: Vec<String>,
        force: Number,
    },
    Mate {
        constraint: String,
        #[serde(deserialize_with = "nullable")]
        insertion_force: Option<Number>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        own: Option<Number>,
        #[serde(deserialize_with = "nullable")]
        limit: Option<Number>,
    },
    Clip {
        constraint: String,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        branch: Option<String>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        s: Option<Number>,
        reach: Number,
    },
}

/// Energy by effect, J.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Energy {
    pub total: Number,
    pub stretch: Number,
    pub shear: Number,
    pub bend: Number,
    pub twist: Number,
    pub gravity: Number,
    pub load: Number,
    pub joint: Number,
    pub constraint: Number,
}

/// The tightest bend.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TightestBend {
    pub branch: String,
    pub s: Number,
    pub value: Number,
    #[serde(deserialize_with = "nullable")]
    pub limit: Option<Number>,
}

/// Work and residuals of the minimiser. `device`: where that was not the processor; `polish`: iterations that another
/// minimiser made to finish.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Minimiser {
    pub kind: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device: Option<String>,
    pub iterations: usize,
    #[serde(default, skip_serializing_if = "is_zero")]
    pub polish: usize,
    pub factorisations: usize,
    pub seconds: Number,
    pub force_residual: Number,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape_error: Option<Number>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constraint_residual: Option<Number>,
}

/// Smallest distance of a branch from an obstacle or another branch.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clearance {
    pub branch: String,
    pub s: Number,
    pub position: Vector3,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obstacle: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other_s: Option<Number>,
    pub distance: Number,
    #[serde(deserialize_with = "nullable")]
    pub required: Option<Number>,
    pub at: Increment,
}

/// The fault of a constraint, a joint, the rod of a branch or the minimiser that ended the run.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constraint: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rod: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub minimiser: Option<String>,
    pub kind: String,
    pub step: String,
    pub increment: usize,
    pub message: String,
}
