//! Wires, and the segments through which they run.

use super::{BEND_RADII, DIAMETERS, ImportError, Quantity, Reader, Route, Segment, Wire, Xml, children, title, words};
use std::collections::HashMap;

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// The ways of all wires of the chosen modules.
    pub(super) fn read_routes(&mut self, root: Xml<'a, 'i>) -> Vec<Route<'a, 'i>> {
        const OCCURRENCES: [&str; 3] = ["General_wire_occurrence", "Wire_occurrence", "Core_occurrence"];
        let mut routes = Vec::new();
        for routing in children(root, "Routing") {
            let connection = self.target(routing, "Routed_wire");
            let wire = connection.map(|own| self.target(own, "Wire").unwrap_or(own));
            if wire.is_some_and(|wire| self.chosen.leaves_out(wire, connection)) {
                self.left_out.insert(routing.id());
                continue;
            }
            let routed = ["Connection", OCCURRENCES[0], OCCURRENCES[1], OCCURRENCES[2]];
            let then = "its wire is not counted";
            let Some(routed) = self.optional(routing, "Routed_wire", &routed, then) else { continue };
            let wire = if routed.name() == "Connection" {
                self.optional(routed, "Wire", &OCCURRENCES, then)
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
        let mut wires = Vec::new();
        let mut seen: HashMap<&str, Vec<usize>> = HashMap::new();
        for Route { routing, wire, segments: route } in routes {
            let mut run = Vec::new();
            for reference in route {
                match index.get(reference) {
                    Some(&segment) => run.push(segment),
                    None => self.findings.add(format!(
                        "{} runs through segment `{reference}`, which is not in the file; left out",
                        title(routing)
                    )),
                }
            }
            let wire_id = wire.attribute("id").unwrap_or_default();
            if run.is_empty() {
                self.findings.add_to("wires are routed through no segment; they are not counted", wire_id);
                self.keep(routing);
                continue;
            }
            self.mark(routing);
            let meet = |a: usize, b: usize| segments[a].ends.iter().any(|end| segments[b].ends.contains(end));
            if run.windows(2).any(|pair| !meet(pair[0], pair[1])) {
                self.findings.add_to(
                    "wires run through segments that do not follow on one another; counted where they are",
                    wire_id,
                );
            }
            // One index for a wire, several for a cable routed as a whole.
            let strands = match seen.get(wire_id) {
                Some(strands) => strands.clone(),
                None => {
                    let first = wires.len();
                    wires.append(&mut self.read_wire(wire)?);
                    let strands: Vec<usize> = (first..wires.len()).collect();
                    seen.insert(wire_id, strands.clone());
                    strands
                }
            };
            for segment in run {
                for &strand in &strands {
                    if !segments[segment].wires.contains(&strand) {
                        segments[segment].wires.push(strand);
                    }
                }
            }
        }
        Ok(wires)
    }

    /// The wire of an occurrence: one, or every core of a cable that is routed as a whole.
    fn read_wire(&mut self, occurrence: Xml<'a, 'i>) -> Result<Vec<Wire>, ImportError> {
        let id = occurrence.attribute("id").unwrap_or_default().to_owned();
        let then = "a wire of 0.5 mm² is taken";
        let Some(part) = self.optional(occurrence, "Part", &["General_wire", "Core"], then) else {
            let (copper_area, outside_diameter) = (None, None);
            return Ok(vec![Wire { id, copper_area, outside_diameter, linear_density: None, bend_radius: None }]);
        };
        let cores: Vec<Xml> = children(part, "Core").collect();
        if cores.is_empty() {
            return Ok(vec![self.read_wire_part(id, part)?]);
        }
        cores.into_iter().map(|core| self.read_wire_part(id.clone(), core)).collect()
    }

    /// Mass per length of a cable per area of the copper of all its cores, kg/m³.
    fn mass_per_copper(&mut self, cable: Xml<'a, 'i>) -> Result<Option<f64>, ImportError> {
        if let Some(known) = self.per_copper.get(&cable.id()) {
            return Ok(*known);
        }
        let mut copper = 0.0;
        for core in children(cable, "Core") {
            copper += self.value(core, "Cross_section_area", Quantity::Area)?.unwrap_or(0.0);
        }
        let density = self.value(cable, "Mass_information", Quantity::MassPerLength)?;
        let found = density.filter(|_| copper > 0.0).map(|density| density / copper);
        self.per_copper.insert(cable.id(), found);
        Ok(found)
    }

    /// A `General_wire` without cores, or a `Core`. A core has the same fraction of its cable's mass as of the cable's
    /// copper: jacket and filler are divided likewise.
    fn read_wire_part(&mut self, id: String, part: Xml<'a, 'i>) -> Result<Wire, ImportError> {
        let copper_area = self.value(part, "Cross_section_area", Quantity::Area)?;
        let linear_density = match part.parent().filter(|parent| parent.name() == "General_wire") {
            None => self.value(part, "Mass_information", Quantity::MassPerLength)?,
            Some(cable) => self.mass_per_copper(cable)?.zip(copper_area).map(|(mass, area)| mass * area),
        };
        let wire = Wire {
            id,
            copper_area,
            outside_diameter: self.value_within(part, "Outside_diameter", Quantity::Length, DIAMETERS)?,
            linear_density,
            bend_radius: self.value_within(part, "Bend_radius", Quantity::Length, BEND_RADII)?,
        };
        let lacking: Vec<&str> = [
            ("copper area", wire.copper_area),
            ("outside diameter", wire.outside_diameter),
            ("mass per length", wire.linear_density),
            ("bend radius", wire.bend_radius),
        ]
        .iter()
        .filter(|(_, value)| value.is_none())
        .map(|(name, _)| *name)
        .collect();
        if !lacking.is_empty() {
            self.findings.add_to(format!("wires without usable {}; estimated", lacking.join(", ")), title(part));
        }
        Ok(wire)
    }
}
