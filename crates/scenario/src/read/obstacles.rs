//! Reads obstacles and contact.

use super::entry::Entry;
use super::kinds::{self, Chosen};
use super::names::{Names, register};
use super::places::facing;
use crate::scenario::{Body, Facing};
use wireloom_core::identity::Identified;
use wireloom_core::mechanism::Mount;
use wireloom_core::obstacle::{ContactSettings, Obstacle, ShapeFile, ShapeSpec};
use wireloom_core::registry::BuildError;
use wireloom_core::rotation::{frame_from, orthogonal};
use wireloom_core::{Pose, Rotation, Vector};

/// A body that is larger than all cables together by this factor is probably in other units.
const LARGE: f64 = 50.0;

/// What the size of a body is compared with.
#[derive(Clone, Copy)]
pub(crate) struct Cables {
    /// Length of all cables together, m.
    pub length: f64,
    /// Diameter of the thinnest one, m.
    pub thinnest: f64,
}

/// A body with its shape. `None` if it is faulty.
pub(crate) fn obstacle<'a>(entry: &Entry<'a>, cables: Cables, names: &mut Names<'a>) -> Option<Body> {
    let before = entry.reader.fault_count();
    let chosen = kinds::read(entry);
    let index = names.obstacles.len();
    let name = entry.word("name").filter(|name| register(entry, entry.keys.what, &mut names.obstacles, name, index));
    names.identify(entry, Identified::Obstacle, name);
    let (mesh, scale) = (entry.word("mesh"), entry.number("scale").unwrap_or(1.0));
    let position = entry.vector("position").unwrap_or_default();
    let orientation = match facing(entry) {
        Facing::Left => Some(Rotation::identity()),
        Facing::Tangent(tangent) => frame_from(&tangent, &orthogonal(&tangent)),
        Facing::Orientation(orientation) => Some(orientation),
    };
    let friction = entry.number("friction").unwrap_or(0.0);
    let (min_clearance, max_contact_force) = (entry.number("min_clearance"), entry.number("max_contact_force"));
    let kind = chosen.as_ref().map_or("", |chosen| chosen.kind.as_str());
    if !entry.has("shape") && !entry.has("mesh") {
        let message = format!("{} has neither `shape` nor `mesh`", entry.label);
        entry.fault_here(message, "add one of them, such as shape = \"box\" or mesh = \"panel.stl\"");
    } else if entry.has("mesh") && !matches!(kind, "mesh" | "") {
        let message = format!("{} has `mesh` beside shape = \"{kind}\"", entry.label);
        entry.fault_at("mesh", message, "leave one of them out");
    }
    let file = mesh.and_then(|name| {
        let bytes = entry.reader.bytes(name, entry.span_of("mesh"))?;
        Some(ShapeFile { name: name.to_owned(), bytes, scale })
    });
    let mount = names.mount(entry);
    names.mounted_obstacles.extend(mount.map(|_| index));
    let sound = entry.reader.fault_count() == before;
    names.broken |= !sound;
    let (true, Some(chosen), Some(name), Some(orientation)) = (sound, chosen, name, orientation) else { return None };
    let pose = Pose { position, orientation };
    let placed = Placed { name: name.to_owned(), label: entry.label.clone(), pose, mount };
    match body(entry, chosen, file, placed, cables) {
        Ok(mut body) => {
            let obstacle = Obstacle { friction, min_clearance, max_contact_force, ..body.obstacle };
            body.obstacle = obstacle;
            Some(body)
        }
        Err(error) => {
            let span =
                error.key.as_deref().filter(|key| entry.has(key)).map_or(entry.span.clone(), |key| entry.span_of(key));
            entry.reader.fault(span, format!("{}: {}", entry.label, error.message), error.help);
            names.broken = true;
            None
        }
    }
}

/// A body's name, what it is called in notes, and where it is.
pub(super) struct Placed {
    pub name: String,
    pub label: String,
    pub pose: Pose,
    pub mount: Option<Mount>,
}

/// A smooth body of a kind without limits.
pub(super) fn body(
    entry: &Entry<'_>,
    chosen: Chosen,
    file: Option<ShapeFile>,
    placed: Placed,
    cables: Cables,
) -> Result<Body, BuildError> {
    let Placed { name, label, pose, mount } = placed;
    let kind = entry.reader.registry.shape(&chosen.kind);
    let unknown = || BuildError::new(format!("there is no shape \"{}\"", chosen.kind), "register it");
    let meshed = file.is_some();
    let shape = (kind.ok_or_else(unknown)?.build)(&ShapeSpec { file }, &chosen.parameters)?;
    let mut notes: Vec<String> = shape.notes().iter().map(|note| format!("{label}: {note}")).collect();
    let surface = shape.surface(0.0);
    let size = surface.corners.iter().map(|corner| corner.amax()).fold(0.0, f64::max);
    let extent = extent(&surface.corners);
    if size > LARGE * cables.length {
        notes.push(format!(
            "{label}: it reaches {size:.1} m from its origin, and all cables together are {:.1} m long; if its \
             file is in millimetres, write scale = 0.001",
            cables.length
        ));
    } else if meshed && extent < 0.5 * cables.thinnest {
        notes.push(format!(
            "{label}: it is {:.2} mm large, less than the radius of the thinnest cable, {:.2} mm; if its file is in \
             metres, leave `scale` out",
            1e3 * extent,
            0.5e3 * cables.thinnest
        ));
    }
    let obstacle = Obstacle {
        name,
        kind: chosen.kind,
        shape: shape.into(),
        pose,
        mount,
        friction: 0.0,
        min_clearance: None,
        max_contact_force: None,
    };
    Ok(Body { obstacle, notes, spans: entry.spans() })
}

/// Longest side of the box around points.
fn extent(points: &[Vector]) -> f64 {
    let side = |axis: usize| {
        let along = points.iter().map(|point| point[axis]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    (0..3).map(side).fold(0.0, f64::max)
}

/// Settings of contact between cables and with the bodies.
pub(crate) fn contact(entry: &Entry<'_>) -> ContactSettings {
    let default = ContactSettings::default();
    ContactSettings {
        cables: entry.flag("cables").unwrap_or(default.cables),
        friction: entry.number("friction").unwrap_or(default.friction),
        resolve: entry.flag("resolve").unwrap_or(default.resolve),
    }
}
