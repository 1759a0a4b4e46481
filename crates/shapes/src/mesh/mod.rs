//! Bodies given by triangles.

mod fault;
mod inside;
mod parts;
mod read;
#[cfg(test)]
mod tests;
mod topology;

pub use fault::MeshFault;
pub use read::{ReadFault, StepReader, read};

use crate::parameters::{flag, length};
use crate::tree::Feature;
use inside::{Region, Regions};
use parts::{Nearest, Parts};
use topology::{NONE, Topology};
use wireloom_core::obstacle::{Shape, Surface, Touch};
use wireloom_core::registry::{BuildError, Parameter, ShapeKind};
use wireloom_core::{Matrix, Vector};

/// The kind `mesh`: the surface is in a file; `step`: what reads STEP files.
pub fn kind(step: Option<StepReader>) -> ShapeKind {
    let deflection = Parameter {
        required: false,
        ..length(
            "deflection",
            "largest distance of the triangles from the surfaces of a STEP file; default 0.1 mm; other files have \
             triangles already",
        )
    };
    let open = flag(
        "open",
        "true: the surface is a sheet, solid on both sides, and may have borders; default false: it is closed about a \
         body",
    );
    ShapeKind {
        name: "mesh".into(),
        doc: "a surface of triangles out of a file: STL, OBJ, PLY, glTF, GLB or STEP; taken where `mesh` is given"
            .into(),
        parameters: vec![open, deflection],
        build: Box::new(move |spec, parameters| {
            let Some(file) = &spec.file else {
                let help = "add `mesh`: a file, from the folder of the scenario, such as mesh = \"panel.stl\"";
                return Err(BuildError::new("it is a mesh, and has no `mesh`", help).at("shape"));
            };
            let (surface, notes) = read::read_or_step(file, parameters.number("deflection"), step.as_ref())?;
            let mut mesh = Mesh::new(&surface, parameters.flag("open").unwrap_or(false))?;
            mesh.topology.notes.extend(notes);
            Ok(Box::new(mesh))
        }),
    }
}

/// A triangle mesh: φ is the distance from its triangles, negative inside where it is closed.
pub struct Mesh {
    topology: Topology,
    parts: Parts,
    /// Of each corner, the normals of its triangles, weighted with their angles there: positive on it is outside
    /// (Bærentzen and Aanæs 2005).
    corner_normals: Vec<Vector>,
    /// Of a closed surface.
    regions: Option<Regions>,
}

/// Bend, rad, below which an edge is a groove seen from outside, where its sides hide nothing of each other. What lies
/// flat but for round-off is none.
const FLAT: f32 = 1e-3;
/// So many parts are seen at one place at most.
const MANY: usize = 32;

impl Mesh {
    /// A body with this surface; with `open`, a sheet.
    ///
    /// # Errors
    /// If the triangles are not a surface, or not a closed one where `open` is false.
    pub fn new(surface: &Surface, open: bool) -> Result<Self, MeshFault> {
        let topology = Topology::of(surface, open)?;
        let parts = Parts::of(&topology, open);
        let mut corner_normals = vec![Vector::zeros(); topology.corners.len()];
        for t in 0..topology.triangles.len() {
            let places = topology.at(t);
            for k in 0..3 {
                let [u, v] = [1, 2].map(|j| places[(k + j) % 3] - places[k]);
                corner_normals[topology.triangles[t][k] as usize] += topology.normals[t] * u.angle(&v);
            }
        }
        let mut mesh = Self { topology, parts, corner_normals, regions: None };
        if !open {
            let signed_distance = |x: &Vector| {
                mesh.parts.nearest(&mesh.topology, x, f64::INFINITY).map_or(f64::INFINITY, |n| mesh.signed(&n, x))
            };
            mesh.regions = Some(Regions::of(mesh.parts.corners(), signed_distance));
        }
        Ok(mesh)
    }

    /// Into how many parts it is cut.
    pub fn parts(&self) -> usize {
        self.parts.count()
    }

    /// Out of the body at a place of the surface, of no particular length.
    fn normal(&self, nearest: &Nearest) -> Vector {
        let t = nearest.triangle as usize;
        let own = self.topology.normals[t];
        match nearest.feature {
            Feature::Face => own,
            Feature::Edge(e) => match self.topology.neighbours[t][e] {
                NONE => own,
                other => own + self.topology.normals[other as usize],
            },
            Feature::Corner(k) => self.corner_normals[self.topology.triangles[t][k] as usize],
        }
    }

    /// 1 before a place of the surface, −1 behind it.
    fn side(&self, nearest: &Nearest, x: &Vector) -> f64 {
        let before = (x - nearest.place).dot(&self.normal(nearest));
        if before < 0.0 { -1.0 } else { 1.0 }
    }

    /// φ by the nearest place.
    fn signed(&self, nearest: &Nearest, x: &Vector) -> f64 {
        if self.regions.is_none() { nearest.distance } else { self.side(nearest, x) * nearest.distance }
    }

    /// Radius of a search that tells whether a point is inside, and finds all of the surface that is nearer than
    /// `reach`.
    fn far_enough(&self, x: &Vector, reach: f64) -> f64 {
        match self.regions.as_ref().map(|regions| regions.at(x)) {
            None | Some(Region::Outside) => reach,
            Some(Region::Inside) => f64::INFINITY,
            Some(Region::Near(distance)) => distance.max(reach),
        }
    }

    /// Touch at the nearest place p. With r = x − p and s its side, φ = s |r| and n = s r/|r|. As x moves, p follows in
    /// its face, along its edge e, or not at all: ∂²φ/∂x² = 0, s (I − n nᵀ − e eᵀ)/|r|, s (I − n nᵀ)/|r|.
    fn touch(&self, nearest: &Nearest, x: &Vector) -> Touch {
        let open = self.regions.is_none();
        let t = nearest.triangle as usize;
        let side = self.side(nearest, x);
        let own = self.topology.normals[t];
        let sign = if open { 1.0 } else { side };
        let r = x - nearest.place;
        if nearest.feature == Feature::Face {
            // The face's own normal is exact however near it is.
            let normal = if open { own * side } else { own };
            let distance = normal.dot(&(x - self.topology.at(t)[0]));
            return Touch { distance, normal, curvature: Matrix::zeros(), part: nearest.part };
        }
        let distance = sign * nearest.distance;
        let scale = self.topology.at(t)[0].amax().max(x.amax());
        if nearest.distance <= 1e-13 * scale {
            let normal = self.normal(nearest).try_normalize(0.0).unwrap_or(own);
            return Touch { distance, normal, curvature: Matrix::zeros(), part: nearest.part };
        }
        let normal = r * (sign / nearest.distance);
        let mut across = Matrix::identity() - normal * normal.transpose();
        if let Feature::Edge(e) = nearest.feature {
            let places = self.topology.at(t);
            let along = (places[(e + 1) % 3] - places[e]).normalize();
            across -= along * along.transpose();
        }
        Touch { distance, normal, curvature: across * (sign / nearest.distance), part: nearest.part }
    }

    /// Whether a place at the border of its part is nearest also as seen from the triangles beside it, across edges
    /// that are no grooves, and theirs is not a part before its own: such a place belongs to all of them and is told
    /// once.
    fn is_told_by(&self, nearest: &Nearest, x: &Vector) -> bool {
        let t = nearest.triangle as usize;
        let r = x - nearest.place;
        let side = if self.regions.is_none() { self.side(nearest, x) as f32 } else { 1.0 };
        let seamless = |t: usize, e: usize| side * self.topology.bends[t][e] > -FLAT;
        let leads_on = |t: usize, from: usize, to: usize| {
            let places = self.topology.at(t);
            r.dot(&(places[to] - places[from])) > 1e-12 * r.norm() * (places[to] - places[from]).norm()
        };
        let mut told = true;
        match nearest.feature {
            Feature::Face => {}
            Feature::Edge(e) => {
                let other = self.topology.neighbours[t][e];
                if other != NONE && seamless(t, e) {
                    let u = other as usize;
                    let (a, b) = (self.topology.triangles[t][e], self.topology.triangles[t][(e + 1) % 3]);
                    let apex = (0..3).find(|&k| ![a, b].contains(&self.topology.triangles[u][k])).unwrap_or(0);
                    let [p, q] = [a, b].map(|corner| self.topology.corners[corner as usize]);
                    let along = (q - p).normalize();
                    let inward = self.topology.at(u)[apex] - p;
                    let inward = inward - along * along.dot(&inward);
                    told = r.dot(&inward) <= 1e-12 * r.norm() * inward.norm() && self.parts.part_of(u) >= nearest.part;
                }
            }
            Feature::Corner(k) => self.topology.around(t, k, seamless, |u, j| {
                let on = leads_on(u, j, (j + 1) % 3) || leads_on(u, j, (j + 2) % 3);
                told &= !on && self.parts.part_of(u) >= nearest.part;
            }),
        }
        told
    }

    /// Whether other triangles are between a point and a place of the surface.
    fn is_hidden(&self, nearest: &Nearest, x: &Vector) -> bool {
        const ALMOST: f64 = 1.0 - 1e-6;
        self.parts.first_hit(&self.topology, x, &(nearest.place - x), ALMOST).is_some()
    }
}

impl Shape for Mesh {
    fn distance(&self, x: &Vector, reach: f64) -> f64 {
        let nearest = self.parts.nearest(&self.topology, x, self.far_enough(x, reach));
        nearest.map_or(f64::INFINITY, |nearest| self.signed(&nearest, x))
    }

    fn touches(&self, x: &Vector, reach: f64, see: &mut dyn FnMut(Touch)) {
        let Some(nearest) = self.parts.nearest(&self.topology, x, self.far_enough(x, reach)) else { return };
        let closed = self.regions.is_some();
        if self.signed(&nearest, x) >= reach {
            return;
        }
        if self.parts.count() == 1 || (closed && self.side(&nearest, x) < 0.0) {
            see(self.touch(&nearest, x));
            return;
        }
        // In the order of the parts.
        let (mut near, mut count) = ([u32::MAX; MANY], 0);
        self.parts.within(x, reach, |part| {
            if count < MANY {
                near[count] = part;
                count += 1;
            }
        });
        near[..count].sort_unstable();
        let (mut told, mut places) = (0, [Vector::zeros(); MANY]);
        for &part in &near[..count] {
            let Some(own) = self.parts.nearest_of(&self.topology, part, x, reach) else { continue };
            let faces = !closed || self.side(&own, x) > 0.0;
            // On a seam, by round-off, each side may take a place for its own.
            let again = places[..told].iter().any(|place| (own.place - place).norm() <= 1e-9 * own.distance);
            if faces && !again && self.is_told_by(&own, x) && (part == nearest.part || !self.is_hidden(&own, x)) {
                see(self.touch(&own, x));
                places[told] = own.place;
                told += 1;
            }
        }
        // Or each may leave it to the other.
        if told == 0 {
            see(self.touch(&nearest, x));
        }
    }

    fn crossing(&self, from: &Vector, to: &Vector) -> Option<f64> {
        self.parts.first_hit(&self.topology, from, &(to - from), 1.0_f64.next_up())
    }

    fn surface(&self, _: f64) -> Surface {
        let all = self.topology.triangles.iter().zip(&self.topology.normals);
        let triangles = all.filter(|(_, normal)| **normal != Vector::zeros()).map(|(t, _)| *t).collect();
        Surface { corners: self.topology.corners.clone(), triangles }
    }

    fn notes(&self) -> Vec<String> {
        self.topology.notes.clone()
    }
}
