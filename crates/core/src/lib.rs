//! Basic types of Wireloom: the network of a harness, its state, its energy, and the traits that rods, joints,
//! constraints, shapes and minimisers implement.
//!
//! No I/O, no printing, no file format, no graphics API, no dynamic library: see `crates/README.md`.
//!
//! | symbol | name in code | unit | meaning |
//! | --- | --- | --- | --- |
//! | `x_i` | `points` | m | position of node `i` |
//! | `q_c` | `frames` | – | frame of a segment or of a station; columns d1, d2, d3 (d3: the tangent) |
//! | `ℓ_j` | `rest_lengths` | m | unstressed length of segment `j` |
//! | `λ_c` | `coupling_lengths` | m | length of the bend-twist coupling between frames `c` and `c+1` |
//! | `Γ_j` | strain | – | `R_jᵀ (x_{j+1} − x_j)/ℓ_j − e3`: shear along d1, d2; stretch along d3 |
//! | `κ_c` | curvature | 1/m | `(2/λ_c) (1 + v·v/6) v`, `v = Im(q̄_c q_{c+1})`: bending (d1, d2), twist (d3) |
//! | `n_j` | force | N | `R_j C Γ_j`: internal force that the part with larger s exerts on the part with smaller s |
//! | `m_c` | moment | N m | internal moment, with the same sign |

use serde::{Deserialize, Serialize};

pub mod arc;
mod build_error;
pub mod conditions;
pub mod constitutive;
pub mod constraint;
pub mod curve;
pub mod equilibrium;
pub mod event;
pub mod identity;
pub mod joint;
pub mod law;
pub mod load;
pub mod mechanism;
mod mesh_motion;
pub mod minimiser;
pub mod monitor;
pub mod network;
pub mod numeric;
pub mod obstacle;
pub mod prescribed;
pub mod problem;
mod quantity;
pub mod registry;
pub mod requirement;
pub mod rod;
pub mod rotation;
pub mod scales;
pub mod section;
pub mod sections;
pub mod state;
pub mod status;
pub mod steps;
pub mod terms;
pub mod variable;

/// A vector of three numbers.
pub type Vector = nalgebra::Vector3<f64>;
/// A 3 × 3 matrix.
pub type Matrix = nalgebra::Matrix3<f64>;
/// A unit quaternion.
pub type Rotation = nalgebra::UnitQuaternion<f64>;

/// Position (m) and orientation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Position, m.
    pub position: Vector,
    /// Orientation: columns d1, d2, d3 in world axes.
    pub orientation: Rotation,
}

impl Pose {
    /// Pose of the world frame.
    pub fn identity() -> Self {
        Self { position: Vector::zeros(), orientation: Rotation::identity() }
    }

    /// World pose of a body whose pose in the frame of `self` is `local`.
    pub fn compose(&self, local: &Pose) -> Pose {
        Pose {
            position: self.position + self.orientation * local.position,
            orientation: self.orientation * local.orientation,
        }
    }

    /// World position of a point with these coordinates in the axes of the pose, m.
    pub fn world(&self, x: &Vector) -> Vector {
        self.position + self.orientation * x
    }

    /// Coordinates of a world point in the axes of the pose, m.
    pub fn local(&self, x: &Vector) -> Vector {
        self.orientation.inverse_transform_vector(&(x - self.position))
    }

    /// Inverse of the pose.
    pub fn inverse(&self) -> Pose {
        let orientation = self.orientation.inverse();
        Pose { position: -(orientation * self.position), orientation }
    }
}

pub use build_error::BuildError;
pub use conditions::{Conditions, System};
pub use constraint::{
    Action, Constraint, ConstraintView, Equations, Hold, HoldWord, Limits, Potential, Relation, Residual, RotationHold,
    Slide,
};
pub use equilibrium::{Run, StepResult};
pub use event::{Event, EventKind, EventPlace, Moment};
pub use joint::{Arm, ArmSpring, Continuation, JointModel, JointShape, Mounting};
pub use minimiser::{Minimiser, Report, Stop};
pub use monitor::Monitor;
pub use network::Network;
pub use problem::Problem;
pub use registry::{Parameter, Parameters, Quantity, Registry, Value};
pub use rod::{BranchShape, RodSegment};
pub use section::Section;
pub use sections::Sections;
pub use state::{State, Tangent};
pub use status::Status;
