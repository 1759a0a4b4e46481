//! Wires with what they connect: signals, cavities, terminals and seals are kept.

use super::wires::has_parts;
use super::{Reader, Xml, child, child_text, children, element};
use crate::document::{End, Wiring};
use crate::xml::words;
use std::collections::HashMap;
use wireloom_core::identity::Identity;

/// The id of a connector, and the number of one of its cavities.
type Plugged<'a> = (&'a str, Option<String>);

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// Wires and cores with their connections.
    pub(super) fn read_wiring(&mut self) -> Vec<Wiring> {
        let mut segments: HashMap<&str, Vec<String>> = HashMap::new();
        for routing in self.all("Routing") {
            let path = child(routing, "Path");
            let run = path.into_iter().flat_map(|path| words(path, "Segment")).map(str::to_owned);
            segments.entry(child_text(routing, "RoutedElement").unwrap_or_default()).or_default().extend(run);
        }
        let mut mountings: HashMap<&str, (Xml, Xml)> = HashMap::new();
        for contact in self.all("ContactPoint") {
            for mounting in children(contact, "WireMounting") {
                for end in words(mounting, "ReferencedWireEnd") {
                    mountings.entry(end).or_insert((contact, mounting));
                }
            }
        }
        let mut wiring = Vec::new();
        for wire in self.all("WireElementReference") {
            // A cable of which the cores are referred to, too, is listed by its cores.
            let element = self.file.target(wire, "ReferencedWireElement");
            let others = wire.parent().is_some_and(|role| children(role, "WireElementReference").nth(1).is_some());
            if self.chosen.leaves_out(wire, None) || (others && element.is_some_and(has_parts)) {
                continue;
            }
            self.file.keep(wire);
            let id = wire.attribute("id");
            let connection = words(wire, "Connection").find_map(|id| self.file.ids.get(id).copied());
            connection.into_iter().for_each(|own| self.file.keep(own));
            let routed = id.and_then(|id| segments.get(id));
            let of_connection = || connection.and_then(|own| segments.get(own.attribute("id")?));
            let run = routed.or_else(of_connection).cloned().unwrap_or_default();
            let of = |node: Option<Xml<'a, 'i>>| node.and_then(|node| child_text(node, "Identification"));
            let number = of(Some(wire));
            let label = of(connection).or(number).or(id).unwrap_or_default().to_owned();
            let signal = [Some(wire), connection].into_iter().flatten().find_map(|own| self.signal(own));
            let ends: Vec<Xml> = children(wire, "WireEnd").collect();
            let ends = ends.into_iter().filter_map(|end| mountings.get(end.attribute("id")?).copied());
            let ends = ends.map(|(contact, mounting)| self.end(contact, mounting)).collect();
            let identity = self.wire_identity(wire, element);
            let number = number.filter(|number| *number != label).map(str::to_owned);
            wiring.push(Wiring { label, signal, number, identity, ends, segments: run });
        }
        wiring
    }

    /// Name of the signal of a wire or a connection.
    fn signal(&mut self, node: Xml<'a, 'i>) -> Option<String> {
        let signal = self.file.target(node, "Signal")?;
        self.file.keep(signal);
        child_text(signal, "SignalName").or_else(|| child_text(signal, "Identification")).map(str::to_owned)
    }

    /// Identity of a wire: that of its part, with the colours of the insulation of its element.
    fn wire_identity(&mut self, wire: Xml<'a, 'i>, element: Option<Xml<'a, 'i>>) -> Identity {
        const COLOURS: [&str; 3] = ["BaseColor", "FirstIdentificationColor", "SecondIdentificationColor"];
        let occurrence = wire.ancestors().find(element::is_occurrence);
        let mut identity = occurrence.map(|own| self.identity_of(own)).unwrap_or_default();
        let specification = element.and_then(|own| self.file.target(own, "WireElementSpecification"));
        let insulation = specification.and_then(|own| self.file.target(own, "InsulationSpecification"));
        if let Some(insulation) = insulation {
            self.file.keep(insulation);
            let colours = COLOURS.into_iter().flat_map(|name| children(insulation, name));
            identity.colour = element::joined(colours).or(identity.colour);
        }
        identity
    }

    /// The end of a wire that is mounted at a contact point.
    fn end(&mut self, contact: Xml<'a, 'i>, mounting: Xml<'a, 'i>) -> End {
        self.file.keep(contact);
        let mut end = End::default();
        let cavity = children(contact, "CavityMounting").flat_map(|own| words(own, "EquippedCavityRef")).next();
        if let Some(&cavity) = cavity.and_then(|id| self.file.ids.get(id)) {
            // From the cavity to the occurrence of its connector.
            for node in cavity.ancestors().filter(|node| node.attribute("id").is_some()) {
                end.within.extend(node.attribute("id").map(str::to_owned));
                if element::is_occurrence(&node) {
                    break;
                }
            }
            end.cavity = self.cavity_number(cavity);
        }
        let terminal = self.file.target(contact, "MountedTerminal");
        end.terminal = terminal.and_then(|role| self.number_of(role));
        // A terminal without a housing, as a ring terminal, is what the wire ends in.
        if end.within.is_empty() {
            let occurrence = terminal.and_then(|role| role.ancestors().find(element::is_occurrence));
            end.within.extend(occurrence.and_then(|own| own.attribute("id")).map(str::to_owned));
        }
        let seal = self.file.target(mounting, "MountedCavitySeal");
        end.seal = seal.and_then(|role| self.number_of(role));
        end
    }

    /// Number of a cavity, which stands in the specification of its connector.
    fn cavity_number(&mut self, cavity: Xml<'a, 'i>) -> Option<String> {
        let own = self.file.target(cavity, "ReferencedCavity");
        let number = own.and_then(|own| child_text(own, "CavityNumber"));
        number.or_else(|| child_text(cavity, "Identification")).map(str::to_owned)
    }

    /// Part number of the occurrence that has a role.
    fn number_of(&mut self, role: Xml<'a, 'i>) -> Option<String> {
        let occurrence = role.ancestors().find(element::is_occurrence)?;
        self.identity_of(occurrence).part
    }

    /// Connectors and cavities of cavity plugs, by the ids of these.
    pub(super) fn plugs(&mut self) -> HashMap<&'a str, Vec<Plugged<'a>>> {
        let mut plugs: HashMap<&str, Vec<Plugged>> = HashMap::new();
        for role in self.all("CavityPlugRole") {
            let occurrence = role.ancestors().find(element::is_occurrence);
            let Some(plug) = occurrence.and_then(|own| own.attribute("id")) else { continue };
            for id in words(role, "PluggedCavityRef").collect::<Vec<_>>() {
                let Some(&cavity) = self.file.ids.get(id) else { continue };
                let connector = cavity.ancestors().find(element::is_occurrence).and_then(|own| own.attribute("id"));
                let number = self.cavity_number(cavity);
                plugs.entry(plug).or_default().extend(connector.map(|connector| (connector, number)));
            }
        }
        plugs
    }
}
