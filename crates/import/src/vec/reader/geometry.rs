//! 3D geometry: places of nodes and components, and centre curves.

use super::{ImportError, Quantity, Reader, Xml, child, child_text, children, missing};
use crate::curve::{Polygon, Vector};
use crate::document::{LARGEST, Placement};
use crate::vec::places::{Frame, Geometry};
use crate::xml::{number, position, text, title, words};
use nalgebra::Matrix3;
use std::collections::HashMap;

/// Largest distance, m, between two places of a node that are the same.
const SAME: f64 = 1e-6;

/// Least distance of two knots of a curve, as a part of all, for them to differ.
const LEAST_SPAN: f64 = 1e-9;

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// The geometry of all building blocks in the vehicle.
    pub(super) fn read_geometry(&mut self) -> Result<Geometry<'a, 'i>, ImportError> {
        let mut geometry = Geometry::default();
        let places = self.block_places()?;
        for block in self.all("BuildingBlockSpecification3D") {
            let id = block.attribute("id").unwrap_or_default();
            let frame = match places.get(id) {
                None => Frame::of_vehicle(),
                Some(Some(frame)) => *frame,
                Some(None) => {
                    self.file.findings.add_to("building blocks lie on a formboard only; not used", title(block));
                    continue;
                }
            };
            for node in children(block, "GeometryNode") {
                self.geometry_node(node, &frame, &mut geometry)?;
            }
            for segment in children(block, "GeometrySegment") {
                self.geometry_segment(segment, &frame, &mut geometry)?;
            }
            for item in children(block, "PlacedElementViewItem3D") {
                for occurrence in words(item, "OccurrenceOrUsage") {
                    geometry.items.entry(occurrence).or_insert((item, frame));
                }
            }
        }
        Ok(geometry)
    }

    /// The place of each building block that a geometry of the harness places; `None`: on a formboard only.
    fn block_places(&mut self) -> Result<HashMap<&'a str, Option<Frame>>, ImportError> {
        let mut places: HashMap<&str, Option<Frame>> = HashMap::new();
        for geometry in self.all("HarnessGeometrySpecification3D") {
            let on_board = child_text(geometry, "Type").is_some_and(|kind| kind.eq_ignore_ascii_case("Formboard"));
            for positioning in children(geometry, "BuildingBlockPositionings") {
                let (name, then) = ("Referenced3DBuildingBlock", "it is not used");
                let Some(block) = self.file.optional(positioning, name, &["BuildingBlockSpecification3D"], then) else {
                    continue;
                };
                let id = block.attribute("id").unwrap_or_default();
                if on_board {
                    places.entry(id).or_insert(None);
                    continue;
                }
                if matches!(places.get(id), Some(Some(_))) {
                    self.file
                        .findings
                        .add_to("building blocks have several places; the first one is taken", title(block));
                    continue;
                }
                self.file.mark(positioning);
                let frame = match child(positioning, "Positioning") {
                    Some(transformation) => self.frame(transformation)?,
                    None => Frame::of_vehicle(),
                };
                places.insert(id, Some(frame));
            }
        }
        Ok(places)
    }

    /// A transformation: axes, and the point where it puts the origin.
    fn frame(&self, transformation: Xml<'a, 'i>) -> Result<Frame, ImportError> {
        const ENTRIES: [&str; 9] = ["A11", "A12", "A13", "A21", "A22", "A23", "A31", "A32", "A33"];
        let mut axes = Matrix3::zeros();
        for (k, name) in ENTRIES.into_iter().enumerate() {
            let right = "a transformation has nine of them, row by row";
            let entry = child(transformation, name).ok_or_else(|| missing(transformation, name, right))?;
            axes[(k / 3, k % 3)] = number(entry, 1e6)?;
        }
        let right = "a transformation refers to the point where it puts the origin";
        let origin = self.file.required(transformation, "Origin", &["CartesianPoint"], right)?;
        Ok(Frame { axes, origin: self.point(origin)? })
    }

    /// Coordinates in the building block, m.
    fn point(&self, point: Xml<'a, 'i>) -> Result<Vector, ImportError> {
        let size = self.base_unit(point)?;
        let mut x = Vector::zeros();
        for (k, name) in ["X", "Y", "Z"].into_iter().enumerate() {
            let coordinate = child(point, name).ok_or_else(|| missing(point, name, "a point has X, Y and Z"))?;
            x[k] = number(coordinate, LARGEST / size)? * size;
        }
        Ok(x)
    }

    /// Size of the unit of the specification in which a point stands, m.
    fn base_unit(&self, point: Xml<'a, 'i>) -> Result<f64, ImportError> {
        let (name, right) = ("BaseUnit", "the coordinates of its points are in it");
        let around = point.parent().unwrap_or(point);
        let holder = child(around, name).ok_or_else(|| missing(around, name, right))?;
        let id = text(holder).unwrap_or_default();
        let unit = self.file.units.get(id).filter(|unit| unit.quantity == Quantity::Length);
        self.file.ids.get(id).into_iter().for_each(|unit| self.file.mark(*unit));
        unit.map(|unit| unit.size).ok_or_else(|| {
            let (line, column) = position(holder);
            let actual = match (self.file.units.get(id), self.file.ids.get(id)) {
                (Some(unit), _) => format!("it is that of a unit of {}", unit.quantity.word()),
                (None, Some(other)) => format!("it is that of a `{}` that is not known", other.class()),
                (None, None) => "nothing has it".to_owned(),
            };
            let (found, expected) = (id.to_owned(), "unit of length".to_owned());
            ImportError::Reference { line, column, found, expected, actual }
        })
    }

    /// Id of the element of the topology that one of the geometry stands for; none is told.
    fn stands_for(&mut self, node: Xml<'a, 'i>, name: &'static str, class: &str) -> Option<&'a str> {
        let Some(holder) = child(node, name) else {
            self.file.findings.add_to(format!("parts of the geometry stand for no {class}; not used"), title(node));
            return None;
        };
        match self.file.resolve(holder, text(holder).unwrap_or_default(), &[class]) {
            Ok(target) => target.attribute("id"),
            Err(fault) => {
                self.file.findings.add(format!("{}: {fault}; not used", title(node)));
                None
            }
        }
    }

    fn geometry_node(
        &mut self,
        node: Xml<'a, 'i>,
        frame: &Frame,
        geometry: &mut Geometry<'a, 'i>,
    ) -> Result<(), ImportError> {
        let Some(of) = self.stands_for(node, "ReferenceNode", "TopologyNode") else { return Ok(()) };
        let right = "a node refers to the point where it lies";
        let point = self.file.required(node, "CartesianPoint", &["CartesianPoint"], right)?;
        let position = frame.point(self.point(point)?);
        self.file.mark(node);
        if let Some(first) = geometry.nodes.get(of) {
            if (first - position).norm() > SAME {
                self.file.findings.add_to("nodes are drawn at several places; the first one is taken", of);
            }
            return Ok(());
        }
        geometry.nodes.insert(of, position);
        Ok(())
    }

    fn geometry_segment(
        &mut self,
        segment: Xml<'a, 'i>,
        frame: &Frame,
        geometry: &mut Geometry<'a, 'i>,
    ) -> Result<(), ImportError> {
        let Some(of) = self.stands_for(segment, "ReferenceSegment", "TopologySegment") else { return Ok(()) };
        let mut curves = Vec::new();
        for curve in children(segment, "Curve") {
            let Some(curve) = self.curve(curve, frame)? else {
                let what = format!("{}: its curves are not used", title(segment));
                self.file.findings.add(what);
                return Ok(());
            };
            curves.push(curve);
        }
        self.file.mark(segment);
        if geometry.curves.contains_key(of) {
            self.file.findings.add_to("segments are drawn several times; the first curves are taken", of);
            return Ok(());
        }
        geometry.curves.insert(of, curves);
        Ok(())
    }

    /// A curve; `None`, and reported, if it cannot be used.
    fn curve(&mut self, curve: Xml<'a, 'i>, frame: &Frame) -> Result<Option<Polygon>, ImportError> {
        if curve.class() != "NURBSCurve" {
            self.file.findings.add(format!("{}: curves of this class are not known, NURBSCurve is", title(curve)));
            return Ok(None);
        }
        let degree = child(curve, "Degree").map(|degree| number(degree, 1e6)).transpose()?.unwrap_or_default();
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        for control in children(curve, "ControlPoint") {
            let right = "a control point refers to a point";
            match self.file.required(control, "CartesianPoint3D", &["CartesianPoint"], right) {
                Ok(point) => points.push(frame.point(self.point(point)?)),
                Err(fault) => {
                    self.file.findings.add(format!("{}: {fault}", title(curve)));
                    return Ok(None);
                }
            }
            weights.push(child(control, "Weight").map(|weight| number(weight, 1e9)).transpose()?.unwrap_or(1.0));
        }
        if degree.fract() != 0.0 || !(1.0..=20.0).contains(&degree) || points.len() <= degree as usize {
            let count = points.len();
            self.file
                .findings
                .add(format!("{}: degree {degree} with {count} control points is not a curve", title(curve)));
            return Ok(None);
        }
        let degree = degree as usize;
        let mut knots = Vec::new();
        for holder in children(curve, "Knots") {
            let found = text(holder).unwrap_or_default();
            for word in found.split_whitespace() {
                knots.push(word.parse::<f64>().ok().filter(|knot| knot.is_finite()).ok_or_else(|| {
                    let (line, column) = position(holder);
                    let (element, found) = (holder.name().to_owned(), word.to_owned());
                    let expected = "a finite decimal number".to_owned();
                    ImportError::Number { line, column, element, found, expected }
                })?);
            }
        }
        let knots = self.knots(curve, degree, points.len(), knots);
        let rational = weights.iter().any(|weight| *weight != weights[0]);
        if rational && weights.iter().any(|weight| *weight <= 0.0) {
            self.file.findings.add(format!("{}: weights of a curve are above zero", title(curve)));
            return Ok(None);
        }
        Ok(Some(Polygon { degree, points, knots, weights: rational.then_some(weights) }))
    }

    /// The knots of a curve; `None`, and reported, where they are not those of one: both usual ones are then tried.
    fn knots(&mut self, curve: Xml<'a, 'i>, degree: usize, points: usize, mut knots: Vec<f64>) -> Option<Vec<f64>> {
        // Without the first and the last one, which have no influence.
        if knots.len() + 1 == degree + points {
            knots.insert(0, knots[0]);
            knots.extend(knots.last().copied());
        }
        if knots.len() == degree + points + 1 {
            // From 0 to 1, as only their ratios matter.
            let (first, range) = (knots[degree], knots[points] - knots[degree]);
            knots.iter_mut().for_each(|knot| *knot = (*knot - first) / range);
            let rising = |pair: &[f64]| pair[1] == pair[0] || pair[1] - pair[0] > LEAST_SPAN;
            // A point inside has at most `degree` knots, or the curve falls into pieces.
            let whole = (degree + 1..points).all(|k| knots[k] < knots[k + degree]);
            if range.is_finite() && range > 0.0 && knots.windows(2).all(rising) && whole {
                return Some(knots);
            }
        }
        self.file.findings.add_to(
            "curves without usable knots; uniform and clamped ones are tried",
            format!("{} ({} knots for {points} control points of degree {degree})", title(curve), knots.len()),
        );
        None
    }

    /// Drawn place of an occurrence. The axis is the tangent of its placement point, if its part has one alone, or else
    /// its second axis.
    pub(super) fn placement(
        &mut self,
        occurrence: Xml<'a, 'i>,
        geometry: &Geometry<'a, 'i>,
    ) -> Result<Option<Placement>, ImportError> {
        let Some(&(item, frame)) = occurrence.attribute("id").and_then(|id| geometry.items.get(id)) else {
            return Ok(None);
        };
        let Some(orientation) = child(item, "Orientation") else { return Ok(None) };
        self.file.mark(item);
        let own = self.frame(orientation)?;
        let along = self.tangent(occurrence)?.unwrap_or_else(Vector::y);
        let axis = (frame.axes * own.axes * along).try_normalize(1e-6);
        Ok(Some(Placement { position: frame.point(own.origin), axis }))
    }

    /// Direction of a cable through the part of an occurrence, in the axes of the part.
    fn tangent(&mut self, occurrence: Xml<'a, 'i>) -> Result<Option<Vector>, ImportError> {
        let local =
            self.specifications_of(occurrence).into_iter().find(|own| own.class() == "LocalGeometrySpecification");
        let tangents: Vec<Xml> = local
            .into_iter()
            .flat_map(|local| children(local, "Positions"))
            .filter_map(|position| child(position, "Tangent"))
            .collect();
        let [tangent] = tangents[..] else { return Ok(None) };
        local.into_iter().for_each(|local| self.file.mark(local));
        let mut along = Vector::zeros();
        for (k, name) in ["X", "Y", "Z"].into_iter().enumerate() {
            along[k] = child(tangent, name).map(|part| number(part, 1e6)).transpose()?.unwrap_or_default();
        }
        Ok(along.try_normalize(1e-6))
    }
}
