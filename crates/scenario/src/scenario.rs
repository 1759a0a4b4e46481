//! A checked scenario: plain data, names resolved to indices, all values in SI units.

use crate::Span;
use crate::bundle::Bundle;
use crate::sweep::Sweep;
use std::collections::BTreeMap;
use wireloom_core::constraint::{Limits, Slide};
use wireloom_core::joint::WireShare;
use wireloom_core::obstacle::{ContactSettings, Obstacle};
use wireloom_core::steps::{Initial, Step};
use wireloom_core::{HoldWord, Parameters, Rotation, Section, Stop, Vector};

/// Where an entry of the file is, for faults that only the building of parts can find.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Spans {
    /// The entry, bytes.
    pub entry: Span,
    /// The values of its keys, bytes.
    pub keys: BTreeMap<String, Span>,
}

impl Spans {
    /// The value of a key, or the entry where the key is not given.
    pub fn of(&self, key: Option<&str>) -> Span {
        key.and_then(|key| self.keys.get(key)).unwrap_or(&self.entry).clone()
    }
}

/// A whole scenario. Made by [`crate::parse`] only, which has checked that everything fits together.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Scenario {
    /// Name, for results.
    pub name: String,
    /// Gravity at the beginning, m/s².
    pub gravity: Vector,
    /// Sections, in the order of the file.
    pub sections: Vec<Section>,
    /// What the rule says of the sections that have wires.
    pub by_rule: Vec<ByRule>,
    /// Branches, in the order of the file.
    pub branches: Vec<Branch>,
    /// Joints, in the order of the file.
    pub joints: Vec<Joint>,
    /// Constraints: those that act from the beginning, then those that steps add.
    pub constraints: Vec<Constraint>,
    /// Dead loads.
    pub loads: Vec<Load>,
    /// Bodies that the harness may touch, in the order of the file.
    pub obstacles: Vec<Body>,
    /// How cables meet each other and these.
    pub contact: ContactSettings,
    /// Where the rest shape is laid, where the file says so.
    pub initial: Option<Initial>,
    /// How equilibria are found.
    pub minimiser: Minimiser,
    /// Assembly operations.
    pub steps: Vec<Step>,
    /// Where each step is in the file, bytes.
    pub step_spans: Vec<Span>,
    /// What it is run over, by `wireloom sweep`.
    pub sweep: Option<Sweep>,
    /// What is written besides the result.
    pub output: Output,
}

/// What follows from the wires of a section; what is measured beside them goes before it.
#[derive(Clone, Debug)]
pub struct ByRule {
    /// Index of the section.
    pub section: usize,
    /// What the rule says.
    pub bundle: Bundle,
    /// Names of the coverings, inside out.
    pub coverings: Vec<String>,
    /// Keys of the section that hold measured values.
    pub measured: Vec<String>,
    /// What does not go together.
    pub remarks: Vec<String>,
}

/// A branch.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Name.
    pub name: String,
    /// Vertices where it begins and ends.
    pub vertices: [String; 2],
    /// Index of its section.
    pub section: usize,
    /// Unstressed length, m.
    pub length: f64,
    /// How finely it is divided.
    pub division: Division,
    /// Kind of rod.
    pub rod: String,
    /// Parameters of the kind.
    pub parameters: Parameters,
    /// Rest curvature about d1 and d2 and rest twist about d3, 1/m.
    pub curvature: Vector,
    /// Drawn centre line, m, world coordinates; empty where none is drawn.
    pub path: Vec<Vector>,
    /// Where it is in the file.
    pub spans: Spans,
}

/// How finely a branch is divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Division {
    /// Into so many segments.
    Segments(usize),
    /// Into segments no longer than this, m.
    MaxSegment(f64),
}

/// A joint.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name of the vertex.
    pub name: String,
    /// Kind of model.
    pub model: String,
    /// Parameters of the kind.
    pub parameters: Parameters,
    /// Mass, kg.
    pub mass: f64,
    /// The arms, in the order of the file.
    pub arms: Vec<Arm>,
    /// Anatomy; empty where the file gives none.
    pub wires: Vec<WireShare>,
    /// Where it is in the file; the key `offset` stands for the first arm that has one.
    pub spans: Spans,
}

/// An arm of a joint.
#[derive(Clone, Debug)]
pub struct Arm {
    /// Index of its branch.
    pub branch: usize,
    /// Whether the branch starts here.
    pub starts_here: bool,
    /// Rest frame of the branch (d3 `from → to`) in the joint's frame.
    pub rest: Rotation,
    /// Where the arm leaves, in the joint's frame, m.
    pub offset: Vector,
}

/// Where something attaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum At {
    /// On a branch.
    Branch {
        /// Index of the branch.
        branch: usize,
        /// Unstressed arc length, m.
        s: f64,
    },
    /// On a joint, by index.
    Joint(usize),
}

/// A part of a branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Index of the branch.
    pub branch: usize,
    /// Unstressed arc length where it begins, m.
    pub from: f64,
    /// And where it ends, m.
    pub to: f64,
}

impl Constraint {
    /// The first place it attaches to, or else where its span begins.
    pub fn place(&self) -> At {
        let of_span = || self.span.map(|span| At::Branch { branch: span.branch, s: span.from });
        self.at.first().copied().or_else(of_span).unwrap_or(NOWHERE)
    }

    /// Every place it attaches to, and both ends of its span.
    pub fn places(&self) -> impl Iterator<Item = At> {
        let ends = self.span.into_iter().flat_map(|span| [span.from, span.to].map(|s| (span.branch, s)));
        self.at.iter().copied().chain(ends.map(|(branch, s)| At::Branch { branch, s }))
    }
}

/// Stands for a place at fault.
pub(crate) const NOWHERE: At = At::Branch { branch: 0, s: 0.0 };

/// A direction or frame that a scenario gives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Facing {
    /// Neither.
    #[default]
    Left,
    /// d3 alone; a unit vector.
    Tangent(Vector),
    /// The whole frame.
    Orientation(Rotation),
}

/// A constraint.
#[derive(Clone, Debug)]
pub struct Constraint {
    /// Name.
    pub name: String,
    /// Kind of the registry.
    pub kind: String,
    /// What the file calls it: that kind, or a type of fixing.
    pub called: String,
    /// Parameters of the kind.
    pub parameters: Parameters,
    /// Where it attaches.
    pub at: Vec<At>,
    /// Along which part of a branch it acts.
    pub span: Option<Stretch>,
    /// Where it holds, m; left out: where the cable is when it begins.
    pub position: Option<Vector>,
    /// Direction or frame it holds.
    pub facing: Facing,
    /// Whether the scenario, or a later move, gives a tangent.
    pub tangent_given: bool,
    /// Whether the scenario, or a later move, gives the direction of d1.
    pub up_given: bool,
    /// Freedoms spelled out.
    pub hold: Option<Vec<HoldWord>>,
    /// World axis about which alone it may turn; a unit vector.
    pub free_axis: Option<Vector>,
    /// World directions along which the held point may move; unit vectors.
    pub rails: Vec<Vector>,
    /// Whether, and how, the cable runs through.
    pub slide: Option<Slide>,
    /// What it bears.
    pub limits: Limits,
    /// Whether it closes where the cable is nearest when it begins; its place is a provisional one then.
    pub nearest: bool,
    /// Whether it acts from the beginning.
    pub from_start: bool,
    /// Where it is in the file.
    pub spans: Spans,
}

/// A dead load.
#[derive(Clone, Debug)]
pub struct Load {
    /// Name.
    pub name: String,
    /// Where it acts.
    pub at: At,
    /// Force, N, world axes.
    pub force: Vector,
    /// Moment, N m, world axes.
    pub moment: Vector,
    /// Factor at the beginning.
    pub factor: f64,
    /// Where it is in the file.
    pub spans: Spans,
}

/// A body that the harness may touch. Its shape is made as it is read, once.
#[derive(Clone, Debug)]
pub struct Body {
    /// As the mechanics knows it.
    pub obstacle: Obstacle,
    /// What an engineer should know of it.
    pub notes: Vec<String>,
    /// Where it is in the file.
    pub spans: Spans,
}

/// How equilibria are found.
#[derive(Clone, Debug)]
pub struct Minimiser {
    /// Kind.
    pub kind: String,
    /// Parameters of the kind.
    pub parameters: Parameters,
    /// When it stops.
    pub stop: Stop,
    /// Where it is in the file; empty where the file has none.
    pub spans: Spans,
}

/// What is written besides the result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// Every increment, not only the last of each step.
    pub increments: bool,
    /// The branches as CSV.
    pub csv: bool,
    /// The shape as VTK.
    pub vtk: bool,
    /// A picture of the shape.
    pub picture: bool,
    /// How near every branch comes to every obstacle and other branch.
    pub clearance: bool,
    /// The whole run as one page.
    pub report: bool,
    /// Harness and obstacles at the end of each step as glTF.
    pub gltf: bool,
    /// The space that the harness goes through, as glTF, from a grid with cells of this size, m.
    pub swept: Option<f64>,
}

impl Output {
    /// Whether files of the format with this key of `[output]` are asked for.
    pub fn asks_for(&self, key: &str) -> bool {
        match key {
            "csv" => self.csv,
            "vtk" => self.vtk,
            "picture" => self.picture,
            "report" => self.report,
            "gltf" => self.gltf,
            "swept" => self.swept.is_some(),
            _ => false,
        }
    }
}
