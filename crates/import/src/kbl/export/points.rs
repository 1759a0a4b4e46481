//! The points of a file, and who refers to them.

use super::edits::{Edits, coordinates};
use crate::curve::Vector;
use crate::xml::{Xml, child, children, text};
use std::collections::{HashMap, HashSet};

/// Points that differ by less than this, m, are written as one.
const SAME: f64 = 1e-9;

/// The points of a file.
pub struct Points<'a, 'i> {
    /// By id.
    elements: HashMap<&'a str, Xml<'a, 'i>>,
    /// Number of references to each, beside those of curves that are replaced.
    references: HashMap<&'a str, usize>,
    /// The last one of the file, behind which others are added.
    last: Option<Xml<'a, 'i>>,
    /// Points that curves have taken over.
    taken: HashSet<&'a str>,
    /// Elements that refer to a point (`Cartesian_point` of a node or a placement), and where it moves, m.
    wanted: Vec<(Xml<'a, 'i>, Vector)>,
}

impl<'a, 'i> Points<'a, 'i> {
    /// Those of a file; `replaced`: segments whose curves are replaced.
    pub fn new(root: Xml<'a, 'i>, replaced: impl Iterator<Item = Xml<'a, 'i>>) -> Self {
        let elements: HashMap<&str, Xml> =
            children(root, "Cartesian_point").filter_map(|point| Some((point.attribute("id")?, point))).collect();
        let old: HashSet<_> =
            replaced.flat_map(|segment| children(segment, "Center_curve")).map(|curve| curve.id()).collect();
        let mut references: HashMap<&str, usize> = HashMap::new();
        for node in root.descendants().filter(|node| node.parent().is_none_or(|parent| !old.contains(&parent.id()))) {
            // Whatever its name is: a text that is the id of a point is taken for a reference.
            for word in text(node).unwrap_or_default().split_whitespace() {
                if let Some((id, _)) = elements.get_key_value(word) {
                    *references.entry(id).or_default() += 1;
                }
            }
        }
        let last = children(root, "Cartesian_point").last();
        Self { elements, references, last, taken: HashSet::new(), wanted: Vec::new() }
    }

    /// Writes the control points of a curve of this id into the points that only the old curves have; returns the ids.
    pub fn of_curve(&mut self, old: &[Xml<'a, 'i>], id: &str, new: &[Vector], edits: &mut Edits<'a>) -> Vec<String> {
        let mut free = Vec::new();
        for holder in old.iter().flat_map(|curve| children(*curve, "Control_points")) {
            for word in text(holder).unwrap_or_default().split_whitespace() {
                let Some((word, point)) = self.elements.get_key_value(word) else { continue };
                if !self.references.contains_key(word) && self.taken.insert(word) {
                    free.push((*word, *point));
                }
            }
        }
        let mut ids = Vec::new();
        for ((word, point), position) in free.iter().zip(new) {
            edits.set_vector(*point, "Coordinates", coordinates(position));
            ids.push((*word).to_owned());
        }
        let like = free.last().map(|(_, point)| *point).or(self.last);
        for position in &new[ids.len()..] {
            let own = edits.fresh(&format!("{id}_point"));
            if let Some(like) = like {
                add(like, &own, position, edits);
            }
            ids.push(own);
        }
        free.iter().skip(new.len()).for_each(|(_, point)| edits.remove(*point));
        ids
    }

    /// Notes where the point of a node or a placement moves.
    pub fn want(&mut self, holder: Xml<'a, 'i>, position: Vector) {
        if let Some(reference) = child(holder, "Cartesian_point") {
            self.wanted.push((reference, position));
        }
    }

    /// Writes the points that were noted. One that all its references move alike is moved; otherwise those get a new
    /// one.
    pub fn write(&self, edits: &mut Edits<'a>) {
        let mut by_point: Vec<(Xml, Vec<(Xml, Vector)>)> = Vec::new();
        let mut index: HashMap<&str, usize> = HashMap::new();
        for &(reference, position) in &self.wanted {
            let Some((id, point)) = text(reference).and_then(|id| self.elements.get_key_value(id)) else { continue };
            let at = *index.entry(id).or_insert_with(|| {
                by_point.push((*point, Vec::new()));
                by_point.len() - 1
            });
            by_point[at].1.push((reference, position));
        }
        for (point, wanted) in by_point {
            let id = point.attribute("id").unwrap_or_default();
            let alike = wanted.iter().all(|(_, position)| (position - wanted[0].1).norm() <= SAME);
            if alike && self.references.get(id) == Some(&wanted.len()) {
                edits.set_vector(point, "Coordinates", coordinates(&wanted[0].1));
                continue;
            }
            let mut made: Vec<(Vector, String)> = Vec::new();
            for (reference, position) in wanted {
                let known = made.iter().find(|(at, _)| (at - position).norm() <= SAME).map(|(_, own)| own.clone());
                let own = known.unwrap_or_else(|| {
                    let own = edits.fresh(&format!("{id}_moved"));
                    add(point, &own, &position, edits);
                    made.push((position, own.clone()));
                    own
                });
                edits.set(reference, &own);
            }
        }
    }
}

/// Adds a point behind another one, with the white space of that.
fn add(like: Xml, id: &str, position: &Vector, edits: &mut Edits) {
    let range = like.range();
    let [first, last] = [like.elements().next(), like.elements().last()].map(|own| own.map(|own| own.range()));
    let before = edits.space_before(range.start);
    let inner = first.map_or("", |first| edits.space_before(first.start));
    let end = last.map_or("", |last| edits.space_behind(last.end));
    let prefix = edits.prefix(like);
    let values =
        coordinates(position).map(|value| format!("{inner}<{prefix}Coordinates>{value}</{prefix}Coordinates>"));
    let new =
        format!("{before}<{prefix}Cartesian_point id=\"{id}\">{}{end}</{prefix}Cartesian_point>", values.concat());
    edits.insert(range.end, new);
}
