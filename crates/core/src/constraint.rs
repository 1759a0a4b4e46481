//! The trait of a constraint: what acts on stations of the harness, or along a span of a branch.

use crate::law::SpringLaw;
use crate::{Matrix, Pose, Vector};
use nalgebra::Unit;
use std::ops::RangeInclusive;

/// A freedom of a station, as scenarios spell it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum HoldWord {
    /// The point.
    Position,
    /// d3.
    Tangent,
    /// Turning about d3.
    Twist,
}

/// Which rotations of a station are given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RotationHold {
    /// None.
    Free,
    /// d3 is given, turning about it is free.
    Tangent,
    /// Turning about d3 is not possible; d3 is free.
    Twist,
    /// All.
    All,
    /// All but turning about this world axis: a hinge.
    Hinge(Unit<Vector>),
}

/// Which freedoms of a station a constraint prescribes.
#[derive(Clone, Debug, PartialEq)]
pub struct Hold {
    /// Whether the position is given.
    pub position: bool,
    /// World directions (orthonormal, at most two) along which the held point may move all the same.
    pub rails: Vec<Vector>,
    /// Rotations.
    pub rotation: RotationHold,
}

impl Hold {
    /// From the words of a scenario.
    pub fn new(words: &[HoldWord], free_axis: Option<Unit<Vector>>, rails: &[Vector]) -> Self {
        let tangent = words.contains(&HoldWord::Tangent);
        let twist = words.contains(&HoldWord::Twist);
        let rotation = match (free_axis, tangent, twist) {
            (Some(axis), ..) => RotationHold::Hinge(axis),
            (None, true, true) => RotationHold::All,
            (None, true, false) => RotationHold::Tangent,
            (None, false, true) => RotationHold::Twist,
            (None, false, false) => RotationHold::Free,
        };
        let mut orthonormal: Vec<Vector> = Vec::new();
        for rail in rails {
            let rest = orthonormal.iter().fold(*rail, |r, d| r - d * d.dot(&r));
            if let Some(d) = rest.try_normalize(1e-9 * rail.norm()) {
                orthonormal.push(d);
            }
        }
        Self { position: words.contains(&HoldWord::Position), rails: orthonormal, rotation }
    }

    /// World directions in which the point may not move.
    pub fn held_directions(&self) -> Vec<Vector> {
        match (self.position, self.rails.as_slice()) {
            (false, _) => vec![],
            (true, []) => vec![Vector::x(), Vector::y(), Vector::z()],
            (true, [a]) => {
                let b = crate::rotation::orthogonal(a);
                vec![b, a.cross(&b)]
            }
            (true, [a, b, ..]) => vec![a.cross(b)],
        }
    }
}

/// What a constraint sees of the harness: m stations, and n nodes of its span; either may be none.
#[derive(Clone, Copy, Debug)]
pub struct ConstraintView<'a> {
    /// Pose of each station. One that needs no frame and has none is not turned.
    pub stations: &'a [Pose],
    /// Target of each station; see [`Constraint::target`]. Those of the second and further ones go along with the first as one rigid
    /// body: they keep the places that the stations had relative to the first when the constraint began to act.
    pub targets: &'a [Pose],
    /// Position of each node of the span, m.
    pub span: &'a [Vector],
    /// Unstressed length of cable that each of them stands for, m: half of the span's segments on either side.
    pub span_lengths: &'a [f64],
    /// Share, 0 to 1, of the step in which the constraint began to act; from then on 1.
    pub progress: f64,
    /// What it remembers; see [`Constraint::memory`].
    pub memory: &'a [f64],
}

/// An energy of stations and of nodes of a span: a spring, say.
///
/// Contract: twice differentiable (but for lines where a second derivative jumps), finite, the same bits for the same input. Derivatives
/// are taken along `x + δ`, `q ∘ exp(θ)` (θ in the station's body frame). All room for derivatives holds zeros when it is handed over.
/// A potential whose energy is the least possible at its targets makes that 0.
pub trait Potential: Send + Sync {
    /// Energy, J.
    fn energy(&self, at: &ConstraintView<'_>) -> f64;
    /// First derivatives; returns the energy, J. `stations` has 2 m entries: ∂E/∂x (N) and ∂E/∂θ (N m) of each station; `span` has n:
    /// ∂E/∂x (N) of each node.
    fn gradient(&self, at: &ConstraintView<'_>, stations: &mut [Vector], span: &mut [Vector]) -> f64;
    /// Second derivatives. `stations` is a 2 m × 2 m table of blocks, row by row, in the order of [`Self::gradient`], symmetric as a
    /// whole: block (2 a + 1, 2 b) is ∂²E/∂θ_a∂x_b. `span` has n blocks ∂²E/∂x²: the nodes are coupled neither with one another nor with
    /// stations.
    fn hessian(&self, at: &ConstraintView<'_>, stations: &mut [Matrix], span: &mut [Matrix]);
}

/// What a residual must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// `c = 0`.
    Zero,
    /// `c ≤ 0`.
    NotPositive,
}

/// One equation or inequality.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// What it must be.
    pub relation: Relation,
    /// What counts as one, in the residual's unit: 1 m for a distance, 1 rad for an angle. The residual is met to the force tolerance
    /// times a hundredth of this (1e-8 of it where the tolerance is 1e-6).
    pub scale: f64,
}

impl Residual {
    /// `c = 0`, measured by `scale`.
    pub fn zero(scale: f64) -> Self {
        Self { relation: Relation::Zero, scale }
    }
    /// `c ≤ 0`, measured by `scale`.
    pub fn not_positive(scale: f64) -> Self {
        Self { relation: Relation::NotPositive, scale }
    }
}

/// Equations `c = 0` and inequalities `c ≤ 0` of stations, and of each node of a span for itself. They are enforced by an augmented
/// Lagrangian (Hestenes 1969, Powell 1969; Rockafellar 1973 for inequalities); what they exert is −Jᵀλ.
///
/// Contract: twice differentiable, finite, the same bits for the same input; a residual that is not met has a derivative that is not 0.
/// Derivatives are taken as those of a [`Potential`], and all room holds zeros when it is handed over. Residuals come in this order: those of the
/// stations, then those of the first node of the span, of the second, and so on.
pub trait Equations: Send + Sync {
    /// The residuals of the stations.
    fn of_stations(&self) -> Vec<Residual>;
    /// The residuals of one node of the span; every node has the same.
    fn of_each_node(&self) -> Vec<Residual> {
        Vec::new()
    }
    /// c.
    fn residuals(&self, at: &ConstraintView<'_>, c: &mut [f64]);
    /// c and J = ∂c/∂(x, θ). `stations` has a row of 2 m vectors for each residual of the stations: ∂c/∂x and ∂c/∂θ of each station;
    /// `span` has one vector for each residual of a node: ∂c/∂x of that node.
    fn jacobian(&self, at: &ConstraintView<'_>, c: &mut [f64], stations: &mut [Vector], span: &mut [Vector]);
    /// Σ w c″ over all residuals, in the places of [`Potential::hessian`]. Left at zero (as this does), second derivatives are those of
    /// Gauss and Newton, and it takes more iterations where a residual is curved.
    fn curvature(&self, _at: &ConstraintView<'_>, _w: &[f64], _stations: &mut [Matrix], _span: &mut [Matrix]) {}
}

/// How a constraint acts.
pub enum Action<'a> {
    /// Some of the six freedoms of its one station are given: eliminated, exact.
    Prescribed(&'a Hold),
    /// An energy pulls at the stations, or along the span.
    Potential(&'a dyn Potential),
    /// Equations and inequalities hold for them.
    Equations(&'a dyn Equations),
}

/// What acts on one station, on several, or along a span. Its target pose belongs to the [`crate::Conditions`] and is moved by the steps.
///
/// Contract: hot calls (those of [`Action`], [`Self::target`]) neither fail nor allocate, and say the same each time.
pub trait Constraint: Send + Sync {
    /// How it acts.
    fn action(&self) -> Action<'_>;
    /// The energy of a [`Potential`] as plain numbers, if it is of that form and acts on one station alone.
    fn law(&self) -> Option<SpringLaw> {
        None
    }
    /// Whether it needs its stations to have frames.
    fn needs_frame(&self) -> bool {
        match self.action() {
            Action::Prescribed(hold) => hold.rotation != RotationHold::Free,
            Action::Potential(_) | Action::Equations(_) => true,
        }
    }
    /// Whether nothing changes when stations, span and targets undergo the same rigid motion: false for what knows a place or a direction
    /// of the world by itself.
    fn objective(&self) -> bool {
        true
    }
    /// The target that follows from the one the scenario gives (`base`) at a fraction of the step in which the constraint began to act; see
    /// [`ConstraintView::progress`].
    fn target(&self, base: &Pose, _progress: f64) -> Pose {
        *base
    }
    /// What it remembers when it begins to act, each time anew: as many numbers as it will ever need.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Called once at the equilibrium that an increment ends in, never for one that is tried and taken back: what is remembered from
    /// here on. `memory` holds what was remembered before.
    fn commit(&self, _at: &ConstraintView<'_>, _memory: &mut [f64]) {}
    /// Why nothing it has said may be relied on any more, if so (a plugin that crashed or took too long); the run then ends.
    fn fault(&self) -> Option<String> {
        None
    }
}

/// Whether a kind acts along a span.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpanUse {
    /// No.
    Never,
    /// Where the scenario gives one.
    Maybe,
    /// Always.
    Always,
}

/// What a kind of constraint attaches to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attaches {
    /// How many stations.
    pub stations: RangeInclusive<usize>,
    /// Whether it acts along a span.
    pub span: SpanUse,
}

impl Attaches {
    /// To so many stations and no span.
    pub fn to_stations(stations: RangeInclusive<usize>) -> Self {
        Self { stations, span: SpanUse::Never }
    }
}

/// To one station.
impl Default for Attaches {
    fn default() -> Self {
        Self::to_stations(1..=1)
    }
}

/// What a constraint bears. Beyond it the constraint still holds: the run says so, and the engineer judges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Largest force it takes before it comes off, N.
    pub pull_out_force: Option<f64>,
    /// Largest moment it takes, N m.
    pub max_moment: Option<f64>,
    /// Force it takes to push it home, N.
    pub insertion_force: Option<f64>,
}

/// The cable may run through a constraint: its place is fixed in space, not in the material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slide {
    /// Coulomb coefficient: the axial force it takes is at most so many times the force across. 0 is smooth.
    pub friction: f64,
}

/// A place that a constraint acts on, as its factory is told.
#[derive(Clone, Debug, PartialEq)]
pub struct StationSpec {
    /// Branch and arc length, m; `None`: a joint.
    pub place: Option<(String, f64)>,
    /// Diameter of the cable there, m; of the thickest arm of a joint.
    pub diameter: f64,
}

/// A span that a constraint acts along, as its factory is told.
#[derive(Clone, Debug, PartialEq)]
pub struct SpanSpec {
    /// Branch.
    pub branch: String,
    /// Arc lengths where it begins and ends, m.
    pub range: (f64, f64),
    /// Diameter of the cable, m.
    pub diameter: f64,
}

/// Everything a constraint factory is told.
#[derive(Clone, Debug, Default)]
pub struct ConstraintSpec {
    /// Name in the scenario.
    pub name: String,
    /// Stations.
    pub stations: Vec<StationSpec>,
    /// Span.
    pub span: Option<SpanSpec>,
    /// Whether the scenario (or a later move) gives a tangent.
    pub tangent_given: bool,
    /// Whether the scenario (or a later move) gives the direction of d1, or a whole orientation.
    pub up_given: bool,
    /// `hold = […]`, where it is spelled out.
    pub hold: Option<Vec<HoldWord>>,
    /// `free_axis`.
    pub free_axis: Option<Unit<Vector>>,
    /// `rail`.
    pub rails: Vec<Vector>,
}

impl ConstraintSpec {
    /// The freedoms: those spelled out, or else `default`.
    pub fn hold(&self, default: &[HoldWord]) -> Hold {
        Hold::new(self.hold.as_deref().unwrap_or(default), self.free_axis, &self.rails)
    }
}
