//! The box.

use super::build::kind;
use crate::field::{Field, Place};
use crate::parameters::vector;
use wireloom_core::obstacle::Surface;
use wireloom_core::registry::{BuildError, ShapeKind};
use wireloom_core::{Matrix, Quantity, Value, Vector};

/// With h half the size: q = |x| − h beside the box along each axis. Outside, φ = |max(q, 0)|: flat over faces, round
/// about edges and corners. Inside, φ = max q.
struct Cuboid {
    half: Vector,
}

/// The kind `box`.
pub(super) fn cuboid() -> ShapeKind {
    let parameters =
        vec![vector("size", "its edges along its three axes; its middle is at `position`", Quantity::Length, None)];
    kind("box", "a box with sharp edges", parameters, |parameters| match parameters.0.get("size") {
        Some(Value::Vector(size)) if size.min() > 0.0 => Ok(Cuboid { half: size * 0.5 }),
        Some(Value::Vector(size)) => {
            let message = format!("`size` = [{}, {}, {}] has an edge that is no length", size.x, size.y, size.z);
            Err(BuildError::new(message, "all three must be greater than 0 m").at("size"))
        }
        _ => Err(BuildError::new("it has no `size`", "add `size`, in m").at("size")),
    })
}

impl Field for Cuboid {
    fn at(&self, x: &Vector) -> Place {
        let sign = x.map(|c| if c < 0.0 { -1.0 } else { 1.0 });
        let q = x.abs() - self.half;
        if q.iter().all(|c| *c <= 0.0) {
            let nearest_face = q.imax();
            return Place::flat(q[nearest_face], Vector::ith(nearest_face, sign[nearest_face]));
        }
        let beside = q.map(|c| if c <= 0.0 { 0.0 } else { c });
        let distance = beside.norm();
        let normal = beside.component_mul(&sign) / distance;
        // Along axes on which x is beside the box the nearest place stays; along the others it follows.
        let stays = Matrix::from_diagonal(&q.map(|c| if c > 0.0 { 1.0 } else { 0.0 }));
        Place { distance, normal, curvature: (stays - normal * normal.transpose()) / distance }
    }

    fn convex(&self) -> bool {
        true
    }

    fn fineness(&self) -> f64 {
        1e-3 * self.half.min()
    }

    fn outline(&self, _: f64) -> Surface {
        let sign = |k: usize, bit: usize| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let corner = |k| self.half.component_mul(&Vector::new(sign(k, 0), sign(k, 1), sign(k, 2)));
        const FACES: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = FACES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Surface { corners: (0..8).map(corner).collect(), triangles }
    }
}
