//! XML to plain values in SI: the contents of the file, without any decision.

use super::curve::{Polygon, Vector};
use super::error::ImportError;
use super::findings::Findings;
use super::options::Selection;
use super::unit::{Quantity, Unit};
use super::usage::Element;
use roxmltree::NodeId;
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap, HashSet};
use wireloom_core::identity::Identity;
use wireloom_scenario::Places;

mod identities;
mod modules;
mod parts;
mod tolerances;
mod usage;
mod wires;
pub(super) mod xml;

pub(super) use identities::{End, Listed, ListedPlace, Wiring};
pub(super) use modules::contents;

use xml::{
    Read, Xml, child, child_text, children, is_occurrence, occurrences, place, position, text, title, words, xml,
};

/// Largest valid coordinate, m: control points of good curves reach some 10³ m.
const LARGEST: f64 = 1e5;

/// Valid outer diameters and bend radii of wires, m.
const DIAMETERS: [f64; 2] = [1e-6, 1.0];
const BEND_RADII: [f64; 2] = [1e-6, 1e3];

/// The harness in the file.
pub(super) struct Document {
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
}

impl Location {
    /// As a fraction of a segment of this length, m.
    pub fn fraction(self, length: f64) -> f64 {
        match self {
            Location::Relative(f) => f,
            Location::Absolute(s) => s / length,
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
    /// m, read from the description.
    pub inner_diameter: Option<f64>,
    /// m, read from the description.
    pub outer_diameter: Option<f64>,
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
}

/// Reads a KBL text. Faults of the topology and unreadable numbers are errors, everything else a finding.
pub(super) fn read(text: &str, selection: &Selection, findings: &mut Findings) -> Result<Document, ImportError> {
    let file = xml(text)?;
    let read = Read::nothing_of(&file);
    let root = Xml::root(&file, &read);
    let mut reader = Reader {
        ids: ids(root)?,
        occurrences: occurrences(root),
        units: HashMap::new(),
        per_copper: HashMap::new(),
        jackets: HashMap::new(),
        identities: HashMap::new(),
        places: Places::of(text),
        chosen: Chosen::default(),
        used: RefCell::default(),
        kept: HashSet::new(),
        left_out: HashSet::new(),
        findings,
    };
    reader.choose(root, selection)?;
    reader.read_units(root);
    let routes = reader.read_routes(root);
    let of_harness = reader.segments_of_harness(root, selection, &routes)?;
    let (nodes, index) = reader.read_nodes(root, &of_harness)?;
    let (mut segments, segment_index) = reader.read_segments(&of_harness, &index)?;
    let wires = reader.read_wires(routes, &mut segments, &segment_index)?;
    reader.read_tolerances(root, &mut segments, &segment_index)?;
    reader.note_unused(root);
    reader.note_protection_lengths(root, &segments)?;
    let (listed, wiring) = (reader.read_listed(root), reader.read_wiring(root));
    let elements = reader.elements(root);
    Ok(Document { name: reader.name(root), nodes, segments, wires, listed, wiring, elements })
}

/// The elements by their ids, which differ.
pub(super) fn ids<'a, 'i>(root: Xml<'a, 'i>) -> Result<HashMap<&'a str, Xml<'a, 'i>>, ImportError> {
    let mut ids: HashMap<&str, Xml> = HashMap::new();
    for node in root.descendants() {
        if let Some(id) = node.attribute("id")
            && let Some(first) = ids.insert(id, node)
        {
            let ((line, column), (first_line, _)) = (position(node), position(first));
            return Err(ImportError::DuplicateId { line, column, id: id.to_owned(), first_line });
        }
    }
    Ok(ids)
}

fn id(node: Xml) -> Result<String, ImportError> {
    node.attribute("id").map(str::to_owned).ok_or_else(|| missing(node, "id", "every node and segment needs one"))
}

fn missing(node: Xml, what: &str, right: &str) -> ImportError {
    missing_at(position(node), node, what, right)
}

fn missing_at((line, column): (u32, u32), node: Xml, what: &str, right: &str) -> ImportError {
    ImportError::Missing { line, column, element: title(node), missing: what.to_owned(), right: right.to_owned() }
}

/// The number in an element: finite, no larger than `largest` in size.
fn number(node: Xml, largest: f64) -> Result<f64, ImportError> {
    let found = text(node).unwrap_or_default();
    match found.parse::<f64>() {
        Ok(value) if value.is_finite() && value.abs() <= largest => Ok(value),
        _ => {
            let (line, column) = position(node);
            let element = node.name().to_owned();
            let expected = format!("a finite decimal number of size {largest:e} or less");
            Err(ImportError::Number { line, column, element, found: found.to_owned(), expected })
        }
    }
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

/// Parts that modules control.
#[derive(Default)]
struct Chosen<'a> {
    /// Ids of the parts of the chosen modules.
    present: HashSet<&'a str>,
    /// Ids of the parts of all others.
    left_out: HashSet<&'a str>,
}

impl<'a> Chosen<'a> {
    /// Whether a part is left out: one of other modules only. What no module controls is in every car. A part within
    /// another one, such as a core of a cable, goes with it; a wire goes with its connection, too.
    fn leaves_out(&self, part: Xml<'a, '_>, connection: Option<Xml<'a, '_>>) -> bool {
        let around = part.ancestors().chain(connection);
        let ids: Vec<&str> = around.filter_map(|node| node.attribute("id")).collect();
        !ids.iter().any(|id| self.present.contains(id)) && ids.iter().any(|id| self.left_out.contains(id))
    }
}

/// The way of a wire of the chosen modules.
struct Route<'a, 'i> {
    routing: Xml<'a, 'i>,
    wire: Xml<'a, 'i>,
    /// XML ids, as the file gives them.
    segments: Vec<&'a str>,
}

struct Reader<'a, 'i, 'f> {
    ids: HashMap<&'a str, Xml<'a, 'i>>,
    /// Occurrences of parts, by the ids of these.
    occurrences: HashMap<&'a str, Vec<Xml<'a, 'i>>>,
    units: HashMap<&'a str, Unit>,
    /// Known masses of cables with several cores, by area of copper.
    per_copper: HashMap<NodeId, Option<f64>>,
    /// Known outside diameters of cables with several cores, m.
    jackets: HashMap<NodeId, Option<f64>>,
    /// Identities of parts, as far as they were asked for.
    identities: HashMap<NodeId, Identity>,
    /// Broken references are findings, of which there may be very many.
    places: Places<'a>,
    /// The parts of the modules that are imported.
    chosen: Chosen<'a>,
    /// Elements on which the computation depends: those that a reference has led to.
    used: RefCell<HashSet<NodeId>>,
    /// Elements that are kept, though they do not act.
    kept: HashSet<NodeId>,
    /// Elements of other modules than the chosen ones, beside those that modules name.
    left_out: HashSet<NodeId>,
    findings: &'f mut Findings,
}

impl<'a, 'i> Reader<'a, 'i, '_> {
    fn name(&self, root: Xml) -> Option<String> {
        let harness = child(root, "Harness")?;
        child_text(harness, "Description").or_else(|| child_text(harness, "Part_number")).map(str::to_owned)
    }

    /// Notes that the computation depends on an element.
    fn mark(&self, node: Xml<'a, 'i>) {
        self.used.borrow_mut().insert(node.id());
    }

    /// The element that a child refers to, whatever it is.
    fn target(&self, node: Xml<'a, 'i>, name: &'static str) -> Option<Xml<'a, 'i>> {
        child_text(node, name).and_then(|reference| self.ids.get(reference).copied())
    }

    /// Unknown units are reported with the values that use them.
    fn read_units(&mut self, root: Xml<'a, 'i>) {
        for unit in children(root, "Unit") {
            let of = |name| child_text(unit, name);
            let parsed = Unit::parse(of("Unit_name"), of("Si_unit_name"), of("Si_prefix"), of("Si_dimension"));
            if let (Some(id), Some(parsed)) = (unit.attribute("id"), parsed) {
                self.units.insert(id, parsed);
            }
        }
    }

    /// The unit in a child.
    fn unit(&self, node: Xml<'a, 'i>) -> Option<Unit> {
        let id = child_text(node, "Unit_component")?;
        let unit = self.units.get(id).copied()?;
        self.ids.get(id).into_iter().for_each(|unit| self.mark(*unit));
        Some(unit)
    }

    /// The element that `holder` refers to; a fault of the reference is an error for the caller to return or report.
    fn follow(&self, holder: Xml<'a, 'i>, found: &str, expected: &[&str]) -> Result<Xml<'a, 'i>, ImportError> {
        let target = self.ids.get(found).copied();
        match target {
            Some(target) if expected.contains(&target.name()) => {
                self.mark(target);
                Ok(target)
            }
            _ => {
                let (line, column) = place(&self.places, holder.range().start);
                let actual = match target {
                    Some(target) => format!("it is that of a `{}`", target.name()),
                    None => "nothing has it".to_owned(),
                };
                Err(ImportError::Reference {
                    line,
                    column,
                    found: found.to_owned(),
                    expected: expected.join("` or `"),
                    actual,
                })
            }
        }
    }

    /// Follows the reference in a child; a broken or missing one is an error.
    fn required(
        &self,
        node: Xml<'a, 'i>,
        name: &'static str,
        expected: &[&str],
        right: &str,
    ) -> Result<Xml<'a, 'i>, ImportError> {
        let at = || place(&self.places, node.range().start);
        let holder = child(node, name).ok_or_else(|| missing_at(at(), node, name, right))?;
        self.follow(holder, text(holder).unwrap_or_default(), expected)
    }

    /// Follows the reference in a child; a broken one is reported, with its consequence `then`.
    fn optional(
        &mut self,
        node: Xml<'a, 'i>,
        name: &'static str,
        expected: &[&str],
        then: &str,
    ) -> Option<Xml<'a, 'i>> {
        match self.required(node, name, expected, "it should refer to one") {
            Ok(target) => Some(target),
            Err(fault) => {
                self.findings.add(format!("{}: {fault}; {then}", title(node)));
                None
            }
        }
    }

    /// The value of a child in SI; reported and left out if its unit is unknown or of another quantity, or if the
    /// value is impossible.
    fn value(&mut self, node: Xml<'a, 'i>, name: &'static str, quantity: Quantity) -> Result<Option<f64>, ImportError> {
        self.value_within(node, name, quantity, quantity.range())
    }

    /// Likewise, with other limits.
    fn value_within(
        &mut self,
        node: Xml<'a, 'i>,
        name: &'static str,
        quantity: Quantity,
        [least, greatest]: [f64; 2],
    ) -> Result<Option<f64>, ImportError> {
        let Some(holder) = child(node, name) else { return Ok(None) };
        let Some(amount) = child(holder, "Value_component") else {
            self.findings.add(format!("{}: {name} has no Value_component; left out", title(node)));
            return Ok(None);
        };
        let amount = number(amount, f64::MAX)?;
        let unit_id = child_text(holder, "Unit_component").unwrap_or_default();
        let fault = match self.unit(holder) {
            Some(unit) if unit.quantity == quantity => {
                let value = amount * unit.size;
                if (least..=greatest).contains(&value) {
                    return Ok(Some(value));
                }
                format!("{name} is {amount}, which is impossible")
            }
            Some(unit) => {
                format!("{name} is {amount} of unit `{unit_id}`, a {}, not a {}", unit.quantity.word(), quantity.word())
            }
            None => format!("{name} is {amount} of the unknown unit `{unit_id}`"),
        };
        self.findings.add(format!("{}: {fault}; left out", title(node)));
        Ok(None)
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

    /// The segments of the harness: all of them, or those with wires of the chosen modules.
    fn segments_of_harness(
        &mut self,
        root: Xml<'a, 'i>,
        selection: &Selection,
        routes: &[Route<'a, 'i>],
    ) -> Result<Vec<Xml<'a, 'i>>, ImportError> {
        let mut segments: Vec<Xml> = children(root, "Segment").collect();
        if segments.is_empty() {
            let (line, column) = position(root);
            return Err(ImportError::NoSegments { line, column });
        }
        if *selection == Selection::All {
            return Ok(segments);
        }
        let with_wires: HashSet<&str> = routes.iter().flat_map(|route| &route.segments).copied().collect();
        for empty in segments.extract_if(.., |own| own.attribute("id").is_some_and(|id| !with_wires.contains(id))) {
            self.left_out.insert(empty.id());
            let id = empty.attribute("id").unwrap_or_default();
            self.findings.add_to("segments have no wires of the chosen modules; left out", id);
        }
        if segments.is_empty() { Err(ImportError::NoWires) } else { Ok(segments) }
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
                    self.findings.add_to("no segment ends at a node; left out", &id);
                }
                continue;
            }
            let point = self.required(
                node,
                "Cartesian_point",
                &["Cartesian_point"],
                "a node refers to the point where it lies",
            )?;
            let mut components = Vec::new();
            for reference in words(node, "Referenced_components") {
                match self.ids.get(reference) {
                    Some(&component) if self.chosen.leaves_out(component, None) => {}
                    Some(&component) => components.push(self.component(component, reference)?),
                    None => self.findings.add(format!(
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
            self.mark(segment);
            let mut ends = [0; 2];
            for (end, name) in ends.iter_mut().zip(["Start_node", "End_node"]) {
                let node = self.required(segment, name, &["Node"], "a segment runs from one node to another")?;
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
                Some(information) => self.value(information, "Area", Quantity::Area)?,
                None => None,
            };
            index.insert(segment.attribute("id").unwrap_or_default(), segments.len());
            segments.push(Segment {
                label: child_text(segment, "Id").unwrap_or(&id).to_owned(),
                ends,
                virtual_length: self.value(segment, "Virtual_length", Quantity::Length)?,
                physical_length: self.value(segment, "Physical_length", Quantity::Length)?,
                tolerance: None,
                area,
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
                    match self.follow(holder, reference, &["Cartesian_point"]) {
                        Ok(point) => points.push(self.point(point)?),
                        Err(fault) => {
                            self.findings
                                .add(format!("{}: {fault}; the curves of the segment are not used", title(curve)));
                            return Ok(Vec::new());
                        }
                    }
                }
            }
            if degree.fract() != 0.0 || !(1.0..=20.0).contains(&degree) || points.len() <= degree as usize {
                self.findings.add(format!(
                    "{}: degree {degree} with {} control points is not a curve; the curves of {} are not used",
                    title(curve),
                    points.len(),
                    title(segment)
                ));
                return Ok(Vec::new());
            }
            curves.push(Polygon { degree: degree as usize, points });
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
        if let Some(s) = self.value(node, absolute, Quantity::Length)? {
            return Ok(Some(Location::Absolute(s)));
        }
        match child(node, relative) {
            Some(holder) => Ok(Some(Location::Relative(number(holder, 1e6)?))),
            None => {
                self.findings.add(format!("{} has no {relative}; left out", title(node)));
                Ok(None)
            }
        }
    }

    fn read_coverings(&mut self, segment: Xml<'a, 'i>) -> Result<Vec<Covering>, ImportError> {
        let mut coverings = Vec::new();
        for area in children(segment, "Protection_area") {
            let from = self.location(area, "Start_location", "Absolute_start_location")?;
            let to = self.location(area, "End_location", "Absolute_end_location")?;
            let (Some(from), Some(to)) = (from, to) else { continue };
            let then = "its covering is not counted";
            if self.target(area, "Associated_protection").is_some_and(|own| self.chosen.leaves_out(own, None)) {
                continue;
            }
            let Some(occurrence) = self.optional(area, "Associated_protection", &["Wire_protection_occurrence"], then)
            else {
                continue;
            };
            let Some(part) = self.optional(occurrence, "Part", &["Wire_protection"], then) else { continue };
            let description = child_text(part, "Description").unwrap_or_default();
            let kind = child_text(part, "Protection_type").unwrap_or_default();
            let linear_density = self.covering_density(part, occurrence)?;
            if linear_density.is_none() {
                self.findings.add_to("coverings without usable mass; it follows from the library", title(part));
            }
            let (inner_diameter, outer_diameter) = diameters(description);
            let read: Vec<String> =
                [inner_diameter, outer_diameter].iter().flatten().map(|d| format!("{:.1} mm", d * 1e3)).collect();
            if !read.is_empty() {
                self.findings.add_to(
                    "diameters of tubes are read from descriptions",
                    format!("`{description}` ({})", read.join(", ")),
                );
            }
            coverings.push(Covering {
                id: occurrence.attribute("id").unwrap_or_default().to_owned(),
                kind: kind.to_owned(),
                description: description.to_owned(),
                linear_density,
                inner_diameter,
                outer_diameter,
                from,
                to,
            });
        }
        Ok(coverings)
    }

    /// Mass per covered length; a mass of the whole piece is divided by its `Protection_length`.
    fn covering_density(&mut self, part: Xml<'a, 'i>, occurrence: Xml<'a, 'i>) -> Result<Option<f64>, ImportError> {
        if self.unit_of(part, "Mass_information") == Some(Quantity::Mass) {
            let mass = self.value(part, "Mass_information", Quantity::Mass)?;
            let length = self.value(occurrence, "Protection_length", Quantity::Length)?;
            let Some((mass, length)) = mass.zip(length) else { return Ok(None) };
            let [least, greatest] = Quantity::MassPerLength.range();
            let density = mass / length;
            if (least..=greatest).contains(&density) {
                return Ok(Some(density));
            }
            self.findings
                .add(format!("{}: {mass} kg on a length of {length} m is impossible; left out", title(occurrence)));
            return Ok(None);
        }
        self.value(part, "Mass_information", Quantity::MassPerLength)
    }

    fn unit_of(&self, node: Xml<'a, 'i>, name: &'static str) -> Option<Quantity> {
        let unit = child(node, name).and_then(|holder| child_text(holder, "Unit_component"))?;
        self.units.get(unit).map(|unit| unit.quantity)
    }

    /// Reports coverings whose length is not that of the places that they cover, where the harness has all of these.
    fn note_protection_lengths(&mut self, root: Xml<'a, 'i>, segments: &[Segment]) -> Result<(), ImportError> {
        // None where a segment has no length of its own.
        let mut covered: BTreeMap<&str, Option<f64>> = BTreeMap::new();
        for segment in segments {
            let length = segment.physical_length.or(segment.virtual_length);
            for covering in &segment.coverings {
                let span = |length| (covering.to.fraction(length) - covering.from.fraction(length)).abs() * length;
                let sum = covered.entry(&covering.id).or_insert(Some(0.0));
                *sum = sum.zip(length).map(|(sum, length)| sum + span(length));
            }
        }
        let without = children(root, "Segment").filter(|segment| self.left_out.contains(&segment.id()));
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
                let stated = self.value(occurrence, "Protection_length", Quantity::Length)?;
                match (covered.get(id), stated) {
                    (None, _) => self.findings.add_to("coverings cover no segment; not counted", id),
                    (Some(Some(covered)), Some(stated)) if (covered - stated).abs() > 0.01 * stated + 1e-3 => {
                        self.findings.add_to(
                            "coverings do not have the length of the places that they cover; the places count",
                            format!("{id} ({:.1} mm, places {:.1} mm)", stated * 1e3, covered * 1e3),
                        );
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }
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
