//! What `read.py` writes: a line of JSON, then corners and triangles of each solid.

use crate::assembly::{Assembly, Part, Place, Solid};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use serde::Deserialize;
use std::sync::Arc;
use wireloom_core::obstacle::Surface;
use wireloom_core::{Pose, Vector};

/// Length of a millimetre, m, as a divisor: 10 mm is the double nearest to 0.01 m.
const MM: f64 = 1000.0;
/// Deviation of a placement from a rotation that is round-off: STEP files have 13 to 16 digits.
const RIGID: f64 = 1e-9;

/// First line.
#[derive(Deserialize)]
#[serde(untagged)]
enum Found {
    Refused { refused: String },
    Read { units: Vec<String>, notes: Vec<String>, parts: Vec<FoundPart>, places: Vec<FoundPlace> },
}

#[derive(Deserialize)]
struct FoundPart {
    name: String,
    colour: Option<[f64; 3]>,
    solids: Vec<FoundSolid>,
    loose_faces: usize,
    empty: bool,
}

#[derive(Deserialize)]
struct FoundSolid {
    name: String,
    colour: Option<[f64; 3]>,
    corners: usize,
    triangles: usize,
    volume: f64,
}

#[derive(Deserialize)]
struct FoundPlace {
    path: Vec<FoundName>,
    part: usize,
    colour: Option<[f64; 3]>,
    above: Option<[f64; 3]>,
    matrix: [f64; 12],
}

#[derive(Deserialize)]
struct FoundName {
    name: String,
    part: String,
}

/// What the bytes say.
pub(crate) enum Message {
    /// Open CASCADE could not read the file: `syntax`, `no shapes` or `no transfer`.
    Refused(String),
    Read(Assembly),
}

/// Reads the message; `None` where it is damaged.
pub(crate) fn decode(bytes: &[u8]) -> Option<Message> {
    let end = bytes.iter().position(|byte| *byte == b'\n')?;
    let (units, notes, parts, places) = match serde_json::from_slice(&bytes[..end]).ok()? {
        Found::Refused { refused } => return Some(Message::Refused(refused)),
        Found::Read { units, notes, parts, places } => (units, notes, parts, places),
    };
    let mut rest = &bytes[end + 1..];
    let parts: Option<Vec<Part>> = parts.into_iter().map(|part| part.decode(&mut rest)).collect();
    let parts = parts?;
    let places: Vec<Place> = places.into_iter().map(FoundPlace::decode).collect();
    let whole = rest.is_empty() && places.iter().all(|place| place.part < parts.len());
    whole.then_some(Message::Read(Assembly { units, notes, parts, places }))
}

/// Takes elements of three numbers from the front of the bytes.
fn take<const N: usize, T>(rest: &mut &[u8], count: usize, number: fn([u8; N]) -> T) -> Option<Vec<[T; 3]>> {
    let (own, others) = rest.split_at_checked(count.checked_mul(3 * N)?)?;
    *rest = others;
    let (numbers, _) = own.as_chunks::<N>();
    let (triples, _) = numbers.as_chunks::<3>();
    Some(triples.iter().map(|triple| triple.map(number)).collect())
}

impl FoundPart {
    fn decode(self, rest: &mut &[u8]) -> Option<Part> {
        let solids: Option<Vec<Solid>> = self.solids.into_iter().map(|solid| solid.decode(rest)).collect();
        let Self { name, colour, loose_faces, empty, .. } = self;
        Some(Part { name, colour, solids: solids?, loose_faces, empty })
    }
}

impl FoundSolid {
    fn decode(self, rest: &mut &[u8]) -> Option<Solid> {
        let corners = take(rest, self.corners, f64::from_le_bytes)?;
        let triangles = take(rest, self.triangles, u32::from_le_bytes)?;
        let sound = triangles.iter().flatten().all(|corner| (*corner as usize) < corners.len());
        let corners = corners.into_iter().map(|corner| Vector::from(corner) / MM).collect();
        sound.then(|| Solid {
            name: self.name,
            colour: self.colour,
            surface: Arc::new(Surface { corners, triangles }),
            volume: self.volume.abs() / MM.powi(3),
        })
    }
}

impl FoundPlace {
    fn decode(self) -> Place {
        let m = self.matrix;
        let turned = Matrix3::new(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
        let rigid = (turned.transpose() * turned - Matrix3::identity()).amax() < RIGID && turned.determinant() > 0.0;
        let orientation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turned));
        let pose = Pose { position: Vector::new(m[3], m[7], m[11]) / MM, orientation };
        let path = self.path.into_iter().map(|own| if own.is_telling() { own.name } else { own.part }).collect();
        Place { path, part: self.part, colour: self.colour, above: self.above, pose: rigid.then_some(pose) }
    }
}

impl FoundName {
    /// Whether the name of a place says more than a number that the program gave.
    fn is_telling(&self) -> bool {
        let number = self.name.strip_prefix("NAUO").unwrap_or(&self.name);
        !number.trim().chars().all(|c| c.is_ascii_digit()) && !self.name.starts_with("=>[")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message() -> Vec<u8> {
        let json = r#"{"units":["INCH"],"notes":[],"parts":[{"name":"box","colour":null,"loose_faces":0,"empty":false,
            "solids":[{"name":"","colour":[1,0,0],"corners":3,"triangles":1,"volume":-2e9}]}],
            "places":[{"path":[{"name":"NAUO7","part":"box"}],"part":0,"colour":null,"above":null,"matrix":[0,-1,0,10,1,0,0,20,0,0,1,30]}]}"#;
        let mut bytes = json.split_whitespace().collect::<String>().into_bytes();
        bytes.push(b'\n');
        bytes.extend((0..9).flat_map(|k| (10.0 * f64::from(k)).to_le_bytes()));
        bytes.extend([0_u32, 1, 2].iter().flat_map(|k| k.to_le_bytes()));
        bytes
    }

    #[test]
    fn millimetres_become_metres_and_matrices_poses() {
        let Some(Message::Read(assembly)) = decode(&message()) else { panic!("not read") };
        let solid = &assembly.parts[0].solids[0];
        assert_eq!(solid.surface.corners[1], Vector::new(0.03, 0.04, 0.05));
        assert_eq!((solid.volume, solid.surface.triangles[0]), (2.0, [0, 1, 2]));
        let place = &assembly.places[0];
        assert_eq!(place.path, ["box"], "a number that the program gave says nothing");
        let pose = place.pose.expect("it is rigid");
        assert!((pose.world(&Vector::x()) - Vector::new(0.01, 1.02, 0.03)).norm() < 1e-15);
    }

    #[test]
    fn damaged_messages_are_none() {
        let whole = message();
        for length in 0..whole.len() {
            assert!(decode(&whole[..length]).is_none(), "{length} bytes");
        }
        let mut longer = whole.clone();
        longer.push(0);
        assert!(decode(&longer).is_none());
        let mut beyond = whole.clone();
        let last = beyond.len() - 1;
        beyond[last] = 9;
        assert!(decode(&beyond).is_none(), "a corner that is not there");
    }

    #[test]
    fn what_is_mirrored_or_scaled_has_no_pose() {
        let at = |matrix| FoundPlace { path: vec![], part: 0, colour: None, above: None, matrix }.decode().pose;
        assert!(at([-1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]).is_none());
        assert!(at([2.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0]).is_none());
    }
}
