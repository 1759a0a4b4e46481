//! Connectors and fixings on the topology.

use super::{ImportError, Quantity, Reader, Vector, Xml, around, child, child_text, children, number, title, words};
use crate::document::{Component, Fixing, Placement};
use std::collections::BTreeSet;

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// A component. Its name is its `Id`, or that of the component that it is a part of (as the connectors of a
    /// component box); likewise its place and weight.
    pub(super) fn component(&mut self, component: Xml<'a, 'i>, reference: &str) -> Result<Component, ImportError> {
        let mut placement = None;
        let within = || around(component);
        for node in within() {
            placement = self.placement(node)?;
            if placement.is_some() {
                break;
            }
        }
        let part = self.file.target(component, "Part");
        let mass = match part {
            Some(part) if child(part, "Mass_information").is_some() => {
                self.file.mark(part);
                self.file.value(part, "Mass_information", Quantity::Mass)?
            }
            _ => None,
        };
        let label = within().find_map(|node| child_text(node, "Id"));
        Ok(Component {
            id: reference.to_owned(),
            label: label.unwrap_or(reference).to_owned(),
            splice: child_text(component, "Usage") == Some("splice"),
            placement,
            mass,
        })
    }

    /// Drawn place of an occurrence; `None`, and reported, if its point is not in the file.
    fn placement(&mut self, occurrence: Xml<'a, 'i>) -> Result<Option<Placement>, ImportError> {
        let Some(placement) = child(occurrence, "Placement") else { return Ok(None) };
        let then = "it has no drawn place";
        let Some(point) = self.file.optional(placement, "Cartesian_point", &["Cartesian_point"], then) else {
            return Ok(None);
        };
        let mut axis = Vec::new();
        for part in children(placement, "V") {
            axis.push(number(part, 1e6)?);
        }
        let axis = <[f64; 3]>::try_from(axis).ok().and_then(|v| Vector::from(v).try_normalize(1e-6));
        Ok(Some(Placement { position: self.point(point)?, axis }))
    }

    pub(super) fn read_fixings(&mut self, segment: Xml<'a, 'i>) -> Result<Vec<Fixing>, ImportError> {
        let mut fixings = Vec::new();
        for assignment in children(segment, "Fixing_assignment") {
            let Some(at) = self.location(assignment, "Location", "Absolute_location")? else { continue };
            let fixing = self.file.target(assignment, "Fixing");
            if fixing.is_none() {
                self.file
                    .findings
                    .add_to("fixing assignments refer to no fixing of the file; held nevertheless", title(assignment));
            }
            if fixing.is_some_and(|fixing| self.chosen.leaves_out(fixing, None)) {
                continue;
            }
            let own = assignment.attribute("id").unwrap_or("fixing");
            let part = fixing.and_then(|fixing| self.file.target(fixing, "Part"));
            let kind = part.and_then(|part| child_text(part, "Fixing_type")).unwrap_or_default();
            if !kind.is_empty() {
                part.into_iter().for_each(|part| self.file.mark(part));
            }
            fixings.push(Fixing {
                id: own.to_owned(),
                of: fixing.and_then(|fixing| fixing.attribute("id")).map(str::to_owned),
                label: fixing.and_then(|fixing| child_text(fixing, "Id")).unwrap_or(own).to_owned(),
                at,
                placement: fixing.map(|fixing| self.placement(fixing)).transpose()?.flatten(),
                duct: ["DUCT", "GROMMET"].iter().any(|word| kind.to_ascii_uppercase().contains(word)),
            });
        }
        Ok(fixings)
    }

    /// Reports fixings and connectors of the file that nothing refers to: they do not act.
    pub(super) fn note_unused(&mut self, root: Xml<'a, 'i>) {
        let placed: BTreeSet<&str> =
            children(root, "Node").flat_map(|node| words(node, "Referenced_components")).collect();
        let assigned: BTreeSet<&str> = children(root, "Segment")
            .flat_map(|segment| children(segment, "Fixing_assignment"))
            .filter_map(|assignment| child_text(assignment, "Fixing"))
            .collect();
        for harness in children(root, "Harness") {
            for occurrence in children(harness, "Fixing_occurrence") {
                let id = occurrence.attribute("id").unwrap_or_default();
                if !assigned.contains(id) && !self.chosen.leaves_out(occurrence, None) {
                    let label = child_text(occurrence, "Id").unwrap_or(id);
                    self.file
                        .findings
                        .add_to("fixings are assigned to no segment; left out", format!("{id} `{label}`"));
                }
            }
            for occurrence in children(harness, "Connector_occurrence") {
                if self.chosen.leaves_out(occurrence, None) {
                    continue;
                }
                let id = occurrence.attribute("id").unwrap_or_default();
                // Ring terminals are listed twice: the node refers to the terminal.
                let twin = child_text(occurrence, "Usage") == Some("ring terminal");
                if !placed.contains(id) && !twin {
                    let label = child_text(occurrence, "Id").unwrap_or(id);
                    self.file.findings.add_to("connectors sit at no node; left out", format!("{id} `{label}`"));
                }
            }
        }
    }
}
