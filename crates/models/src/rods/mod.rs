//! Rods.

pub mod cosserat;
pub mod kirchhoff;
pub mod mass_spring;
pub mod staggered;
