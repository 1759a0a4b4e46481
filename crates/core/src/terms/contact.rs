//! Contact: cables are kept out of obstacles and of each other.
//!
//! A cable of radius R is examined at **contact points**: its nodes, places between them that are no farther apart than
//! `SPACING` radii, and places that were found to lie deeper than `BETWEEN` radii. With φ(x) the distance of a contact
//! point x from the surface of a body, `c = R − φ(x) ≤ 0` must hold: an inequality as those of
//! [`super::constraints`], with multiplier λ (the normal force, N) and penalty ρ (N/m), which adds
//! `(μ² − λ²)/(2ρ)`, `μ = max(0, λ + ρ c)`, to the energy; the force on the contact point is `μ n` with
//! `n = ∂φ/∂x`, and the second derivatives are `ρ n nᵀ − μ ∂²φ/∂x²` (Alart and Curnier 1991, without
//! their friction). The solver updates the multipliers until no contact point is deeper than [`DEPTH`] radii, nor has a
//! force while it is farther than that from the surface.
//!
//! Near a constraint that holds a cable inside a body or at its surface (a clip on a panel) R grows from its distance
//! there to the radius over `RUN_OUT` radii of cable.

mod broad_phase;
mod cables;
mod complementarity;
mod continuous;
mod distance_cache;
mod evaluate;
mod held;
mod loads;
mod pairs;
mod refine;
mod term;

pub use broad_phase::Penetration;
pub use complementarity::{ContactViolation, Lack};
pub use evaluate::inequality;
pub use loads::ObstacleLoad;
pub use pairs::HeldOverlap;
pub(crate) use term::Touched;
pub use term::{Contact, ContactTerm, DEPTH};
