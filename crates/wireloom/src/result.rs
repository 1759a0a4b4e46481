//! Result of a run: its status, its verdict, the equilibrium at the end of each step, and events.
//!
//! ```
//! use wireloom::{Control, Status};
//!
//! let text = std::fs::read_to_string("../../scenarios/first.toml")?;
//! let (_, built) = wireloom::load(&text, &wireloom::registry()).expect("no faults");
//! let run = wireloom::run(built, &mut |_, _| Control::Continue);
//! assert_eq!(run.status(), Status::Converged);
//! println!("{}", run.verdict().word());
//! for line in &run.requirements {
//!     println!("{}: {} ({:?})", line.name, line.verdict.word(), line.margin());
//! }
//! for event in &run.events {
//!     println!("{} at {}: {}", event.kind.title(), event.place, event.message);
//! }
//! for plug in &run.steps.last().expect("a step").constraints {
//!     println!("{} exerts {:.3} N", plug.name, plug.force.norm());
//! }
//! # Ok::<(), std::io::Error>(())
//! ```

pub use wireloom_core::equilibrium::{
    ArmFriction, BranchResult, Clearance, ClearanceFrom, ConstraintResult, Deviation, DeviationCause, DrawnStart,
    EndsElsewhere, Energy, FrictionResult, JointResult, Library, MarkerResult, MechanismResult, MinimiserResult,
    ObstacleResult, OperationResult, Outcome, PartFamily, PartFault, Run, SlideMotion, SlideResult, SpanResult,
    StationResult, StepResult, TightestBend,
};
pub use wireloom_core::event::{Event, EventKind, EventPlace, Group, Moment, grouped};
pub use wireloom_core::identity::{Component, Connection, Identified, Identities, Identity, WireEnd};
pub use wireloom_core::requirement::{
    Bound, Measure, Motion, Origin, Part, Requirement, RequirementResult, Severity, Verdict, Violation, by_urgency,
    verdict,
};
pub use wireloom_core::sections::{Bend, SectionResult};
pub use wireloom_core::status::Status;
