//! The trait of a joint: what holds the arms of a break-out together.

use crate::law::JointLaw;
use crate::{Matrix, Rotation, Section, Vector};

/// One arm of a joint, as its model sees it.
#[derive(Clone, Debug)]
pub struct Arm {
    /// Name of the branch.
    pub branch: String,
    /// Whether the branch starts here (its d3 then points out of the joint).
    pub starts_here: bool,
    /// Rest frame of the branch (d3 `from → to`) at the joint itself, in the joint's frame.
    pub rest: Rotation,
    /// Where the arm leaves, in the joint's frame, m.
    pub offset: Vector,
    /// The arm's section.
    pub section: Section,
    /// Rest length of its segment at the joint, m.
    pub segment_length: f64,
    /// Unstressed length of its branch, m.
    pub length: f64,
    /// Rest curvature of its branch, 1/m.
    pub curvature: Vector,
}

/// Which fraction of the wires of arm `from` passes to arm `to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WireShare {
    /// Index of the first arm.
    pub from: usize,
    /// Index of the second arm.
    pub to: usize,
    /// Share, 0 to 1.
    pub fraction: f64,
}

/// Everything a joint factory is told.
#[derive(Clone, Debug)]
pub struct JointSpec {
    /// Name of the vertex.
    pub name: String,
    /// The arms, in the order of the scenario.
    pub arms: Vec<Arm>,
    /// Anatomy; empty where the scenario has no `wires` table.
    pub wires: Vec<WireShare>,
}

/// How the arms hang on the joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mounting {
    /// The arms share one point; the joint's energy couples the frames of their segments at the
    /// joint. The joint has a position and no frame.
    Point,
    /// The arms share one point; the end of every arm has a frame of its own there, that of a station, and the joint's energy couples
    /// these. The joint has a position and no frame.
    Stations,
    /// The joint is a hub with a pose; the end station of every arm is carried by it rigidly.
    Pose,
}

/// A joint of any number k ≥ 2 of arms.
///
/// Contract: the energy depends on the frames of the arms' segments at the joint, or of the stations at their ends (in the order of the
/// arms, as frames of their branches: d3 `from → to`), is ≥ 0, 0 at the rest directions (near them where arms are
/// curved at rest), unchanged by a common rotation, and unchanged when a branch is run from its other end. Hubs that carry
/// their arms rigidly ([`Mounting::Pose`]) have no energy and keep the default methods. Methods neither allocate
/// nor fail.
pub trait JointModel: Send + Sync {
    /// How the arms hang on it.
    fn mounting(&self) -> Mounting;

    /// Energy, J.
    fn energy(&self, _frames: &[Rotation]) -> f64 {
        0.0
    }

    /// Adds ∂E/∂θ_a (N m, body frame of arm a). Returns the energy, J.
    fn add_gradient(&self, _frames: &[Rotation], _gradient: &mut [Vector]) -> f64 {
        0.0
    }

    /// Adds ∂²E/∂θ_a∂θ_b to `hessian[a * k + b]` for b ≤ a (N m).
    fn add_hessian(&self, _frames: &[Rotation], _hessian: &mut [Matrix]) {}

    /// The energy as plain numbers, if it is of that form.
    fn law(&self) -> Option<JointLaw> {
        None
    }

    /// Why nothing it has said may be relied on any more, if so (a plugin that crashed or took too long); the run then ends.
    fn fault(&self) -> Option<String> {
        None
    }

    /// What an engineer should know about this joint: wires that end in it, for example.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}
