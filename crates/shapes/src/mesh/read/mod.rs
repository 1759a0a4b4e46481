//! From the bytes of a file to triangles. Axes stay those of the file; several bodies of a file become one.

mod gltf;
mod obj;
mod ply;
mod polygon;
mod stl;
#[cfg(test)]
mod tests;

use wireloom_core::obstacle::{ShapeFile, Surface};
use wireloom_core::registry::BuildError;

/// Why a file gives no triangles.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReadFault {
    /// Its ending names no format that is read.
    #[error("\"{name}\" is of no known format")]
    UnknownFormat {
        /// Name of the file.
        name: String,
    },
    /// It is not what its ending says.
    #[error("\"{name}\" cannot be read as {format}: {reason}")]
    Unreadable {
        /// Name of the file.
        name: String,
        /// Format that its ending stands for.
        format: &'static str,
        /// Reason of the reader.
        reason: String,
    },
}

impl From<ReadFault> for BuildError {
    fn from(fault: ReadFault) -> Self {
        let help = match &fault {
            ReadFault::UnknownFormat { .. } => "give a file that ends in .stl, .obj, .ply, .gltf or .glb",
            ReadFault::Unreadable { .. } => "export the body again, or in another of the formats STL, OBJ, PLY and GLB",
        };
        BuildError::new(fault.to_string(), help).at("mesh")
    }
}

/// Reader of a format: bytes to corners in the file's units and triangles, or the reason why not.
type Read = fn(&[u8]) -> Result<Surface, String>;

/// The triangles of a file, m.
///
/// # Errors
/// If its ending is of no known format, or its content is not of that format.
pub fn read(file: &ShapeFile) -> Result<Surface, ReadFault> {
    let name = file.name.clone();
    let ending = name.rsplit_once('.').map(|(_, ending)| ending.to_ascii_lowercase()).unwrap_or_default();
    let (format, read): (_, Read) = match ending.as_str() {
        "stl" => ("STL", stl::read),
        "obj" => ("OBJ", obj::read),
        "ply" => ("PLY", ply::read),
        "gltf" | "glb" => ("glTF", gltf::read),
        _ => return Err(ReadFault::UnknownFormat { name }),
    };
    let mut surface = read(&file.bytes).map_err(|reason| {
        // Some readers write over several lines.
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        ReadFault::Unreadable { name, format, reason }
    })?;
    surface.corners.iter_mut().for_each(|corner| *corner *= file.scale);
    Ok(surface)
}
