//! Wires, and the segments through which they run.

use super::{ImportError, Quantity, Reader, Route, Segment, Xml, children, title, words};
use crate::document::{BEND_RADII, DIAMETERS, Wire};
use crate::wires;
use std::collections::HashMap;

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// The ways of all wires of the chosen modules.
    pub(super) fn read_routes(&mut self, root: Xml<'a, 'i>) -> Vec<Route<'a, 'i>> {
        const OCCURRENCES: [&str; 3] = ["General_wire_occurrence", "Wire_occurrence", "Core_occurrence"];
        let mut routes = Vec::new();
        for routing in children(root, "Routing") {
            let connection = self.file.target(routing, "Routed_wire");
            let wire = connection.map(|own| self.file.target(own, "Wire").unwrap_or(own));
            if wire.is_some_and(|wire| self.chosen.leaves_out(wire, connection)) {
                self.file.left_out.insert(routing.id());
                continue;
            }
            let routed = ["Connection", OCCURRENCES[0], OCCURRENCES[1], OCCURRENCES[2]];
            let then = "its wire is not counted";
            let Some(routed) = self.file.optional(routing, "Routed_wire", &routed, then) else { continue };
            let wire = if routed.name() == "Connection" {
                self.file.optional(routed, "Wire", &OCCURRENCES, then)
            } else {
                Some(routed)
            };
            let segments = words(routing, "Segments").collect();
            if let Some(wire) = wire {
                routes.push(Route { routing, wire, segments });
            }
        }
        routes
    }

    /// Reads the wires of every segment.
    pub(super) fn read_wires(
        &mut self,
        routes: Vec<Route<'a, 'i>>,
        segments: &mut [Segment],
        index: &HashMap<&'a str, usize>,
    ) -> Result<Vec<Wire>, ImportError> {
        let mut all = Vec::new();
        let mut seen: HashMap<&str, Vec<usize>> = HashMap::new();
        for Route { routing, wire, segments: route } in routes {
            let mut run = Vec::new();
            for reference in route {
                match index.get(reference) {
                    Some(&segment) => run.push(segment),
                    None => self.file.findings.add(format!(
                        "{} runs through segment `{reference}`, which is not in the file; left out",
                        title(routing)
                    )),
                }
            }
            let wire = self.jacketed(wire)?.unwrap_or(wire);
            let wire_id = wire.attribute("id").unwrap_or_default();
            if run.is_empty() {
                self.file.findings.add_to("wires are routed through no segment; they are not counted", wire_id);
                self.file.keep(routing);
                continue;
            }
            self.file.mark(routing);
            // One index for a wire or a cable with a jacket, several for a cable without that is routed as a whole.
            let strands = match seen.get(wire_id) {
                Some(strands) => strands.clone(),
                None => {
                    let first = all.len();
                    all.append(&mut self.read_wire(wire)?);
                    let strands: Vec<usize> = (first..all.len()).collect();
                    seen.insert(wire_id, strands.clone());
                    strands
                }
            };
            wires::run(segments, &run, &strands, wire_id, self.file.findings);
        }
        Ok(all)
    }

    /// The cable with a jacket that an occurrence is, or in which it is a core. Such a cable counts whole, wherever one
    /// of its cores runs.
    fn jacketed(&mut self, wire: Xml<'a, 'i>) -> Result<Option<Xml<'a, 'i>>, ImportError> {
        let cable = if wire.name() == "Core_occurrence" { wire.parent() } else { Some(wire) };
        let part = cable.and_then(|cable| self.file.target(cable, "Part")).filter(|part| part.name() == "General_wire");
        let Some(part) = part else { return Ok(None) };
        Ok(if self.jacket(part)?.is_some() { cable } else { None })
    }

    /// Outside diameter of a cable with several cores, if it has a usable one, m.
    fn jacket(&mut self, cable: Xml<'a, 'i>) -> Result<Option<f64>, ImportError> {
        if children(cable, "Core").next().is_none() {
            return Ok(None);
        }
        if let Some(known) = self.jackets.get(&cable.id()) {
            return Ok(*known);
        }
        let found = self.file.value_within(cable, "Outside_diameter", Quantity::Length, DIAMETERS)?;
        self.jackets.insert(cable.id(), found);
        Ok(found)
    }

    /// The wire of an occurrence: one, or every core of a cable without a jacket that is routed as a whole.
    fn read_wire(&mut self, occurrence: Xml<'a, 'i>) -> Result<Vec<Wire>, ImportError> {
        let id = occurrence.attribute("id").unwrap_or_default().to_owned();
        let then = "a wire of 0.5 mm² is taken";
        let Some(part) = self.file.optional(occurrence, "Part", &["General_wire", "Core"], then) else {
            return Ok(vec![Wire::unknown(id)]);
        };
        let cores: Vec<Xml> = children(part, "Core").collect();
        if cores.is_empty() {
            return Ok(vec![self.read_wire_part(id, part)?]);
        }
        if let Some(outside) = self.jacket(part)? {
            let copper = self.copper(part)?;
            let density = self.file.value(part, "Mass_information", Quantity::MassPerLength)?;
            return Ok(vec![self.weighed(
                id,
                part,
                Some(copper).filter(|area| *area > 0.0),
                Some(outside),
                density,
            )?]);
        }
        cores.into_iter().map(|core| self.read_wire_part(id.clone(), core)).collect()
    }

    /// Mass per length of a cable per area of the copper of all its cores, kg/m³.
    fn mass_per_copper(&mut self, cable: Xml<'a, 'i>) -> Result<Option<f64>, ImportError> {
        if let Some(known) = self.per_copper.get(&cable.id()) {
            return Ok(*known);
        }
        let copper = self.copper(cable)?;
        let density = self.file.value(cable, "Mass_information", Quantity::MassPerLength)?;
        let found = density.filter(|_| copper > 0.0).map(|density| density / copper);
        self.per_copper.insert(cable.id(), found);
        Ok(found)
    }

    /// Area of all cores of a cable, m².
    fn copper(&mut self, cable: Xml<'a, 'i>) -> Result<f64, ImportError> {
        let mut copper = 0.0;
        for core in children(cable, "Core") {
            copper += self.file.value(core, "Cross_section_area", Quantity::Area)?.unwrap_or(0.0);
        }
        Ok(copper)
    }

    /// A `General_wire` without cores, or a `Core`. A core has the same fraction of its cable's mass as of the cable's
    /// copper: jacket and filler are divided likewise.
    fn read_wire_part(&mut self, id: String, part: Xml<'a, 'i>) -> Result<Wire, ImportError> {
        let copper_area = self.file.value(part, "Cross_section_area", Quantity::Area)?;
        let linear_density = match part.parent().filter(|parent| parent.name() == "General_wire") {
            None => self.file.value(part, "Mass_information", Quantity::MassPerLength)?,
            Some(cable) => self.mass_per_copper(cable)?.zip(copper_area).map(|(mass, area)| mass * area),
        };
        let outside_diameter = self.file.value_within(part, "Outside_diameter", Quantity::Length, DIAMETERS)?;
        self.weighed(id, part, copper_area, outside_diameter, linear_density)
    }

    /// A wire with the bend radius of its part. What it cannot weigh, or what is not given, is a finding.
    fn weighed(
        &mut self,
        id: String,
        part: Xml<'a, 'i>,
        copper_area: Option<f64>,
        outside_diameter: Option<f64>,
        linear_density: Option<f64>,
    ) -> Result<Wire, ImportError> {
        let bend_radius = self.file.value_within(part, "Bend_radius", Quantity::Length, BEND_RADII)?;
        let wire = Wire { copper_area, outside_diameter, linear_density, bend_radius, ..Wire::unknown(id) };
        Ok(wires::checked(wire, &title(part), part.name() == "Core", self.file.findings))
    }
}
