//! Sections of a branch along its length.

use crate::Section;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::ops::Range;

/// Sections of a branch: one for the whole branch, or one for each of its spans. Where two spans meet the mesh has a
/// station, so a segment and a coupling belong to one span.
#[derive(Clone, Debug, PartialEq)]
pub struct Sections {
    /// In the order of arc length; not empty.
    spans: Vec<SectionSpan>,
}

/// Segments of a branch that have the same section.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionSpan {
    /// The section.
    pub section: Section,
    /// The segments.
    pub segments: Range<usize>,
}

/// Part of a branch with one section, in a result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SectionResult {
    /// Name of the section.
    pub section: String,
    /// Arc length where the part begins, m.
    pub from: f64,
    /// Arc length where it ends, m.
    pub to: f64,
    /// Diameter, m.
    pub diameter: f64,
    /// Smallest bend radius allowed, m.
    pub bend_radius_limit: Option<f64>,
    /// Axial stiffness EA, N.
    pub axial_stiffness: f64,
}

/// Bend at a place of a branch, in a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// Arc length, m.
    pub s: f64,
    /// Bend radius, m; infinite where straight.
    pub radius: f64,
    /// Smallest bend radius allowed there, m.
    pub limit: Option<f64>,
}

impl Bend {
    /// Limit over radius: above 1 it is too tight; 0 without a limit, or if there is no radius.
    pub fn use_of_limit(&self) -> f64 {
        self.limit.map_or(0.0, |limit| (limit / self.radius).max(0.0))
    }

    /// The bend nearest to its limit, or farthest beyond it, comes first; without limits the tighter one.
    pub fn compare(&self, other: &Self) -> Ordering {
        other.use_of_limit().total_cmp(&self.use_of_limit()).then(self.radius.total_cmp(&other.radius))
    }
}

impl From<Section> for Sections {
    fn from(section: Section) -> Self {
        Self { spans: vec![SectionSpan { section, segments: 0..usize::MAX }] }
    }
}

impl Sections {
    /// Of these spans, in the order of arc length and without gaps.
    ///
    /// # Panics
    /// Without a span.
    pub fn new(spans: Vec<SectionSpan>) -> Self {
        assert!(!spans.is_empty(), "a branch has a section");
        Self { spans }
    }

    /// The spans, in the order of arc length. The last one of a whole branch may end beyond its segments.
    pub fn spans(&self) -> &[SectionSpan] {
        &self.spans
    }

    /// The section of every span.
    pub fn iter(&self) -> impl Iterator<Item = &Section> {
        self.spans.iter().map(|span| &span.section)
    }

    /// The section of every span, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Section> {
        self.spans.iter_mut().map(|span| &mut span.section)
    }

    /// The section of the whole branch; `None` where it changes.
    pub fn only(&self) -> Option<&Section> {
        if let [span] = self.spans.as_slice() { Some(&span.section) } else { None }
    }

    /// Section of a segment.
    #[inline]
    pub fn of(&self, segment: usize) -> &Section {
        match self.spans.as_slice() {
            [span] => &span.section,
            spans => &spans[spans.partition_point(|span| span.segments.end <= segment).min(spans.len() - 1)].section,
        }
    }

    /// Section at the start of the branch, or at its end.
    pub fn at_end(&self, start: bool) -> &Section {
        &self.spans[if start { 0 } else { self.spans.len() - 1 }].section
    }

    /// Sections on both sides of a node, that before it first.
    pub fn beside(&self, node: usize) -> [&Section; 2] {
        [self.of(node.saturating_sub(1)), self.of(node)]
    }

    /// Nodes at which the section changes.
    pub fn changes(&self) -> impl Iterator<Item = usize> {
        self.spans.iter().skip(1).map(|span| span.segments.start)
    }

    /// The parts of a branch with nodes at these arc lengths, m; none where the section does not change.
    pub fn results(&self, s: &[f64]) -> Vec<SectionResult> {
        let part = |SectionSpan { section, segments }: &SectionSpan| SectionResult {
            section: section.name.clone(),
            from: s[segments.start],
            to: s[segments.end],
            diameter: section.diameter,
            bend_radius_limit: section.min_bend_radius,
            axial_stiffness: section.axial_stiffness,
        };
        if self.only().is_some() { Vec::new() } else { self.spans.iter().map(part).collect() }
    }

    /// The greatest of the smallest bend radii allowed, m.
    pub fn bend_radius_limit(&self) -> Option<f64> {
        self.iter().filter_map(|section| section.min_bend_radius).reduce(f64::max)
    }

    /// The least diameter, m.
    pub fn thinnest(&self) -> f64 {
        self.iter().map(|section| section.diameter).fold(f64::INFINITY, f64::min)
    }

    /// The greatest diameter, m.
    pub fn diameter(&self) -> f64 {
        self.iter().map(|section| section.diameter).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;

    #[test]
    fn a_segment_has_the_section_of_its_span() {
        let section = |diameter| Section {
            name: format!("{diameter}"),
            diameter,
            linear_density: 0.1,
            axial_stiffness: 1e4,
            shear_stiffness: [1e4; 2],
            bending_stiffness: [0.1; 2],
            torsion_stiffness: 0.1,
            coupling_stiffness: [0.0; 3],
            min_bend_radius: None,
            min_bend_radius_moving: None,
            max_tension: None,
            max_torsion: None,
            thermal_expansion: 0.0,
            thermal_curvature: Vector::zeros(),
            friction: Default::default(),
            set: None,
            laws: Default::default(),
        };
        let span = |diameter, segments| SectionSpan { section: section(diameter), segments };
        let all = Sections::new(vec![span(1.0, 0..2), span(3.0, 2..3), span(2.0, 3..5)]);
        let diameters: Vec<f64> = (0..5).map(|segment| all.of(segment).diameter).collect();
        assert_eq!(diameters, [1.0, 1.0, 3.0, 2.0, 2.0]);
        assert_eq!(all.beside(2).map(|section| section.diameter), [1.0, 3.0]);
        assert_eq!(all.beside(0).map(|section| section.diameter), [1.0; 2]);
        assert_eq!(all.beside(5).map(|section| section.diameter), [2.0; 2]);
        assert_eq!(all.changes().collect::<Vec<_>>(), [2, 3]);
        assert_eq!([true, false].map(|start| all.at_end(start).diameter), [1.0, 2.0]);
        assert_eq!((all.diameter(), all.only()), (3.0, None));
        let one = Sections::from(section(4.0));
        assert_eq!((one.of(7).diameter, one.only().map(|own| own.diameter)), (4.0, Some(4.0)));
    }

    /// A tube that is bent beyond its own limit was not told of beside a bare cable that may be bent more tightly.
    #[test]
    fn the_bend_nearest_to_its_limit_comes_first() {
        let bend = |radius, limit| Bend { s: 0.0, radius, limit };
        let bare = bend(0.03, Some(0.02));
        let tube = bend(0.08, Some(0.1));
        let others = [bend(f64::INFINITY, Some(0.1)), bend(0.001, None), bend(0.002, None), bend(f64::NAN, Some(0.1))];
        let mut all = [bare, others[0], tube, others[2], others[1], others[3]];
        all.sort_by(Bend::compare);
        assert_eq!(all[..4], [tube, bare, others[1], others[2]]);
        assert!(tube.use_of_limit() > 1.0 && bare.use_of_limit() < 1.0);
    }
}
