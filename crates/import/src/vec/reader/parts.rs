//! Occurrences of parts: what they are, what they weigh, and their numbers.

use super::{Geometry, ImportError, Placed, Quantity, Reader, Xml, child, child_text, children};
use crate::document::{Component, Fixing, Listed, ListedPlace};
use crate::vec::element::{NOTHING, joined, localized, role};
use crate::vec::places::Along;
use crate::xml::{title, words};
use wireloom_core::identity::Identity;

/// Whether an occurrence is a joint of wires within the harness.
fn is_splice(occurrence: Xml) -> bool {
    children(occurrence, "Role").any(|role| role.class() == "SpliceTerminalRole")
}

/// Roles of parts that let the cable slide along itself, by their references.
const SLIDING: [&str; 2] = ["GrommetSpecification", "CableDuctSpecification"];

/// Whether an occurrence holds the cable on its way, and whether it lets it slide.
fn holds(occurrence: Xml) -> Option<bool> {
    let slides = SLIDING.iter().any(|name| role(occurrence, name).is_some());
    (slides || role(occurrence, "FixingSpecification").is_some()).then_some(slides)
}

/// Words for what an occurrence is, as in other formats.
fn kind(occurrence: Xml, part: Option<Xml>) -> String {
    for (specification, kind) in [("WireProtectionSpecification", "wire protection"), ("FixingSpecification", "fixing")]
    {
        if role(occurrence, specification).is_some() {
            return kind.to_owned();
        }
    }
    let specific = |role: &Xml| !["PlaceableElementRole", "SpecificRole"].contains(&role.class());
    let class = children(occurrence, "Role").find(specific).map(|role| role.class().trim_end_matches("Role"));
    let class = class.or_else(|| part.and_then(|part| child_text(part, "PrimaryPartType")));
    match class.unwrap_or("Part") {
        "ConnectorHousing" => "connector".to_owned(),
        "SpliceTerminal" => "splice".to_owned(),
        "EEComponent" => "component".to_owned(),
        class if class.ends_with("Terminal") => "terminal".to_owned(),
        class => spaced(class),
    }
}

/// `CavityPlug` as "cavity plug".
fn spaced(class: &str) -> String {
    let mut words = String::new();
    for c in class.chars() {
        if c.is_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.extend(c.to_lowercase());
    }
    words
}

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// Specifications of an occurrence: those of its part, or those that a usage refers to.
    pub(super) fn specifications_of(&self, occurrence: Xml<'a, 'i>) -> Vec<Xml<'a, 'i>> {
        let part = child_text(occurrence, "Part").and_then(|part| self.specifications.get(part));
        let own = words(occurrence, "PartOrUsageRelatedSpecification");
        part.into_iter().flatten().copied().chain(own.filter_map(|id| self.file.ids.get(id).copied())).collect()
    }

    /// Mass of an occurrence, or its mass per length.
    pub(super) fn mass(&mut self, occurrence: Xml<'a, 'i>, quantity: Quantity) -> Result<Option<f64>, ImportError> {
        let all = self.specifications_of(occurrence);
        self.mass_of(&all, quantity)
    }

    /// Likewise, by some specifications. Of several masses the first one of the quantity counts.
    pub(super) fn mass_of(
        &mut self,
        specifications: &[Xml<'a, 'i>],
        quantity: Quantity,
    ) -> Result<Option<f64>, ImportError> {
        let technical = specifications.iter().filter(|own| own.class() == "GeneralTechnicalPartSpecification");
        let masses: Vec<Xml> = technical.flat_map(|own| children(*own, "MassInformation")).collect();
        let of_quantity = |mass: &&Xml<'a, 'i>| self.file.unit_of(**mass, "Value") == Some(quantity);
        let Some(&mass) = masses.iter().find(of_quantity).or_else(|| masses.first()) else { return Ok(None) };
        mass.parent().into_iter().for_each(|specification| self.file.mark(specification));
        self.file.value(mass, "Value", quantity)
    }

    /// A component at a node; `None` if it belongs to other modules, or holds the cable on its way.
    pub(super) fn component(
        &mut self,
        placed: &Along<'a, 'i>,
        geometry: &Geometry<'a, 'i>,
    ) -> Result<Option<Component>, ImportError> {
        let occurrence = placed.occurrence;
        if self.chosen.leaves_out(occurrence, None) || holds(occurrence).is_some() {
            return Ok(None);
        }
        self.file.mark(placed.placement);
        let id = occurrence.attribute("id").unwrap_or_default().to_owned();
        // What it weighs matters where it has a mass, not a mass per length.
        let masses = self.specifications_of(occurrence).into_iter().flat_map(|own| children(own, "MassInformation"));
        let has_mass =
            masses.collect::<Vec<_>>().into_iter().any(|mass| self.file.unit_of(mass, "Value") == Some(Quantity::Mass));
        let mass = if has_mass { self.mass(occurrence, Quantity::Mass)? } else { None };
        Ok(Some(Component {
            label: child_text(occurrence, "Identification").unwrap_or(&id).to_owned(),
            splice: is_splice(occurrence),
            placement: self.placement(occurrence, geometry)?,
            mass,
            id,
        }))
    }

    /// A fixing along a segment; `None` if it belongs to other modules, or holds nothing there, which is told.
    pub(super) fn fixing(
        &mut self,
        placed: &Along<'a, 'i>,
        geometry: &Geometry<'a, 'i>,
    ) -> Result<Option<Fixing>, ImportError> {
        let occurrence = placed.occurrence;
        if self.chosen.leaves_out(occurrence, None) {
            return Ok(None);
        }
        let id = occurrence.attribute("id").unwrap_or_default();
        let Some(slides) = holds(occurrence) else {
            let label = child_text(occurrence, "Identification").unwrap_or(id);
            let kind = kind(occurrence, self.file.target(occurrence, "Part"));
            self.file.findings.add_to(
                "parts that are no fixings, grommets or ducts sit along segments; they hold nothing there",
                format!("{id} `{label}` ({kind})"),
            );
            return Ok(None);
        };
        let special = |name| {
            let specification = role(occurrence, name).and_then(|role| self.file.target(role, name))?;
            self.file.mark(specification);
            child_text(specification, "SpecialPartType").map(str::to_ascii_uppercase)
        };
        let special = special("FixingSpecification").unwrap_or_default();
        self.file.mark(placed.placement);
        Ok(Some(Fixing {
            id: placed.placement.attribute("id").unwrap_or("fixing").to_owned(),
            of: Some(id.to_owned()),
            label: child_text(occurrence, "Identification").unwrap_or(id).to_owned(),
            at: placed.at,
            placement: self.placement(occurrence, geometry)?,
            duct: slides || ["DUCT", "GROMMET"].iter().any(|word| special.contains(word)),
        }))
    }

    /// Whether an occurrence holds the cable on its way.
    pub(super) fn holds(&self, occurrence: Xml<'a, 'i>) -> bool {
        holds(occurrence).is_some()
    }

    /// Identity of a part of the file.
    pub(super) fn identity(&mut self, part: Xml<'a, 'i>) -> Identity {
        self.file.keep(part);
        if let Some(known) = self.identities.get(&part.id()) {
            return known.clone();
        }
        let own = |name| child_text(part, name).filter(|text| !NOTHING.contains(text)).map(str::to_owned);
        let all = part.attribute("id").and_then(|id| self.specifications.get(id)).cloned().unwrap_or_default();
        let coloured: Vec<Xml> = all.into_iter().filter(|own| child(*own, "ColorInformation").is_some()).collect();
        coloured.iter().for_each(|own| self.file.keep(*own));
        let colours = coloured.into_iter().flat_map(|own| children(own, "ColorInformation"));
        let identity = Identity {
            part: own("PartNumber"),
            description: localized(part, "Description").map(str::to_owned),
            supplier: own("CompanyName"),
            colour: joined(colours),
        };
        self.identities.insert(part.id(), identity.clone());
        identity
    }

    /// Identity of the part of an occurrence.
    pub(super) fn identity_of(&mut self, occurrence: Xml<'a, 'i>) -> Identity {
        let part = self.file.target(occurrence, "Part");
        part.map(|part| self.identity(part)).unwrap_or_default()
    }

    /// All occurrences of parts but wires and modules.
    pub(super) fn read_listed(&mut self, placed: &Placed<'a, 'i>) -> Vec<Listed> {
        let plugs = self.plugs();
        let mut listed = Vec::new();
        for node in [self.all("Component"), self.all("PartUsage")].concat() {
            let is = |specification| role(node, specification).is_some();
            if self.chosen.leaves_out(node, None) || is("WireSpecification") || self.is_module(node) {
                continue;
            }
            self.file.keep(node);
            self.keep_specifications(node);
            let Some(id) = node.attribute("id").map(str::to_owned) else { continue };
            let ids: Vec<String> =
                node.descendants().filter_map(|node| node.attribute("id")).map(str::to_owned).collect();
            let mut places: Vec<ListedPlace> = Vec::new();
            for place in placed.listed.get(id.as_str()).into_iter().flatten() {
                places.push(place.listed());
            }
            places.extend(plugs.get(id.as_str()).into_iter().flatten().map(|(component, cavity)| ListedPlace::In {
                component: (*component).to_owned(),
                cavity: cavity.clone(),
            }));
            let label = child_text(node, "Identification").unwrap_or(&id).to_owned();
            let kind = kind(node, self.file.target(node, "Part"));
            let mut identity = self.identity_of(node);
            if identity.description.is_none() {
                identity.description = localized(node, "Description").map(str::to_owned);
            }
            listed.push(Listed { id, label, kind, identity, places, ids });
        }
        listed
    }

    /// Notes that the specifications that the roles of an occurrence refer to are kept: they say what it is.
    fn keep_specifications(&mut self, occurrence: Xml<'a, 'i>) {
        for role in children(occurrence, "Role") {
            let references = role.elements().filter(|own| own.name().ends_with("Specification"));
            for specification in references.filter_map(crate::xml::text).collect::<Vec<_>>() {
                if let Some(&specification) = self.file.ids.get(specification) {
                    self.file.keep(specification);
                }
            }
        }
    }

    /// Reports occurrences that are placed nowhere though their kind has a place: fixings, connectors.
    pub(super) fn note_unplaced(&mut self, placed: &Placed<'a, 'i>) {
        for node in self.all("Component") {
            let id = node.attribute("id").unwrap_or_default();
            if placed.listed.contains_key(id) || self.chosen.leaves_out(node, None) {
                continue;
            }
            let what = match () {
                () if holds(node).is_some() => "fixings are placed at no node and no segment; left out",
                () if role(node, "ConnectorHousingSpecification").is_some() => "connectors sit at no node; left out",
                () => continue,
            };
            let label = child_text(node, "Identification").unwrap_or(id);
            self.file.findings.add_to(what, format!("{} `{label}`", title(node)));
        }
    }
}
