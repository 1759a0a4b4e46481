//! A checked scenario: plain data, names resolved to indices, all values in SI units.

use crate::attachment::{At, NOWHERE, Stretch};
use crate::bundle::Bundle;
use crate::optimise::Optimise;
use crate::output::Output;
use crate::span::{Span, Spans};
use crate::sweep::Sweep;
use wireloom_core::conditions::RotatingAxes;
use wireloom_core::constraint::{Limits, Slide};
use wireloom_core::identity::{CrossSection, Identities};
use wireloom_core::joint::WireShare;
use wireloom_core::load::LoadAction;
use wireloom_core::mechanism::{Mechanism, Mount};
use wireloom_core::obstacle::{ContactSettings, Obstacle};
use wireloom_core::requirement::{Marker, Requirement};
use wireloom_core::steps::{Initial, Step, Turn};
use wireloom_core::{ArmSpring, HoldWord, Parameters, Rotation, Section, Stop, Vector};

/// A whole scenario. Only [`crate::parse`] makes one, after all checks.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Scenario {
    /// Name, for results.
    pub name: String,
    /// Gravity at the beginning less the acceleration of the car, m/s².
    pub gravity: Vector,
    /// Rotation of the axes at the beginning.
    pub rotation: RotatingAxes,
    /// Sections, in the order of the file.
    pub sections: Vec<Section>,
    /// Results of the rule for the sections that have wires.
    pub by_rule: Vec<ByRule>,
    /// Branches, in the order of the file.
    pub branches: Vec<Branch>,
    /// Largest discretisation error of bend radii, relative to them, if the mesh follows from it.
    pub accuracy: Option<f64>,
    /// Joints, in the order of the file.
    pub joints: Vec<Joint>,
    /// Constraints: those that act from the beginning, then those that steps add.
    pub constraints: Vec<Constraint>,
    /// Loads.
    pub loads: Vec<Load>,
    /// Bodies that the harness may touch, in the order of the file.
    pub obstacles: Vec<Body>,
    /// Settings of contact between cables and with these bodies.
    pub contact: ContactSettings,
    /// Mechanisms, in the order of the file.
    pub mechanisms: Vec<Mechanism>,
    /// Pose of the rest shape, if the file gives one.
    pub initial: Option<Initial>,
    /// The minimiser that finds equilibria.
    pub minimiser: Minimiser,
    /// Assembly operations.
    pub steps: Vec<Step>,
    /// Place of each step in the file, bytes.
    pub step_spans: Vec<Span>,
    /// Entries of `[[requirements]]`.
    pub requirements: Vec<Required>,
    /// Markers.
    pub markers: Vec<Marker>,
    /// The sweep of `wireloom sweep`.
    pub sweep: Option<Sweep>,
    /// What `wireloom optimise` chooses, and to what end.
    pub optimise: Option<Optimise>,
    /// Part numbers and the like.
    pub identities: Identities,
    /// Part numbers of constraints that the catalogue does not have.
    pub unmatched: Vec<String>,
    /// Notes on other files.
    pub file_notes: Vec<String>,
    /// Output besides the result.
    pub output: Output,
}

impl Scenario {
    /// Whether the axes rotate at some time.
    pub fn rotates(&self) -> bool {
        let speeds = self.steps.iter().filter_map(|step| step.angular_velocity);
        std::iter::once(self.rotation.velocity).chain(speeds).any(|velocity| velocity != Vector::zeros())
    }
}

/// Values of a section by the rule, from its wires. Measured values take precedence over them.
#[derive(Clone, Debug)]
pub struct ByRule {
    /// Index of the section.
    pub section: usize,
    /// Values by the rule.
    pub bundle: Bundle,
    /// What it is made of.
    pub made_of: CrossSection,
    /// Keys of the section that hold measured values.
    pub measured: Vec<String>,
    /// Remarks on contradictions, such as a tube that is too narrow.
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
    /// Its parts that have another section, in the order of arc length, none over another one.
    pub parts: Vec<SectionPart>,
    /// Unstressed length, m.
    pub length: f64,
    /// Its division into segments.
    pub division: Division,
    /// For [`Division::ByAccuracy`]: arc lengths (increasing) and the length of segments there, linear in between, as
    /// fractions of the length of the branch; empty before they are known.
    pub sizes: Vec<[f64; 2]>,
    /// For [`Division::ByAccuracy`]: arc lengths of nodes to keep (increasing, with both ends), as fractions of the
    /// length of the branch. Further attachments add nodes. Empty where [`Self::sizes`] decide.
    pub nodes: Vec<f64>,
    /// For each span between attachments the lengths of its segments as fractions of it, in place of
    /// [`Self::division`]; empty where that decides. See [`Scenario::keep_mesh_of`].
    pub shares: Vec<Vec<f64>>,
    /// Kind of rod.
    pub rod: String,
    /// Parameters of the kind.
    pub parameters: Parameters,
    /// Rest curvature about d1 and d2 and rest twist about d3, 1/m.
    pub curvature: Vector,
    /// Centre line along which it is laid at the start, m, world coordinates; empty where none is given.
    pub path: Vec<Vector>,
    /// Drawn centre line, if it is not [`Self::path`]; see [`Self::drawn`].
    pub own_drawn: Vec<Vector>,
    /// Its place in the file.
    pub spans: Spans,
}

/// Part of a branch that has another section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPart {
    /// Index of that section.
    pub section: usize,
    /// Arc lengths where it begins and ends, m.
    pub range: [f64; 2],
}

impl Branch {
    /// Its sections by spans that cover all of it, in the order of arc length; neighbours have another section.
    pub fn section_spans(&self) -> Vec<SectionPart> {
        let mut spans: Vec<SectionPart> = Vec::new();
        let mut add = |section: usize, from: f64, to: f64| match spans.last_mut() {
            _ if to - from <= Self::COINCIDENT * self.length => {}
            Some(last) if last.section == section => last.range[1] = to,
            _ => spans.push(SectionPart { section, range: [from, to] }),
        };
        let mut reached = 0.0;
        for part in &self.parts {
            add(self.section, reached, part.range[0]);
            add(part.section, part.range[0], part.range[1]);
            reached = part.range[1];
        }
        add(self.section, reached, self.length);
        spans
    }

    /// Indices of its sections.
    pub fn sections(&self) -> impl Iterator<Item = usize> {
        self.section_spans().into_iter().map(|span| span.section)
    }

    /// Whether one of its sections is this one.
    pub fn has_section(&self, section: usize) -> bool {
        self.sections().any(|own| own == section)
    }

    /// Index of its section at its start, or at its end.
    pub fn end_section(&self, start: bool) -> usize {
        let spans = self.section_spans();
        let span = if start { spans.first() } else { spans.last() };
        span.map_or(self.section, |span| span.section)
    }

    /// Places closer than this, relative to the length of a branch, are one.
    pub(crate) const COINCIDENT: f64 = 1e-9;

    /// Drawn centre line, with which results are compared, m, world coordinates; empty where none is drawn.
    pub fn drawn(&self) -> &[Vector] {
        if self.own_drawn.is_empty() { &self.path } else { &self.own_drawn }
    }
}

/// Division of a branch into segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Division {
    /// Number of segments.
    Segments(usize),
    /// Largest length of a segment, m.
    MaxSegment(f64),
    /// As [`Branch::nodes`] or [`Branch::sizes`] say; `longest`, m, is the largest length of a segment. Before sizes
    /// are known, it is divided uniformly into some segments.
    ByAccuracy {
        /// Largest length of a segment, m; may be infinite.
        longest: f64,
    },
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
    /// Springs that hold its arms to a compliant hub, where an arm says nothing else.
    pub spring: ArmSpring,
    /// The arms, in the order of the file.
    pub arms: Vec<Arm>,
    /// Anatomy; empty where the file gives none.
    pub wires: Vec<WireShare>,
    /// Its place in the file; the key `offset` is that of the first arm that has one, `arms.NAME` the arm of a branch.
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
    /// Point where the arm leaves the joint, in the joint's frame, m.
    pub offset: Vector,
    /// Spring that holds it to a compliant hub: its own, else that of the joint.
    pub spring: ArmSpring,
}

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

impl Facing {
    /// The turn of a motion that ends in this direction or frame.
    pub fn turn(self) -> Turn {
        match self {
            Facing::Left => Turn::Keep,
            Facing::Tangent(tangent) => Turn::Tangent(tangent),
            Facing::Orientation(orientation) => Turn::Orientation(orientation),
        }
    }
}

/// A constraint.
#[derive(Clone, Debug)]
pub struct Constraint {
    /// Name.
    pub name: String,
    /// Kind of the registry.
    pub kind: String,
    /// Name of the kind in the file: the kind itself, or a type of fixing.
    pub called: String,
    /// Parameters of the kind.
    pub parameters: Parameters,
    /// Places where it attaches.
    pub at: Vec<At>,
    /// The part of a branch along which it acts.
    pub span: Option<Stretch>,
    /// Body of a mechanism that carries it; its pose is then as the mechanism is drawn.
    pub mount: Option<Mount>,
    /// Position that it holds, m; `None`: the position of the cable when it begins.
    pub position: Option<Vector>,
    /// Direction or frame that it holds.
    pub facing: Facing,
    /// Whether the scenario, or a later move, gives a tangent.
    pub tangent_given: bool,
    /// Whether the scenario, or a later move, gives the direction of d1.
    pub up_given: bool,
    /// Freedoms that it holds, if the scenario lists them.
    pub hold: Option<Vec<HoldWord>>,
    /// World axis about which alone it may turn; a unit vector.
    pub free_axis: Option<Vector>,
    /// World directions along which the held point may move; unit vectors.
    pub rails: Vec<Vector>,
    /// Sliding of the cable through it, if the cable may slide.
    pub slide: Option<Slide>,
    /// Its load limits.
    pub limits: Limits,
    /// Whether it closes at the nearest place of the branch when it begins; until then its place is provisional.
    pub nearest: bool,
    /// Whether it acts from the beginning.
    pub from_start: bool,
    /// Its place in the file.
    pub spans: Spans,
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

/// An entry of `[[requirements]]`.
#[derive(Clone, Debug)]
pub struct Required {
    /// The requirement.
    pub requirement: Requirement,
    /// Its place in the file.
    pub spans: Spans,
}

/// A load.
#[derive(Clone, Debug)]
pub struct Load {
    /// Name.
    pub name: String,
    /// What it exerts, and where.
    pub action: LoadAction<At, Stretch>,
    /// Factor at the beginning.
    pub factor: f64,
    /// Its place in the file.
    pub spans: Spans,
}

impl Load {
    /// The place it acts at, or both ends of every part along which it acts.
    pub fn places(&self) -> impl Iterator<Item = At> {
        let (place, spans) = match &self.action {
            LoadAction::At { place, .. } => (Some(*place), &[][..]),
            LoadAction::Along { spans, .. } => (None, &spans[..]),
        };
        let ends = spans.iter().flat_map(|span| [span.from, span.to].map(|s| At::Branch { branch: span.branch, s }));
        place.into_iter().chain(ends)
    }
}

/// A body that the harness may touch. Its shape is made as it is read, once.
#[derive(Clone, Debug)]
pub struct Body {
    /// The obstacle of the network.
    pub obstacle: Obstacle,
    /// Notes for the user.
    pub notes: Vec<String>,
    /// Its place in the file.
    pub spans: Spans,
}

/// The minimiser that finds equilibria.
#[derive(Clone, Debug)]
pub struct Minimiser {
    /// Kind.
    pub kind: String,
    /// Parameters of the kind.
    pub parameters: Parameters,
    /// Its stopping criteria.
    pub stop: Stop,
    /// Its place in the file; empty if the file has none.
    pub spans: Spans,
}
