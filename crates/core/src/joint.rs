//! Trait of a joint, which connects the arms of a break-out.

use crate::law::JointLaw;
use crate::section::SectionFriction;
use crate::{Matrix, Rotation, Section, Vector};

/// One arm of a joint, as input of its model.
#[derive(Clone, Debug)]
pub struct Arm {
    /// Name of the branch.
    pub branch: String,
    /// Whether the branch starts here (its d3 then points out of the joint).
    pub starts_here: bool,
    /// Rest frame of the branch (d3 `from → to`) at the joint itself, in the joint's frame.
    pub rest: Rotation,
    /// Position of the arm's end in the joint's frame, m.
    pub offset: Vector,
    /// The arm's section.
    pub section: Section,
    /// Rest length of its segment at the joint, m.
    pub segment_length: f64,
    /// Unstressed length of its branch, m.
    pub length: f64,
    /// Rest curvature of its branch, 1/m.
    pub curvature: Vector,
    /// What holds it to a compliant hub, as far as the scenario gives it.
    pub spring: ArmSpring,
}

/// Spring and friction between an arm and its hub, about the axes of the arm's frame; `None`: not given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ArmSpring {
    /// Stiffness about d1 and d2, N m/rad.
    pub bending: Option<[f64; 2]>,
    /// Stiffness about d3, N m/rad.
    pub torsion: Option<f64>,
    /// Friction beside it; empty where the scenario gives none.
    pub friction: SectionFriction,
}

/// Fraction of the wires of arm `from` that passes to arm `to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WireShare {
    /// Index of the first arm.
    pub from: usize,
    /// Index of the second arm.
    pub to: usize,
    /// The fraction, 0 to 1.
    pub fraction: f64,
}

/// Input of a joint factory.
#[derive(Clone, Debug)]
pub struct JointSpec {
    /// Name of the vertex.
    pub name: String,
    /// The arms, in the order of the scenario.
    pub arms: Vec<Arm>,
    /// Distribution of the wires; empty where the scenario has no `wires` table.
    pub wires: Vec<WireShare>,
}

impl JointSpec {
    /// Remark of a model that is told EI1, EI2 and GJ of its arms alone, where one of them couples bending and twist.
    pub fn note_on_coupling(&self) -> Option<String> {
        let arm = self.arms.iter().find(|arm| arm.section.couples())?;
        let (name, section) = (&self.name, &arm.section.name);
        Some(format!(
            "joint `{name}`: its model is told EI1, EI2 and GJ of its arms, not the `coupling_stiffness` of section \
             `{section}`"
        ))
    }
}

/// Connection of the arms to the joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mounting {
    /// The arms share one point; the joint's energy couples the frames of their segments at the
    /// joint. The joint has a position and no frame.
    Point,
    /// The arms share one point; the end of every arm has a frame of its own there, that of a station, and the joint's
    /// energy couples these frames. The joint has a position and no frame.
    Stations,
    /// The joint is a hub with a pose; the end station of every arm is rigidly connected to it.
    Pose,
    /// The joint is a hub with a pose; the end of every arm is fixed to it at the arm's offset and has a frame of its
    /// own there, that of a station. The joint's energy couples these frames and, behind them, the frame of the hub.
    CompliantHub,
}

impl Mounting {
    /// Whether the joint is a hub: it has a frame, and arms leave it at offsets.
    pub fn is_hub(self) -> bool {
        matches!(self, Mounting::Pose | Mounting::CompliantHub)
    }
}

/// What the rod of an arm couples beyond its first segment: pairs of couplings ([`crate::rod::CellPair`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Continuation {
    /// Length λ of the coupling between the first two segments at the joint, m.
    pub length: f64,
    /// Factor on the energy of the variation of curvature ([`crate::law::RodLaw::variation`]).
    pub variation: f64,
}

/// What the energy of a joint depends on.
#[derive(Clone, Copy, Debug)]
pub struct JointShape<'a> {
    /// Frames of the arms' segments at the joint, or of the stations at their ends, in the order of the arms, as frames
    /// of their branches: d3 `from → to`; behind them that of a compliant hub, or those of the second segments where
    /// the model continues the rods ([`JointModel::continue_rods`]).
    pub frames: &'a [Rotation],
    /// Memory of the joint; see [`JointModel::memory`].
    pub memory: &'a [f64],
}

/// A joint of any number k ≥ 2 of arms.
///
/// A joint may remember ([`Self::memory`]). Its energy is then the incremental potential of its law for the memory at
/// the start of the increment, as that of a rod; see [`crate::RodSegment`].
///
/// Contract: the energy depends on a [`JointShape`]. It is ≥ 0, 0 at the rest directions with the initial memory (near
/// them where arms are curved at rest), unchanged by a common rotation, and unchanged when the direction of a branch is
/// reversed. Energy and derivatives have no default: a joint that leaves one out would exert nothing. A hub with
/// rigidly connected arms ([`Mounting::Pose`]) has no energy: it returns 0 and adds nothing. Methods neither allocate
/// nor fail.
pub trait JointModel: Send + Sync {
    /// Connection of the arms.
    fn mounting(&self) -> Mounting;

    /// Called once, with what the rods of the arms couple beyond their first segments ([`Mounting::Point`] only). A
    /// model that continues the rods through the joint returns true: its energy then depends on the frames of the
    /// second segments too, and all slices have those of the first segments and then those of the second ones. It
    /// remembers nothing.
    fn continue_rods(&mut self, _arms: &[Option<Continuation>]) -> bool {
        false
    }

    /// Energy, J.
    fn energy(&self, shape: &JointShape<'_>) -> f64;

    /// Adds ∂E/∂θ_a (N m, body frame a). Returns the energy, J.
    fn add_gradient(&self, shape: &JointShape<'_>, gradient: &mut [Vector]) -> f64;

    /// Adds ∂²E/∂θ_a∂θ_b to `hessian[a * k + b]` for b ≤ a (N m), k being the number of frames.
    fn add_hessian(&self, shape: &JointShape<'_>, hessian: &mut [Matrix]);

    /// Initial memory: state variables, their number always the same; empty for an elastic joint. It is that of the
    /// joint at rest, and held fixed while the minimum of an increment is searched for.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Updates the memory, on entry that of `shape`, to the equilibrium `shape` that ends an increment. Adds the energy
    /// dissipated in it at each arm to `dissipated`, J, never negative. With the new memory the joint exerts the same
    /// moments; a second call then changes no bit and adds 0. Never called for a trial that is discarded.
    fn commit(&self, _shape: &JointShape<'_>, _memory: &mut [f64], _dissipated: &mut [f64]) {}

    /// Set of an arm with this memory: the turn from its rest frame that would remain if nothing exerted a moment
    /// (rotation vector in the axes of the arm, rad). `None`: it is not known.
    fn set(&self, _arm: usize, _memory: &[f64]) -> Option<Vector> {
        None
    }

    /// The coefficients of the energy, if it is of this form.
    fn law(&self) -> Option<JointLaw> {
        None
    }

    /// Message of a fatal fault, if one has occurred (a plugin that crashed or exceeded its time limit): its results
    /// are then invalid, and the run ends.
    fn fault(&self) -> Option<String> {
        None
    }

    /// Remarks for the user, for example on wires that end in the joint.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}
