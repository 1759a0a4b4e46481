//! From a checked scenario to the network, the schedule and the minimiser.

mod mesh;
pub(crate) mod network;
mod notes;
pub(crate) mod placement;
pub(crate) mod requirements;
