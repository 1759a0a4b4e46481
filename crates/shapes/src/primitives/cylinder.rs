//! The cylinder; with a bore, the tube.

use super::build::{bore, kind, length};
use super::revolution::revolved;
use crate::field::{Field, Place, SINGULAR};
use crate::parameters;
use wireloom_core::obstacle::Surface;
use wireloom_core::registry::ShapeKind;
use wireloom_core::{Matrix, Vector};

/// A rectangle in (ρ, z), revolved about z: inner ≤ ρ ≤ outer, |z| ≤ h. With
/// `a = |ρ − (inner + outer)/2| − (outer − inner)/2` and `b = |z| − h`, φ = |(max(a, 0), max(b, 0))| outside and max(a,
/// b) inside.
struct Cylinder {
    inner: f64,
    outer: f64,
    half_length: f64,
}

/// The kind `cylinder`.
pub(super) fn cylinder() -> ShapeKind {
    let parameters = vec![
        parameters::length("radius", "its radius; its axis is its third axis"),
        parameters::length("length", "its length; its middle is at `position`"),
        parameters::bore("radius of a hole along its axis, open at both ends, for a tube; default 0: none"),
    ];
    kind("cylinder", "a cylinder with flat ends, or a tube", parameters, |parameters| {
        let outer = length(parameters, "radius")?;
        let inner = bore(parameters, "radius", outer)?;
        Ok(Cylinder { inner, outer, half_length: 0.5 * length(parameters, "length")? })
    })
}

impl Field for Cylinder {
    fn at(&self, x: &Vector) -> Place {
        let from_axis = Vector::new(x.x, x.y, 0.0);
        let rho = from_axis.norm();
        let on_axis = rho < SINGULAR;
        let outward = if on_axis { Vector::x() } else { from_axis / rho };
        let around = outward.cross(&Vector::z());
        // Of the two walls that of the bore, where there is one and it is nearer.
        let bored = self.inner > 0.0 && rho < 0.5 * (self.inner + self.outer);
        let (a, side) = if bored { (self.inner - rho, -1.0) } else { (rho - self.outer, 1.0) };
        let b = x.z.abs() - self.half_length;
        // Derivatives of a and b.
        let (along_a, along_b) = (outward * side, Vector::z() * if x.z < 0.0 { -1.0 } else { 1.0 });
        let turning = if on_axis { Matrix::zeros() } else { around * around.transpose() * (side / rho) };
        match (a > 0.0, b > 0.0) {
            (true, true) => {
                let distance = a.hypot(b);
                let normal = (along_a * a + along_b * b) / distance;
                let curvature = along_a * along_a.transpose() + along_b * along_b.transpose() + turning * a;
                Place { distance, normal, curvature: (curvature - normal * normal.transpose()) / distance }
            }
            (false, true) => Place::flat(b, along_b),
            (false, false) if b > a => Place::flat(b, along_b),
            _ => Place { distance: a, normal: along_a, curvature: turning },
        }
    }

    fn convex(&self) -> bool {
        self.inner == 0.0
    }

    fn fineness(&self) -> f64 {
        1e-3 * self.half_length.min(self.outer - self.inner)
    }

    fn outline(&self, _: f64) -> Surface {
        let Cylinder { inner, outer, half_length: h } = *self;
        if inner == 0.0 {
            return revolved(&[(0.0, -h), (outer, -h), (outer, h), (0.0, h)], false);
        }
        revolved(&[(inner, -h), (outer, -h), (outer, h), (inner, h)], true)
    }
}
