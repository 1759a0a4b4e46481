//! Rods.

pub mod cosserat;
