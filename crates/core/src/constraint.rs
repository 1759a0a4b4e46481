//! The trait of a constraint: what fixes a station of the harness.

use crate::{Matrix, Pose, Vector};
use nalgebra::Unit;

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

/// A potential on the pose of a station: a spring, say.
///
/// Derivatives are taken along `x + δ`, `q ∘ exp(θ)` (θ in the station's body frame).
pub trait Potential: Send + Sync {
    /// Energy, J.
    fn energy(&self, at: &Pose, target: &Pose) -> f64;
    /// (∂E/∂x, N; ∂E/∂θ, N m).
    fn gradient(&self, at: &Pose, target: &Pose) -> (Vector, Vector);
    /// `[∂²E/∂x², ∂²E/∂θ∂x, ∂²E/∂θ²]`.
    fn hessian(&self, at: &Pose, target: &Pose) -> [Matrix; 3];
}

/// How a constraint acts.
pub enum Action<'a> {
    /// Some of the station's six freedoms are given: eliminated, exact.
    Prescribed(&'a Hold),
    /// An energy pulls the station towards its target.
    Potential(&'a dyn Potential),
}

/// A fixing at one station. Its target pose belongs to the [`crate::Conditions`] and is moved by the steps.
///
/// Contract: a potential is ≥ 0, 0 at the target, twice differentiable, and unchanged when station and
/// target undergo the same rigid motion.
pub trait Constraint: Send + Sync {
    /// How it acts.
    fn action(&self) -> Action<'_>;
    /// Whether it needs the station to have a frame.
    fn needs_frame(&self) -> bool {
        match self.action() {
            Action::Prescribed(hold) => hold.rotation != RotationHold::Free,
            Action::Potential(_) => true,
        }
    }
}

/// What a fixing bears. Beyond it the fixing still holds: the run says so, and the engineer judges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Largest force it takes before it comes off, N.
    pub pull_out_force: Option<f64>,
    /// Largest moment it takes, N m.
    pub max_moment: Option<f64>,
    /// Force it takes to push it home, N.
    pub insertion_force: Option<f64>,
}

/// The cable may run through a fixing: its place is fixed in space, not in the material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slide {
    /// Coulomb coefficient: the axial force it takes is at most so many times the force across. 0 is smooth.
    pub friction: f64,
}

/// Everything a constraint factory is told.
#[derive(Clone, Debug, Default)]
pub struct ConstraintSpec {
    /// Name in the scenario.
    pub name: String,
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
