//! Linear system of a Newton step: a sparse symmetric matrix of 3 × 3 blocks, with one block row per point and per
//! frame.

pub mod assembly;
pub mod border;
pub mod elimination_tree;
pub mod factor;
pub mod matrix;
pub mod symbolic;
pub mod without_potential;
