//! glTF 2.0, as GLB or with its data in the text: the triangles of its scene, in its metres and axes. Of the format
//! only what makes surfaces is read, with every index and range checked: the crate for it indexes past the end in
//! damaged files.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use nalgebra::{Matrix4, Quaternion, UnitQuaternion};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;
use wireloom_core::Vector;
use wireloom_core::obstacle::Surface;

#[derive(Deserialize, Default)]
#[serde(default)]
struct Document {
    scene: Option<usize>,
    scenes: Vec<Scene>,
    nodes: Vec<Node>,
    meshes: Vec<Mesh>,
    accessors: Vec<Accessor>,
    #[serde(rename = "bufferViews")]
    views: Vec<View>,
    buffers: Vec<Buffer>,
    #[serde(rename = "extensionsRequired")]
    required: Vec<String>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Scene {
    nodes: Vec<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Node {
    children: Vec<usize>,
    mesh: Option<usize>,
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
    skin: Option<usize>,
    weights: Option<Vec<f64>>,
    extensions: BTreeMap<String, IgnoredAny>,
}

#[derive(Deserialize)]
struct Mesh {
    primitives: Vec<Primitive>,
    /// Of the morph targets, where the node gives none.
    #[serde(default)]
    weights: Vec<f64>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: Attributes,
    indices: Option<usize>,
    mode: Option<u32>,
    /// Morph targets.
    #[serde(default)]
    targets: Vec<IgnoredAny>,
}

#[derive(Deserialize)]
struct Attributes {
    #[serde(rename = "POSITION")]
    position: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    count: usize,
    #[serde(rename = "type")]
    shape: String,
    sparse: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct View {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
struct Buffer {
    uri: Option<String>,
}

/// Codes of the format: numbers of four bytes, whole ones of four, two and one; triangles.
const FLOAT: u32 = 5126;
const UNSIGNED: [(u32, usize); 3] = [(5125, 4), (5123, 2), (5121, 1)];
const TRIANGLES: u32 = 4;

/// Extensions, or beginnings of their names, that leave surfaces where they are. Numbers that
/// `KHR_mesh_quantization` allows are refused where they are met.
const HARMLESS: [&str; 6] =
    ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_punctual", "KHR_xmp", "KHR_mesh_quantization"];
/// Sets the mesh of a node in many places.
const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Nodes within nodes that are taken for meant.
const DEEPEST: usize = 100;
/// Corners, and triangles, that any file may come to: a small one may set one mesh in many places. A larger file may
/// come to one for each of its bytes, which is more than it can hold without that.
const MANY: usize = 2_000_000;

pub(super) fn read(bytes: &[u8]) -> Result<Surface, String> {
    let (text, mut binary) = if bytes.starts_with(b"glTF") { chunks(bytes)? } else { (bytes, None) };
    let document: Document = serde_json::from_slice(text).map_err(|error| error.to_string())?;
    let known = |name: &str| HARMLESS.iter().any(|harmless| name.starts_with(harmless));
    if let Some(name) = document.required.iter().find(|name| !known(name)) {
        return Err(format!("it needs the extension {name}, which is not read; export it without that"));
    }
    let mut buffers = Vec::new();
    for (k, buffer) in document.buffers.iter().enumerate() {
        let data = match &buffer.uri {
            None => binary.take().ok_or("the binary part is missing")?.to_vec(),
            Some(uri) => {
                let (_, data) = uri.split_once(";base64,").filter(|_| uri.starts_with("data:")).ok_or_else(|| {
                    format!("its data is in another file, \"{uri}\"; export it as one file, such as .glb")
                })?;
                STANDARD.decode(data).map_err(|error| format!("data of buffer {k}: {error}"))?
            }
        };
        buffers.push(data);
    }
    let scene = document.scenes.get(document.scene.unwrap_or(0)).ok_or("it has no scene")?;
    let mut file = File {
        document: &document,
        buffers,
        surface: Surface::default(),
        seen: vec![false; document.nodes.len()],
        many: MANY.max(bytes.len()),
    };
    scene.nodes.iter().try_for_each(|&node| file.add(node, &Matrix4::identity(), 0))?;
    Ok(file.surface)
}

/// The text and the binary part of a GLB.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let chunk = |at: usize| {
        let header = bytes.get(at..at.checked_add(8)?)?;
        let length = u32::from_le_bytes(header[..4].try_into().ok()?) as usize;
        Some((&header[4..], bytes.get(at + 8..(at + 8).checked_add(length)?)?))
    };
    let Some((b"JSON", text)) = chunk(12) else { return Err("its first part is no text".into()) };
    let binary = chunk(20 + text.len()).filter(|(kind, _)| kind == b"BIN\0").map(|(_, data)| data);
    Ok((text, binary))
}

struct File<'d> {
    document: &'d Document,
    buffers: Vec<Vec<u8>>,
    surface: Surface,
    /// Nodes that have been met.
    seen: Vec<bool>,
    /// Most corners, and most triangles.
    many: usize,
}

impl File<'_> {
    fn add(&mut self, node: usize, parent: &Matrix4<f64>, depth: usize) -> Result<(), String> {
        let document = self.document;
        let own = document.nodes.get(node).ok_or_else(|| format!("there is no node {node}"))?;
        if depth > DEEPEST {
            return Err(format!("its nodes lie within each other more than {DEEPEST} deep"));
        }
        // Nodes are trees: one with two parents would be met once for every way to it, and ways can be more than there
        // are atoms.
        if std::mem::replace(&mut self.seen[node], true) {
            return Err(format!("node {node} lies within two others, or within itself"));
        }
        let placed = parent * own.placed();
        if let Some(mesh) = own.mesh {
            let mesh = document.meshes.get(mesh).ok_or_else(|| format!("there is no mesh {mesh}"))?;
            if let Some(what) = own.deforms(mesh) {
                return Err(format!("node {node} has {what}, which is not read; export its triangles as they stand"));
            }
            mesh.primitives.iter().try_for_each(|part| self.add_part(part, &placed))?;
        }
        own.children.iter().try_for_each(|&child| self.add(child, &placed, depth + 1))
    }

    fn add_part(&mut self, part: &Primitive, placed: &Matrix4<f64>) -> Result<(), String> {
        if part.mode.is_some_and(|mode| mode != TRIANGLES) {
            return Err("it has lines, points, strips or fans; export it as triangles".into());
        }
        let Some(places) = part.attributes.position else { return Ok(()) };
        let first = self.surface.corners.len();
        let accessor = self.accessor(places)?;
        if accessor.component_type != FLOAT || accessor.shape != "VEC3" {
            return Err(format!("data {places} is of a kind that is not read; export it without compression"));
        }
        self.has_room(first, accessor.count, "corners")?;
        let number = |bytes: &[u8]| f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
        let corner = |bytes: &[u8]| Vector::new(number(bytes), number(&bytes[4..]), number(&bytes[8..]));
        let corners: Vec<Vector> = self.elements(places, 12)?.map(corner).collect();
        let (turned, moved) = (placed.fixed_view::<3, 3>(0, 0), placed.fixed_view::<3, 1>(0, 3));
        let count = corners.len();
        self.surface.corners.extend(corners.iter().map(|corner| turned * corner + moved));
        let uses = part.indices.map_or(Ok(count), |indices| Ok::<_, String>(self.accessor(indices)?.count))?;
        self.has_room(self.surface.triangles.len(), uses / 3, "triangles")?;
        let indices: Vec<u32> = match part.indices {
            None => (0..count as u32).collect(),
            Some(indices) => {
                let accessor = self.accessor(indices)?;
                let size = UNSIGNED.iter().find(|(code, _)| *code == accessor.component_type).map(|(_, size)| *size);
                let size = size.filter(|_| accessor.shape == "SCALAR").ok_or("indices are no whole numbers")?;
                let index = |bytes: &[u8]| bytes.iter().rev().fold(0, |index, byte| index << 8 | u32::from(*byte));
                self.elements(indices, size)?.map(index).collect()
            }
        };
        if let Some(index) = indices.iter().find(|index| **index as usize >= count) {
            return Err(format!("a triangle has corner {index}, of {count}"));
        }
        // What is mirrored faces inward.
        let mirrored = turned.determinant() < 0.0;
        self.surface.triangles.extend(indices.chunks_exact(3).map(|t| {
            let [a, b, c] = [t[0], t[1], t[2]].map(|k| k + first as u32);
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
        Ok(())
    }

    /// Refuses more corners or triangles than are taken for meant, before they are made.
    fn has_room(&self, taken: usize, further: usize, what: &str) -> Result<(), String> {
        if further > self.many.saturating_sub(taken) {
            return Err(format!("it has more than {} {what}", self.many));
        }
        Ok(())
    }

    fn accessor(&self, index: usize) -> Result<&Accessor, String> {
        self.document.accessors.get(index).ok_or_else(|| format!("there is no data {index}"))
    }

    /// The bytes of each element of an accessor.
    fn elements(&self, index: usize, size: usize) -> Result<impl Iterator<Item = &[u8]>, String> {
        let accessor = self.accessor(index)?;
        let view =
            accessor.buffer_view.filter(|_| accessor.sparse.is_none()).and_then(|view| self.document.views.get(view));
        let view = view.ok_or_else(|| format!("data {index} is sparse or missing; export it without compression"))?;
        let stride = view.byte_stride.unwrap_or(size);
        let range = || {
            let begin = view.byte_offset.checked_add(accessor.byte_offset)?;
            let length = match accessor.count.checked_sub(1) {
                Some(others) => others.checked_mul(stride)?.checked_add(size)?,
                None => 0,
            };
            self.buffers.get(view.buffer)?.get(begin..begin.checked_add(length)?)
        };
        let bytes = range().filter(|_| stride >= size);
        let bytes = bytes.ok_or_else(|| format!("data {index} lies beyond the end of its buffer"))?;
        Ok(bytes.chunks(stride).map(move |element| &element[..size]))
    }
}

impl Node {
    /// What moves or repeats the triangles of its mesh, if anything does.
    fn deforms(&self, mesh: &Mesh) -> Option<&'static str> {
        let weights = self.weights.as_ref().unwrap_or(&mesh.weights);
        let morphed = mesh.primitives.iter().any(|part| !part.targets.is_empty()) && weights.iter().any(|w| *w != 0.0);
        match () {
            () if self.skin.is_some() => Some("a skin"),
            () if morphed => Some("a morph target with a weight other than 0"),
            () if self.extensions.contains_key(INSTANCING) => Some(INSTANCING),
            () => None,
        }
    }

    /// Transformation into the axes of its parent node.
    fn placed(&self) -> Matrix4<f64> {
        if let Some(matrix) = &self.matrix {
            return Matrix4::from_column_slice(matrix);
        }
        let [x, y, z, w] = self.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)).to_homogeneous();
        let scale = Matrix4::new_nonuniform_scaling(&self.scale.unwrap_or([1.0; 3]).into());
        Matrix4::new_translation(&self.translation.unwrap_or_default().into()) * rotation * scale
    }
}
