//! The total energy, term by term:
//!
//! ```text
//! E = Σ rods + Σ joints + Σ constraints + contact + friction + weight and loads
//! ```
//!
//! | term | module | energy |
//! | --- | --- | --- |
//! | rods | [`rods`] | `Σ ½ ℓ Γᵀ C Γ + ½ λ (κ − κ°)ᵀ D (κ − κ°)`; temperature changes what Γ and κ are measured from |
//! | joints | [`joints`] | that of each joint model |
//! | constraints | [`constraints`] | potentials, and `λ c + ½ ρ c²` of equations (augmented Lagrangian) |
//! | sliding | [`sliding`] | none of its own: `∂E/∂s` of the arc length s at a sliding constraint |
//! | contact | [`contact`] | `(max(0, λ + ρ c)² − λ²)/(2ρ)` |
//! | friction | [`friction`] | `½ k u²`, up to `f N` |
//! | weight | [`gravity`] | `−Σ m g·x`, and `−½ Σ m |ω × r|²` in axes that rotate |
//! | loads | [`loads`] | `−Σ f·x` of dead forces; moments, followers and drag have none |
//!
//! Each term is a struct with its workspace. It evaluates the energy (J), the gradient (N, N m) and the second
//! derivatives of a [`crate::conditions::System`] at a [`crate::State`]. [`crate::Problem`] is their sum.

pub mod constraints;
pub mod contact;
pub mod friction;
pub mod gravity;
pub mod joints;
pub mod loads;
pub mod rods;
pub mod sliding;
pub mod slope;
