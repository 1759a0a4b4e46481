//! STL, as text or binary.

use std::io::Cursor;
use wireloom_core::Vector;
use wireloom_core::obstacle::Surface;

/// Bytes of the header of a binary file, of its count, of a triangle.
const HEADER: usize = 80;
const COUNT: usize = 4;
const TRIANGLE: usize = 50;

pub(super) fn read(bytes: &[u8]) -> Result<Surface, String> {
    let mut bytes = bytes.to_vec();
    // Some binary files begin with "solid", as text does: their length tells them apart.
    let count = bytes.get(HEADER..HEADER + COUNT).and_then(|count| <[u8; COUNT]>::try_from(count).ok());
    if count.is_some_and(|count| {
        u32::from_le_bytes(count) as usize == bytes.len().saturating_sub(HEADER + COUNT) / TRIANGLE
    }) {
        bytes[..HEADER].fill(0);
    }
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|error| error.to_string())?;
    let corners = mesh.vertices.iter().map(|corner| Vector::from(corner.0.map(f64::from))).collect();
    Ok(Surface { corners, triangles: mesh.faces.iter().map(|face| face.vertices.map(|k| k as u32)).collect() })
}
