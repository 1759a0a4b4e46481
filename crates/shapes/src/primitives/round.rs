//! Bodies about a point, a line or a circle: spheres, capsules and tori, with hollows of the same shape if they have a
//! bore.

use super::build::{bore, kind, length};
use super::revolution::{arc, revolved};
use crate::field::{Field, Place, SINGULAR};
use crate::parameters;
use wireloom_core::obstacle::Surface;
use wireloom_core::registry::{BuildError, ShapeKind};
use wireloom_core::{Parameters, Vector};

/// Point, line or circle in the middle of the body.
#[derive(Clone, Copy)]
enum Core {
    /// The origin.
    Point,
    /// A part of the axis z, so long to either side of the origin.
    Line(f64),
    /// A circle of this radius about the axis z.
    Circle(f64),
}

/// φ = d − outer, with d the distance from the core; with a bore, the nearer of that and inner − d.
struct Round {
    core: Core,
    inner: f64,
    outer: f64,
}

/// The kind `sphere`.
pub(super) fn sphere() -> ShapeKind {
    let parameters = vec![
        parameters::length("radius", "its radius; its middle is at `position`"),
        parameters::bore("radius of a hollow in its middle; default 0: none"),
    ];
    kind("sphere", "a sphere", parameters, |parameters| round(parameters, Core::Point, "radius"))
}

/// The kind `capsule`.
pub(super) fn capsule() -> ShapeKind {
    let parameters = vec![
        parameters::length("radius", "its radius; its axis is its third axis"),
        parameters::length("length", "from the middle of one of its round ends to that of the other"),
        parameters::bore("radius of a hollow of the same shape in its middle; default 0: none"),
    ];
    kind("capsule", "a cylinder with half a sphere at either end", parameters, |parameters| {
        round(parameters, Core::Line(0.5 * length(parameters, "length")?), "radius")
    })
}

/// The kind `torus`.
pub(super) fn torus() -> ShapeKind {
    let parameters = vec![
        parameters::length("ring_radius", "radius of the circle in its middle, which goes about its third axis"),
        parameters::length("radius", "radius of what lies about that circle"),
        parameters::bore("radius of a hollow along that circle; default 0: none"),
    ];
    kind("torus", "a ring, such as a grommet", parameters, |parameters| {
        let (ring, radius) = (length(parameters, "ring_radius")?, length(parameters, "radius")?);
        if radius < ring {
            return round(parameters, Core::Circle(ring), "radius");
        }
        let message = format!("`radius` = {radius} m leaves no opening in a ring with `ring_radius` = {ring} m");
        Err(BuildError::new(message, "give a `radius` that is less than `ring_radius`").at("radius"))
    })
}

fn round(parameters: &Parameters, core: Core, key: &str) -> Result<Round, BuildError> {
    let outer = length(parameters, key)?;
    Ok(Round { core, inner: bore(parameters, key, outer)?, outer })
}

impl Core {
    fn at(&self, x: &Vector) -> Place {
        match *self {
            Core::Point => Place::round(x),
            Core::Line(half) => {
                let beyond = x.z.abs() - half;
                if beyond > 0.0 {
                    return Place::round(&Vector::new(x.x, x.y, beyond.copysign(x.z)));
                }
                let r = Vector::new(x.x, x.y, 0.0);
                let distance = r.norm();
                if distance < SINGULAR {
                    return Place::flat(distance, Vector::x());
                }
                let normal = r / distance;
                let around = normal.cross(&Vector::z());
                Place { distance, normal, curvature: around * around.transpose() / distance }
            }
            Core::Circle(radius) => {
                let r = Vector::new(x.x, x.y, 0.0);
                let rho = r.norm();
                let outward = if rho < SINGULAR { Vector::x() } else { r / rho };
                let around = outward.cross(&Vector::z());
                let beside = outward * (rho - radius) + Vector::z() * x.z;
                let distance = beside.norm();
                if distance < SINGULAR {
                    return Place::flat(distance, Vector::z());
                }
                // d² = (ρ − r)² + z²: about the circle, and with it about the axis.
                let normal = beside / distance;
                let tangent = around.cross(&normal);
                let mut curvature = tangent * tangent.transpose() / distance;
                if rho >= SINGULAR {
                    curvature += around * around.transpose() * ((rho - radius) / (distance * rho));
                }
                Place { distance, normal, curvature }
            }
        }
    }
}

impl Field for Round {
    fn at(&self, x: &Vector) -> Place {
        self.core.at(x).wall(self.inner, self.outer)
    }

    fn convex(&self) -> bool {
        self.inner == 0.0 && !matches!(self.core, Core::Circle(_))
    }

    fn fineness(&self) -> f64 {
        1e-3 * (self.outer - self.inner)
    }

    fn outline(&self, _: f64) -> Surface {
        let about = |radius: f64| match self.core {
            Core::Point => revolved(&arc(0.0, 0.0, radius, -0.25, 0.25), false),
            Core::Line(half) => {
                let mut profile = arc(0.0, -half, radius, -0.25, 0.0);
                profile.extend(arc(0.0, half, radius, 0.0, 0.25));
                revolved(&profile, false)
            }
            Core::Circle(ring) => {
                let mut profile = arc(ring, 0.0, radius, 0.0, 1.0);
                profile.pop();
                revolved(&profile, true)
            }
        };
        let mut surface = about(self.outer);
        if self.inner > 0.0 {
            let within = about(self.inner);
            let first = surface.corners.len() as u32;
            surface.corners.extend(within.corners);
            surface.triangles.extend(within.triangles.iter().map(|t| [t[0], t[2], t[1]].map(|k| k + first)));
        }
        surface
    }
}
