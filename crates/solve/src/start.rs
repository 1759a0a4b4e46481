//! Initial shapes: from rest shapes and drawn curves, and from another mesh.

pub mod layout;
pub mod prolongation;
