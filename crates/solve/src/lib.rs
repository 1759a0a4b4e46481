//! CPU minimisers, certificate and step driver.
//!
//! The Hessian of a harness is a sparse symmetric matrix of 3 × 3 blocks, one block row for each point and each
//! frame. [`structure`] orders the blocks by minimum degree, which on trees gives no fill at all; [`gather`]
//! puts the parts' second derivatives into a [`matrix`], [`factor`] factorises it in place, [`newton`] walks downhill
//! with it, [`settle`] brings the points into balance after every step, [`border`] adds the arc lengths of fixings that slide,
//! [`nested`] carries a start over from a coarse mesh, [`certificate`] grades the result, [`steps`] carries out the assembly, [`events`] keeps the log of what happened on the way.

pub mod border;
pub mod certificate;
pub mod checkpoint;
mod clips;
pub mod events;
pub mod factor;
pub mod gather;
pub mod matrix;
pub mod nested;
pub mod newton;
mod operations;
pub mod parts;
mod plan;
pub mod result;
pub mod settle;
pub mod start;
pub mod steps;
pub mod structure;

pub use steps::{Control, Progress, carry_out};

use wireloom_core::Registry;

/// Adds the minimisers.
///
/// # Panics
/// If one of their names is taken: built-ins are registered first.
pub fn register(registry: &mut Registry) {
    registry.add_minimiser(newton::kind()).map_err(|_| "built-ins are registered first").unwrap();
}
