//! CPU minimisers, certificate and step driver.
//!
//! | module | contents |
//! | --- | --- |
//! | [`linear`] | linear system of a Newton step: symbolic ordering, assembly, factor, border of sliding constraints |
//! | [`minimisers`] | `newton`, `lbfgs`, `ncg`; static condensation of positions, line search, convergence |
//! | [`contact`] | active set within a Newton step; multipliers, penalties and friction between minimisations |
//! | [`start`] | initial shapes, prolongation from a coarse mesh |
//! | [`steps`] | run of a schedule: increments and cut-back, initial equilibrium, certificate, stability, checkpoints |
//! | [`report`] | results, events, clearances |

pub mod contact;
pub mod linear;
pub mod minimisers;
pub mod report;
pub mod start;
pub mod steps;

pub use report::{clearance_from_obstacle, clearance_of_branches};
pub use steps::{Control, Progress, carry_out, start_near};

use minimisers::{lbfgs, ncg, newton};
use wireloom_core::Registry;

/// Registers the minimisers.
///
/// # Panics
/// If one of their names is taken: built-ins are registered first.
pub fn register(registry: &mut Registry) {
    for kind in [newton::kind(), lbfgs::kind(), ncg::kind()] {
        registry.add_minimiser(kind).map_err(|_| "built-ins are registered first").unwrap();
    }
}
