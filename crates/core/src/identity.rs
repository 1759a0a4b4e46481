//! Identity of the parts of a harness: what drawings and parts lists call them. Nothing of it changes an equilibrium.

use serde::{Deserialize, Serialize};
use std::fmt;

/// What a parts list says of a part.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Part number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Description.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// Company that supplies it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub supplier: Option<String>,
    /// Colour.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colour: Option<String>,
}

impl Identity {
    /// Whether nothing is known.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Example: "8K0 971 824, cable guide (supplier GCMC, black)".
impl fmt::Display for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named: Vec<&str> = [&self.part, &self.description].into_iter().flatten().map(String::as_str).collect();
        f.write_str(&named.join(", "))?;
        let supplier = self.supplier.as_ref().map(|supplier| format!("supplier {supplier}"));
        let more: Vec<String> = supplier.into_iter().chain(self.colour.clone()).collect();
        match (named.is_empty(), more.is_empty()) {
            (_, true) => Ok(()),
            (true, false) => f.write_str(&more.join(", ")),
            (false, false) => write!(f, " ({})", more.join(", ")),
        }
    }
}

/// Kinds of parts of the model that can have an identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Identified {
    /// A branch.
    Branch,
    /// A section.
    Section,
    /// A joint.
    Joint,
    /// A constraint.
    Constraint,
    /// An obstacle.
    Obstacle,
}

impl Identified {
    /// Word for one of them.
    pub fn word(self) -> &'static str {
        match self {
            Self::Branch => "branch",
            Self::Section => "section",
            Self::Joint => "joint",
            Self::Constraint => "constraint",
            Self::Obstacle => "obstacle",
        }
    }
}

/// A part of the model with its identity.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// What it is.
    pub of: Identified,
    /// Its name.
    pub name: String,
    /// Its identity.
    #[serde(flatten)]
    pub identity: Identity,
}

/// A component of the harness that is no part of the model: it is listed, and does not act.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Component {
    /// Name.
    pub name: String,
    /// What it is, such as "cavity plug".
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// Its identity.
    #[serde(flatten)]
    pub identity: Identity,
    /// Constraint or component that it belongs to, such as the connector that it closes a cavity of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub connector: Option<String>,
    /// Cavity of that connector.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cavity: Option<String>,
    /// Vertex where it sits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertex: Option<String>,
    /// Branch where it sits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub branch: Option<String>,
    /// Arc length where it begins, m; `None`: at the start of the branch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// Arc length where it ends, m; `None`: at the end of the branch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
}

/// End of a wire.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WireEnd {
    /// Constraint or component in which it ends: a connector, a splice, a terminal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub connector: Option<String>,
    /// Cavity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cavity: Option<String>,
    /// Part number of the terminal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terminal: Option<String>,
    /// Part number of the seal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seal: Option<String>,
}

/// An electrical connection: a wire, or a core of a cable, from one cavity to another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Connection {
    /// Name.
    pub name: String,
    /// Signal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signal: Option<String>,
    /// Identity of the wire.
    #[serde(flatten)]
    pub identity: Identity,
    /// Number of the wire in the harness, or the name of the core.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wire: Option<String>,
    /// Its ends.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ends: Vec<WireEnd>,
    /// Branches through which it runs, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub branches: Vec<String>,
    /// Sum of the unstressed lengths of these branches, m.
    pub length: f64,
}

/// The KBL file that a scenario was imported from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KblFile {
    /// Its name.
    pub file: String,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
    /// The parts of the model that come from one of its elements: branches from segments, constraints from assignments
    /// of fixings.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub elements: Vec<Element>,
}

/// A part of the model, and the element of a KBL file that it comes from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Element {
    /// What it is.
    pub of: Identified,
    /// Its name.
    pub name: String,
    /// Id of the element.
    pub id: String,
}

/// All identities of a harness.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identities {
    /// Parts of the model that have one, by kind, in the order of the scenario.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<Part>,
    /// Components that are no parts of the model.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub components: Vec<Component>,
    /// Connections.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub connections: Vec<Connection>,
    /// What the sections in use are made of, of those whose wires are given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cross_sections: Vec<CrossSection>,
    /// Where it was imported from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kbl: Option<KblFile>,
}

/// What a section is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CrossSection {
    /// Name of the section.
    pub section: String,
    /// Its wires.
    pub wires: Vec<WiresOfType>,
    /// Diameter of all wires together, by their fill factor, m.
    pub wires_diameter: f64,
    /// Its coverings, from the inside.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub coverings: Vec<CoveringOfSection>,
}

/// Wires of one type in a section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WiresOfType {
    /// Name of the type.
    #[serde(rename = "type")]
    pub kind: String,
    /// Their number.
    pub count: usize,
    /// Diameter of one of them, m.
    pub diameter: f64,
}

/// A covering in a section. Its diameters are those where all of the coverings lie.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoveringOfSection {
    /// Name.
    pub name: String,
    /// Fraction of the length that it covers.
    pub share: f64,
    /// Inner diameter, m.
    pub inner: f64,
    /// Outer diameter, m.
    pub outer: f64,
}

impl Identities {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The identity of a part of the model.
    pub fn find(&self, of: Identified, name: &str) -> Option<&Identity> {
        self.parts.iter().find(|part| part.of == of && part.name == name).map(|part| &part.identity)
    }
}
