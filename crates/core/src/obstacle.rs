//! Obstacles, which cables may touch but not enter: trait of their shapes, poses and settings of contact.

use crate::mechanism::Mount;
use crate::{Matrix, Pose, Vector};
use std::fmt;
use std::sync::Arc;

/// Point of a surface that is locally nearest to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// φ, m: signed distance of the point from the surface; negative inside.
    pub distance: f64,
    /// n = ∂φ/∂x, a unit vector: out of the body.
    pub normal: Vector,
    /// ∂²φ/∂x², 1/m.
    pub curvature: Matrix,
    /// Index of the part of the surface. Parts are such that a cable may touch several of them at one place (the two
    /// sides of a groove), each of them at one point.
    pub part: u32,
}

/// Triangle mesh of a surface, for pictures and exported meshes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Corners, m, in the axes of the body.
    pub corners: Vec<Vector>,
    /// Indices of the corners of each triangle, counter-clockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Shape of an obstacle, in its own axes, given by a signed distance φ with `|∂φ/∂x| = 1` wherever the nearest
/// point of the surface is unique.
///
/// Contract: the same bits for the same input; methods do not fail; only [`Self::surface`] and [`Self::notes`]
/// allocate. An infinite shape (a plane) is cut off in [`Self::surface`] only.
pub trait Shape: Send + Sync {
    /// φ(x), m, negative inside; where φ exceeds `reach`, any number above `reach`.
    fn distance(&self, x: &Vector, reach: f64) -> f64;
    /// Calls `visit` with the nearest point of every part of the surface that is nearer than `reach` to `x` and not
    /// hidden behind another part, in order of the parts. `x` may also be inside.
    fn touches(&self, x: &Vector, reach: f64, visit: &mut dyn FnMut(Touch));
    /// First fraction, 0 to 1, of the straight line between two points at which it crosses the surface, from outside or
    /// inside.
    fn crossing(&self, from: &Vector, to: &Vector) -> Option<f64>;
    /// Triangle mesh of the surface; an infinite shape is cut off at `size` (m).
    fn surface(&self, size: f64) -> Surface;
    /// Remarks for the user.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

/// An obstacle.
#[derive(Clone)]
pub struct Obstacle {
    /// Name.
    pub name: String,
    /// Kind of its shape, as scenarios name it.
    pub kind: String,
    /// Its shape.
    pub shape: Arc<dyn Shape>,
    /// Pose at the start of the run.
    pub pose: Pose,
    /// Body of a mechanism that carries it.
    pub mount: Option<Mount>,
    /// Coefficient of Coulomb friction; 0 is smooth.
    pub friction: f64,
    /// Required clearance, m.
    pub min_clearance: Option<f64>,
    /// Largest sum of the sizes of the contact forces that it may exert on the cables, N.
    pub max_contact_force: Option<f64>,
}

/// Prints all fields but the shape.
impl fmt::Debug for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, kind, shape: _, pose, mount, friction, min_clearance, max_contact_force } = self;
        let mut f = f.debug_struct("Obstacle");
        f.field("name", name).field("kind", kind).field("pose", pose).field("mount", mount).field("friction", friction);
        f.field("min_clearance", min_clearance).field("max_contact_force", max_contact_force).finish_non_exhaustive()
    }
}

/// File with the surface of an obstacle.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeFile {
    /// Its name; the extension determines the format.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
    /// Length, m, of a unit of its coordinates.
    pub scale: f64,
}

/// Input of a shape factory besides its parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapeSpec {
    /// File of the surface, for a shape given by one. Its errors refer to the key `mesh`.
    pub file: Option<ShapeFile>,
}

/// Settings of contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSettings {
    /// Whether contact between cables, including self-contact, is considered.
    pub cables: bool,
    /// Coefficient of Coulomb friction between cables; 0 is smooth.
    pub friction: f64,
    /// Whether a harness that starts inside an obstacle is pushed out of it.
    pub resolve: bool,
}
