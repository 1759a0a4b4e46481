//! A harness as plain values in SI: the contents of a file, without any decision. Every format is read into it.

use super::curve::{Polygon, Vector};
use super::usage::Element;
use wireloom_core::identity::Identity;

/// Largest valid coordinate, m: control points of good curves reach some 10³ m.
pub(super) const LARGEST: f64 = 1e5;

/// Valid outer diameters and bend radii of wires, m.
pub(super) const DIAMETERS: [f64; 2] = [1e-6, 1.0];
pub(super) const BEND_RADII: [f64; 2] = [1e-6, 1e3];

/// Format of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Kbl,
    /// With its version; empty if it states none.
    Vec(String),
}

impl Format {
    pub fn name(&self) -> &'static str {
        match self {
            Self::Kbl => "KBL",
            Self::Vec(_) => "VEC",
        }
    }

    /// A file of this format in words, after "a".
    pub fn title(&self) -> String {
        match self {
            Self::Kbl => "KBL file (VDA 4964)".to_owned(),
            Self::Vec(version) => format!("VEC file (VDA 4968{}{version})", if version.is_empty() { "" } else { ", " }),
        }
    }

    /// Whether results are written back into a file of this format.
    pub fn is_written_back(&self) -> bool {
        *self == Self::Kbl
    }

    /// Names of the length that a segment is built to, and of the one that is drawn.
    pub fn lengths(&self) -> [&'static str; 2] {
        match self {
            Self::Kbl => ["Physical_length", "Virtual_length"],
            Self::Vec(_) => ["a length of the class Adapted", "one of the class Designed"],
        }
    }
}

/// The harness in the file.
pub(super) struct Document {
    pub format: Format,
    /// Whether the file says where the nodes lie; if not, they have any places that a board then replaces.
    pub drawn: bool,
    pub name: Option<String>,
    pub nodes: Vec<Node>,
    pub segments: Vec<Segment>,
    pub wires: Vec<Wire>,
    /// Occurrences of all parts but wires.
    pub listed: Vec<Listed>,
    /// Wires with what they connect.
    pub wiring: Vec<Wiring>,
    /// The elements of the file, and the use that is made of them.
    pub elements: Vec<Element>,
}

pub(super) struct Node {
    /// XML id.
    pub id: String,
    /// Readable `Id`.
    pub label: String,
    /// m.
    pub position: Vector,
    pub components: Vec<Component>,
}

/// A component at a node.
pub(super) struct Component {
    pub id: String,
    pub label: String,
    /// A joint of wires within the harness, without a counterpart.
    pub splice: bool,
    pub placement: Option<Placement>,
    /// kg.
    pub mass: Option<f64>,
}

/// Drawn place of a component or fixing.
#[derive(Clone, Copy)]
pub(super) struct Placement {
    /// m.
    pub position: Vector,
    /// Its second axis (`V`), a unit vector: along the cable, in either direction, for parts that close around a cable.
    pub axis: Option<Vector>,
}

pub(super) struct Segment {
    pub id: String,
    pub label: String,
    /// Indices of nodes.
    pub ends: [usize; 2],
    /// m.
    pub virtual_length: Option<f64>,
    /// m.
    pub physical_length: Option<f64>,
    /// Deviations of its length that are allowed, m: the least (mostly negative) and the greatest.
    pub tolerance: Option<[f64; 2]>,
    /// Area of the cross-section as drawn, m².
    pub area: Option<f64>,
    /// Least bend radius beside those of its wires and coverings, m.
    pub bend_radius: Option<f64>,
    /// Likewise, while it moves, m.
    pub moving_bend_radius: Option<f64>,
    pub curves: Vec<Polygon>,
    pub fixings: Vec<Fixing>,
    pub coverings: Vec<Covering>,
    /// Indices of the wires that run through it, each once.
    pub wires: Vec<usize>,
}

/// A place along a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Location {
    /// 0 to 1.
    Relative(f64),
    /// m from the start.
    Absolute(f64),
    /// m before the end.
    BeforeEnd(f64),
}

impl Location {
    /// As a fraction of a segment of this length, m.
    pub fn fraction(self, length: f64) -> f64 {
        match self {
            Location::Relative(f) => f,
            Location::Absolute(s) => s / length,
            Location::BeforeEnd(s) => 1.0 - s / length,
        }
    }
}

pub(super) struct Fixing {
    /// XML id of the assignment.
    pub id: String,
    /// XML id of the fixing.
    pub of: Option<String>,
    pub label: String,
    pub at: Location,
    pub placement: Option<Placement>,
    /// Whether the cable may slide through it.
    pub duct: bool,
}

pub(super) struct Covering {
    pub id: String,
    /// Its declared type; may be empty.
    pub kind: String,
    /// May be empty.
    pub description: String,
    /// kg per metre of covered length.
    pub linear_density: Option<f64>,
    /// m.
    pub inner_diameter: Option<f64>,
    /// m.
    pub outer_diameter: Option<f64>,
    /// Least bend radius of a tube, m.
    pub bend_radius: Option<f64>,
    pub from: Location,
    pub to: Location,
}

/// A single wire, a cable with its jacket, or one core of a cable without.
pub(super) struct Wire {
    /// XML id of the occurrence.
    pub id: String,
    /// m².
    pub copper_area: Option<f64>,
    /// m.
    pub outside_diameter: Option<f64>,
    /// kg/m.
    pub linear_density: Option<f64>,
    /// m.
    pub bend_radius: Option<f64>,
    /// Where the wire moves, m.
    pub moving_bend_radius: Option<f64>,
}

impl Wire {
    /// One of which nothing is known.
    pub fn unknown(id: String) -> Self {
        Self {
            id,
            copper_area: None,
            outside_diameter: None,
            linear_density: None,
            bend_radius: None,
            moving_bend_radius: None,
        }
    }
}

/// An occurrence of a part in the harness.
pub(super) struct Listed {
    /// XML id.
    pub id: String,
    /// Readable `Id`.
    pub label: String,
    /// What it is, such as "cavity plug".
    pub kind: String,
    pub identity: Identity,
    pub places: Vec<ListedPlace>,
    /// Ids of its elements, by which nodes, segments and wires refer to it.
    pub ids: Vec<String>,
}

/// Where an occurrence sits, by XML ids.
pub(super) enum ListedPlace {
    Node(String),
    Segment { id: String, from: Option<Location>, to: Option<Location> },
    In { component: String, cavity: Option<String> },
}

/// End of a wire: the XML id of what it ends in, and part numbers.
#[derive(Default)]
pub(super) struct End {
    /// Ids of the connector's elements, the inner ones first.
    pub within: Vec<String>,
    pub cavity: Option<String>,
    pub terminal: Option<String>,
    pub seal: Option<String>,
}

/// A wire, or a core of a cable, with what it connects.
pub(super) struct Wiring {
    /// Readable `Id` of the connection, or the XML id of the wire.
    pub label: String,
    pub signal: Option<String>,
    /// Its number in the harness.
    pub number: Option<String>,
    pub identity: Identity,
    pub ends: Vec<End>,
    /// XML ids of its segments.
    pub segments: Vec<String>,
}

/// `D(i)=8.3` and `D(a)=13,4` in the description of a tube: inner and outer diameter in mm, as German part names give
/// them, with a decimal point or comma; here in m.
pub(super) fn diameters(description: &str) -> (Option<f64>, Option<f64>) {
    let after = |mark: &str| {
        let rest = description.split(mark).nth(1)?;
        let end = rest.find(|c: char| !(c.is_ascii_digit() || ".,".contains(c))).unwrap_or(rest.len());
        let number = rest[..end].trim_end_matches(['.', ',']).replace(',', ".");
        number.parse::<f64>().ok().filter(|d| *d > 0.1 && *d < 1000.0).map(|d| d * 1e-3)
    };
    (after("D(i)="), after("D(a)="))
}

#[cfg(test)]
mod tests {
    use super::diameters;

    /// They were read as 8 mm and 13 mm.
    #[test]
    fn a_decimal_comma_in_the_description_of_a_tube_does_not_cut_its_diameters() {
        let (inner, outer) = diameters("Tube D(i)=8,9 D(a)=13,9");
        assert!((inner.unwrap() - 8.9e-3).abs() < 1e-15 && (outer.unwrap() - 13.9e-3).abs() < 1e-15);
    }

    #[test]
    fn diameters_stand_in_the_description_of_some_tubes() {
        let (inner, outer) = diameters("Tube size 8 D(i)=7.5 D(a)=10.25 black");
        assert!((inner.unwrap() - 7.5e-3).abs() < 1e-15 && (outer.unwrap() - 10.25e-3).abs() < 1e-15);
        assert_eq!(diameters("Tube D(a)="), (None, None));
        assert_eq!(diameters("Tube D(i)=8, D(a)=10."), (Some(8e-3), Some(10e-3)));
        assert_eq!(diameters("tape"), (None, None));
    }
}
