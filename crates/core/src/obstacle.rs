//! Bodies that cables may touch but not enter: what their shapes can say, and where they stand.

use crate::{Matrix, Pose, Vector};
use std::fmt;
use std::sync::Arc;

/// A place of a body's surface that is nearest to a point, among those about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// φ, m: how far the point is from the surface; negative inside.
    pub distance: f64,
    /// n = ∂φ/∂x, a unit vector: out of the body.
    pub normal: Vector,
    /// ∂²φ/∂x², 1/m.
    pub curvature: Matrix,
    /// Which part of the surface it is on, from 0: parts are such that a cable may touch several of them at one place (the two sides of a
    /// groove) and lies against each of them at one point.
    pub part: u32,
}

/// A triangle mesh of a surface, for pictures and meshes written out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Corners, m, in the axes of the body.
    pub corners: Vec<Vector>,
    /// Indices of the corners of each triangle, counter-clockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// The shape of a body, in axes of its own. Beyond its surface the distance φ grows with slope 1 (`|∂φ/∂x| = 1`) as far as the nearest
/// place is unique.
///
/// Contract: the same bits for the same input; methods neither fail nor, but for [`Self::surface`] and [`Self::notes`], allocate. A shape that has no end (a plane)
/// is cut off in [`Self::surface`] only.
pub trait Shape: Send + Sync {
    /// φ(x), m, negative inside; any number above `reach` where it is above it.
    fn distance(&self, x: &Vector, reach: f64) -> f64;
    /// The nearest place of every part of the surface that is nearer than `reach` to `x` and not hidden behind another one, in order of the
    /// parts. Nearest places inside the body count, too.
    fn touches(&self, x: &Vector, reach: f64, see: &mut dyn FnMut(Touch));
    /// The first fraction, 0 to 1, of the straight way between two points at which it goes through the surface, from outside or inside.
    fn crossing(&self, from: &Vector, to: &Vector) -> Option<f64>;
    /// The surface as triangles, `size` (m) being how far a body without end is drawn.
    fn surface(&self, size: f64) -> Surface;
    /// What an engineer should know of it.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

/// A body in the scene.
#[derive(Clone)]
pub struct Obstacle {
    /// Name.
    pub name: String,
    /// Kind of its shape, as scenarios name it.
    pub kind: String,
    /// Its shape.
    pub shape: Arc<dyn Shape>,
    /// Where it stands at the beginning.
    pub pose: Pose,
    /// Coefficient of Coulomb friction; 0 is smooth.
    pub friction: f64,
    /// Least clearance that is asked for, m.
    pub min_clearance: Option<f64>,
}

/// All but its shape.
impl fmt::Debug for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, kind, shape: _, pose, friction, min_clearance } = self;
        let mut f = f.debug_struct("Obstacle");
        f.field("name", name).field("kind", kind).field("pose", pose).field("friction", friction);
        f.field("min_clearance", min_clearance).finish_non_exhaustive()
    }
}

/// A file with the surface of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeFile {
    /// Its name, whose ending tells the format.
    pub name: String,
    /// What it holds.
    pub bytes: Vec<u8>,
    /// Length, m, of a unit of its coordinates.
    pub scale: f64,
}

/// Everything the factory of a shape is told beside its parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapeSpec {
    /// The surface, for a body that is given by one. What is wrong with it is said of the key `mesh`.
    pub file: Option<ShapeFile>,
}

/// How cables meet each other and what is about them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSettings {
    /// Whether cables touch each other, and themselves.
    pub cables: bool,
    /// Coefficient of Coulomb friction of cables on each other; 0: they are smooth.
    pub friction: f64,
    /// Whether a harness that begins within a body is pushed out of it.
    pub resolve: bool,
}
