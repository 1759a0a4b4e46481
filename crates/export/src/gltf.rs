//! glTF 2.0 in one binary file (GLB): the harness with its obstacles, and surfaces. Metres; coordinates are in the
//! axes of the scenario, under one node that turns them so that y points up, as the format demands.

mod tubes;

pub use tubes::{Tube, write_tubes};

use crate::format::{self as output, Ended, Format};
use crate::json;
use crate::local::node_count;
use serde_json::{Value, json};
use std::f64::consts::{FRAC_1_SQRT_2, TAU};
use std::io::{self, Write};
use wireloom_core::equilibrium::{BranchResult, ConstraintResult, Run, StepResult};
use wireloom_core::identity::Identified;
use wireloom_core::obstacle::{Obstacle, Surface};
use wireloom_core::rotation::columns;
use wireloom_core::{Pose, Vector};

/// Sides of a tube.
const SIDES: usize = 16;
/// A quarter turn that takes z to y: x, y, z, w.
const UPRIGHT: [f64; 4] = [-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];
/// Length of a connector, in diameters of its cable; that of any other constraint; their width.
const CONNECTOR: f64 = 4.0;
const CONSTRAINT: f64 = 1.0;
const WIDTH: f64 = 2.0;
/// Size of an unbounded obstacle, in units of the largest distance of the harness from it.
const BEYOND: f64 = 1.5;
/// Points farther away than this are not drawn, m.
const FAR: f64 = 1e9;

/// Constants of the format: targets of buffer views, types of components.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// Materials: name and colour.
const MATERIALS: [(&str, [f64; 4]); 4] = [
    ("cable", [0.10, 0.11, 0.13, 1.0]),
    ("constraint", [0.13, 0.35, 0.75, 1.0]),
    ("obstacle", [0.70, 0.73, 0.76, 1.0]),
    ("swept", [0.90, 0.55, 0.10, 0.5]),
];
const CABLE: usize = 0;
const HELD: usize = 1;
const OBSTACLE: usize = 2;
const SWEPT: usize = 3;

/// Writes the harness at the end of each step of a run, a scene each, of which the last is the one shown: branches as
/// tubes of their diameter, constraints as boxes (longer for connectors), obstacles at their poses. Nodes have their
/// names, and what a parts list says of them in their `extras`. Parts without finite coordinates, which a failed run
/// may leave, are omitted. The `extras` of the file have `status`, `verdict` and `requirements` as they are in
/// `result.json`.
///
/// # Errors
/// Those of `out`; `InvalidInput` where a branch's vectors differ in length, or the file grows beyond the 4 GB that
/// the format can hold.
pub fn write(run: &Run, obstacles: &[Obstacle], out: &mut impl Write) -> io::Result<()> {
    let steps = output::ends(run);
    let mut file = File { extras: Some(json::sheet(run)?), ..File::default() };
    let bodies: Vec<Option<usize>> = obstacles
        .iter()
        .enumerate()
        .map(|(k, obstacle)| {
            let reach = steps.iter().map(|step| reach(step, &step.obstacles[k].pose)).fold(0.0, f64::max);
            file.surface(&obstacle.name, &obstacle.shape.surface(BEYOND * reach), OBSTACLE)
        })
        .collect();
    let cube = file.mesh("box", &cube(), HELD);
    for step in steps {
        let mut children = vec![];
        for branch in &step.branches {
            if node_count(branch)? < 2 || !branch.position.iter().all(is_drawable) || !branch.diameter.is_finite() {
                continue;
            }
            let mesh = file.mesh(&branch.name, &tube(branch), CABLE);
            let node = json!({ "name": branch.name, "mesh": mesh });
            children.push(file.node(identified(node, run, Identified::Branch)?));
        }
        for constraint in step.constraints.iter().filter(|constraint| is_drawable(&constraint.position)) {
            let mut node =
                placed(&constraint.name, &Pose { position: constraint.position, orientation: constraint.orientation });
            node["mesh"] = cube.into();
            let diameter = diameter_at(step, constraint);
            let length = if constraint.kind == "connector" { CONNECTOR } else { CONSTRAINT };
            node["scale"] = json!([WIDTH * diameter, WIDTH * diameter, length * diameter]);
            children.push(file.node(identified(node, run, Identified::Constraint)?));
        }
        for ((obstacle, result), mesh) in obstacles.iter().zip(&step.obstacles).zip(&bodies) {
            let mut node = placed(&obstacle.name, &result.pose);
            if let Some(mesh) = mesh {
                node["mesh"] = (*mesh).into();
            }
            children.push(file.node(identified(node, run, Identified::Obstacle)?));
        }
        file.scene(&step.name, children);
    }
    file.write(out)
}

/// Writes a surface, such as the space that a harness goes through, with this name.
///
/// # Errors
/// As those of [`write()`].
pub fn write_surface(name: &str, surface: &Surface, out: &mut impl Write) -> io::Result<()> {
    let mut file = File::default();
    let mesh = file.surface(name, surface, SWEPT);
    let node = mesh.map(|mesh| file.node(json!({ "name": name, "mesh": mesh })));
    file.scene(name, node.into_iter().collect());
    file.write(out)
}

/// Writes a part of the surroundings, with its name and colour (linear red, green and blue), for an obstacle of a
/// scenario: its axes are those of the part, not turned so that y points up. Corners are in millimetres about the
/// middle of the part, and the node has place and scale: single precision holds them to 6e-8 of half its size, and what
/// is drawn in whole millimetres exactly.
///
/// # Errors
/// As those of [`write()`].
pub fn write_part(name: &str, colour: Option<[f64; 3]>, surface: &Surface, out: &mut impl Write) -> io::Result<()> {
    let mut file = File::default();
    let bound = |best: fn(f64, f64) -> f64| surface.corners.iter().copied().reduce(|a, b| a.zip_map(&b, best));
    let middle = bound(f64::min).zip(bound(f64::max)).map_or(Vector::zeros(), |(least, most)| (least + most) * 0.5);
    let corners = surface.corners.iter().map(|corner| (corner - middle) * 1e3).collect();
    let own = Surface { corners, triangles: surface.triangles.clone() };
    let material = match colour {
        Some([red, green, blue]) => file.material(name, [red, green, blue, 1.0]),
        None => OBSTACLE,
    };
    let mut node = json!({ "name": name, "translation": middle.as_slice(), "scale": [1e-3, 1e-3, 1e-3] });
    if let Some(mesh) = file.surface(name, &own, material) {
        node["mesh"] = mesh.into();
    }
    let node = file.node(node);
    file.scenes.push(json!({ "name": name, "nodes": [node] }));
    file.write(out)
}

/// Whether its coordinates are finite and small enough for single precision.
fn is_drawable(x: &Vector) -> bool {
    x.iter().all(|c| c.abs() < FAR)
}

/// Largest distance of the nodes of a step from a pose, m.
fn reach(step: &StepResult, pose: &Pose) -> f64 {
    let all = step.branches.iter().flat_map(|branch| &branch.position).filter(|x| is_drawable(x));
    all.map(|x| (x - pose.position).norm()).fold(0.0, f64::max)
}

/// Diameter of the branch whose centre line is nearest to a constraint, m.
fn diameter_at(step: &StepResult, constraint: &ConstraintResult) -> f64 {
    let off = |branch: &BranchResult| {
        branch.position.iter().map(|x| (x - constraint.position).norm_squared()).fold(f64::INFINITY, f64::min)
    };
    let nearest = step
        .branches
        .iter()
        .filter(|branch| branch.diameter.is_finite())
        .map(|branch| (off(branch), branch.diameter))
        .min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or(0.0, |(_, diameter)| diameter)
}

/// A node with what the parts list of the run says of the part of its name.
fn identified(mut node: Value, run: &Run, of: Identified) -> io::Result<Value> {
    if let Some(identity) = node["name"].as_str().and_then(|name| run.identities.find(of, name)) {
        node["extras"] = serde_json::to_value(identity)?;
    }
    Ok(node)
}

/// A node at a pose.
fn placed(name: &str, pose: &Pose) -> Value {
    let q = pose.orientation.coords;
    json!({
        "name": name,
        "translation": pose.position.as_slice(),
        "rotation": [q.x, q.y, q.z, q.w],
    })
}

/// Vertices of a mesh, with normals where it is smooth.
#[derive(Default)]
struct Mesh {
    corners: Vec<Vector>,
    normals: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A ring of corners about `at`, their normals made of the directions from there; returns the index of the first.
    fn ring(&mut self, at: &Vector, axes: [Vector; 2], radius: f64, normal: impl Fn(&Vector) -> Vector) -> u32 {
        let first = self.corners.len() as u32;
        for k in 0..SIDES {
            let (sine, cosine) = (TAU * k as f64 / SIDES as f64).sin_cos();
            let outward = axes[0] * cosine + axes[1] * sine;
            self.corners.push(at + outward * radius);
            self.normals.push(normal(&outward));
        }
        first
    }
}

/// A branch as a tube with flat ends, and a step where its diameter changes.
fn tube(branch: &BranchResult) -> Mesh {
    let mut mesh = Mesh::default();
    let sides = SIDES as u32;
    let last = branch.position.len() - 1;
    let radii =
        |node: usize| [node.saturating_sub(1), node.min(last - 1)].map(|segment| 0.5 * branch.diameter_of(segment));
    for (node, (x, frame)) in branch.position.iter().zip(&branch.frame).enumerate() {
        let [d1, d2, _] = columns(frame);
        let [before, after] = radii(node);
        for radius in std::iter::once(before).chain((after != before).then_some(after)) {
            let ring = mesh.ring(x, [d1, d2], radius, |outward| *outward);
            for k in (0..sides).filter(|_| ring > 0) {
                let (a, b) = (ring + k, ring + (k + 1) % sides);
                mesh.triangles.push([a - sides, b - sides, b]);
                mesh.triangles.push([a - sides, b, a]);
            }
        }
    }
    for (node, side) in [(0, -1.0), (last, 1.0)] {
        let radius = radii(node)[0];
        let [d1, d2, d3] = columns(&branch.frame[node]);
        let ring = mesh.ring(&branch.position[node], [d1, d2], radius, |_| d3 * side);
        for k in 1..sides - 1 {
            let (a, b) = if side > 0.0 { (k, k + 1) } else { (k + 1, k) };
            mesh.triangles.push([ring, ring + a, ring + b]);
        }
    }
    mesh
}

/// A box of size 1 about the origin.
fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for (normal, along) in [(Vector::x(), Vector::y()), (Vector::y(), Vector::z()), (Vector::z(), Vector::x())] {
        for side in [-0.5, 0.5] {
            let first = mesh.corners.len() as u32;
            let across = normal.cross(&along) * (2.0 * side);
            for (a, b) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
                mesh.corners.push(normal * side + along * a + across * b);
                mesh.normals.push(normal * (2.0 * side));
            }
            mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k: u32| first + k)));
        }
    }
    mesh
}

/// A file while it is written.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    scenes: Vec<Value>,
    /// Materials beside [`MATERIALS`]: name and colour.
    materials: Vec<(String, [f64; 4])>,
    /// Data of applications, if there are any.
    extras: Option<Value>,
}

impl File {
    /// Appends numbers of four bytes; returns the index of their accessor.
    fn numbers(&mut self, numbers: impl Iterator<Item = [u8; 4]>, target: u32, mut accessor: Value) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(numbers.flatten());
        accessor["bufferView"] = self.views.len().into();
        self.views.push(json!({
            "buffer": 0,
            "byteOffset": offset,
            "byteLength": self.bytes.len() - offset,
            "target": target,
        }));
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn vectors(&mut self, vectors: &[Vector]) -> usize {
        // The format demands the bounds of the values, in single precision.
        let single: Vec<[f32; 3]> = vectors.iter().map(|v| [v.x as f32, v.y as f32, v.z as f32]).collect();
        let bound = |best: fn(f32, f32) -> f32| {
            single.iter().copied().reduce(|a, b| [0, 1, 2].map(|d| best(a[d], b[d]))).unwrap_or_default()
        };
        let accessor = json!({
            "componentType": FLOAT,
            "type": "VEC3",
            "count": single.len(),
            "min": bound(f32::min),
            "max": bound(f32::max),
        });
        self.numbers(single.iter().flatten().map(|x| x.to_le_bytes()), VERTICES, accessor)
    }

    /// Appends a mesh that has triangles; without normals it is flat between its edges.
    fn mesh(&mut self, name: &str, mesh: &Mesh, material: usize) -> usize {
        let mut attributes = json!({ "POSITION": self.vectors(&mesh.corners) });
        if !mesh.normals.is_empty() {
            attributes["NORMAL"] = self.vectors(&mesh.normals).into();
        }
        let accessor = json!({ "componentType": UNSIGNED_INT, "type": "SCALAR", "count": 3 * mesh.triangles.len() });
        let indices = mesh.triangles.iter().flatten().map(|k| k.to_le_bytes());
        let indices = self.numbers(indices, INDICES, accessor);
        self.meshes.push(json!({
            "name": name,
            "primitives": [{ "attributes": attributes, "indices": indices, "material": material }],
        }));
        self.meshes.len() - 1
    }

    /// The same of a surface; none where it is empty, which the format does not allow.
    fn surface(&mut self, name: &str, surface: &Surface, material: usize) -> Option<usize> {
        let Surface { corners, triangles } = surface;
        let mesh = Mesh { corners: corners.clone(), normals: vec![], triangles: triangles.clone() };
        (!triangles.is_empty()).then(|| self.mesh(name, &mesh, material))
    }

    /// Index of a material with this colour.
    fn material(&mut self, name: &str, colour: [f64; 4]) -> usize {
        self.materials.push((name.to_owned(), colour));
        MATERIALS.len() + self.materials.len() - 1
    }

    fn node(&mut self, node: Value) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// A scene of nodes, turned so that y points up.
    fn scene(&mut self, name: &str, children: Vec<usize>) {
        let mut upright = json!({ "name": name, "rotation": UPRIGHT });
        if !children.is_empty() {
            upright["children"] = children.into();
        }
        let upright = self.node(upright);
        self.scenes.push(json!({ "name": name, "nodes": [upright] }));
    }

    fn write(mut self, out: &mut impl Write) -> io::Result<()> {
        let own = self.materials.iter().map(|(name, colour)| (name.as_str(), *colour));
        let materials = MATERIALS.into_iter().chain(own).map(|(name, colour)| {
            json!({
                "name": name,
                "pbrMetallicRoughness": { "baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": 0.7 },
                "alphaMode": if colour[3] < 1.0 { "BLEND" } else { "OPAQUE" },
                "doubleSided": true,
            })
        });
        let materials: Vec<Value> = materials.collect();
        let mut document = json!({
            "asset": { "version": "2.0", "generator": "wireloom" },
            "scene": self.scenes.len().saturating_sub(1),
            "scenes": self.scenes,
            "nodes": self.nodes,
            "materials": materials,
        });
        if let Some(extras) = self.extras {
            document["extras"] = extras;
        }
        // Lists may not be empty.
        let lists = [("meshes", self.meshes), ("accessors", self.accessors), ("bufferViews", self.views)];
        for (key, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
            document[key] = list.into();
        }
        if !self.bytes.is_empty() {
            document["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        }
        let mut text = serde_json::to_vec(&document)?;
        text.resize(text.len().next_multiple_of(4), b' ');
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let total = 12 + 8 + text.len() + 8 + self.bytes.len();
        let total = u32::try_from(total).map_err(|_| {
            io::Error::new(io::ErrorKind::InvalidInput, "it is larger than the 4 GB that glTF can hold")
        })?;
        out.write_all(b"glTF")?;
        out.write_all(&2_u32.to_le_bytes())?;
        out.write_all(&total.to_le_bytes())?;
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &self.bytes)] {
            out.write_all(&(chunk.len() as u32).to_le_bytes())?;
            out.write_all(kind)?;
            out.write_all(chunk)?;
        }
        Ok(())
    }
}

/// The format `harness.glb`.
pub struct Gltf;

/// Its media type.
const MEDIA_TYPE: &str = "model/gltf-binary";

impl Format for Gltf {
    fn key(&self) -> Option<&'static str> {
        Some("gltf")
    }

    fn files(&self) -> &'static [&'static str] {
        &["harness.glb"]
    }

    fn media_type(&self) -> &'static str {
        MEDIA_TYPE
    }

    fn at_end<'a>(&self, ended: &'a Ended<'a>) -> Vec<output::File<'a>> {
        if ended.run.steps.is_empty() {
            return vec![];
        }
        let obstacles = ended.surroundings.obstacles();
        vec![output::File::new("harness.glb", |mut out| write(ended.run, obstacles, &mut out))]
    }
}

/// The format `swept.glb`.
pub struct Swept;

impl Format for Swept {
    fn key(&self) -> Option<&'static str> {
        Some("swept")
    }

    fn files(&self) -> &'static [&'static str] {
        &["swept.glb"]
    }

    fn media_type(&self) -> &'static str {
        MEDIA_TYPE
    }

    fn at_end<'a>(&self, ended: &'a Ended<'a>) -> Vec<output::File<'a>> {
        let surface = ended.swept.filter(|surface| !surface.triangles.is_empty());
        let file = |surface| output::File::new("swept.glb", move |mut out| write_surface("swept", surface, &mut out));
        surface.map(file).into_iter().collect()
    }
}
