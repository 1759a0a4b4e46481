//! Wavefront OBJ; materials are left alone.

use std::io::Cursor;
use wireloom_core::Vector;
use wireloom_core::obstacle::Surface;

pub(super) fn read(bytes: &[u8]) -> Result<Surface, String> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) =
        tobj::load_obj_buf(&mut Cursor::new(bytes), &options, no_materials).map_err(|error| error.to_string())?;
    let mut surface = Surface::default();
    for model in models {
        let first = surface.corners.len() as u32;
        surface.corners.extend(model.mesh.positions.chunks_exact(3).map(Vector::from_column_slice));
        surface
            .triangles
            .extend(model.mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|k| k.saturating_add(first))));
    }
    Ok(surface)
}
