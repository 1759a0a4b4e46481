//! Trait of a constraint, which acts on stations of the harness or along a span of a branch.

use crate::law::SpringLaw;
use crate::{Matrix, Pose, Vector};
use nalgebra::Unit;
use std::ops::RangeInclusive;

/// A degree of freedom of a station, as scenarios spell it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum HoldWord {
    /// The point.
    Position,
    /// d3.
    Tangent,
    /// Rotation about d3.
    Twist,
}

/// Prescribed rotations of a station.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RotationHold {
    /// None.
    Free,
    /// d3 is prescribed; rotation about it is free.
    Tangent,
    /// Rotation about d3 is prescribed; d3 is free.
    Twist,
    /// All.
    All,
    /// All but the rotation about this world axis: a hinge.
    Hinge(Unit<Vector>),
}

/// Degrees of freedom of a station that a constraint prescribes.
#[derive(Clone, Debug, PartialEq)]
pub struct Hold {
    /// Whether the position is prescribed.
    pub position: bool,
    /// World directions (orthonormal, at most two) along which the held point is free to move.
    pub rails: Vec<Vector>,
    /// Rotations.
    pub rotation: RotationHold,
}

impl Hold {
    /// Converts the words of a scenario.
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

    /// World directions in which the point is held.
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

/// Input of a constraint's model: m stations and n nodes of its span; m or n may be 0.
#[derive(Clone, Copy, Debug)]
pub struct ConstraintView<'a> {
    /// Pose of each station; the identity orientation for a station without a frame.
    pub stations: &'a [Pose],
    /// Target of each station; see [`Constraint::target`]. The targets of the further stations move with the first as
    /// one rigid body: they keep the relative poses that the stations had when the constraint began to act.
    pub targets: &'a [Pose],
    /// Position of each node of the span, m.
    pub span: &'a [Vector],
    /// Unstressed length of cable lumped at each of these nodes, m: half of the span's segments on either side.
    pub span_lengths: &'a [f64],
    /// Completed fraction, 0 to 1, of the step in which the constraint began to act; 1 in later steps.
    pub progress: f64,
    /// Memory of the constraint; see [`Constraint::memory`].
    pub memory: &'a [f64],
    /// Tension of the cable before and behind each station, by its arc length, N; 0 at a joint and beyond the end of a
    /// branch. Known in [`Constraint::outputs`] and [`Constraint::commit`] alone, else empty.
    pub tensions: &'a [[f64; 2]],
}

/// Energy of stations and of nodes of a span, for example of a spring.
///
/// Contract: twice differentiable (except where a second derivative jumps), finite, the same bits for the same input.
/// Derivatives are taken along `x + δ`, `q ∘ exp(θ)` (θ in the station's body frame). All slices for derivatives
/// are zero on entry. If the energy is least at the targets, that least value is 0.
pub trait Potential: Send + Sync {
    /// Energy, J.
    fn energy(&self, at: &ConstraintView<'_>) -> f64;
    /// First derivatives; returns the energy, J. `stations` has 2 m entries: ∂E/∂x (N) and ∂E/∂θ (N m) of each
    /// station; `span` has n: ∂E/∂x (N) of each node.
    fn gradient(&self, at: &ConstraintView<'_>, stations: &mut [Vector], span: &mut [Vector]) -> f64;
    /// Second derivatives. `stations` is a 2 m × 2 m table of blocks, row by row, in the order of [`Self::gradient`],
    /// symmetric as a whole: block (2 a + 1, 2 b) is ∂²E/∂θ_a∂x_b. `span` has n blocks ∂²E/∂x²: the nodes
    /// are coupled neither with one another nor with stations.
    fn hessian(&self, at: &ConstraintView<'_>, stations: &mut [Matrix], span: &mut [Matrix]);
}

/// Relation that a residual must satisfy.
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
    /// Relation that it must satisfy.
    pub relation: Relation,
    /// Scale in the residual's unit: 1 m for a distance, 1 rad for an angle. The tolerance of the residual is the force
    /// tolerance times a hundredth of this (1e-8 of it where the force tolerance is 1e-6).
    pub scale: f64,
}

impl Residual {
    /// Equation `c = 0` with this scale.
    pub fn zero(scale: f64) -> Self {
        Self { relation: Relation::Zero, scale }
    }
    /// Inequality `c ≤ 0` with this scale.
    pub fn not_positive(scale: f64) -> Self {
        Self { relation: Relation::NotPositive, scale }
    }
}

/// Equations `c = 0` and inequalities `c ≤ 0` of stations, and of each node of a span separately. They are enforced
/// by an augmented Lagrangian (Hestenes 1969, Powell 1969; Rockafellar 1973 for inequalities); the generalised force on
/// the harness is −Jᵀλ.
///
/// Contract: twice differentiable, finite, the same bits for the same input; a violated residual has a derivative that
/// is not 0. Derivatives are taken as those of a [`Potential`], and all slices are zero on entry. Order of the
/// residuals: those of the stations, then those of the first node of the span, of the second, and so on.
pub trait Equations: Send + Sync {
    /// The residuals of the stations.
    fn of_stations(&self) -> Vec<Residual>;
    /// The residuals of one node of the span, the same for every node.
    fn of_each_node(&self) -> Vec<Residual> {
        Vec::new()
    }
    /// Values c.
    fn residuals(&self, at: &ConstraintView<'_>, c: &mut [f64]);
    /// c and the Jacobian J = ∂c/∂(x, θ). `stations` has a row of 2 m vectors for each residual of the stations:
    /// ∂c/∂x and ∂c/∂θ of each station; `span` has one vector for each residual of a node: ∂c/∂x of that
    /// node.
    fn jacobian(&self, at: &ConstraintView<'_>, c: &mut [f64], stations: &mut [Vector], span: &mut [Vector]);
    /// Σ w c″ over all residuals, in the layout of [`Potential::hessian`]. The default leaves it at zero: the
    /// Gauss–Newton approximation, which takes more iterations where a residual is curved.
    fn curvature(&self, _at: &ConstraintView<'_>, _w: &[f64], _stations: &mut [Matrix], _span: &mut [Matrix]) {}
}

/// Kind of action of a constraint.
pub enum Action<'a> {
    /// Prescribes some of the six degrees of freedom of its one station; they are eliminated, so the result is exact.
    Prescribed(&'a Hold),
    /// Adds a potential energy of the stations or of the span.
    Potential(&'a dyn Potential),
    /// Imposes equations and inequalities on them.
    Equations(&'a dyn Equations),
    /// Does both, such as a clip that holds two directions and is a spring in the third.
    PotentialAndEquations(&'a dyn Potential, &'a dyn Equations),
}

impl<'a> Action<'a> {
    /// Its potential, if it has one.
    pub fn potential(&self) -> Option<&'a dyn Potential> {
        match *self {
            Self::Potential(potential) | Self::PotentialAndEquations(potential, _) => Some(potential),
            Self::Prescribed(_) | Self::Equations(_) => None,
        }
    }

    /// Its equations and inequalities, if it has some.
    pub fn equations(&self) -> Option<&'a dyn Equations> {
        match *self {
            Self::Equations(equations) | Self::PotentialAndEquations(_, equations) => Some(equations),
            Self::Prescribed(_) | Self::Potential(_) => None,
        }
    }
}

/// A constraint on one or several stations, or along a span. Its target pose belongs to the [`crate::Conditions`] and
/// is moved by the steps.
///
/// Contract: hot calls (those of [`Action`], [`Self::target`]) neither fail nor allocate, and return the same result
/// each time.
pub trait Constraint: Send + Sync {
    /// Its action.
    fn action(&self) -> Action<'_>;
    /// The coefficients of the energy, if it is a [`Potential`] of this form that acts on one station alone, without
    /// equations.
    fn law(&self) -> Option<SpringLaw> {
        None
    }
    /// Whether it needs its stations to have frames.
    fn needs_frame(&self) -> bool {
        match self.action() {
            Action::Prescribed(hold) => hold.rotation != RotationHold::Free,
            _ => true,
        }
    }
    /// Whether the energy and the residuals are invariant when stations, span and targets undergo the same rigid
    /// motion: false if the model has a place or a direction of the world of its own.
    fn objective(&self) -> bool {
        true
    }
    /// Target at a given progress of the step in which the constraint began to act, from the target of the scenario
    /// (`base`); see [`ConstraintView::progress`].
    fn target(&self, base: &Pose, _progress: f64) -> Pose {
        *base
    }
    /// Initial memory, set each time the constraint begins to act; its length stays the same.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Updates the memory in place. Called once at the equilibrium that ends an increment, never for a trial that is
    /// discarded.
    fn commit(&self, _at: &ConstraintView<'_>, _memory: &mut [f64]) {}
    /// Names and values (SI) of its outputs: all that its kind declares ([`crate::registry::ConstraintKind`]) but the
    /// events that do not happen. Called at the equilibrium that ends an increment, before [`Self::commit`]; may
    /// allocate.
    fn outputs(&self, _at: &ConstraintView<'_>) -> Vec<(String, f64)> {
        Vec::new()
    }
    /// Message of a fatal fault, if one has occurred (a plugin that crashed or exceeded its time limit): its results
    /// are then invalid, and the run ends.
    fn fault(&self) -> Option<String> {
        None
    }
    /// Remarks for the user.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Use of a span by a kind of constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpanUse {
    /// No.
    Never,
    /// If the scenario gives one.
    Maybe,
    /// Always.
    Always,
}

/// Stations and span that a kind of constraint attaches to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attaches {
    /// Permitted number of stations.
    pub stations: RangeInclusive<usize>,
    /// Whether it acts along a span.
    pub span: SpanUse,
}

impl Attaches {
    /// Attaches to stations, so many of them, and to no span.
    pub fn to_stations(stations: RangeInclusive<usize>) -> Self {
        Self { stations, span: SpanUse::Never }
    }
}

/// One station and no span.
impl Default for Attaches {
    fn default() -> Self {
        Self::to_stations(1..=1)
    }
}

/// Load limits of a constraint. Beyond them the constraint still acts, and the run reports an event.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Pull-out force, N.
    pub pull_out_force: Option<f64>,
    /// Largest permitted moment, N m.
    pub max_moment: Option<f64>,
    /// Force that seats the connector, N.
    pub insertion_force: Option<f64>,
}

/// Sliding of the cable through a constraint: its place is fixed in space, not in the material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slide {
    /// Coefficient of Coulomb friction: bound of the ratio of axial to transverse force. 0 is smooth.
    pub friction: f64,
}

/// Station of a constraint, as input of its factory.
#[derive(Clone, Debug, PartialEq)]
pub struct StationSpec {
    /// Branch and arc length, m; `None`: a joint.
    pub place: Option<(String, f64)>,
    /// Diameter of the cable there, m; at a joint that of the thickest arm.
    pub diameter: f64,
}

/// Span of a constraint, as input of its factory.
#[derive(Clone, Debug, PartialEq)]
pub struct SpanSpec {
    /// Branch.
    pub branch: String,
    /// Arc lengths of its ends, m.
    pub range: (f64, f64),
    /// Diameter of the cable, m.
    pub diameter: f64,
}

/// Input of a constraint factory.
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
    /// `hold = […]`, if given.
    pub hold: Option<Vec<HoldWord>>,
    /// `free_axis`.
    pub free_axis: Option<Unit<Vector>>,
    /// `rail`.
    pub rails: Vec<Vector>,
}

impl ConstraintSpec {
    /// The prescribed degrees of freedom: those given in the scenario, or else `default`.
    pub fn hold(&self, default: &[HoldWord]) -> Hold {
        Hold::new(self.hold.as_deref().unwrap_or(default), self.free_axis, &self.rails)
    }
}
