//! Shapes of the links: primitives, and the meshes that they name.

use super::file::{File, child};
use roxmltree::Node;
use std::collections::BTreeMap;
use std::path::Path;
use wireloom_core::{Parameters, Pose, Quantity, Value, Vector};

/// A shape of a link.
pub struct LinkShape {
    /// Index of the link.
    pub link: usize,
    /// In the world, as drawn.
    pub pose: Pose,
    pub form: LinkForm,
    /// Line of the file.
    pub row: u32,
}

/// What it looks like.
pub enum LinkForm {
    /// A kind of the registry.
    Solid { kind: &'static str, parameters: Parameters },
    /// A file, from the folder of the scenario, and the length of its unit, m.
    Mesh { path: String, scale: f64 },
}

impl<'f> File<'f> {
    /// The shapes in the elements of this name of a link, whose frame is given.
    pub(super) fn shapes(&mut self, node: Node<'f, 'f>, element: &str, link: usize, frame: &Pose) -> Vec<LinkShape> {
        let all: Vec<_> = node.children().filter(|node| node.has_tag_name(element)).collect();
        all.into_iter()
            .filter_map(|node| {
                let pose = frame.compose(&self.origin(node)?);
                let row = self.document.text_pos_at(node.range().start).row;
                Some(LinkShape { link, pose, form: self.form(node)?, row })
            })
            .collect()
    }

    fn form(&mut self, node: Node<'f, 'f>) -> Option<LinkForm> {
        let shape = child(node, "geometry").and_then(|node| node.children().find(Node::is_element));
        let Some(shape) = shape else {
            self.fault(node, format!("<{}> has no shape", node.tag_name().name()), "add <geometry> with a shape");
            return None;
        };
        let solid = |kind: &'static str, parameters: Vec<(&str, Value)>| {
            let parameters: BTreeMap<_, _> = parameters.into_iter().map(|(k, v)| (k.to_owned(), v)).collect();
            Some(LinkForm::Solid { kind, parameters: Parameters(parameters) })
        };
        match shape.tag_name().name() {
            "box" => {
                let size = self.size(shape, "size")?;
                solid("box", vec![("size", Value::Vector(size))])
            }
            "sphere" => {
                let radius = self.length(shape, "radius")?;
                solid("sphere", vec![("radius", Value::Number(radius))])
            }
            kind @ ("cylinder" | "capsule") => {
                let kind = if kind == "cylinder" { "cylinder" } else { "capsule" };
                let (radius, length) = (self.length(shape, "radius")?, self.length(shape, "length")?);
                solid(kind, vec![("radius", Value::Number(radius)), ("length", Value::Number(length))])
            }
            "mesh" => {
                let name = self.attribute(shape, "filename")?;
                let path = self.resolved(shape, name)?;
                let scale =
                    self.vector(shape, "scale", Quantity::Dimensionless)?.unwrap_or_else(|| Vector::repeat(1.0));
                if !(scale.x > 0.0 && scale.y == scale.x && scale.z == scale.x) {
                    let help = "meshes can be scaled alike along all axes: write the mesh itself in its size";
                    self.fault(shape, "the scale differs along the axes, or is not greater than 0", help);
                    return None;
                }
                Some(LinkForm::Mesh { path, scale: scale.x })
            }
            other => {
                let help = "box, sphere, cylinder, capsule and mesh are known";
                self.fault(shape, format!("<{other}> is not a known shape"), help);
                None
            }
        }
    }

    fn length(&mut self, node: Node<'f, 'f>, name: &str) -> Option<f64> {
        self.attribute(node, name)?;
        let length = self.number(node, name, Quantity::Length)??;
        self.positive(node, name, [length])
    }

    fn size(&mut self, node: Node<'f, 'f>, name: &str) -> Option<Vector> {
        self.attribute(node, name)?;
        let size = self.vector(node, name, Quantity::Length)??;
        self.positive(node, name, [size.x, size.y, size.z]).map(|_| size)
    }

    /// The first of some lengths, if all are greater than 0.
    fn positive<const N: usize>(&mut self, node: Node<'f, 'f>, name: &str, lengths: [f64; N]) -> Option<f64> {
        if lengths.iter().all(|length| *length > 0.0) {
            return Some(lengths[0]);
        }
        let text = node.attribute(name).unwrap_or_default();
        self.fault(node, format!("{name}=\"{text}\" is not greater than 0"), "give lengths in m");
        None
    }

    /// The path of a mesh from the folder of the scenario: `package://NAME/…` is in the folder NAME that this file is
    /// in, or else in the one beside this file.
    fn resolved(&mut self, node: Node<'f, 'f>, name: &str) -> Option<String> {
        let beside = Path::new(self.path).parent().unwrap_or(Path::new(""));
        let path = match name.split_once("://") {
            None => beside.join(name),
            Some(("file", path)) => beside.join(path),
            Some(("package", rest)) => {
                let (package, _) = rest.split_once('/').unwrap_or((rest, ""));
                let around = beside.ancestors().find(|folder| folder.ends_with(package));
                around.and_then(Path::parent).unwrap_or(beside).join(rest)
            }
            Some((scheme, _)) => {
                let help = "file names, file:// and package:// are known";
                self.fault(node, format!("filename=\"{name}\" begins with {scheme}://"), help);
                return None;
            }
        };
        Some(path.to_string_lossy().into_owned())
    }
}
