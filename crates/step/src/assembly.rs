//! What a STEP file holds: parts, and the places in which its assembly has them.

use crate::error::StepError;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;
use wildmatch::WildMatch;
use wireloom_core::obstacle::Surface;
use wireloom_core::{Pose, Vector};

/// Share of its volume that a solid may lose or gain by its triangles. A sphere of 28 triangles loses a third, a pipe
/// within 0.3 of its radius a tenth.
const LOST: f64 = 0.1;

/// Linear red, green and blue, 0 to 1.
type Colour = [f64; 3];

/// The content of a STEP file.
#[derive(Clone, Debug, PartialEq)]
pub struct Assembly {
    /// Units of length of the file, as it names them.
    pub units: Vec<String>,
    /// What the file says that was not understood.
    pub notes: Vec<String>,
    /// Parts, each once however often it is placed.
    pub parts: Vec<Part>,
    /// Places of parts.
    pub places: Vec<Place>,
}

/// A part.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its name; empty where the file has none.
    pub name: String,
    /// Its colour.
    pub colour: Option<Colour>,
    /// Its solids.
    pub solids: Vec<Solid>,
    /// Number of faces that belong to no solid.
    pub loose_faces: usize,
    /// Whether it has neither faces nor curves nor points.
    pub empty: bool,
}

/// A solid of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Its name; empty where the file has none.
    pub name: String,
    /// Its colour, or that of all its faces.
    pub colour: Option<Colour>,
    /// Its triangles, m, in the axes of the part.
    pub surface: Arc<Surface>,
    /// Volume within its exact surface, m³.
    pub volume: f64,
}

/// A place in which the assembly has a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Names from the root of the tree to the part.
    pub path: Vec<String>,
    /// Index of the part.
    pub part: usize,
    /// Colour that it has in this place alone.
    pub colour: Option<Colour>,
    /// Colour of the assembly in which it is.
    pub above: Option<Colour>,
    /// Pose in the axes of the file; `None`: it is mirrored or scaled.
    pub pose: Option<Pose>,
}

/// Solids in their places.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bodies {
    /// Meshes, each once however often it is placed.
    pub meshes: Vec<Mesh>,
    /// Bodies, in the order of the tree.
    pub bodies: Vec<Body>,
    /// Names that were changed, and what was left out.
    pub notes: Vec<String>,
}

/// Triangles of one solid in one colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// A name that no other mesh has.
    pub name: String,
    /// Its colour.
    pub colour: Option<Colour>,
    /// Its triangles, m, in the axes of its part.
    pub surface: Arc<Surface>,
}

/// A solid in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Names from the root of the tree, with `/` between them; no other body has the same.
    pub name: String,
    /// Index of its mesh.
    pub mesh: usize,
    /// Its pose in the axes of the file.
    pub pose: Pose,
}

impl Assembly {
    /// The solids in their places, except those whose name, path or part fits one of the patterns `without`;
    /// `deflection`: the one with which they were read, m.
    ///
    /// # Errors
    /// If a pattern fits nothing, nothing is left, or what is left has no sound solids.
    pub fn bodies(&self, without: &[String], deflection: f64) -> Result<Bodies, StepError> {
        let (kept, mut notes) = self.kept(without)?;
        let mut open = BTreeMap::new();
        for place in &kept {
            let part = &self.parts[place.part];
            if part.loose_faces > 0 {
                open.entry(place.part).or_insert_with(|| (self.part_name(place), part.loose_faces));
            }
        }
        if !open.is_empty() {
            return Err(StepError::OpenShell { parts: open.into_values().collect() });
        }
        let (mut meshes, mut bodies) = (Names::default(), Names::default());
        let mut all = Bodies::default();
        let mut known = HashMap::new();
        for place in kept {
            let part = &self.parts[place.part];
            let name = place.path.join("/");
            if part.empty {
                return Err(StepError::NoShape { part: self.part_name(place) });
            }
            if part.solids.is_empty() {
                notes.push(format!("\"{name}\" has curves alone, and is left out"));
                continue;
            }
            let pose = place.pose.ok_or_else(|| StepError::NotRigid { name: name.clone() })?;
            for (k, solid) in part.solids.iter().enumerate() {
                let own = |name: &str| part.name_of_solid(name, k);
                let colour = place.colour.or(solid.colour).or(part.colour).or(place.above);
                let key = (place.part, k, colour.map(|colour| colour.map(f64::to_bits)));
                let mesh = match known.get(&key) {
                    Some(mesh) => *mesh,
                    None => {
                        let name = own(&self.part_name(place));
                        solid.check(&name, deflection)?;
                        let surface = solid.surface.clone();
                        all.meshes.push(Mesh { name: meshes.unique(&name), colour, surface });
                        known.insert(key, all.meshes.len() - 1);
                        all.meshes.len() - 1
                    }
                };
                all.bodies.push(Body { name: bodies.unique(&own(&name)), mesh, pose });
            }
        }
        if all.bodies.is_empty() {
            return Err(StepError::NoSolids);
        }
        notes.splice(0..0, self.notes.iter().cloned());
        notes.extend(bodies.notes);
        Ok(Bodies { notes, ..all })
    }

    /// All solids in their places as one surface, m, in the axes of the file, with notes.
    ///
    /// # Errors
    /// As those of [`Self::bodies`].
    pub fn surface(&self, deflection: f64) -> Result<(Surface, Vec<String>), StepError> {
        let Bodies { meshes, bodies, .. } = self.bodies(&[], deflection)?;
        let mut whole = Surface::default();
        for Body { mesh, pose, .. } in &bodies {
            let Surface { corners, triangles } = &*meshes[*mesh].surface;
            let first = whole.corners.len() as u32;
            whole.corners.extend(corners.iter().map(|corner| pose.world(corner)));
            whole.triangles.extend(triangles.iter().map(|t| t.map(|k| first + k)));
        }
        Ok((whole, self.notes.clone()))
    }

    /// Places that no pattern fits, and what was left out.
    fn kept(&self, without: &[String]) -> Result<(Vec<&Place>, Vec<String>), StepError> {
        let patterns: Vec<WildMatch> = without.iter().map(|pattern| WildMatch::new(pattern)).collect();
        let mut fits = vec![0; patterns.len()];
        let mut kept = vec![];
        for place in &self.places {
            let path = place.path.join("/");
            let last = place.path.last().map_or("", String::as_str);
            let names = [path.as_str(), last, &self.parts[place.part].name];
            let mut left_out = false;
            for (pattern, fits) in patterns.iter().zip(&mut fits) {
                if names.iter().any(|name| pattern.matches(name)) {
                    *fits += 1;
                    left_out = true;
                }
            }
            if !left_out {
                kept.push(place);
            }
        }
        if let Some((pattern, _)) = without.iter().zip(&fits).find(|(_, fits)| **fits == 0) {
            let names: BTreeSet<String> = self.places.iter().map(|place| place.path.join("/")).collect();
            return Err(StepError::NoMatch { pattern: pattern.clone(), names: names.into_iter().collect() });
        }
        if kept.is_empty() {
            let count = self.places.len();
            return Err(if count == 0 { StepError::NoSolids } else { StepError::NothingLeft { count } });
        }
        let count = |n: usize| if n == 1 { "1 part".to_owned() } else { format!("{n} parts") };
        let notes = without.iter().zip(fits).map(|(pattern, n)| format!("{} left out by \"{pattern}\"", count(n)));
        Ok((kept, notes.collect()))
    }

    /// Name of the part of a place.
    fn part_name(&self, place: &Place) -> String {
        let last = place.path.last().filter(|name| !name.is_empty());
        let own = Some(&self.parts[place.part].name).filter(|name| !name.is_empty());
        own.or(last).cloned().unwrap_or_else(|| format!("part {}", place.part + 1))
    }
}

impl Part {
    /// Name of a solid in something of this name.
    fn name_of_solid(&self, name: &str, k: usize) -> String {
        match &*self.solids {
            [_] => name.to_owned(),
            solids if solids[k].name.is_empty() => format!("{name}/{}", k + 1),
            solids => format!("{name}/{}", solids[k].name),
        }
    }
}

impl Solid {
    /// Refuses triangles that have lost the shape of the solid.
    fn check(&self, part: &str, deflection: f64) -> Result<(), StepError> {
        let Surface { corners, triangles } = &*self.surface;
        // About a corner of its own, so that no digits are lost far from the origin.
        let origin = corners.first().copied().unwrap_or_default();
        let at = |k: u32| corners[k as usize] - origin;
        let volume: f64 = triangles.iter().map(|[a, b, c]| at(*a).dot(&at(*b).cross(&at(*c)))).sum::<f64>() / 6.0;
        let share = volume.abs() / self.volume;
        if (share - 1.0).abs() <= LOST {
            return Ok(());
        }
        let bound = |best: fn(f64, f64) -> f64| corners.iter().copied().reduce(|a, b| a.zip_map(&b, best));
        let sides: Vector = bound(f64::max).unwrap_or_default() - bound(f64::min).unwrap_or_default();
        let right = (0.1 * sides.min()).min(0.1 * deflection);
        Err(StepError::Vanished { part: part.to_owned(), deflection, share, right })
    }
}

/// Names that were given.
#[derive(Default)]
struct Names {
    taken: BTreeSet<String>,
    notes: Vec<String>,
}

impl Names {
    /// The name, with a number where it is taken.
    fn unique(&mut self, name: &str) -> String {
        // Line ends and the like would break lines of messages and files.
        let name: String = name.trim().chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let name = if name.is_empty() { "part".to_owned() } else { name };
        let mut own = name.clone();
        let mut k = 2;
        while self.taken.contains(&own) {
            own = format!("{name} {k}");
            k += 1;
        }
        if own != name {
            self.notes.push(format!("the name \"{name}\" is there more than once: one is now \"{own}\""));
        }
        self.taken.insert(own.clone());
        own
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(side: f64) -> Solid {
        let corners = (0..8).map(|k| Vector::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)) * side);
        let triangles = vec![
            [0, 2, 3],
            [0, 3, 1],
            [4, 5, 7],
            [4, 7, 6],
            [0, 1, 5],
            [0, 5, 4],
            [2, 6, 7],
            [2, 7, 3],
            [0, 4, 6],
            [0, 6, 2],
            [1, 3, 7],
            [1, 7, 5],
        ];
        let surface = Arc::new(Surface { corners: corners.collect(), triangles });
        Solid { name: String::new(), colour: None, surface, volume: side.powi(3) }
    }

    fn part(name: &str, solids: usize, loose_faces: usize) -> Part {
        Part { name: name.into(), colour: Some([0.5; 3]), solids: vec![cube(0.1); solids], loose_faces, empty: false }
    }

    fn place(path: &[&str], part: usize) -> Place {
        let path = path.iter().map(|name| (*name).to_owned()).collect();
        Place { path, part, colour: None, above: None, pose: Some(Pose::identity()) }
    }

    fn assembly() -> Assembly {
        let parts = vec![part("box", 1, 0), part("pair", 2, 0), part("sheet", 0, 3)];
        let places = vec![
            place(&["car", "left"], 0),
            place(&["car", "left"], 0),
            Place { colour: Some([1.0, 0.0, 0.0]), ..place(&["car", "right"], 0) },
            place(&["car", "pair"], 1),
            place(&["car", "sheet"], 2),
        ];
        Assembly { units: vec!["MILLIMETRE".into()], notes: vec![], parts, places }
    }

    fn without(patterns: &[&str]) -> Result<Bodies, StepError> {
        assembly().bodies(&patterns.iter().map(|pattern| (*pattern).to_owned()).collect::<Vec<_>>(), 1e-4)
    }

    #[test]
    fn names_are_unique_and_colours_make_meshes_of_their_own() {
        let found = without(&["sheet"]).expect("solids");
        let names: Vec<&str> = found.bodies.iter().map(|body| body.name.as_str()).collect();
        assert_eq!(names, ["car/left", "car/left 2", "car/right", "car/pair/1", "car/pair/2"]);
        let meshes: Vec<&str> = found.meshes.iter().map(|mesh| mesh.name.as_str()).collect();
        assert_eq!(meshes, ["box", "box 2", "pair/1", "pair/2"]);
        assert_eq!(found.meshes[1].colour, Some([1.0, 0.0, 0.0]), "its place has a colour");
        let notes = [
            "1 part left out by \"sheet\"",
            "the name \"car/left\" is there more than once: one is now \"car/left 2\"",
        ];
        assert_eq!(found.notes, notes);
    }

    #[test]
    fn what_cannot_be_a_body_is_refused_by_name() {
        let said = |patterns: &[&str]| without(patterns).expect_err("a refusal").to_string();
        assert_eq!(said(&[]), "part \"sheet\" is an open shell: it has 3 faces that enclose no solid");
        assert_eq!(said(&["screw*"]), "the pattern \"screw*\" fits no part");
        assert_eq!(said(&["*"]), "all 5 parts are left out");
        let mut mirrored = assembly();
        mirrored.places[0].pose = None;
        let said = mirrored.bodies(&["sheet".into()], 1e-4).expect_err("a refusal").to_string();
        assert_eq!(said, "\"car/left\" is mirrored or scaled where it is placed");
        let mut empty = assembly();
        empty.parts[1] = Part { empty: true, ..part("pair", 0, 0) };
        let said = empty.bodies(&["sheet".into()], 1e-4).expect_err("a refusal").to_string();
        assert_eq!(said, "part \"pair\" has no shape: Open CASCADE could make none of what the file says");
        let mut lost = assembly();
        lost.parts[0].solids[0].volume *= 2.0;
        let error = lost.bodies(&["sheet".into()], 0.2).expect_err("a refusal");
        let said = "part \"box\" loses its shape: with a deflection of 200 mm its triangles have 50 % of its volume";
        assert_eq!(
            (error.to_string().as_str(), error.help().as_str()),
            (said, "give a smaller deflection, such as 10 mm")
        );
    }
}
