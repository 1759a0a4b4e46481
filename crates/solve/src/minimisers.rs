//! Minimisers `newton`, `lbfgs` and `ncg`, with their common parts: static condensation, line search, convergence
//! monitor.

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
