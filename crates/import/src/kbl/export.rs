//! A computed harness back into the KBL file that its scenario was imported from.
//!
//! | in the file | becomes |
//! | --- | --- |
//! | `Center_curve` of a `Segment` | one cubic `B_spline_curve` within the tolerance of the computed centre line |
//! | `Start_vector`, `End_vector` | its tangents at its ends |
//! | `Physical_length`, or without it `Virtual_length` | the length of the branch, where that was changed |
//! | `Virtual_length` beside a `Physical_length` | the arc length of the new curve |
//! | `Cartesian_point` of a `Node` | where its branches end |
//! | `Placement` of a component at a node, with `U`, `V` | moved and turned with the end of the cable |
//! | `Location`, `Absolute_location` of a `Fixing_assignment` | the place of its constraint along the branch |
//! | `Orientation` of it, `Placement` of the fixing | moved and turned with the constraint |
//!
//! Everything else keeps its bytes: the text is changed by ranges. What has not moved by more than 1e-6 m (or rad) is
//! left as it is, too, and so is a curve that meets its nodes and is within the tolerance of the computed line. KBL has
//! no element for the bend radius of a segment; lengths of wires, dimensions and coverings stay those of the file.
//!
//! **Knots.** KBL has none. New curves are written for the interpretation, uniform or clamped, with which most of the
//! file's own curves meet their nodes; uniform, which the schema says, where it has none.
//!
//! **References.** A new curve takes over the `Cartesian_point`s that only the old ones refer to; what is left of them
//! is removed. A point that several elements share and that moves for some of them only stays, and those get a new one.

mod computed;
mod edits;
mod error;
mod line;
mod points;

pub use computed::{Branch, Computed, Held};
pub use error::ExportError;

use super::fit::{self, fit};
use super::reader;
use crate::constraints::Holding;
use crate::curve::{Curve, Fit, Knots, Vector};
use crate::document::{Document, Fixing};
use crate::findings::{Finding, Findings};
use crate::options::Selection;
use crate::section::Types;
use crate::segments::{Laid, lay_all};
use crate::unit::{Quantity, Unit};
use crate::xml::{KBL, Read, Xml, child, child_text, children, ids, text, xml};
use computed::JOINED;
use edits::{Edits, direction, significant};
use line::Line;
use nalgebra::UnitQuaternion;
use points::Points;
use std::collections::{BTreeMap, HashMap};

/// What moves by less than this, m and rad, is where it was: scenarios give positions to 1e-9 m, and a result has them
/// to about 1e-8 m.
const STILL: f64 = 1e-6;

/// Lengths that differ by less than this, relative to them, are the same: scenarios have nine significant digits.
const SAME_LENGTH: f64 = 1e-8;

/// Places along a segment that differ by less than this, as a fraction of it, are the same: files have six decimals.
const SAME_PLACE: f64 = 1e-6;

/// Largest distance, m, of a fixing from the centre line of its segment.
const ON_LINE: f64 = 1e-3;

/// A KBL file with a result in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Exported {
    /// Its text.
    pub text: String,
    /// Its segments that are branches of the result, in the order of the file.
    pub segments: Vec<Segment>,
    /// Its nodes that have moved.
    pub nodes: Vec<Moved>,
    /// Placements of components and fixings that have moved.
    pub placements: Vec<Moved>,
    /// Fixings whose place along their segment has changed.
    pub fixings: Vec<Shifted>,
    /// What was not written, and why.
    pub notes: Vec<Finding>,
}

/// A segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Its id.
    pub id: String,
    /// Names of its branches: several where it was split.
    pub branches: Vec<String>,
    /// Its length in the file, m.
    pub before: f64,
    /// Length of its branches, m.
    pub length: f64,
    /// Its new centre curve; `None` where that of the file is within the tolerance.
    pub curve: Option<CentreCurve>,
    /// Least bend radius, m; infinite where it is straight.
    pub bend_radius: f64,
}

impl Segment {
    /// Whether its length differs from that of the file.
    pub fn has_new_length(&self) -> bool {
        (self.length - self.before).abs() > SAME_LENGTH * self.before
    }
}

/// A centre curve that was written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentreCurve {
    /// Number of its control points.
    pub control_points: usize,
    /// Its largest distance from the computed line, m.
    pub distance: f64,
}

/// An element that has moved.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// Id of the node or of the occurrence.
    pub id: String,
    /// By how much, m.
    pub distance: f64,
}

/// A fixing that has another place along its segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Shifted {
    /// Id of its assignment.
    pub id: String,
    /// Name of the constraint.
    pub constraint: String,
    /// Its place before, as it was imported, and now: fractions of the segment.
    pub fractions: [f64; 2],
}

/// Writes a result into the text of its KBL file; `tolerance`: largest distance of the new centre curves from the
/// computed lines, m.
///
/// # Errors
/// [`ExportError`] where the file cannot be imported, the result has segments that it has not, or what the result has
/// at a node or a segment is nothing that KBL can say.
pub fn export(text: &str, computed: &Computed, tolerance: f64) -> Result<Exported, ExportError> {
    let document = reader::read(text, &Selection::All, &mut Findings::default())?;
    let mut types = Types::new();
    let wires: Vec<usize> = document.wires.iter().map(|wire| types.wire(wire, &mut Findings::default())).collect();
    let laid = lay_all(&document, &mut types, &wires, &mut Findings::default());
    let mut notes = Findings::default();
    let lines = line::lines(&document, computed, &mut notes)?;
    let ends = node_ends(&document, &lines)?;
    let file = xml(text, &KBL)?;
    let read = Read::nothing_of(&file);
    let root = Xml::root(&file, &read);
    let ids = ids(root)?;
    let mut writer = Writer {
        document: &document,
        laid: &laid,
        lines: &lines,
        ends: &ends,
        edits: Edits::new(text, ids.keys().copied()),
        ids,
        tolerance,
        reading: reading(&laid),
        notes,
        nodes: Vec::new(),
        placements: Vec::new(),
        fixings: Vec::new(),
    };
    let curves = writer.curves()?;
    let mut points = Points::new(root, curves.keys().map(|segment| writer.element(&document.segments[*segment].id)));
    let segments = writer.segments(&curves, &mut points);
    writer.nodes(&mut points);
    writer.fixings(computed, &mut points);
    points.write(&mut writer.edits);
    let Writer { edits, notes, nodes, placements, fixings, .. } = writer;
    Ok(Exported { text: edits.apply(), segments, nodes, placements, fixings, notes: notes.list })
}

/// The interpretation with which more of the file's own curves meet their nodes.
fn reading(laid: &[Laid]) -> Knots {
    let clamped = laid.iter().filter_map(|laid| laid.curve.reading());
    let votes: i64 = clamped.map(|reading| if reading == Knots::Clamped { 1 } else { -1 }).sum();
    if votes > 0 { Knots::Clamped } else { Knots::Uniform }
}

/// An end of a line at a node.
struct End {
    segment: usize,
    /// 0 at the start of the segment, 1 at its end.
    which: usize,
    position: Vector,
}

/// The ends of lines at each node, which are at one point.
fn node_ends(document: &Document, lines: &BTreeMap<usize, Line>) -> Result<Vec<Vec<End>>, ExportError> {
    let mut ends: Vec<Vec<End>> = document.nodes.iter().map(|_| Vec::new()).collect();
    for (&segment, line) in lines {
        for (which, node) in document.segments[segment].ends.into_iter().enumerate() {
            ends[node].push(End { segment, which, position: line.at(which as f64) });
        }
    }
    for (node, ends) in document.nodes.iter().zip(&ends) {
        let Some(first) = ends.first() else { continue };
        let far = ends.iter().map(|end| (end, (end.position - first.position).norm()));
        if let Some((end, distance)) = far.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, apart)| *apart > JOINED) {
            let branches = [first, end].map(|end| lines[&end.segment].branch_at(end.which).to_owned());
            return Err(ExportError::Apart { node: node.id.clone(), branches, distance });
        }
    }
    Ok(ends)
}

/// A motion of a rigid body: `x → to + R (x − from)`.
struct Motion {
    from: Vector,
    to: Vector,
    rotation: UnitQuaternion<f64>,
}

impl Motion {
    fn is_still(&self) -> bool {
        (self.to - self.from).norm() <= STILL && self.rotation.angle() <= STILL
    }

    fn of(&self, x: &Vector) -> Vector {
        self.to + self.rotation * (x - self.from)
    }
}

/// The curves to be written, by segment.
type Curves = BTreeMap<usize, fit::Fitted>;

struct Writer<'w, 'a, 'i> {
    document: &'w Document,
    laid: &'w [Laid],
    /// By segment.
    lines: &'w BTreeMap<usize, Line<'w>>,
    /// By node.
    ends: &'w [Vec<End>],
    edits: Edits<'a>,
    ids: HashMap<&'a str, Xml<'a, 'i>>,
    tolerance: f64,
    reading: Knots,
    notes: Findings,
    nodes: Vec<Moved>,
    placements: Vec<Moved>,
    fixings: Vec<Shifted>,
}

impl<'a, 'i> Writer<'_, 'a, 'i> {
    /// The element of an id of the document.
    fn element(&self, id: &str) -> Xml<'a, 'i> {
        self.ids[id]
    }

    /// The curves that replace those of the file.
    fn curves(&self) -> Result<Curves, ExportError> {
        let mut curves = Curves::new();
        for (&index, line) in self.lines {
            let segment = &self.document.segments[index];
            if self.is_within(index, line) {
                continue;
            }
            let fitted = fit(&line.to_fit(), self.tolerance, self.reading);
            if fitted.distance > self.tolerance {
                let (segment, tolerance, distance) = (segment.id.clone(), self.tolerance, fitted.distance);
                return Err(ExportError::Tolerance { segment, tolerance, distance });
            }
            curves.insert(index, fitted);
        }
        Ok(curves)
    }

    /// Whether the drawn line of a segment meets its nodes, which are still, and is within the tolerance of the
    /// computed one.
    fn is_within(&self, index: usize, line: &Line) -> bool {
        let (curve, segment) = (&self.laid[index].curve, &self.document.segments[index]);
        let still = (segment.ends.into_iter().enumerate())
            .all(|(which, node)| (line.at(which as f64) - self.document.nodes[node].position).norm() <= STILL);
        let count = 8 * line.nodes;
        let near = |j: usize| {
            let f = j as f64 / count as f64;
            (curve.point(f * curve.length) - line.at(f)).norm() <= self.tolerance
        };
        still && !matches!(self.laid[index].fit, Fit::Stale { .. }) && (0..=count).all(near)
    }

    /// Writes lengths and curves of segments.
    fn segments(&mut self, curves: &Curves, points: &mut Points<'a, 'i>) -> Vec<Segment> {
        let mut segments = Vec::new();
        for (&index, line) in self.lines {
            let of_file = &self.document.segments[index];
            let element = self.element(&of_file.id);
            let curve = curves.get(&index);
            let segment = Segment {
                id: of_file.id.clone(),
                branches: line.names(),
                before: self.laid[index].length,
                length: line.length,
                curve: curve.map(|fitted| CentreCurve {
                    control_points: fitted.polygon.points.len(),
                    distance: fitted.distance,
                }),
                bend_radius: line.bend_radius(),
            };
            self.length(index, &segment, element, curve);
            if let Some(fitted) = curve {
                self.curve(element, fitted, points);
                let tangents = line.to_fit().tangents;
                for (name, tangent) in ["Start_vector", "End_vector"].into_iter().zip(tangents) {
                    self.edits.set_vector(element, name, direction(&tangent));
                }
            }
            segments.push(segment);
        }
        segments
    }

    /// Writes the length of a segment, if it was changed. A file that gives none gets one with a new curve, as the
    /// length was that of the old curve.
    fn length(&mut self, index: usize, segment: &Segment, element: Xml<'a, 'i>, curve: Option<&fit::Fitted>) {
        let of_file = &self.document.segments[index];
        let (new, length) = (segment.has_new_length(), segment.length);
        match (of_file.physical_length, of_file.virtual_length) {
            (Some(_), drawn) => {
                if new {
                    self.value(element, "Physical_length", length);
                }
                if let (Some(_), Some(fitted)) = (drawn, curve) {
                    let [from, to] = [0.0, 1.0].map(|f| self.lines[&index].at(f));
                    let (curve, _) = Curve::lay(std::slice::from_ref(&fitted.polygon), from, to, None);
                    self.value(element, "Virtual_length", curve.length);
                }
            }
            (None, Some(_)) => {
                if new {
                    self.value(element, "Virtual_length", length);
                }
            }
            (None, None) if new || curve.is_some() => self.new_length(element, &segment.id, length),
            (None, None) => {}
        }
    }

    /// Writes a length into a value that is there.
    fn value(&mut self, holder: Xml<'a, 'i>, name: &'static str, length: f64) {
        let Some(value) = child(holder, name) else { return };
        let unit =
            child_text(value, "Unit_component").and_then(|id| self.ids.get(id)).and_then(|unit| length_unit(*unit));
        if let (Some(size), Some(component)) = (unit, child(value, "Value_component")) {
            self.edits.set(component, &significant(length / size));
        }
    }

    /// Adds a `Virtual_length` to a segment without a length.
    fn new_length(&mut self, element: Xml<'a, 'i>, id: &str, length: f64) {
        let mut units = self.ids.values().filter_map(|unit| Some((length_unit(*unit)?, unit.attribute("id")?)));
        let there = ["Virtual_length", "Physical_length"].iter().any(|name| child(element, name).is_some());
        // The same one in every run.
        let unit = units.by_ref().min_by(|a, b| a.1.cmp(b.1)).filter(|_| !there);
        let Some((size, unit)) = unit else {
            self.notes.add_to("lengths of segments without a usable value and unit of the file; not written", id);
            return;
        };
        const BEFORE: [&str; 4] = ["Id", "Alias_id", "Start_vector", "End_vector"];
        let inner = self.indent(element);
        let (line, deeper, prefix) = (inner.child, inner.deeper(), self.edits.prefix(element));
        let own = self.edits.fresh(&format!("{id}_Virtual_length"));
        let value = significant(length / size);
        let new = format!(
            "{line}<{prefix}Virtual_length id=\"{own}\">{deeper}<{prefix}Unit_component>{unit}</{prefix}Unit_component>\
             {deeper}<{prefix}Value_component>{value}</{prefix}Value_component>{line}</{prefix}Virtual_length>"
        );
        self.edits.insert(behind(element, &BEFORE), new);
    }

    /// Replaces the curves of a segment by one.
    fn curve(&mut self, element: Xml<'a, 'i>, fitted: &fit::Fitted, points: &mut Points<'a, 'i>) {
        const BEFORE: [&str; 9] = [
            "Id",
            "Alias_id",
            "Start_vector",
            "End_vector",
            "Virtual_length",
            "Physical_length",
            "Form",
            "End_node",
            "Start_node",
        ];
        let old: Vec<Xml> = children(element, "Center_curve").collect();
        let own = old.first().and_then(|curve| curve.attribute("id")).map(str::to_owned);
        let own = own.unwrap_or_else(|| {
            let segment = element.attribute("id").unwrap_or_default();
            self.edits.fresh(&format!("{segment}_Center_curve"))
        });
        let references = points.of_curve(&old, &own, &fitted.polygon.points, &mut self.edits).join(" ");
        let (degree, prefix) = (fitted.polygon.degree, self.edits.prefix(element));
        let inner = self.indent(element);
        let (line, deeper) = (inner.child, inner.deeper());
        let new = format!(
            "<{prefix}Center_curve id=\"{own}\">{deeper}<{prefix}Degree>{degree}</{prefix}Degree>\
             {deeper}<{prefix}Control_points>{references}</{prefix}Control_points>{line}</{prefix}Center_curve>"
        );
        match &old[..] {
            [] => self.edits.insert(behind(element, &BEFORE), format!("{line}{new}")),
            [first, more @ ..] => {
                self.edits.replace(first.range(), new);
                more.iter().for_each(|curve| self.edits.remove(*curve));
            }
        }
    }

    /// White space before the children of an element.
    fn indent(&self, element: Xml<'a, 'i>) -> Indent<'a> {
        let before = |node: Xml| self.edits.space_before(node.range().start);
        Indent { own: before(element), child: element.elements().next().map_or("", before) }
    }

    /// Writes nodes that have moved, and what sits there.
    fn nodes(&mut self, points: &mut Points<'a, 'i>) {
        for (node, ends) in self.document.nodes.iter().zip(self.ends) {
            let Some(end) = ends.first() else { continue };
            let distance = (end.position - node.position).norm();
            if distance > STILL {
                self.nodes.push(Moved { id: node.id.clone(), distance });
                points.want(self.element(&node.id), end.position);
            }
            let curve = &self.laid[end.segment].curve;
            let drawn = curve.frame(if end.which == 0 { 0.0 } else { curve.length });
            let rotation = self.lines[&end.segment].frames()[end.which] * drawn.inverse();
            let motion = Motion { from: node.position, to: end.position, rotation };
            if motion.is_still() {
                continue;
            }
            for component in node.components.iter().filter(|component| component.placement.is_some()) {
                let element = self.element(&component.id);
                if child(element, "Placement").is_none() {
                    let what = "components that are placed with the part they stand in; left where they are";
                    self.notes.add_to(what, &component.id);
                    continue;
                }
                self.place(element, &motion, points);
            }
        }
    }

    /// Moves the placement of an occurrence.
    fn place(&mut self, occurrence: Xml<'a, 'i>, motion: &Motion, points: &mut Points<'a, 'i>) {
        let id = occurrence.attribute("id").unwrap_or_default().to_owned();
        if self.placements.iter().any(|own| own.id == id) {
            self.notes.add_to("occurrences with several places; moved with the first of them", id);
            return;
        }
        let Some(placement) = child(occurrence, "Placement") else { return };
        let Some(point) = child_text(placement, "Cartesian_point").and_then(|id| self.ids.get(id)) else { return };
        let Some(from) = vector(*point, "Coordinates").map(|x| x * 1e-3) else { return };
        let to = motion.of(&from);
        for name in ["U", "V"] {
            if let Some(axis) = vector(placement, name) {
                self.edits.set_vector(placement, name, direction(&(motion.rotation * axis)));
            }
        }
        points.want(placement, to);
        self.placements.push(Moved { id, distance: (to - from).norm() });
    }

    /// Writes places and placements of fixings.
    fn fixings(&mut self, computed: &Computed, points: &mut Points<'a, 'i>) {
        let held: HashMap<&str, &Held> = computed.fixings.iter().map(|own| (own.assignment.as_str(), own)).collect();
        let holding = Holding { document: self.document, laid: self.laid, incidences: &[] };
        for (&index, line) in self.lines {
            let segment = &self.document.segments[index];
            for fixing in &segment.fixings {
                let seat = holding.seat(segment, &self.laid[index], fixing, &mut Findings::default());
                let Some((held, seat)) = held.get(fixing.id.as_str()).zip(seat) else {
                    self.notes.add_to("fixings that no constraint of the result holds; left as they are", &fixing.id);
                    continue;
                };
                let (s, distance) = line.place_of(held);
                if distance > ON_LINE {
                    let item = format!("{} (`{}`, {:.1} mm)", fixing.id, held.name, distance * 1e3);
                    self.notes.add_to("fixings that are held beside their segment; left as they are", item);
                    continue;
                }
                let curve = &self.laid[index].curve;
                let before = seat.drawn_s / curve.length.max(f64::MIN_POSITIVE);
                let rotation = UnitQuaternion::rotation_between(&seat.tangent, &held.tangent).unwrap_or_default();
                let motion = Motion { from: curve.point(seat.drawn_s), to: held.position, rotation };
                let fractions = [before, s / line.length];
                // An arc length changes with that of the segment, too.
                let stated = segment.physical_length.or(segment.virtual_length).unwrap_or(curve.length);
                let elsewhere = has_moved(fractions) || (line.length - stated).abs() > SAME_LENGTH * stated;
                self.fixing(fixing, held, fractions, elsewhere.then_some(s), &motion, points);
            }
        }
    }

    fn fixing(
        &mut self,
        fixing: &Fixing,
        held: &Held,
        fractions: [f64; 2],
        arc_length: Option<f64>,
        motion: &Motion,
        points: &mut Points<'a, 'i>,
    ) {
        let Some(assignment) = self.ids.get(fixing.id.as_str()).copied() else { return };
        if let Some(s) = arc_length {
            self.value(assignment, "Absolute_location", s);
        }
        if has_moved(fractions) {
            if let Some(location) = child(assignment, "Location") {
                self.edits.set(location, &edits::decimals(fractions[1], 9));
            }
            self.fixings.push(Shifted { id: fixing.id.clone(), constraint: held.name.clone(), fractions });
        }
        if motion.is_still() {
            return;
        }
        if let Some(axis) = vector(assignment, "Orientation") {
            self.edits.set_vector(assignment, "Orientation", direction(&(motion.rotation * axis)));
        }
        if let Some(occurrence) = fixing.of.as_deref().and_then(|id| self.ids.get(id)) {
            self.place(*occurrence, motion, points);
        }
    }
}

/// Whether a place along a segment, as a fraction of it, is another one than before.
fn has_moved([before, now]: [f64; 2]) -> bool {
    (now - before).abs() > SAME_PLACE
}

/// White space before an element and before its children.
struct Indent<'t> {
    own: &'t str,
    child: &'t str,
}

impl Indent<'_> {
    /// White space one level deeper than the children; none where these stand on one line.
    fn deeper(&self) -> String {
        let step = self.child.strip_prefix(self.own).unwrap_or_default();
        format!("{}{step}", self.child)
    }
}

/// The byte behind the last child of an element that has one of these names.
fn behind(element: Xml, names: &[&str]) -> usize {
    let before = element.elements().filter(|child| names.contains(&child.name())).last();
    let inside = || element.first_child().map_or(element.range().start, |child| child.range().start);
    before.map_or_else(inside, |child| child.range().end)
}

/// Size of a unit of length, m.
fn length_unit(unit: Xml) -> Option<f64> {
    let of = |name| child_text(unit, name);
    let is_unit = unit.name() == "Unit";
    let unit = Unit::parse(of("Unit_name"), of("Si_unit_name"), of("Si_prefix"), of("Si_dimension"))?;
    (is_unit && unit.quantity == Quantity::Length).then_some(unit.size)
}

/// The three numbers in elements of a name.
fn vector(node: Xml, name: &'static str) -> Option<Vector> {
    let parts: Option<Vec<f64>> =
        children(node, name).map(|part| text(part).and_then(|text| text.trim().parse().ok())).collect();
    <[f64; 3]>::try_from(parts?).ok().map(Vector::from)
}
