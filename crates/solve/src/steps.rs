//! Steps of an assembly: increments, each of which ends in an equilibrium that the certificate grades.

pub mod certificate;
pub mod checkpoint;
pub mod checkpoint_transfer;
mod clips;
mod driver;
mod initial_equilibrium;
pub mod interactive;
mod operations;
mod plan;
mod progress;
mod refine;
pub mod stability;

pub use driver::carry_out;
pub use initial_equilibrium::start_near;
pub use progress::{Control, Progress};
