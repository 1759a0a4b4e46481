//! Joints.

mod continued;
pub mod cosserat;
pub mod hub;
pub mod sharing;
