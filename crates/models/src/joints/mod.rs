//! Joints.

pub mod cosserat;
pub mod hub;
pub mod sharing;
