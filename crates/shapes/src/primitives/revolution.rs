//! Triangles of surfaces of revolution about z.

use std::f64::consts::TAU;
use wireloom_core::Vector;
use wireloom_core::obstacle::Surface;

/// Parts of a full circle.
const AROUND: usize = 64;

/// A circle about (ρ, z), from one fraction of a full turn to another; 0 is away from the axis, 1/4 is up.
pub(super) fn arc(rho: f64, z: f64, radius: f64, from: f64, to: f64) -> Vec<(f64, f64)> {
    let parts = ((to - from) * AROUND as f64).round() as usize;
    let point = |k: usize| {
        let (sin, cos) = (TAU * (from + (to - from) * k as f64 / parts as f64)).sin_cos();
        // The ends of half a circle lie on the axis, not beside it by round-off.
        let beside = rho + radius * cos;
        (if beside.abs() < 1e-12 * radius { 0.0 } else { beside }, z + radius * sin)
    };
    (0..=parts).map(point).collect()
}

/// A line of points (ρ, z) with the body to its left, that is on the side of smaller ρ where it goes up, taken about
/// the axis; `closed` joins its end to its beginning. Points on the axis are one corner each.
pub(super) fn revolved(profile: &[(f64, f64)], closed: bool) -> Surface {
    let mut surface = Surface::default();
    let rings: Vec<(u32, usize)> = profile
        .iter()
        .map(|&(rho, z)| {
            let first = surface.corners.len() as u32;
            let parts = if rho == 0.0 { 1 } else { AROUND };
            surface.corners.extend((0..parts).map(|k| {
                let (sin, cos) = (TAU * k as f64 / AROUND as f64).sin_cos();
                Vector::new(rho * cos, rho * sin, z)
            }));
            (first, parts)
        })
        .collect();
    let legs = if closed { rings.len() } else { rings.len() - 1 };
    for leg in 0..legs {
        let (low, high) = (rings[leg], rings[(leg + 1) % rings.len()]);
        let corner = |(first, parts): (u32, usize), k: usize| first + (k % parts) as u32;
        for k in 0..AROUND {
            let (a, b, c, d) = (corner(low, k), corner(low, k + 1), corner(high, k + 1), corner(high, k));
            surface
                .triangles
                .extend([[a, b, c], [a, c, d]].into_iter().filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]));
        }
    }
    surface
}
