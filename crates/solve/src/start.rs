//! Initial shapes: from rest shapes, from drawn curves, and by prolongation from another mesh.

pub mod layout;
pub mod prolongation;
