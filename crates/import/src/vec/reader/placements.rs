//! Places of parts on the topology: at nodes, along segments, and over ways through them.

use super::{ImportError, Quantity, Reader, Xml, child, child_text, children, element};
use crate::document::{LARGEST, Location};
use crate::vec::places::{Along, Over, Place, Placed};
use crate::xml::{text, title, words};
use std::collections::{HashMap, HashSet, VecDeque};

/// A `Location` of the file.
#[derive(Clone, Copy)]
enum Spot<'a> {
    Node(&'a str),
    Segment(&'a str, Location),
}

/// The topology by XML ids.
struct Topology<'a> {
    ends: HashMap<&'a str, [&'a str; 2]>,
    segments: HashMap<&'a str, Vec<&'a str>>,
}

impl<'a> Topology<'a> {
    fn of(segments: &[Xml<'a, '_>]) -> Self {
        let mut all = Self { ends: HashMap::new(), segments: HashMap::new() };
        for segment in segments {
            let ends = ["StartNode", "EndNode"].map(|name| child_text(*segment, name));
            let (Some(id), [Some(from), Some(to)]) = (segment.attribute("id"), ends) else { continue };
            all.ends.insert(id, [from, to]);
            [from, to].iter().for_each(|end| all.segments.entry(end).or_default().push(id));
        }
        all
    }

    /// The fewest segments from one spot to another.
    fn way(&self, from: Spot<'a>, to: Spot<'a>) -> Option<Vec<&'a str>> {
        let reached = |node: &str, segment: Option<&str>| match to {
            Spot::Node(end) => node == end,
            Spot::Segment(end, _) => segment == Some(end),
        };
        let mut before: HashMap<&str, Option<&str>> = HashMap::new();
        let mut seen: HashSet<&str> = HashSet::new();
        let mut open: VecDeque<(&str, &str)> = VecDeque::new();
        match from {
            Spot::Segment(id, _) => {
                before.insert(id, None);
                for end in *self.ends.get(id)? {
                    open.push_back((id, end));
                }
            }
            Spot::Node(node) => {
                seen.insert(node);
                for &id in self.segments.get(node)? {
                    before.insert(id, None);
                    let [a, b] = *self.ends.get(id)?;
                    open.push_back((id, if a == node { b } else { a }));
                }
            }
        }
        while let Some((segment, node)) = open.pop_front() {
            if reached(node, Some(segment)) {
                let mut way = vec![segment];
                while let Some(Some(earlier)) = way.last().and_then(|last| before.get(last)) {
                    way.push(earlier);
                }
                way.reverse();
                return Some(way);
            }
            if !seen.insert(node) {
                continue;
            }
            for &next in self.segments.get(node).into_iter().flatten() {
                if before.contains_key(next) {
                    continue;
                }
                before.insert(next, Some(segment));
                let [a, b] = *self.ends.get(next)?;
                open.push_back((next, if a == node { b } else { a }));
            }
        }
        None
    }

    /// The pieces of segments that a way covers.
    fn pieces(&self, from: Spot<'a>, to: Spot<'a>, way: &[&'a str]) -> Option<Vec<(&'a str, Location, Location)>> {
        let at = |segment: &str, node: &str| {
            Some(Location::Relative(if *self.ends.get(segment)?.first()? == node { 0.0 } else { 1.0 }))
        };
        let shared = |a: &str, b: &str| {
            let next = self.ends.get(b)?;
            self.ends.get(a)?.iter().find(|end| next.contains(end)).copied()
        };
        let mut pieces = Vec::new();
        for (k, &segment) in way.iter().enumerate() {
            // Where it enters the segment, and where it leaves it.
            let side = |spot: Spot<'a>, neighbour: Option<&&'a str>| match (neighbour, spot) {
                (Some(other), _) => at(segment, shared(segment, other)?),
                (None, Spot::Segment(id, location)) if id == segment => Some(location),
                (None, Spot::Node(node)) if self.ends.get(segment)?.contains(&node) => at(segment, node),
                _ => None,
            };
            let before = k.checked_sub(1).and_then(|k| way.get(k));
            let enters = side(from, before)?;
            let leaves = side(to, way.get(k + 1))?;
            pieces.push((segment, enters, leaves));
        }
        Some(pieces)
    }
}

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// The placements of all parts; those of other modules are among them.
    pub(super) fn read_placements(&mut self, segments: &[Xml<'a, 'i>]) -> Result<Placed<'a, 'i>, ImportError> {
        let topology = Topology::of(segments);
        let mut placed = Placed::default();
        for class in ["OnPointPlacement", "OnWayPlacement"] {
            for placement in self.all(class) {
                let occurrences = self.placed_occurrences(placement);
                if class == "OnPointPlacement" {
                    self.on_point(placement, &occurrences, &topology, &mut placed)?;
                } else {
                    self.on_way(placement, &occurrences, &topology, &mut placed)?;
                }
            }
        }
        self.note_unplaced(&placed);
        Ok(placed)
    }

    /// The occurrences whose roles a placement places.
    fn placed_occurrences(&mut self, placement: Xml<'a, 'i>) -> Vec<Xml<'a, 'i>> {
        let mut occurrences = Vec::new();
        for holder in children(placement, "PlacedElement") {
            for id in text(holder).unwrap_or_default().split_whitespace() {
                let found = self.file.resolve(holder, id, &["PlaceableElementRole", "Component", "PartUsage"]);
                match found {
                    Ok(role) => occurrences.extend(role.ancestors().find(element::is_occurrence)),
                    Err(fault) => self.file.findings.add(format!("{}: {fault}; left out", title(placement))),
                }
            }
        }
        let chosen = occurrences.iter().any(|own| !self.chosen.leaves_out(*own, None));
        if chosen {
            self.file.keep(placement);
        } else if !occurrences.is_empty() {
            self.file.left_out.insert(placement.id());
        }
        occurrences
    }

    /// A location on the topology.
    fn spot(&mut self, location: Xml<'a, 'i>) -> Result<Option<Spot<'a>>, ImportError> {
        let then = "its place is not used";
        let (name, class) = match location.class() {
            "NodeLocation" => ("ReferencedNode", "TopologyNode"),
            _ => ("ReferencedSegment", "TopologySegment"),
        };
        let Some(holder) = child(location, name) else {
            self.file.findings.add(format!("{} has no {name}; {then}", title(location)));
            return Ok(None);
        };
        let target = match self.file.resolve(holder, text(holder).unwrap_or_default(), &[class]) {
            Ok(target) => target.attribute("id"),
            Err(fault) => {
                self.file.findings.add(format!("{}: {fault}; {then}", title(location)));
                return Ok(None);
            }
        };
        if class == "TopologyNode" {
            return Ok(target.map(Spot::Node));
        }
        let Some(holder) = child(location, "Offset") else {
            self.file.findings.add(format!("{} has no Offset; {then}", title(location)));
            return Ok(None);
        };
        // Zero is a valid place, and one beyond the segment is told with the part.
        let Some(offset) = self.file.amount(location, holder, Quantity::Length, [-LARGEST, LARGEST])? else {
            return Ok(None);
        };
        let from_end = match child_text(location, "Anchor") {
            Some("FromEndNode") => true,
            Some("FromStartNode") => false,
            _ => {
                self.file.findings.add_to("places without a usable Anchor; counted from the start", title(location));
                false
            }
        };
        let at = if from_end { Location::BeforeEnd(offset) } else { Location::Absolute(offset) };
        Ok(target.map(|id| Spot::Segment(id, at)))
    }

    fn on_point(
        &mut self,
        placement: Xml<'a, 'i>,
        occurrences: &[Xml<'a, 'i>],
        topology: &Topology<'a>,
        placed: &mut Placed<'a, 'i>,
    ) -> Result<(), ImportError> {
        for location in children(placement, "Location") {
            let Some(spot) = self.spot(location)? else { continue };
            for &occurrence in occurrences {
                let id = occurrence.attribute("id").unwrap_or_default();
                // A fixing at a node holds the end of one of its segments.
                let beside = |node| {
                    let segment = *topology.segments.get(node)?.first()?;
                    let starts = topology.ends.get(segment)?[0] == node;
                    Some((segment, Location::Relative(if starts { 0.0 } else { 1.0 })))
                };
                let (place, along) = match spot {
                    Spot::Node(node) if self.holds(occurrence) => (Place::Node(node), beside(node)),
                    Spot::Node(node) => {
                        let own = Along { placement, occurrence, at: Location::Relative(0.0) };
                        placed.at_nodes.entry(node).or_default().push(own);
                        (Place::Node(node), None)
                    }
                    Spot::Segment(segment, at) => {
                        (Place::Segment { id: segment, from: at, to: at }, Some((segment, at)))
                    }
                };
                if let Some((segment, at)) = along {
                    placed.along.entry(segment).or_default().push(Along { placement, occurrence, at });
                }
                placed.listed.entry(id).or_default().push(place);
            }
        }
        Ok(())
    }

    fn on_way(
        &mut self,
        placement: Xml<'a, 'i>,
        occurrences: &[Xml<'a, 'i>],
        topology: &Topology<'a>,
        placed: &mut Placed<'a, 'i>,
    ) -> Result<(), ImportError> {
        let mut ends = [None; 2];
        for (end, name) in ends.iter_mut().zip(["StartLocation", "EndLocation"]) {
            match child(placement, name) {
                Some(location) => *end = self.spot(location)?,
                None => self.file.findings.add(format!("{} has no {name}; left out", title(placement))),
            }
        }
        let [Some(from), Some(to)] = ends else { return Ok(()) };
        let stated: Vec<&str> = child(placement, "Path").into_iter().flat_map(|path| words(path, "Segment")).collect();
        let way = match (from, to) {
            _ if !stated.is_empty() => Some(stated),
            (Spot::Segment(a, _), Spot::Segment(b, _)) if a == b => Some(vec![a]),
            _ => topology.way(from, to),
        };
        let Some(pieces) = way.and_then(|way| topology.pieces(from, to, &way)) else {
            self.file.findings.add_to(
                "no way through the segments of the harness leads from start to end of placements; left out",
                title(placement),
            );
            return Ok(());
        };
        for (segment, from, to) in pieces {
            for &occurrence in occurrences {
                let id = occurrence.attribute("id").unwrap_or_default();
                placed.over.entry(segment).or_default().push(Over { placement, occurrence, from, to });
                placed.listed.entry(id).or_default().push(Place::Segment { id: segment, from, to });
            }
        }
        Ok(())
    }
}
