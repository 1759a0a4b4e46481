//! Contact of cables with obstacles and with each other.
//!
//! A cable of radius R is examined at **contact points**: its nodes, further points such that the distance is at most
//! `SPACING` radii (no more than `MOST_PIECES` on a segment), and points added where an obstacle or a cable presses in
//! between (`refine`). Where on their segment they touch obstacles says `follow`, and other cables `crossing`. With
//! φ(x) the distance of a contact point x from the surface of a body, `c = R − φ(x) ≤ 0` must hold: an inequality like
//! those of [`super::constraints`], with multiplier λ (the normal force, N) and penalty ρ (N/m), which adds `(μ² −
//! λ²)/(2ρ)`, `μ = max(0, λ + ρ c)`, to the energy; the force on the contact point is `μ n` with `n = ∂φ/∂x`, and the
//! second derivatives are `ρ n nᵀ − μ ∂²φ/∂x²` (Alart and Curnier 1991, without their friction). The solver updates the
//! multipliers until no contact point is deeper than [`DEPTH`] radii, and none has a force at a gap larger than that.
//!
//! Near a constraint that holds a cable inside an obstacle or at its surface (a clip on a panel) R grows from the held
//! distance to the radius over `RUN_OUT` radii of cable.

mod broad_phase;
mod cables;
mod complementarity;
mod continuous;
mod crossing;
mod distance_cache;
mod evaluate;
mod follow;
mod held;
mod loads;
mod pairs;
mod refine;
mod term;

pub use broad_phase::Penetration;
pub use complementarity::{ContactViolation, Lack};
pub use evaluate::{Weights, inequality};
pub use loads::ObstacleLoad;
pub use pairs::HeldOverlap;
pub(crate) use term::Touched;
pub use term::{Contact, ContactTerm, DEPTH};
