//! The linear system of a Newton step: a sparse symmetric matrix of 3 × 3 blocks, one block row for each point and frame.

pub mod assembly;
pub mod border;
pub mod dead_moments;
pub mod elimination_tree;
pub mod factor;
pub mod matrix;
pub mod symbolic;
