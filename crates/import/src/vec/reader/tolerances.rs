//! Lengths of segments, and what may deviate from them.
//!
//! A `Tolerance` is that of the value in which it stands, as deviations in its unit. A `Dimension` between the nodes of
//! one segment, or a `DefaultDimension` for lengths of segments or for all of them, gives it to lengths without one.

use super::{ImportError, Quantity, Reader, Segment, Xml, child, child_text, children};
use crate::unit::Unit;
use crate::xml::{number, title, words};
use std::collections::HashMap;

/// Types of dimensions to which a default applies, the more specific one first.
const TYPES: [&[&str]; 2] = [&["SegmentLengths", "segment length"], &["MeasurementChains", "default"]];

/// Lengths of a segment, m.
#[derive(Default)]
pub(super) struct Lengths {
    pub drawn: Option<f64>,
    pub built: Option<f64>,
    /// Deviations of the one that counts.
    pub tolerance: Option<[f64; 2]>,
}

/// A tolerance of all lengths in a range.
struct General {
    /// Lengths to which it applies, m.
    range: [f64; 2],
    limits: [f64; 2],
}

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// The lengths of a segment by their classes. One of another class counts as drawn, where there is no other.
    pub(super) fn read_lengths(&mut self, segment: Xml<'a, 'i>) -> Result<Lengths, ImportError> {
        let mut found = Lengths::default();
        let mut tolerances = [None; 2];
        let mut others = Vec::new();
        let id = segment.attribute("id").unwrap_or_default();
        for information in children(segment, "LengthInformation") {
            let class = child_text(information, "Classification").unwrap_or_default();
            let (slot, tolerance) = match class {
                "Adapted" => (&mut found.built, &mut tolerances[0]),
                "Designed" => (&mut found.drawn, &mut tolerances[1]),
                _ => {
                    others.push((information, class));
                    continue;
                }
            };
            if slot.is_some() {
                let what = "segments have several lengths of one class; the first is taken";
                self.file.findings.add_to(what, format!("{id} ({class})"));
                continue;
            }
            *slot = self.file.value(information, "Length", Quantity::Length)?;
            *tolerance = self.tolerance(information)?;
        }
        for (other, class) in others {
            let taken = found.drawn.is_none() && found.built.is_none();
            if taken {
                found.drawn = self.file.value(other, "Length", Quantity::Length)?;
                tolerances[1] = self.tolerance(other)?;
            }
            let what = if taken { "taken, as there is no other" } else { "not used" };
            self.file.findings.add_to(
                format!("lengths of a class that is neither Designed nor Adapted; {what}"),
                format!("{id} (`{class}`)"),
            );
        }
        found.tolerance = if found.built.is_some() { tolerances[0] } else { tolerances[1] };
        Ok(found)
    }

    /// The deviations that stand in the length of an element, m.
    fn tolerance(&mut self, information: Xml<'a, 'i>) -> Result<Option<[f64; 2]>, ImportError> {
        let Some(length) = child(information, "Length") else { return Ok(None) };
        let (unit, tolerance) = (self.file.unit(length), child(length, "Tolerance"));
        tolerance.map_or(Ok(None), |tolerance| self.limits(tolerance, unit))
    }

    /// The two deviations of a tolerance, m, the least first; `None`, and reported, if its unit is none of length.
    fn limits(&mut self, tolerance: Xml<'a, 'i>, unit: Option<Unit>) -> Result<Option<[f64; 2]>, ImportError> {
        let Some(unit) = unit.filter(|unit| unit.quantity == Quantity::Length) else {
            self.file.findings.add_to("tolerances without a unit of length; not used", title(tolerance));
            return Ok(None);
        };
        let limit = |name| child(tolerance, name).map_or(Ok(0.0), |limit| number(limit, f64::MAX));
        let (lower, upper) = (limit("LowerBoundary")? * unit.size, limit("UpperBoundary")? * unit.size);
        Ok(Some([lower.min(upper), lower.max(upper)]))
    }

    /// Reads the tolerance of every segment: its own, that of its dimension, or the first default that applies.
    pub(super) fn read_tolerances(&mut self, segments: &mut [Segment]) -> Result<(), ImportError> {
        let mut defaults = [Vec::new(), Vec::new()];
        for default in self.all("DefaultDimension") {
            let kind = child_text(default, "DimensionType").unwrap_or_default();
            let Some(kind) = TYPES.iter().position(|known| known.contains(&kind)) else { continue };
            let Some(range) = child(default, "DimensionValueRange") else { continue };
            let unit = self.file.unit(range);
            let ends = ["Minimum", "Maximum"].map(|name| child(range, name));
            let (Some(tolerance), [Some(from), Some(to)]) = (child(default, "ToleranceIndication"), ends) else {
                continue;
            };
            let (from, to) = (number(from, f64::MAX)?, number(to, f64::MAX)?);
            if let Some(limits) = self.limits(tolerance, unit)? {
                let size = unit.map_or(1.0, |unit| unit.size);
                self.file.keep(default);
                defaults[kind].push(General { range: [from * size, to * size], limits });
            }
        }
        let dimensions = self.read_dimensions(segments)?;
        for (k, segment) in segments.iter_mut().enumerate() {
            let Some(length) = segment.physical_length.or(segment.virtual_length) else { continue };
            let applies = |default: &&General| (default.range[0]..=default.range[1]).contains(&length);
            let default = || defaults.iter().flatten().find(applies).map(|default| default.limits);
            let limits = segment.tolerance.or_else(|| dimensions.get(&k).copied()).or_else(default);
            segment.tolerance = limits.filter(|[least, _]| length + least > 0.0);
            if limits.is_some() && segment.tolerance.is_none() {
                self.file.findings.add_to("tolerances that leave no length; not used", &segment.id);
            }
        }
        Ok(())
    }

    /// Tolerances of dimensions that are those of one segment, by its index.
    fn read_dimensions(&mut self, segments: &[Segment]) -> Result<HashMap<usize, [f64; 2]>, ImportError> {
        let mut between: HashMap<[&str; 2], Vec<usize>> = HashMap::new();
        let nodes: Vec<String> = self.ends_of(segments);
        for (k, _) in segments.iter().enumerate() {
            let mut ends = [nodes[2 * k].as_str(), nodes[2 * k + 1].as_str()];
            ends.sort_unstable();
            between.entry(ends).or_default().push(k);
        }
        let mut found = HashMap::new();
        for dimension in self.all("Dimension") {
            let Some(tolerance) = child(dimension, "Tolerance") else { continue };
            let anchors = ["DimensionAnchor", "ReferenceAnchor"].map(|name| {
                let location = self.file.target(dimension, name)?;
                child_text(location, "ReferencedNode")
            });
            let path: Vec<&str> =
                child(dimension, "Path").into_iter().flat_map(|path| words(path, "Segment")).collect();
            let along = |k: &usize| path.is_empty() || path == [segments[*k].id.as_str()];
            let segment = match anchors {
                [Some(a), Some(b)] => {
                    let mut ends = [a, b];
                    ends.sort_unstable();
                    between.get(&ends).map_or(&[][..], Vec::as_slice).iter().copied().filter(along).collect::<Vec<_>>()
                }
                _ => Vec::new(),
            };
            let [segment] = segment[..] else {
                let what = "tolerances of dimensions that are not those of one segment; not used";
                self.file.findings.add_to(what, title(dimension));
                continue;
            };
            let unit = self.file.unit(dimension);
            if let Some(limits) = self.limits(tolerance, unit)? {
                self.file.keep(dimension);
                found.insert(segment, limits);
            }
        }
        Ok(found)
    }

    /// Ids of the nodes of each segment, its start before its end.
    fn ends_of(&self, segments: &[Segment]) -> Vec<String> {
        let end = |segment: &Segment, name| {
            let node = self.file.ids.get(segment.id.as_str()).and_then(|own| child_text(*own, name));
            node.unwrap_or_default().to_owned()
        };
        segments.iter().flat_map(|own| [end(own, "StartNode"), end(own, "EndNode")]).collect()
    }
}
