//! Steps of an assembly: increments, each of which ends in an equilibrium that the certificate grades.

pub mod certificate;
pub mod checkpoint;
pub mod checkpoint_transfer;
mod clips;
mod driver;
mod equilibrium;
mod guide;
mod increment;
mod initial_equilibrium;
pub mod interactive;
mod jump;
mod mesh_motion;
pub mod nearby;
mod operations;
mod plan;
mod progress;
mod refine;
mod run;
pub mod stability;
mod step_result;
mod time;

pub use guide::Guide;
pub use initial_equilibrium::start_near;
pub use progress::{Control, Interruption, Progress};
pub use run::{carry_out, steps_of};
