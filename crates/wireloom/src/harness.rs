//! The harness that is computed: the network of branches, joints, constraints and bodies, its state, and the schedule
//! of its steps.
//!
//! [`load`](crate::load) builds it; it is here to be read, and to be laid out or balanced by own programs.
//!
//! ```
//! let text = std::fs::read_to_string("../../scenarios/first.toml")?;
//! let (_, built) = wireloom::load(&text, &wireloom::registry()).expect("no faults");
//! for branch in &built.network.branches {
//!     let mesh = branch.rod.mesh();
//!     println!("{}: {} m, {} nodes", branch.name, mesh.length(), mesh.nodes());
//! }
//! let state = wireloom::harness::place(&built.network, &built.schedule);
//! assert_eq!(state.points.len(), built.network.points);
//! # Ok::<(), std::io::Error>(())
//! ```

pub use wireloom_core::load::{Axes, Dead, DeadLine, Flow, Follower, FollowerLine, LineLoad, LoadAction, PointLoad};
pub use wireloom_core::mechanism::{JointKind, Mechanism, MechanismJoint, Mount};
pub use wireloom_core::network::{
    AttachedConstraint, Branch, BranchPlan, ConstraintPlan, Joint, JointPlan, Load, LoadSite, Network, NodeRange,
    Place, Site, Span,
};
pub use wireloom_core::obstacle::{Obstacle, Shape, ShapeFile, Surface};
pub use wireloom_core::rod::Mesh;
pub use wireloom_core::steps::{
    Bodies, Carried, Course, Drive, Initial, Journey, Move, ObstacleMove, Operation, Schedule, Step, Track, Turn,
};
pub use wireloom_core::{Conditions, Problem, Section, State, Tangent};
pub use wireloom_solve::contact::multipliers::update_constraints;
pub use wireloom_solve::start::layout::place;
pub use wireloom_solve::start::prolongation::prolonged;
