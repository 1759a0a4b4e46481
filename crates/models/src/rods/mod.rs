//! Rods.

pub mod constitutive;
pub mod cosserat;
pub mod kirchhoff;
pub mod mass_spring;
pub mod nonlinear;
pub mod staggered;
mod stretched;
