//! Rods.

pub mod cosserat;
pub mod friction;
pub mod kirchhoff;
pub mod mass_spring;
pub mod staggered;
