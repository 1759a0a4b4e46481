//! KBL to plain values in SI: the contents of the file, without any decision.

use crate::coverings;
use crate::curve::{Polygon, Vector};
use crate::document::{Covering, Document, Format, LARGEST, Location, Node, Segment};
use crate::elements::{Chosen, Elements, Names};
use crate::error::ImportError;
use crate::findings::Findings;
use crate::options::Selection;
use crate::unit::{Quantity, Unit};
use crate::xml::{KBL, Read, Xml, child, child_text, children, id, missing, number, position, text, title, words, xml};
use roxmltree::NodeId;
use std::collections::{HashMap, HashSet};
use wireloom_core::identity::Identity;

mod identities;
mod modules;
mod parts;
mod tolerances;
mod usage;
mod wires;

pub(super) use modules::contents;

/// Reads a KBL text. Faults of the topology and unreadable numbers are errors, everything else a finding.
pub(super) fn read(text: &str, selection: &Selection, findings: &mut Findings) -> Result<Document, ImportError> {
    let file = xml(text, &KBL)?;
    let read = Read::nothing_of(&file);
    let root = Xml::root(&file, &read);
    let names = Names { value: "Value_component", unit: "Unit_component", segment: "Segment" };
    let mut reader = Reader {
        file: Elements::of(text, root, names, findings)?,
        occurrences: occurrences(root),
        per_copper: HashMap::new(),
        jackets: HashMap::new(),
        identities: HashMap::new(),
        chosen: Chosen::default(),
    };
    reader.choose(root, selection)?;
    reader.read_units(root);
    let routes = reader.read_routes(root);
    let with_wires = routes.iter().flat_map(|route| &route.segments).copied();
    let of_harness = reader.file.of_harness(root, children(root, "Segment").collect(), selection, with_wires)?;
    let (nodes, index) = reader.read_nodes(root, &of_harness)?;
    let (mut segments, segment_index) = reader.read_segments(&of_harness, &index)?;
    let wires = reader.read_wires(routes, &mut segments, &segment_index)?;
    reader.read_tolerances(root, &mut segments, &segment_index)?;
    reader.note_unused(root);
    reader.note_protection_lengths(root, &segments)?;
    let (listed, wiring) = (reader.read_listed(root), reader.read_wiring(root));
    let elements = reader.elements(root);
    Ok(Document {
        format: Format::Kbl,
        drawn: true,
        name: reader.name(root),
        nodes,
        segments,
        wires,
        listed,
        wiring,
        elements,
    })
}

/// The way of a wire of the chosen modules.
struct Route<'a, 'i> {
    routing: Xml<'a, 'i>,
    wire: Xml<'a, 'i>,
    /// XML ids, as the file gives them.
    segments: Vec<&'a str>,
}

struct Reader<'a, 'i, 'f> {
    file: Elements<'a, 'i, 'f>,
    /// Occurrences of parts, by the ids of these.
    occurrences: HashMap<&'a str, Vec<Xml<'a, 'i>>>,
    /// Known masses of cables with several cores, by area of copper.
    per_copper: HashMap<NodeId, Option<f64>>,
    /// Known outside diameters of cables with several cores, m.
    jackets: HashMap<NodeId, Option<f64>>,
    /// Identities of parts, as far as they were asked for.
    identities: HashMap<NodeId, Identity>,
    /// The parts of the modules that are imported.
    chosen: Chosen<'a>,
}

/// Occurrences of parts, by the ids of these.
fn occurrences<'a, 'i>(root: Xml<'a, 'i>) -> HashMap<&'a str, Vec<Xml<'a, 'i>>> {
    let mut of: HashMap<&str, Vec<Xml>> = HashMap::new();
    for node in root.descendants().filter(is_occurrence) {
        if let Some(part) = child_text(node, "Part") {
            of.entry(part).or_default().push(node);
        }
    }
    of
}

fn is_occurrence(node: &Xml) -> bool {
    node.name().ends_with("_occurrence")
}

/// An element, and what it stands in, below the harness and the container.
fn around<'a, 'i>(node: Xml<'a, 'i>) -> impl Iterator<Item = Xml<'a, 'i>> + Clone + use<'a, 'i> {
    node.ancestors().take_while(|node| !["Harness", "KBL_container"].contains(&node.name()))
}

impl<'a, 'i> Reader<'a, 'i, '_> {
    fn name(&self, root: Xml) -> Option<String> {
        let harness = child(root, "Harness")?;
        child_text(harness, "Description").or_else(|| child_text(harness, "Part_number")).map(str::to_owned)
    }

    /// Unknown units are reported with the values that use them.
    fn read_units(&mut self, root: Xml<'a, 'i>) {
        for unit in children(root, "Unit") {
            let of = |name| child_text(unit, name);
            let parsed = Unit::parse(of("Unit_name"), of("Si_unit_name"), of("Si_prefix"), of("Si_dimension"));
            if let (Some(id), Some(parsed)) = (unit.attribute("id"), parsed) {
                self.file.units.insert(id, parsed);
            }
        }
    }

    /// Coordinates, from mm to m.
    fn point(&self, point: Xml<'a, 'i>) -> Result<Vector, ImportError> {
        let mut x = Vector::zeros();
        let mut count = 0;
        for coordinate in children(point, "Coordinates") {
            if count < 3 {
                x[count] = number(coordinate, LARGEST * 1e3)? * 1e-3;
            }
            count += 1;
        }
        if count == 3 { Ok(x) } else { Err(missing(point, "Coordinates", "a point has three of them")) }
    }

    /// The nodes at which segments end.
    fn read_nodes(
        &mut self,
        root: Xml<'a, 'i>,
        segments: &[Xml<'a, 'i>],
    ) -> Result<(Vec<Node>, HashMap<&'a str, usize>), ImportError> {
        let ends =
            |own: Xml<'a, 'i>| ["Start_node", "End_node"].map(|name| child_text(own, name)).into_iter().flatten();
        let read: HashSet<&str> = segments.iter().flat_map(|own| ends(*own)).collect();
        let of_all: HashSet<&str> = children(root, "Segment").flat_map(ends).collect();
        let (mut nodes, mut index) = (Vec::new(), HashMap::new());
        for node in children(root, "Node") {
            let id = id(node)?;
            if !read.contains(id.as_str()) {
                if !of_all.contains(id.as_str()) {
                    self.file.findings.add_to("no segment ends at a node; left out", &id);
                }
                continue;
            }
            let point = self.file.required(
                node,
                "Cartesian_point",
                &["Cartesian_point"],
                "a node refers to the point where it lies",
            )?;
            let mut components = Vec::new();
            for reference in words(node, "Referenced_components") {
                match self.file.ids.get(reference) {
                    Some(&component) if self.chosen.leaves_out(component, None) => {}
                    Some(&component) => components.push(self.component(component, reference)?),
                    None => self.file.findings.add(format!(
                        "Node `{id}` refers to component `{reference}`, which is not in the file; left out"
                    )),
                }
            }
            index.insert(node.attribute("id").unwrap_or_default(), nodes.len());
            let label = child_text(node, "Id").unwrap_or(&id).to_owned();
            nodes.push(Node { label, position: self.point(point)?, components, id });
        }
        Ok((nodes, index))
    }

    fn read_segments(
        &mut self,
        of_harness: &[Xml<'a, 'i>],
        nodes: &HashMap<&'a str, usize>,
    ) -> Result<(Vec<Segment>, HashMap<&'a str, usize>), ImportError> {
        let (mut segments, mut index) = (Vec::new(), HashMap::new());
        for &segment in of_harness {
            let id = id(segment)?;
            self.file.mark(segment);
            let mut ends = [0; 2];
            for (end, name) in ends.iter_mut().zip(["Start_node", "End_node"]) {
                let node = self.file.required(segment, name, &["Node"], "a segment runs from one node to another")?;
                *end =
                    node.attribute("id").and_then(|id| nodes.get(id)).copied().ok_or_else(|| {
                        missing(segment, name, "the nodes of a harness stand directly in KBL_container")
                    })?;
            }
            if ends[0] == ends[1] {
                let (line, column) = position(segment);
                let node = child_text(segment, "Start_node").unwrap_or_default().to_owned();
                return Err(ImportError::Ring { line, column, id, node });
            }
            let area = match child(segment, "Cross_section_area_information") {
                Some(information) => self.file.value(information, "Area", Quantity::Area)?,
                None => None,
            };
            index.insert(segment.attribute("id").unwrap_or_default(), segments.len());
            segments.push(Segment {
                label: child_text(segment, "Id").unwrap_or(&id).to_owned(),
                ends,
                virtual_length: self.file.value(segment, "Virtual_length", Quantity::Length)?,
                physical_length: self.file.value(segment, "Physical_length", Quantity::Length)?,
                tolerance: None,
                area,
                bend_radius: None,
                moving_bend_radius: None,
                curves: self.read_curves(segment)?,
                fixings: self.read_fixings(segment)?,
                coverings: self.read_coverings(segment)?,
                wires: Vec::new(),
                id,
            });
        }
        Ok((segments, index))
    }

    /// The chain of centre curves; empty, and reported, if one of them cannot be used.
    fn read_curves(&mut self, segment: Xml<'a, 'i>) -> Result<Vec<Polygon>, ImportError> {
        let mut curves = Vec::new();
        for curve in children(segment, "Center_curve") {
            let degree = match child(curve, "Degree") {
                Some(degree) => number(degree, 1e6)?,
                None => 0.0,
            };
            let mut points = Vec::new();
            for holder in children(curve, "Control_points") {
                for reference in text(holder).unwrap_or_default().split_whitespace() {
                    match self.file.follow(holder, reference, &["Cartesian_point"]) {
                        Ok(point) => points.push(self.point(point)?),
                        Err(fault) => {
                            self.file
                                .findings
                                .add(format!("{}: {fault}; the curves of the segment are not used", title(curve)));
                            return Ok(Vec::new());
                        }
                    }
                }
            }
            if degree.fract() != 0.0 || !(1.0..=20.0).contains(&degree) || points.len() <= degree as usize {
                self.file.findings.add(format!(
                    "{}: degree {degree} with {} control points is not a curve; the curves of {} are not used",
                    title(curve),
                    points.len(),
                    title(segment)
                ));
                return Ok(Vec::new());
            }
            curves.push(Polygon::without_knots(degree as usize, points));
        }
        Ok(curves)
    }

    /// A place along a segment: the absolute form if the file gives it.
    fn location(
        &mut self,
        node: Xml<'a, 'i>,
        relative: &'static str,
        absolute: &'static str,
    ) -> Result<Option<Location>, ImportError> {
        // Zero is a valid place but not a valid length: `value` would refuse it.
        let zero = child(node, absolute).and_then(|holder| child_text(holder, "Value_component"));
        if zero.and_then(|text| text.parse::<f64>().ok()) == Some(0.0) {
            return Ok(Some(Location::Absolute(0.0)));
        }
        if let Some(s) = self.file.value(node, absolute, Quantity::Length)? {
            return Ok(Some(Location::Absolute(s)));
        }
        match child(node, relative) {
            Some(holder) => Ok(Some(Location::Relative(number(holder, 1e6)?))),
            None => {
                self.file.findings.add(format!("{} has no {relative}; left out", title(node)));
                Ok(None)
            }
        }
    }

    fn read_coverings(&mut self, segment: Xml<'a, 'i>) -> Result<Vec<Covering>, ImportError> {
        let mut all = Vec::new();
        for area in children(segment, "Protection_area") {
            let from = self.location(area, "Start_location", "Absolute_start_location")?;
            let to = self.location(area, "End_location", "Absolute_end_location")?;
            let (Some(from), Some(to)) = (from, to) else { continue };
            let then = "its covering is not counted";
            if self.file.target(area, "Associated_protection").is_some_and(|own| self.chosen.leaves_out(own, None)) {
                continue;
            }
            let Some(occurrence) =
                self.file.optional(area, "Associated_protection", &["Wire_protection_occurrence"], then)
            else {
                continue;
            };
            let Some(part) = self.file.optional(occurrence, "Part", &["Wire_protection"], then) else { continue };
            let description = child_text(part, "Description").unwrap_or_default();
            let kind = child_text(part, "Protection_type").unwrap_or_default();
            let linear_density = self.covering_density(part, occurrence)?;
            if linear_density.is_none() {
                self.file.findings.add_to("coverings without usable mass; it follows from the library", title(part));
            }
            let (inner_diameter, outer_diameter) = coverings::diameters(description, self.file.findings);
            all.push(Covering {
                id: occurrence.attribute("id").unwrap_or_default().to_owned(),
                kind: kind.to_owned(),
                description: description.to_owned(),
                linear_density,
                inner_diameter,
                outer_diameter,
                bend_radius: None,
                from,
                to,
            });
        }
        Ok(all)
    }

    /// Mass per covered length; a mass of the whole piece is divided by its `Protection_length`.
    fn covering_density(&mut self, part: Xml<'a, 'i>, occurrence: Xml<'a, 'i>) -> Result<Option<f64>, ImportError> {
        if self.file.unit_of(part, "Mass_information") == Some(Quantity::Mass) {
            let mass = self.file.value(part, "Mass_information", Quantity::Mass)?;
            let length = self.file.value(occurrence, "Protection_length", Quantity::Length)?;
            let piece = mass.zip(length);
            return Ok(piece.and_then(|(mass, length)| self.file.per_length(occurrence, mass, length)));
        }
        self.file.value(part, "Mass_information", Quantity::MassPerLength)
    }

    /// Reports coverings whose length is not that of the places that they cover, where the harness has all of these.
    fn note_protection_lengths(&mut self, root: Xml<'a, 'i>, segments: &[Segment]) -> Result<(), ImportError> {
        let mut stated = Vec::new();
        let without = children(root, "Segment").filter(|segment| self.file.left_out.contains(&segment.id()));
        let elsewhere: HashSet<&str> = without
            .flat_map(|segment| children(segment, "Protection_area"))
            .filter_map(|area| child_text(area, "Associated_protection"))
            .collect();
        for harness in children(root, "Harness") {
            for occurrence in children(harness, "Wire_protection_occurrence") {
                let id = occurrence.attribute("id").unwrap_or_default();
                if elsewhere.contains(id) || self.chosen.leaves_out(occurrence, None) {
                    continue;
                }
                let length = self.file.value(occurrence, "Protection_length", Quantity::Length)?;
                stated.push((id, length));
            }
        }
        coverings::note_lengths(segments, &stated, self.file.findings);
        Ok(())
    }
}
