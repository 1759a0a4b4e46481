//! Joints.

pub mod compliant_hub;
mod continued;
pub mod cosserat;
pub mod hub;
mod pair;
pub mod sharing;
