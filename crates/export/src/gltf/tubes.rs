//! Tubes of the tolerance envelope of a sweep.

use super::{File, Mesh, SIDES, SWEPT};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::f64::consts::FRAC_PI_2;
use std::io::{self, Write};
use wireloom_core::Vector;

/// Rings of a rounded end.
const RINGS: usize = 4;

/// Tubes around a branch that hold it at the end of a step, each in a share of the points of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tube {
    /// Name of the branch.
    pub branch: String,
    /// Name of the step.
    pub step: String,
    /// Number of points of the sweep.
    pub points: usize,
    /// Mean centre line at the stations, m.
    pub centre: Vec<Vector>,
    /// Percentile, and radii at the stations, m; from the smallest percentile.
    pub radii: Vec<(usize, Vec<f64>)>,
}

/// Writes tubes with rounded ends, a scene for each step, of which the last is the one shown. The nodes are named
/// `branch / percentile % / step`, and have these as `extras`, with the number of points.
///
/// # Errors
/// As those of [`write()`](super::write()).
pub fn write_tubes(tubes: &[Tube], out: &mut impl Write) -> io::Result<()> {
    let mut file = File::default();
    for step in tubes.chunk_by(|a, b| a.step == b.step) {
        let mut children = vec![];
        for Tube { branch, step, points, centre, radii } in step {
            for (percentile, radii) in radii {
                let name = format!("{branch} / {percentile} % / {step}");
                let mesh = file.mesh(&name, &round(centre, radii), SWEPT);
                let extras = json!({ "branch": branch, "percentile": percentile, "step": step, "points": points });
                children.push(file.node(json!({ "name": name, "mesh": mesh, "extras": extras })));
            }
        }
        file.scene(&step[0].step, children);
    }
    file.write(out)
}

/// A closed tube along a line, of these radii at its points, with hemispheres at its ends.
fn round(centre: &[Vector], radii: &[f64]) -> Mesh {
    let last = centre.len() - 1;
    let mut mesh = Mesh::default();
    let tangents = tangents(centre);
    // The axes of the rings, transported along the line.
    let mut across = tangents[0].cross(&Vector::ith(tangents[0].iamin(), 1.0)).normalize();
    let latitude = |k: usize| FRAC_PI_2 * k as f64 / RINGS as f64;
    let ring = |mesh: &mut Mesh, k: usize, across: &Vector, angle: f64| {
        let (sine, cosine) = angle.sin_cos();
        let tangent = tangents[k];
        let axes = [*across, tangent.cross(across)];
        let at = centre[k] + tangent * (radii[k] * sine);
        mesh.ring(&at, axes, radii[k] * cosine, |outward| outward * cosine + tangent * sine)
    };
    let first = pole(&mut mesh, centre[0] - tangents[0] * radii[0], -tangents[0]);
    let mut before = None;
    for k in (1..RINGS).rev() {
        let now = ring(&mut mesh, 0, &across, -latitude(k));
        join(&mut mesh, before.replace(now), now, first);
    }
    for (k, tangent) in tangents.iter().enumerate() {
        across = (across - tangent * tangent.dot(&across)).normalize();
        let now = ring(&mut mesh, k, &across, 0.0);
        join(&mut mesh, before.replace(now), now, first);
    }
    for k in 1..RINGS {
        let now = ring(&mut mesh, last, &across, latitude(k));
        join(&mut mesh, before.replace(now), now, first);
    }
    let end = pole(&mut mesh, centre[last] + tangents[last] * radii[last], tangents[last]);
    let ring = end - SIDES as u32;
    mesh.triangles.extend((0..SIDES as u32).map(|k| [ring + k, ring + (k + 1) % SIDES as u32, end]));
    mesh
}

/// Directions of a line at its points; the one before where two of them fall together.
fn tangents(centre: &[Vector]) -> Vec<Vector> {
    let last = centre.len() - 1;
    let mut tangent = Vector::x();
    let mut tangents: Vec<Vector> = (0..=last)
        .map(|k| {
            let along = centre[(k + 1).min(last)] - centre[k.saturating_sub(1)];
            tangent = along.try_normalize(1e-12).unwrap_or(tangent);
            tangent
        })
        .collect();
    // A turn of more than a right angle leaves no axis to transport.
    for k in 1..=last {
        if tangents[k].dot(&tangents[k - 1]) < 0.0 {
            tangents[k] = tangents[k - 1];
        }
    }
    tangents
}

/// A single corner.
fn pole(mesh: &mut Mesh, at: Vector, normal: Vector) -> u32 {
    mesh.corners.push(at);
    mesh.normals.push(normal);
    mesh.corners.len() as u32 - 1
}

/// Joins a ring to the one before it, or to the first pole.
fn join(mesh: &mut Mesh, before: Option<u32>, now: u32, pole: u32) {
    let sides = SIDES as u32;
    for k in 0..sides {
        let next = (k + 1) % sides;
        match before {
            None => mesh.triangles.push([pole, now + next, now + k]),
            Some(before) => {
                mesh.triangles.push([before + k, before + next, now + next]);
                mesh.triangles.push([before + k, now + next, now + k]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn a_tube_is_closed_faces_outward_and_has_the_volume_of_its_cones_and_hemispheres() {
        let centre: Vec<Vector> = (0..5).map(|k| Vector::new(0.1 * f64::from(k), 0.3, -0.2)).collect();
        let mesh = round(&centre, &[0.03; 5]);
        let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
        for [a, b, c] in &mesh.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *edges.entry([*from.min(to), *from.max(to)]).or_default() += if from < to { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|balance| *balance == 0), "every edge has two triangles");
        let corner = |k: &u32| mesh.corners[*k as usize];
        let volume: f64 =
            mesh.triangles.iter().map(|[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c)))).sum::<f64>() / 6.0;
        let round = std::f64::consts::PI * 0.03_f64.powi(2) * (0.4 + 4.0 / 3.0 * 0.03);
        assert!((volume / round - 1.0).abs() < 0.05 && volume < round, "{volume}, not {round}");
        let outward = |(x, n): (&Vector, &Vector)| {
            let nearest = Vector::new(x.x.clamp(0.0, 0.4), 0.3, -0.2);
            (x - nearest).normalize().dot(n) > 0.99
        };
        assert!(mesh.corners.iter().zip(&mesh.normals).all(outward));
    }
}
