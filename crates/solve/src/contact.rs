//! Iterations of constraints, contact and friction around a minimisation: the active set within a Newton step, and the
//! updates of multipliers, penalties and friction between minimisations (augmented Lagrangian).

pub mod active_set;
pub mod multipliers;
mod penalty;
pub mod sliding_friction;
