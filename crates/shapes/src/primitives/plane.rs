//! The plane: everything on one side of it is solid.

use super::build::kind;
use crate::field::{Field, Place};
use crate::parameters::vector;
use wireloom_core::obstacle::Surface;
use wireloom_core::registry::{BuildError, ShapeKind};
use wireloom_core::rotation::orthogonal;
use wireloom_core::{Quantity, Value, Vector};

/// φ = n·(x − p).
struct Plane {
    point: Vector,
    normal: Vector,
}

/// The kind `plane`.
pub(super) fn plane() -> ShapeKind {
    let parameters = vec![
        vector("point", "a point of the plane; default the body's origin", Quantity::Length, Some(Vector::zeros())),
        vector(
            "normal",
            "points out of the body, to where cables are; default along its third axis",
            Quantity::Dimensionless,
            Some(Vector::z()),
        ),
    ];
    kind("plane", "a plane without end; all behind it is solid", parameters, |parameters| {
        let given = |name: &str| match parameters.0.get(name) {
            Some(Value::Vector(vector)) => Some(*vector),
            _ => None,
        };
        let normal = given("normal").unwrap_or(Vector::z());
        let largest = normal.amax();
        if largest > 0.0 {
            let normal = (normal / largest).normalize();
            return Ok(Plane { point: given("point").unwrap_or_default(), normal });
        }
        let message = "`normal` = [0, 0, 0] has no direction";
        Err(BuildError::new(message, "give a vector that is not zero; its length does not matter").at("normal"))
    })
}

impl Field for Plane {
    fn at(&self, x: &Vector) -> Place {
        Place::flat(self.normal.dot(&(x - self.point)), self.normal)
    }

    fn convex(&self) -> bool {
        true
    }

    fn fineness(&self) -> f64 {
        f64::INFINITY
    }

    /// A square about the point.
    fn outline(&self, size: f64) -> Surface {
        let a = orthogonal(&self.normal);
        let b = self.normal.cross(&a);
        let corner = |(s, t): (f64, f64)| self.point + (a * s + b * t) * (0.5 * size);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner).to_vec();
        Surface { corners, triangles: vec![[0, 1, 2], [0, 2, 3]] }
    }
}
