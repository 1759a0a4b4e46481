//! Traits, specifications and kinds for own rods, joints, constraints, shapes and minimisers.
//!
//! A kind has a name, declared parameters and a factory. Scenarios choose own kinds by their names, as they choose
//! built-in ones.
//!
//! ```
//! use wireloom::parts::{Minimiser, MinimiserKind, Newton, Problem, Report, State, Stop};
//!
//! /// Newton's method under another name.
//! struct Own(Newton);
//!
//! impl Minimiser for Own {
//!     fn name(&self) -> &str {
//!         "own"
//!     }
//!     fn minimise(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report {
//!         self.0.minimise(problem, state, stop)
//!     }
//!     fn forget(&mut self) {
//!         self.0.forget();
//!     }
//! }
//!
//! let mut registry = wireloom::registry();
//! let own = MinimiserKind {
//!     name: "own".into(),
//!     doc: "Newton's method under another name".into(),
//!     parameters: vec![],
//!     build: Box::new(|(), _| Ok(Box::new(Own(Newton::new())))),
//! };
//! assert!(registry.add_minimiser(own).is_ok());
//! ```
//!
//! `examples/own_parts.rs` has a rod, a joint and a minimiser that are run.

pub use wireloom_core::constitutive::{
    ConstitutiveLaw, ConstitutiveLaws, ConstitutiveSpec, Past, Point, Response, strain_under,
};
pub use wireloom_core::constraint::{
    Action, Attaches, Constraint, ConstraintSpec, ConstraintView, Equations, Hold, HoldWord, Limits, Potential,
    Relation, Residual, RotationHold, Slide, SpanSpec, SpanUse, StationSpec,
};
pub use wireloom_core::joint::{Arm, ArmSpring, JointModel, JointShape, JointSpec, Mounting};
pub use wireloom_core::minimiser::{Minimiser, Report, Stop};
pub use wireloom_core::numeric::{self, ConstraintEnergy, JointEnergy, Numeric};
pub use wireloom_core::obstacle::{Shape, ShapeSpec, Touch};
pub use wireloom_core::registry::{
    BuildError, ConstitutiveKind, ConstraintKind, Factory, Form, JointKind, Kind, MinimiserKind, Output, Parameter,
    Parameters, Quantity, Registry, RodKind, ShapeKind, Value,
};
pub use wireloom_core::rod::{BranchHessian, BranchShape, RodEnergy, RodSegment, RodSpec};
pub use wireloom_core::status::Status;
pub use wireloom_core::{Conditions, Monitor, Problem, Section, State, Tangent, curve, law};
pub use wireloom_models::kernel;
pub use wireloom_models::{constraints, joints, rods};
pub use wireloom_solve::minimisers::newton::Newton;
