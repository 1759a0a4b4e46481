//! Wires, and the segments through which they run.

use super::{ImportError, Quantity, Reader, Segment, Xml, child, children, element};
use crate::document::{BEND_RADII, DIAMETERS, Wire};
use crate::wires;
use crate::xml::{title, words};
use roxmltree::NodeId;
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

/// The way of a wire of the chosen modules.
pub(super) struct Route<'a, 'i> {
    pub routing: Xml<'a, 'i>,
    /// A `WireElementReference`.
    pub wire: Xml<'a, 'i>,
    /// XML ids, as the file gives them.
    pub segments: Vec<&'a str>,
}

/// Names of wire elements: those of parts, and those in other ones.
const ELEMENTS: [&str; 2] = ["WireElement", "SubWireElement"];

/// Specifications of conductors.
const CONDUCTORS: [&str; 4] =
    ["CoreSpecification", "FlatCoreSpecification", "ShieldSpecification", "ConductorSpecification"];

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// The ways of all wires of the chosen modules.
    pub(super) fn read_routes(&mut self) -> Vec<Route<'a, 'i>> {
        let mut of_connection: HashMap<&str, Vec<Xml>> = HashMap::new();
        for wire in self.all("WireElementReference") {
            for connection in words(wire, "Connection") {
                of_connection.entry(connection).or_default().push(wire);
            }
        }
        let mut routes = Vec::new();
        let mut seen = HashSet::new();
        for routing in self.all("Routing") {
            let (kinds, then) = (["WireElementReference", "Connection"], "its wire is not counted");
            let Some(routed) = self.file.optional(routing, "RoutedElement", &kinds, then) else { continue };
            let wires = match routed.class() {
                "Connection" => {
                    let id = routed.attribute("id").unwrap_or_default();
                    of_connection.get(id).cloned().unwrap_or_default()
                }
                _ => vec![routed],
            };
            if wires.is_empty() {
                self.file.findings.add_to("connections without a wire are routed; not counted", title(routing));
            }
            let path = child(routing, "Path");
            let segments: Vec<&str> = path.into_iter().flat_map(|path| words(path, "Segment")).collect();
            for wire in wires {
                if self.chosen.leaves_out(wire, None) {
                    self.file.left_out.insert(routing.id());
                    continue;
                }
                if !seen.insert(wire.id()) {
                    let id = wire.attribute("id").unwrap_or_default();
                    let what = "wires have several ways, as those of several variants; all of them are taken";
                    self.file.findings.add_to(what, id);
                }
                routes.push(Route { routing, wire, segments: segments.clone() });
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
        // Outside diameters of cables: one may have very many cores.
        let mut jackets: HashMap<NodeId, Option<f64>> = HashMap::new();
        // Strands by their occurrence and their element: a cable and its cores may have references of their own.
        let mut seen: HashMap<(NodeId, NodeId), usize> = HashMap::new();
        let routed: HashSet<NodeId> = routes.iter().map(|route| route.wire.id()).collect();
        for Route { routing, wire, segments: route } in routes {
            let mut run = Vec::new();
            for reference in route {
                match index.get(reference) {
                    Some(&segment) => run.push(segment),
                    None => self.file.findings.add(format!(
                        "{} runs through segment `{reference}`, which is not in the harness; left out",
                        title(routing)
                    )),
                }
            }
            let element = self.element(wire);
            // A cable with a jacket counts whole, wherever one of its cores runs.
            let cable = element.map(whole).filter(|cable| has_parts(*cable));
            let jacket = match cable {
                Some(cable) => match jackets.entry(cable.id()) {
                    Entry::Occupied(known) => *known.get(),
                    Entry::Vacant(new) => *new.insert(self.outside(cable)?),
                },
                None => None,
            };
            let occurrence = occurrence(wire);
            let counted = if jacket.is_some() { occurrence } else { wire };
            let id = counted.attribute("id").unwrap_or_default();
            if run.is_empty() {
                self.file.findings.add_to("wires are routed through no segment; they are not counted", id);
                self.file.keep(routing);
                continue;
            }
            self.file.mark(routing);
            self.file.mark(wire);
            let parts = match (element, jacket.and(cable)) {
                (None, _) => vec![wire],
                (_, Some(cable)) => vec![cable],
                (Some(element), None) => leaves(element),
            };
            let mut strands = Vec::new();
            for part in parts {
                let strand = *seen.entry((occurrence.id(), part.id())).or_insert(all.len());
                strands.push(strand);
                if strand == all.len() {
                    all.push(match (element, jacket) {
                        (None, _) => Wire::unknown(id.to_owned()),
                        (_, Some(_)) => self.cable(id, part)?,
                        (_, None) => self.strand(id, part)?,
                    });
                }
            }
            wires::run(segments, &run, &strands, id, self.file.findings);
        }
        let counted = seen.into_keys().collect();
        self.note_without_routing(&routed, &counted);
        Ok(all)
    }

    /// Reports wires of the chosen modules that no routing leads anywhere, unless they are counted with their cable or
    /// by their cores: `counted`, by occurrence and element.
    fn note_without_routing(&mut self, routed: &HashSet<NodeId>, counted: &HashSet<(NodeId, NodeId)>) {
        for wire in self.all("WireElementReference") {
            if routed.contains(&wire.id()) || self.chosen.leaves_out(wire, None) {
                continue;
            }
            let occurrence = occurrence(wire).id();
            let element = self.file.target(wire, "ReferencedWireElement").filter(|own| ELEMENTS.contains(&own.name()));
            let mut related = element.into_iter().flat_map(|own| own.ancestors().chain(own.descendants()));
            if !related.any(|own| counted.contains(&(occurrence, own.id()))) {
                let id = wire.attribute("id").unwrap_or_default();
                self.file.findings.add_to("wires have no routing; they are not counted", id);
            }
        }
    }

    /// The wire element of a reference.
    fn element(&mut self, wire: Xml<'a, 'i>) -> Option<Xml<'a, 'i>> {
        let then = "a wire of 0.5 mm² is taken";
        self.file.optional(wire, "ReferencedWireElement", &ELEMENTS, then)
    }

    /// The specification of a wire element.
    fn specification(&mut self, element: Xml<'a, 'i>) -> Option<Xml<'a, 'i>> {
        let (name, then) = ("WireElementSpecification", "its wire is estimated");
        self.file.optional(element, name, &[name], then)
    }

    /// Outside diameter of a wire element, m.
    fn outside(&mut self, element: Xml<'a, 'i>) -> Result<Option<f64>, ImportError> {
        match self.specification(element) {
            Some(own) => self.file.value_within(own, "OutsideDiameter", Quantity::Length, DIAMETERS),
            None => Ok(None),
        }
    }

    /// Area of the conductor of a wire element without parts, m².
    fn area(&mut self, element: Xml<'a, 'i>) -> Result<Option<f64>, ImportError> {
        let Some(own) = self.specification(element) else { return Ok(None) };
        let name = "ConductorSpecification";
        if child(own, name).is_none() {
            return Ok(None);
        }
        match self.file.optional(own, name, &CONDUCTORS, "its copper is not known") {
            Some(conductor) => self.file.value(conductor, "CrossSectionArea", Quantity::Area),
            None => Ok(None),
        }
    }

    /// Area of all conductors of a cable, m².
    fn copper(&mut self, cable: Xml<'a, 'i>) -> Result<f64, ImportError> {
        if let Some(&known) = self.copper.get(&cable.id()) {
            return Ok(known);
        }
        let mut copper = 0.0;
        for leaf in leaves(cable) {
            copper += self.area(leaf)?.unwrap_or(0.0);
        }
        self.copper.insert(cable.id(), copper);
        Ok(copper)
    }

    /// Mass per length of the part in whose specification a wire element stands, kg/m.
    fn density(&mut self, element: Xml<'a, 'i>) -> Result<Option<f64>, ImportError> {
        let specification = whole(element).parent();
        specification.into_iter().for_each(|own| self.file.mark(own));
        let described: Vec<&str> = specification.into_iter().flat_map(|own| words(own, "DescribedPart")).collect();
        let of = |part: &&str| self.specifications.get(*part).cloned();
        let all: Vec<Xml> = described.iter().filter_map(of).flatten().collect();
        self.mass_of(&all, Quantity::MassPerLength)
    }

    /// A cable with a jacket.
    fn cable(&mut self, id: &str, cable: Xml<'a, 'i>) -> Result<Wire, ImportError> {
        let copper = self.copper(cable)?;
        let (outside_diameter, linear_density) = (self.outside(cable)?, self.density(cable)?);
        let copper_area = Some(copper).filter(|area| *area > 0.0);
        let wire = Wire { copper_area, outside_diameter, linear_density, ..Wire::unknown(id.to_owned()) };
        self.bent(wire, cable, false)
    }

    /// A single wire, or a core. A core has the same fraction of its cable's mass as of the cable's copper: jacket and
    /// filler are divided likewise.
    fn strand(&mut self, id: &str, element: Xml<'a, 'i>) -> Result<Wire, ImportError> {
        let (copper_area, outside_diameter) = (self.area(element)?, self.outside(element)?);
        let density = self.density(element)?;
        let cable = whole(element);
        let is_core = cable.id() != element.id();
        let linear_density = if is_core {
            let copper = self.copper(cable)?;
            let shares = density.zip(copper_area).filter(|_| copper > 0.0);
            shares.map(|(density, area)| density / copper * area)
        } else {
            density
        };
        let wire = Wire { copper_area, outside_diameter, linear_density, ..Wire::unknown(id.to_owned()) };
        self.bent(wire, element, is_core)
    }

    /// A wire with the bend radii of its element, checked.
    fn bent(&mut self, mut wire: Wire, element: Xml<'a, 'i>, is_core: bool) -> Result<Wire, ImportError> {
        let specification = self.specification(element);
        if let Some(own) = specification {
            let mut radius = |name| self.file.value_within(own, name, Quantity::Length, BEND_RADII);
            (wire.bend_radius, wire.moving_bend_radius) =
                (radius("MinBendRadiusStatic")?, radius("MinBendRadiusDynamic")?);
            if wire.bend_radius.is_none() && wire.moving_bend_radius.is_some() {
                let what = "wires with a dynamic bend radius alone; it counts for those that do not move, too";
                self.file.findings.add_to(what, title(own));
                wire.bend_radius = wire.moving_bend_radius;
            }
        }
        let part = title(specification.unwrap_or(element));
        Ok(wires::checked(wire, &part, is_core, self.file.findings))
    }
}

/// The occurrence of a part to which a reference belongs.
fn occurrence<'a, 'i>(wire: Xml<'a, 'i>) -> Xml<'a, 'i> {
    wire.ancestors().find(element::is_occurrence).unwrap_or(wire)
}

/// The wire element in which another one stands, in the end.
pub(super) fn whole<'a, 'i>(element: Xml<'a, 'i>) -> Xml<'a, 'i> {
    let around = element.ancestors().take_while(|node| ELEMENTS.contains(&node.name()));
    around.last().unwrap_or(element)
}

/// Whether a wire element has others in it.
pub(super) fn has_parts(element: Xml) -> bool {
    children(element, "SubWireElement").next().is_some()
}

/// The wire elements without parts in one.
fn leaves<'a, 'i>(element: Xml<'a, 'i>) -> Vec<Xml<'a, 'i>> {
    let own = element.descendants().filter(|node| ELEMENTS.contains(&node.name()));
    own.filter(|node| !has_parts(*node)).collect()
}
