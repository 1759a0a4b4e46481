//! Results of an increment: shapes, forces, events, clearances, twist.

mod clearance;
pub mod events;
mod linking;
mod log;
pub mod result;
mod twist_loss;

pub(crate) use linking::passed;
pub use log::{EventLog, Occurrence};
pub(crate) use twist_loss::LostTurns;
