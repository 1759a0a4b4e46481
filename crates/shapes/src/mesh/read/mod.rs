//! From the bytes of a file to triangles. Axes stay those of the file; several bodies of a file become one.

mod gltf;
mod obj;
mod ply;
mod polygon;
mod stl;
#[cfg(test)]
mod tests;

use std::sync::Arc;
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
            ReadFault::UnknownFormat { .. } => "give a file that ends in .stl, .obj, .ply, .gltf, .glb, .step or .stp",
            ReadFault::Unreadable { .. } => "export the body again, or in another of the formats STL, OBJ, PLY and GLB",
        };
        BuildError::new(fault.to_string(), help).at("mesh")
    }
}

/// Reader of STEP files: the triangles, m, of a file for their largest distance from its surfaces, m, and notes for the
/// user. It reaches out of this crate, so the program that makes the registry gives it.
pub type StepReader = Arc<dyn Fn(&ShapeFile, f64) -> Result<(Surface, Vec<String>), BuildError> + Send + Sync>;

/// Deflection of a STEP file whose user asks for none, m.
const DEFLECTION: f64 = 1e-4;

/// The triangles of any file, m, a STEP file by its reader; and notes of that reader.
pub(super) fn read_or_step(
    file: &ShapeFile,
    deflection: Option<f64>,
    step: Option<&StepReader>,
) -> Result<(Surface, Vec<String>), BuildError> {
    let ShapeFile { name, scale, .. } = file;
    if !["step", "stp"].contains(&ending(name).as_str()) {
        if deflection.is_some() {
            let message = format!("\"{name}\" has triangles already, which no `deflection` makes finer");
            return Err(BuildError::new(message, "leave `deflection` out; it is for STEP files").at("deflection"));
        }
        return Ok((read(file)?, vec![]));
    }
    if *scale != 1.0 {
        let message = format!("`scale` = {scale} beside the STEP file \"{name}\", which says its unit itself");
        return Err(BuildError::new(message, "leave `scale` out").at("scale"));
    }
    let Some(step) = step else {
        let message = format!("\"{name}\" is a STEP file, which this program was built without a reader for");
        return Err(BuildError::new(message, "build it with the feature `step` of the library wireloom").at("mesh"));
    };
    step(file, deflection.unwrap_or(DEFLECTION))
}

/// Ending of a file's name, in small letters.
fn ending(name: &str) -> String {
    name.rsplit_once('.').map(|(_, ending)| ending.to_ascii_lowercase()).unwrap_or_default()
}

/// Reader of a format: bytes to corners in the file's units and triangles, or the reason why not.
type Read = fn(&[u8]) -> Result<Surface, String>;

/// The triangles of a file that has triangles, m: of any format but STEP.
///
/// # Errors
/// If its ending is of no known format, or its content is not of that format.
pub fn read(file: &ShapeFile) -> Result<Surface, ReadFault> {
    let name = file.name.clone();
    let (format, read): (_, Read) = match ending(&name).as_str() {
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
