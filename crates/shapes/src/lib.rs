//! Bodies that cables may touch: primitives with closed forms, and triangle meshes out of files.
//!
//! Every shape answers three queries ([`wireloom_core::obstacle::Shape`]): the signed distance of a point, the nearest
//! places of the surface, and the first crossing of a straight path. Primitives answer exactly, second derivatives
//! included; meshes answer exactly for their triangles. The volume that cables sweep while they move becomes such a
//! mesh in [`swept`]. `parry` is used in one module, `tree`, and none of its types leaves it.

mod field;
pub mod mesh;
mod parameters;
pub mod primitives;
pub mod swept;
mod tree;

use wireloom_core::Registry;

/// Adds all built-in shapes; `step`: what reads STEP files, which are refused without it.
///
/// # Panics
/// If one of their names is taken: built-ins are registered first.
pub fn register(registry: &mut Registry, step: Option<mesh::StepReader>) {
    const FIRST: &str = "built-ins are registered first";
    for kind in primitives::kinds() {
        registry.add_shape(kind).map_err(|_| FIRST).unwrap();
    }
    registry.add_shape(mesh::kind(step)).map_err(|_| FIRST).unwrap();
}
