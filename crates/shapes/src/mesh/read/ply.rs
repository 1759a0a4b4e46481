//! PLY, as text or binary; polygons are taken for convex.

use super::polygon::fan;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::io::Cursor;
use wireloom_core::Vector;
use wireloom_core::obstacle::Surface;

#[derive(Default)]
struct Corner(Vector);

impl PropertyAccess for Corner {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        let value = match property {
            Property::Float(x) => f64::from(x),
            Property::Double(x) => x,
            Property::Char(x) => x.into(),
            Property::UChar(x) => x.into(),
            Property::Short(x) => x.into(),
            Property::UShort(x) => x.into(),
            Property::Int(x) => x.into(),
            Property::UInt(x) => x.into(),
            _ => return PropertyAccessResult::Ignored,
        };
        let coordinate = match key {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return PropertyAccessResult::Ignored,
        };
        self.0[coordinate] = value;
        PropertyAccessResult::Set
    }
}

/// A polygon; none where its corners are no indices.
struct Face(Option<Vec<u32>>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Some(Vec::new()))
    }

    fn set_property(&mut self, key: &str, property: Property) -> PropertyAccessResult {
        if !["vertex_indices", "vertex_index"].contains(&key) {
            return PropertyAccessResult::Ignored;
        }
        self.0 = property.to_u32_list();
        PropertyAccessResult::Set
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<Surface, String> {
    let mut source = Reader::new(Cursor::new(bytes));
    let (corners, faces) = (Parser::<Corner>::new(), Parser::<Face>::new());
    let header = corners.read_header(&mut source).map_err(|error| error.to_string())?;
    let mut surface = Surface::default();
    for (name, element) in &header.elements {
        // A binary file may claim any number of such without a byte for them.
        if element.properties.is_empty() && element.count > 0 {
            return Err(format!("it has {} of `{name}`, which have no properties", element.count));
        }
        if name != "face" {
            let read = corners.read_payload_for_element(&mut source, element, &header);
            let read = read.map_err(|error| error.to_string())?;
            if name == "vertex" {
                surface.corners = read.into_iter().map(|corner| corner.0).collect();
            }
            continue;
        }
        let read = faces.read_payload_for_element(&mut source, element, &header).map_err(|error| error.to_string())?;
        for (k, face) in read.into_iter().enumerate() {
            let polygon = face.0.ok_or_else(|| format!("face {k} has corners that are no indices"))?;
            surface.triangles.extend(fan(&polygon));
        }
    }
    Ok(surface)
}
