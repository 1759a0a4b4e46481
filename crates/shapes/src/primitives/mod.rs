//! Planes, boxes, cylinders, capsules, spheres and tori, each in axes of its own with its middle at the origin.

mod build;
mod cuboid;
mod cylinder;
mod plane;
mod revolution;
mod round;
#[cfg(test)]
mod tests;

use wireloom_core::registry::ShapeKind;

/// All kinds of primitives.
pub fn kinds() -> Vec<ShapeKind> {
    vec![plane::plane(), cuboid::cuboid(), cylinder::cylinder(), round::capsule(), round::sphere(), round::torus()]
}
