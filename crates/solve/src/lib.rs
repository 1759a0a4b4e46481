//! CPU minimisers, certificate and step driver.
//!
//! The Hessian of a harness is a sparse symmetric matrix of 3 × 3 blocks, one block row for each point and each
//! frame. [`structure`] orders the blocks by minimum degree, which on trees gives no fill at all; [`gather`]
//! puts the parts' second derivatives into a [`matrix`], [`factor`] factorises it in place, [`newton`] walks downhill
//! with it ([`lbfgs`] and [`ncg`] go by gradients), [`settle`] brings the points into balance after every step, [`border`] adds the arc
//! lengths of fixings that slide, [`dead_moments`] loads without a potential, [`nested`] carries a start over from a coarse mesh, or from a neighbour in a sweep, [`changed`] to the same harness with other fixings, [`certificate`] grades the result by forces and [`stability`] by second derivatives, [`steps`]
//! carries out the assembly, [`hands`] one increment at a time, [`events`] keeps the log of what happened on the way.

pub mod border;
pub mod certificate;
pub mod changed;
pub mod checkpoint;
mod clearance;
mod clips;
pub mod dead_moments;
mod descent;
pub mod events;
pub mod factor;
pub mod gather;
pub mod hands;
mod judge;
pub mod lbfgs;
mod line_search;
mod link;
mod lost_turns;
pub mod matrix;
pub mod ncg;
pub mod nested;
pub mod newton;
mod operations;
pub mod parts;
mod plan;
mod precondition;
pub mod result;
pub mod settle;
pub mod stability;
pub mod start;
pub mod steps;
pub mod structure;
mod transport;

pub use steps::{Control, Progress, carry_out, start_near};

use wireloom_core::Registry;

/// Adds the minimisers.
///
/// # Panics
/// If one of their names is taken: built-ins are registered first.
pub fn register(registry: &mut Registry) {
    for kind in [newton::kind(), lbfgs::kind(), ncg::kind()] {
        registry.add_minimiser(kind).map_err(|_| "built-ins are registered first").unwrap();
    }
}
