//! Report of an increment: shapes, forces, events, clearances, lost twist.

pub mod branch;
pub(crate) mod clearance;
pub(crate) mod deviation;
pub mod discretisation;
pub(crate) mod driven;
pub mod events;
mod lines;
mod linking;
mod log;
pub(crate) mod nodes;
mod part;
pub(crate) mod passage;
pub(crate) mod requirements;
pub mod result;
pub(crate) mod sheet;
pub(crate) mod spans;
pub(crate) mod time_error;
mod twist_loss;
pub(crate) mod violations;

pub use clearance::{clearance_from_obstacle, clearance_of_branches};
pub(crate) use linking::self_passing;
pub use log::{EventLog, Occurrence};
pub use sheet::MARGIN_WITHOUT_ERROR;
pub(crate) use twist_loss::TwistMonitor;
