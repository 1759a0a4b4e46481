//! Surroundings out of STEP files, which Python reads with Open CASCADE.
//!
//! [`registry`](crate::registry) has it already: `mesh = "bracket.step"` of an obstacle. [`surroundings`] makes a mesh
//! file of each part of an assembly, and the obstacles that place them.
//!
//! ```no_run
//! use wireloom::session::Monitor;
//! use wireloom::step::{Reader, surroundings};
//!
//! let bytes = std::fs::read("car.step")?;
//! let assembly = Reader::from_environment(Monitor::default()).read(&bytes, 1e-4)?;
//! let found = surroundings(&assembly, &["screw*".into()], 1e-4, "surroundings", "car.step")?;
//! println!("{}", found.obstacles);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use wireloom_step::{Assembly, Bodies, Body, Mesh, PYTHON, Part, Place, REQUIRED, Reader, Solid, StepError};

use std::collections::BTreeSet;
use std::fmt::Write;
use wireloom_core::registry::BuildError;
use wireloom_core::{Pose, Rotation, Vector};
use wireloom_export::gltf::write_part;
use wireloom_shapes::mesh::{self, StepReader};

/// The reader, for the registry.
pub(crate) fn shapes(reader: Reader) -> StepReader {
    std::sync::Arc::new(move |file, deflection| {
        let read = reader.read(&file.bytes, deflection).and_then(|assembly| assembly.surface(deflection));
        read.map_err(|error| {
            let line = error.line().map(|line| format!("line {line}: ")).unwrap_or_default();
            let message = format!("\"{}\" cannot be read as STEP: {line}{error}", file.name);
            BuildError::new(message, error.help()).at("mesh")
        })
    })
}

/// Mesh files of parts, and the obstacles of a scenario that place them.
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings {
    /// Names, from the folder, and bytes.
    pub meshes: Vec<(String, Vec<u8>)>,
    /// Number of triangles of all meshes.
    pub triangles: usize,
    /// Number of obstacles.
    pub bodies: usize,
    /// The part of a scenario with its `[[obstacles]]`, as TOML.
    pub obstacles: String,
    /// Names that were changed, and what was left out.
    pub notes: Vec<String>,
}

/// Makes a mesh file (GLB, with name and colour) of each solid, and the obstacles that place them; the solids that a
/// pattern of `without` fits are left out. `deflection`: the one with which they were read, m. `folder`: where the
/// files will lie, from the folder of the scenario. `source`: name of the STEP file.
///
/// # Errors
/// Those of [`Assembly::bodies`], and [`StepError::NoSurface`] where the triangles of a solid are not closed.
pub fn surroundings(
    assembly: &Assembly,
    without: &[String],
    deflection: f64,
    folder: &str,
    source: &str,
) -> Result<Surroundings, StepError> {
    let Bodies { meshes, bodies, notes } = assembly.bodies(without, deflection)?;
    let (mut files, mut taken) = (vec![], BTreeSet::new());
    for Mesh { name, colour, surface } in &meshes {
        let fault = |reason: String| StepError::NoSurface { part: name.clone(), reason };
        mesh::Mesh::new(surface, false).map_err(|error| fault(error.to_string()))?;
        let mut bytes = vec![];
        write_part(name, *colour, surface, &mut bytes).map_err(|error| fault(error.to_string()))?;
        files.push((file_name(name, &mut taken), bytes));
    }
    let mut obstacles = format!(
        "# Obstacles out of {}, for a scenario from whose folder the paths lead to the meshes.\n",
        one_line(source)
    );
    for Body { name, mesh, pose: Pose { position, orientation } } in &bodies {
        let path = format!("{folder}/{}", files[*mesh].0);
        let _ = write!(obstacles, "\n[[obstacles]]\nname = {}\nmesh = {}\n", quoted(name), quoted(&path));
        if *position != Vector::zeros() {
            let [x, y, z] = [position.x, position.y, position.z];
            let _ = writeln!(obstacles, "position = [{x:?}, {y:?}, {z:?}]");
        }
        if *orientation != Rotation::identity() {
            let q = orientation.coords;
            let _ = writeln!(obstacles, "orientation = [{:?}, {:?}, {:?}, {:?}]", q.w, q.x, q.y, q.z);
        }
    }
    let triangles = meshes.iter().map(|mesh| mesh.surface.triangles.len()).sum();
    Ok(Surroundings { meshes: files, triangles, bodies: bodies.len(), obstacles, notes })
}

/// Name of a file for a part, which no other part has, on systems that tell no small letters from capital ones either.
fn file_name(part: &str, taken: &mut BTreeSet<String>) -> String {
    const LONGEST: usize = 80;
    let plain = |c: char| if c.is_alphanumeric() || "-_+".contains(c) { c } else { '-' };
    let stem: String = part.chars().take(LONGEST).map(plain).collect();
    let stem = Some(stem.trim_matches('-')).filter(|stem| !stem.is_empty()).unwrap_or("part");
    let mut name = format!("{stem}.glb");
    let mut k = 2;
    while !taken.insert(name.to_lowercase()) {
        name = format!("{stem}-{k}.glb");
        k += 1;
    }
    name
}

fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// A string of TOML.
fn quoted(text: &str) -> String {
    format!("\"{}\"", one_line(text).replace('\\', "\\\\").replace('"', "\\\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_parts_have_names_that_any_system_takes() {
        let mut taken = BTreeSet::new();
        let mut name = |part| file_name(part, &mut taken);
        assert_eq!(name("door/hinge 2"), "door-hinge-2.glb");
        assert_eq!(name("Door/Hinge 2"), "Door-Hinge-2-2.glb");
        assert_eq!(name("../../etc"), "etc.glb");
        assert_eq!(name("///"), "part.glb");
        assert_eq!(name("Träger"), "Träger.glb");
    }
}
