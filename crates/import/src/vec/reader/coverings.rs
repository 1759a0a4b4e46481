//! Coverings of segments, and the bend radii that ways through the topology allow.

use super::{ImportError, Placed, Quantity, Reader, Xml, child, child_text, element};
use crate::coverings;
use crate::document::{BEND_RADII, Covering, DIAMETERS, Segment};
use crate::xml::{children, title, words};
use std::collections::{HashMap, HashSet};

/// Reference of the role of a covering to its specification.
const SPECIFICATION: &str = "WireProtectionSpecification";

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// The coverings of a segment.
    pub(super) fn read_coverings(
        &mut self,
        placed: &Placed<'a, 'i>,
        segment: &str,
    ) -> Result<Vec<Covering>, ImportError> {
        let mut all = Vec::new();
        for over in placed.over.get(segment).into_iter().flatten() {
            let occurrence = over.occurrence;
            if self.chosen.leaves_out(occurrence, None) {
                continue;
            }
            let Some(role) = element::role(occurrence, SPECIFICATION) else {
                let item = format!("{segment} {}", title(occurrence));
                self.file.findings.add_to("parts that are no coverings lie over segments; they do not act", item);
                continue;
            };
            let specification = self.file.target(role, SPECIFICATION);
            let Some(specification) = specification.filter(|own| own.class().ends_with("Specification")) else {
                // The reference says what is wrong with it.
                self.file.optional(role, SPECIFICATION, &[SPECIFICATION], "its covering is not counted");
                continue;
            };
            self.file.mark(specification);
            self.file.mark(occurrence);
            self.file.mark(over.placement);
            let part = self.file.target(occurrence, "Part");
            let described = part.and_then(|part| element::localized(part, "Description"));
            let description =
                described.or_else(|| element::localized(specification, "Description")).unwrap_or_default();
            let linear_density = self.covering_density(occurrence, role)?;
            if linear_density.is_none() {
                let what = "coverings without usable mass; it follows from the library";
                self.file.findings.add_to(what, title(part.unwrap_or(specification)));
            }
            let size =
                |reader: &mut Self, name| reader.file.value_within(specification, name, Quantity::Length, DIAMETERS);
            let (inner, outer) = (size(self, "InnerDiameter")?, size(self, "OuterDiameter")?);
            let wall = size(self, "WallThickness")?;
            let stated = inner.or(outer).is_some();
            let written = if stated { (None, None) } else { coverings::diameters(description, self.file.findings) };
            let inner_diameter = inner.or_else(|| Some(outer? - 2.0 * wall?).filter(|d| *d > 0.0)).or(written.0);
            let outer_diameter = outer.or_else(|| Some(inner? + 2.0 * wall?)).or(written.1);
            let kind = specification.class().trim_end_matches("Specification");
            let special = child_text(specification, "SpecialPartType").unwrap_or_default();
            all.push(Covering {
                id: occurrence.attribute("id").unwrap_or_default().to_owned(),
                kind: [kind, special].join(" ").trim().to_owned(),
                description: description.to_owned(),
                linear_density,
                inner_diameter,
                outer_diameter,
                bend_radius: self.file.value_within(specification, "BendRadius", Quantity::Length, BEND_RADII)?,
                from: over.from,
                to: over.to,
            });
        }
        Ok(all)
    }

    /// Mass per covered length; a mass of the whole piece is divided by its `ProtectionLength`.
    fn covering_density(&mut self, occurrence: Xml<'a, 'i>, role: Xml<'a, 'i>) -> Result<Option<f64>, ImportError> {
        let all = self.specifications_of(occurrence);
        let masses: Vec<Xml> = all.iter().flat_map(|own| children(*own, "MassInformation")).collect();
        let quantities: Vec<_> = masses.iter().map(|mass| self.file.unit_of(*mass, "Value")).collect();
        if quantities.contains(&Some(Quantity::MassPerLength)) || !quantities.contains(&Some(Quantity::Mass)) {
            return self.mass_of(&all, Quantity::MassPerLength);
        }
        let mass = self.mass_of(&all, Quantity::Mass)?;
        let length = self.file.value(role, "ProtectionLength", Quantity::Length)?;
        Ok(mass.zip(length).and_then(|(mass, length)| self.file.per_length(occurrence, mass, length)))
    }

    /// Reports coverings that cover nothing, or not what their length says.
    pub(super) fn note_covered(&mut self, segments: &[Segment], placed: &Placed<'a, 'i>) -> Result<(), ImportError> {
        let here: HashSet<&str> = segments.iter().map(|segment| segment.id.as_str()).collect();
        let elsewhere = placed.over.iter().filter(|(segment, _)| !here.contains(*segment)).flat_map(|(_, over)| over);
        let elsewhere: HashSet<_> = elsewhere.map(|over| over.occurrence.id()).collect();
        let mut stated = Vec::new();
        for occurrence in self.all("Component") {
            let Some(role) = element::role(occurrence, SPECIFICATION) else { continue };
            if self.chosen.leaves_out(occurrence, None) || elsewhere.contains(&occurrence.id()) {
                continue;
            }
            let length = self.file.value(role, "ProtectionLength", Quantity::Length)?;
            stated.push((occurrence.attribute("id").unwrap_or_default(), length));
        }
        coverings::note_lengths(segments, &stated, self.file.findings);
        Ok(())
    }

    /// Bend radii that ways through the topology allow.
    pub(super) fn read_bending_restrictions(
        &mut self,
        segments: &mut [Segment],
        index: &HashMap<&'a str, usize>,
    ) -> Result<(), ImportError> {
        for restriction in self.all("TopologyBendingRestriction") {
            let mut radius = |name| self.file.value_within(restriction, name, Quantity::Length, BEND_RADII);
            let (fixed, moving) = (radius("MinBendRadiusStatic")?, radius("MinBendRadiusDynamic")?);
            let path = child(restriction, "RestrictedPath");
            for id in path.into_iter().flat_map(|path| words(path, "Segment")) {
                let Some(&segment) = index.get(id) else { continue };
                self.file.mark(restriction);
                let segment = &mut segments[segment];
                for (own, radius) in [(&mut segment.bend_radius, fixed), (&mut segment.moving_bend_radius, moving)] {
                    *own = (*own).into_iter().chain(radius).max_by(f64::total_cmp);
                }
            }
        }
        Ok(())
    }
}
