//! The minimisers `newton`, `lbfgs` and `ncg`, and what they share.

pub mod condensation;
mod convergence;
mod descent;
pub mod lbfgs;
mod line_search;
pub mod ncg;
pub mod newton;
mod preconditioner;
mod step_control;
mod trace;
mod transport;
