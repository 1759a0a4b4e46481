//! Part numbers and the like, components, and wires with their signals and cavities: what does not act is kept.

use super::{Location, Reader, Xml, around, child, child_text, children, is_occurrence, words};
use crate::document::{End, Listed, ListedPlace, Wiring};
use std::collections::{HashMap, HashSet};
use wireloom_core::identity::Identity;

/// Texts that stand for no value.
const NOTHING: [&str; 3] = ["-", "NotDefined", "/OVMM"];

/// Wires and cores of cables.
const WIRES: [&str; 4] = ["General_wire_occurrence", "Wire_occurrence", "Special_wire_occurrence", "Core_occurrence"];

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// Identity of a part of the file. A core of a cable has the part number of the cable.
    pub(super) fn identity(&mut self, part: Xml<'a, 'i>) -> Identity {
        self.file.keep(part);
        if let Some(known) = self.identities.get(&part.id()) {
            return known.clone();
        }
        let cable = part.parent().filter(|parent| parent.name() == "General_wire");
        let cable = cable.map(|cable| self.identity(cable)).unwrap_or_default();
        let own = |name| child_text(part, name).filter(|text| !NOTHING.contains(text)).map(str::to_owned);
        let identity = Identity {
            part: own("Part_number").or(cable.part),
            description: own("Description").or(cable.description),
            supplier: own("Company_name").or(cable.supplier),
            colour: colour(part),
        };
        self.identities.insert(part.id(), identity.clone());
        identity
    }

    /// Identity of the part of an occurrence, or of the occurrence that it is a part of.
    pub(super) fn identity_of(&mut self, occurrence: Xml<'a, 'i>) -> Identity {
        for node in around(occurrence) {
            let Some(part) = self.file.target(node, "Part").filter(|part| child(*part, "Part_number").is_some()) else {
                continue;
            };
            return self.identity(part);
        }
        Identity::default()
    }

    /// All occurrences of parts but wires, wherever they stand in the file.
    pub(super) fn read_listed(&mut self, root: Xml<'a, 'i>) -> Vec<Listed> {
        let places = places(root);
        let mut listed = Vec::new();
        for node in root.descendants().filter(|node| is_occurrence(node) && !WIRES.contains(&node.name())) {
            if self.leaves_out(node) {
                continue;
            }
            self.file.keep(node);
            let ids: Vec<String> =
                node.descendants().filter_map(|node| node.attribute("id")).map(str::to_owned).collect();
            let Some(id) = node.attribute("id").map(str::to_owned) else { continue };
            let kind = match child_text(node, "Usage") {
                Some("splice") => "splice".to_owned(),
                _ => node.name().trim_end_matches("_occurrence").replace('_', " ").to_lowercase(),
            };
            let mut own: Vec<ListedPlace> =
                ids.iter().flat_map(|id| places.get(id.as_str()).into_iter().flatten()).map(Place::listed).collect();
            own.extend(within_another(node, self.holders(node)));
            let label = child_text(node, "Id").unwrap_or(&id).to_owned();
            let mut identity = self.identity_of(node);
            if identity.description.is_none() {
                identity.description = child_text(node, "Description").map(str::to_owned);
            }
            listed.push(Listed { id, label, kind, identity, places: own, ids });
        }
        listed
    }

    /// Whether an occurrence is left out, or all occurrences of the part that it stands in.
    pub(super) fn leaves_out(&self, node: Xml<'a, 'i>) -> bool {
        let holders = self.holders(node);
        let all = !holders.is_empty() && holders.iter().all(|own| self.chosen.leaves_out(*own, None));
        all || self.chosen.leaves_out(node, None)
    }

    /// Occurrences of the part that a node stands in. What stands in an assembly is at each occurrence of it.
    fn holders(&self, node: Xml<'a, 'i>) -> &[Xml<'a, 'i>] {
        let part = around(node).nth(1).and_then(|parent| parent.attribute("id"));
        part.and_then(|id| self.occurrences.get(id)).map_or(&[], Vec::as_slice)
    }

    /// Wires and cores with their connections.
    pub(super) fn read_wiring(&mut self, root: Xml<'a, 'i>) -> Vec<Wiring> {
        let mut segments: HashMap<&str, Vec<String>> = HashMap::new();
        for routing in children(root, "Routing") {
            let run = words(routing, "Segments").map(str::to_owned);
            segments.entry(child_text(routing, "Routed_wire").unwrap_or_default()).or_default().extend(run);
        }
        let of = |id: Option<&str>| id.and_then(|id| segments.get(id)).cloned().unwrap_or_default();
        let (mut wiring, mut connected) = (Vec::new(), HashSet::new());
        for connection in children(root, "Harness").flat_map(|harness| children(harness, "Connection")) {
            let wire = self.file.target(connection, "Wire");
            if wire.is_some_and(|wire| self.chosen.leaves_out(wire, Some(connection))) {
                connected.extend(wire.map(|wire| wire.id()));
                self.file.left_out.insert(connection.id());
                continue;
            }
            self.file.keep(connection);
            let id = connection.attribute("id");
            let mut run = of(id);
            if run.is_empty() {
                run = of(wire.and_then(|wire| wire.attribute("id")));
            }
            let ends: Vec<Xml> = children(connection, "Extremities").collect();
            let ends = ends.into_iter().map(|end| self.end(end)).collect();
            let label = child_text(connection, "Id").or(id).unwrap_or_default().to_owned();
            let signal = child_text(connection, "Signal_name").map(str::to_owned);
            let own = wire.map(|wire| self.wire(wire)).unwrap_or_default();
            // Cores of a cable that is connected as a whole are connected with it.
            connected.extend(wire.iter().flat_map(|wire| wire.descendants()).map(|node| node.id()));
            wiring.push(Wiring { label, signal, number: own.0, identity: own.1, ends, segments: run });
        }
        let bare = |node: &Xml| {
            WIRES.contains(&node.name())
                && !connected.contains(&node.id())
                && children(*node, "Core_occurrence").next().is_none()
        };
        for wire in root.descendants().filter(bare) {
            if self.leaves_out(wire) {
                continue;
            }
            let (id, (number, identity)) = (wire.attribute("id"), self.wire(wire));
            let label = id.unwrap_or_default().to_owned();
            wiring.push(Wiring { label, signal: None, number, identity, ends: Vec::new(), segments: of(id) });
        }
        wiring
    }

    /// Number and identity of a wire or core.
    fn wire(&mut self, wire: Xml<'a, 'i>) -> (Option<String>, Identity) {
        self.file.keep(wire);
        // A core stands in its cable.
        wire.parent().into_iter().for_each(|parent| self.file.keep(parent));
        let number = child_text(wire, "Wire_number").or_else(|| child_text(wire, "Special_wire_id"));
        let part = self.file.target(wire, "Part");
        (number.map(str::to_owned), part.map(|part| self.identity(part)).unwrap_or_default())
    }

    fn end(&mut self, extremity: Xml<'a, 'i>) -> End {
        let mut end = End::default();
        let Some(contact) = self.file.target(extremity, "Contact_point") else { return end };
        end.within = around(contact).filter_map(|node| node.attribute("id")).map(str::to_owned).collect();
        let cavity = self.file.target(contact, "Contacted_cavity");
        end.cavity = cavity.and_then(|cavity| self.cavity_number(cavity));
        let parts = child_text(contact, "Associated_parts").unwrap_or_default();
        for occurrence in
            parts.split_whitespace().filter_map(|reference| self.file.ids.get(reference).copied()).collect::<Vec<_>>()
        {
            let number = self.identity_of(occurrence).part;
            if occurrence.name() == "Cavity_seal_occurrence" {
                end.seal = number;
            } else {
                end.terminal = number;
            }
        }
        end
    }

    /// Number of a cavity of a connector, which stands in the housing's part.
    fn cavity_number(&self, cavity: Xml<'a, 'i>) -> Option<String> {
        let part = self.file.target(cavity, "Part")?;
        child_text(part, "Cavity_number").map(str::to_owned)
    }
}

/// Colour of a wire or part: its colours, the ground colour first.
fn colour(part: Xml) -> Option<String> {
    let named = ["Cover_colour", "Core_colour"].into_iter().flat_map(|name| children(part, name));
    let values = named.filter_map(|colour| child_text(colour, "Colour_value"));
    let single = ["Housing_colour", "Colour"].into_iter().filter_map(|name| child_text(part, name));
    let all: Vec<&str> = values.chain(single).filter(|colour| !NOTHING.contains(colour)).collect();
    (!all.is_empty()).then(|| all.join("/"))
}

/// The other occurrences that one belongs to: the terminal of a ring terminal's housing, or those of the part that it
/// stands in.
fn within_another(node: Xml, holders: &[Xml]) -> Vec<ListedPlace> {
    let of = |component: &str| ListedPlace::In { component: component.to_owned(), cavity: None };
    if child_text(node, "Usage") == Some("ring terminal") {
        let terminal = child(node, "Contact_points").and_then(|contact| words(contact, "Associated_parts").next());
        return terminal.into_iter().map(of).collect();
    }
    holders.iter().filter_map(|holder| holder.attribute("id")).map(of).collect()
}

/// A place that refers to an occurrence.
enum Place<'a> {
    Node(&'a str),
    Segment { id: &'a str, from: Option<Location>, to: Option<Location> },
    In { component: &'a str, cavity: Option<&'a str> },
}

impl Place<'_> {
    fn listed(&self) -> ListedPlace {
        match *self {
            Self::Node(id) => ListedPlace::Node(id.to_owned()),
            Self::Segment { id, from, to } => ListedPlace::Segment { id: id.to_owned(), from, to },
            Self::In { component, cavity } => {
                ListedPlace::In { component: component.to_owned(), cavity: cavity.map(str::to_owned) }
            }
        }
    }
}

/// Places that refer to occurrences, by their ids.
fn places<'a>(root: Xml<'a, '_>) -> HashMap<&'a str, Vec<Place<'a>>> {
    let mut places: HashMap<&str, Vec<Place>> = HashMap::new();
    for node in children(root, "Node") {
        let Some(id) = node.attribute("id") else { continue };
        for reference in words(node, "Referenced_components") {
            places.entry(reference).or_default().push(Place::Node(id));
        }
    }
    let relative =
        |node: Xml, name| child_text(node, name)?.parse().ok().filter(|f: &f64| f.is_finite()).map(Location::Relative);
    for segment in children(root, "Segment") {
        let Some(id) = segment.attribute("id") else { continue };
        for assignment in children(segment, "Fixing_assignment") {
            let Some(reference) = child_text(assignment, "Fixing") else { continue };
            let from = relative(assignment, "Location");
            places.entry(reference).or_default().push(Place::Segment { id, from, to: from });
        }
        for area in children(segment, "Protection_area") {
            let Some(reference) = child_text(area, "Associated_protection") else { continue };
            let (from, to) = (relative(area, "Start_location"), relative(area, "End_location"));
            places.entry(reference).or_default().push(Place::Segment { id, from, to });
        }
    }
    let ids: HashMap<&str, Xml> = root.descendants().filter_map(|node| Some((node.attribute("id")?, node))).collect();
    for cavity in root.descendants().filter(|node| node.name() == "Cavities") {
        let Some(plug) = child_text(cavity, "Associated_plug") else { continue };
        let occurrence = cavity.ancestors().find(is_occurrence);
        let Some(component) = occurrence.and_then(|node| node.attribute("id")) else { continue };
        let part = child_text(cavity, "Part").and_then(|reference| ids.get(reference));
        let cavity = part.and_then(|part| child_text(*part, "Cavity_number"));
        places.entry(plug).or_default().push(Place::In { component, cavity });
    }
    places
}
