//! Bodies that cables may touch: primitives with closed forms, and triangle meshes out of files.
//!
//! Every shape answers three questions ([`wireloom_core::obstacle::Shape`]): how far is a point from the surface, which places of the surface
//! are nearest to it, and where does a straight way go through. Primitives answer exactly, second derivatives included; meshes answer exactly
//! for their triangles. What cables go through while they move becomes such a mesh in [`swept`]. `parry` is named in one module, `tree`, and none of its types leaves it.

mod field;
pub mod mesh;
mod parameters;
pub mod primitives;
pub mod swept;
mod tree;

use wireloom_core::Registry;

/// Adds all built-in shapes.
///
/// # Panics
/// If one of their names is taken: built-ins are registered first.
pub fn register(registry: &mut Registry) {
    const FIRST: &str = "built-ins are registered first";
    for kind in primitives::kinds() {
        registry.add_shape(kind).map_err(|_| FIRST).unwrap();
    }
    registry.add_shape(mesh::kind()).map_err(|_| FIRST).unwrap();
}
