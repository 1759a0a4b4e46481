//! Made-up lines of branches, and what holds of every file into which they are written.

use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use roxmltree::Node;
use std::collections::HashSet;
use wireloom_import::kbl::export::Branch;

pub type Vector = Vector3<f64>;

/// A branch along a line, which is close enough to its points to be smooth, of this length of cable.
pub struct Drawn {
    pub name: String,
    pub segment: Option<String>,
    pub points: Vec<Vector>,
    /// Arc lengths of the points.
    along: Vec<f64>,
    pub s: Vec<f64>,
}

impl Drawn {
    pub fn new(name: &str, segment: &str, length: f64, points: Vec<Vector>) -> Self {
        let mut along = vec![0.0];
        points.windows(2).for_each(|pair| along.push(along[along.len() - 1] + (pair[1] - pair[0]).norm()));
        let whole = along[along.len() - 1];
        let s = along.iter().map(|own| length * (own / whole)).collect();
        Self { name: name.to_owned(), segment: Some(segment.to_owned()), points, along, s }
    }

    /// The point at a fraction of the arc length.
    pub fn at(&self, f: f64) -> Vector {
        let last = self.along.len() - 1;
        let s = f * self.along[last];
        let k = self.along.partition_point(|own| *own <= s).clamp(1, last);
        let part = (s - self.along[k - 1]) / (self.along[k] - self.along[k - 1]);
        self.points[k - 1].lerp(&self.points[k], part)
    }

    /// Distance of a point from the line, m.
    pub fn distance(&self, x: &Vector) -> f64 {
        let to_chord = |pair: &[Vector]| {
            let chord = pair[1] - pair[0];
            let part = ((x - pair[0]).dot(&chord) / chord.norm_squared()).clamp(0.0, 1.0);
            (pair[0] + chord * part - x).norm()
        };
        self.points.windows(2).map(to_chord).fold(f64::INFINITY, f64::min)
    }

    /// The frame at a point: rotation-minimising along the plane lines of these tests, d1 upward at the start.
    fn frame(&self, from: usize, to: usize) -> UnitQuaternion<f64> {
        let tangent = (self.points[to] - self.points[from]).normalize();
        let start = (self.points[1] - self.points[0]).normalize();
        let up = if start.z.abs() > 0.95 { Vector::x() } else { Vector::z() };
        let d1 = (up - tangent * tangent.dot(&up)).normalize();
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_basis_unchecked(&[d1, tangent.cross(&d1), tangent]))
    }

    pub fn branch(&self) -> Branch<'_> {
        let last = self.points.len() - 1;
        Branch {
            name: self.name.clone(),
            segment: self.segment.clone(),
            s: &self.s,
            at: Box::new(|f| self.at(f)),
            frames: [self.frame(0, 1), self.frame(last - 1, last)],
            bend_radius: 0.1,
        }
    }
}

/// The order of elements within the types that are written: KBL 2.3 SR-1 and 2.4 SR-1 (prostep ivip) agree in it.
const ORDER: &[(&str, &[&str])] = &[
    (
        "Segment",
        &[
            "Id",
            "Alias_id",
            "Start_vector",
            "End_vector",
            "Virtual_length",
            "Physical_length",
            "Form",
            "End_node",
            "Start_node",
            "Center_curve",
            "Cross_section_area_information",
            "Fixing_assignment",
            "Processing_information",
            "Protection_area",
        ],
    ),
    ("Center_curve", &["Degree", "Control_points"]),
    ("Cartesian_point", &["Coordinates"]),
    ("Virtual_length", &["Unit_component", "Value_component"]),
];

/// Ids are unique, and references lead where they did; the elements of what is written are in the order of the schema.
pub fn valid(text: &str, original: &str) {
    let (xml, before) = (roxmltree::Document::parse(text).unwrap(), roxmltree::Document::parse(original).unwrap());
    let ids = |xml: &roxmltree::Document| -> Vec<String> {
        xml.descendants().filter_map(|node| node.attribute("id")).map(str::to_owned).collect()
    };
    let all = ids(&xml);
    let unique: HashSet<&String> = all.iter().collect();
    assert_eq!(unique.len(), all.len(), "an id is there twice");
    let mut known: HashSet<String> = ids(&before).into_iter().collect();
    known.extend(all.iter().cloned());
    // Every word that is an id of the file before or after is one after.
    for node in xml.descendants().filter(|node| !node.has_tag_name("Id")) {
        for word in node.text().unwrap_or_default().split_whitespace().filter(|word| known.contains(*word)) {
            assert!(unique.contains(&word.to_owned()), "{} refers to `{word}`", node.tag_name().name());
        }
    }
    for (name, order) in ORDER {
        // Where the file's own order is that of the schema.
        let in_order = |node: &Node| {
            let found: Vec<usize> = node
                .children()
                .filter(Node::is_element)
                .filter_map(|child| order.iter().position(|known| child.has_tag_name(*known)))
                .collect();
            found.is_sorted()
        };
        let of = |xml: &'_ roxmltree::Document| -> Vec<(String, bool)> {
            let all = xml.descendants().filter(|node| node.has_tag_name(*name));
            all.map(|node| (node.attribute("id").unwrap_or_default().to_owned(), in_order(&node))).collect()
        };
        let wrong: HashSet<String> = of(&before).into_iter().filter(|(_, sorted)| !sorted).map(|(id, _)| id).collect();
        for (id, sorted) in of(&xml) {
            assert!(sorted || wrong.contains(&id), "{name} `{id}`");
        }
    }
}

/// The text without what a result changes: points, curves, vectors, lengths, references to points, places of fixings.
pub fn rest(text: &str) -> String {
    let xml = roxmltree::Document::parse(text).unwrap();
    let mut cut: Vec<std::ops::Range<usize>> = Vec::new();
    for node in xml.descendants().filter(Node::is_element) {
        let name = node.tag_name().name();
        let parent = node.parent_element().map_or("", |parent| parent.tag_name().name());
        let whole = matches!(name, "Cartesian_point" | "Center_curve") && node.attribute("id").is_some();
        let number = match name {
            "Start_vector" | "End_vector" | "U" | "V" | "Location" | "Orientation" => true,
            "Cartesian_point" => ["Node", "Placement"].contains(&parent),
            "Value_component" => ["Virtual_length", "Physical_length", "Absolute_location"].contains(&parent),
            _ => false,
        };
        let range = node.range();
        if whole {
            cut.push(text[..range.start].trim_end().len()..range.end);
        } else if number {
            cut.extend(node.first_child().map(|text| text.range()));
        }
    }
    let (mut out, mut done) = (String::new(), 0);
    for range in cut {
        out.push_str(&text[done..range.start]);
        done = range.end;
    }
    out + &text[done..]
}
