//! Options and result of an import.

use super::findings::Finding;
use super::usage::Usage;
use std::collections::HashMap;

/// Options of the importer.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Longest segment of the mesh and longest distance between the points of a `path`, m; above zero.
    pub max_segment: f64,
    /// Accuracy of the mesh, as in `[mesh]` of a scenario; `None`: segments of [`Self::max_segment`].
    pub accuracy: Option<f64>,
    /// The initial and the final arrangement of the scenario.
    pub arrangement: Arrangement,
    /// Which part of the angles of the board joints have at rest, 0 to 1, if the scenario begins there: 1 if the
    /// harness is built flat and at rest on the board, 0 if its joints keep their drawn angles. `None`: 1 for
    /// [`Arrangement::Board`], 0.3 for [`Arrangement::Assembly`]: with 1 arms that rest far from where they are drawn
    /// have to bend within their joints.
    pub memory: Option<f64>,
    /// Order of installation of [`Arrangement::Assembly`].
    pub order: Order,
    /// The modules that are imported.
    pub selection: Selection,
    /// Name of the scenario; `None`: the description or part number of the harness.
    pub name: Option<String>,
    /// The file. The scenario names it if it is KBL, so that results can be written back into it.
    pub file: Option<Source>,
}

/// A harness file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Its name.
    pub name: String,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
}

impl Default for Options {
    fn default() -> Self {
        let (arrangement, order) = (Arrangement::Installed, Order::Outward);
        Self {
            max_segment: 0.010,
            accuracy: None,
            arrangement,
            memory: None,
            order,
            selection: Selection::All,
            name: None,
            file: None,
        }
    }
}

impl Options {
    /// [`Self::memory`], with its default.
    pub(super) fn memory_of_board(&self) -> f64 {
        self.memory.unwrap_or(if self.arrangement == Arrangement::Assembly { 0.3 } else { 1.0 })
    }
}

/// The initial and the final arrangement of a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrangement {
    /// In the vehicle, as drawn.
    Installed,
    /// Flat on a formboard.
    Board,
    /// From the board into the vehicle, step by step.
    Assembly,
}

/// Orders in which connectors and clips are installed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Along the cable from the connector of the heaviest branch outward.
    Outward,
    /// Random; the same for equal seeds.
    Random(u64),
}

/// Modules of a harness that are imported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Selection {
    /// All of them, as in a car with every option.
    All,
    /// Those of a variant, by name.
    Variant(String),
    /// These, by name.
    Modules(Vec<String>),
}

/// Modules and variants of a harness.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contents {
    /// Its modules.
    pub modules: Vec<Module>,
    /// Its variants.
    pub variants: Vec<Variant>,
}

/// A module: parts that a car has together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Module {
    /// Its name: the part number, where no other module has it.
    pub name: String,
    /// Its description.
    pub description: Option<String>,
    /// Code of the option that asks for it.
    pub option_code: Option<String>,
    /// Number of its parts: wires, connectors, coverings and others.
    pub parts: usize,
}

/// A variant: modules that make a harness together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variant {
    /// Its name.
    pub name: String,
    /// Names of its modules.
    pub modules: Vec<String>,
}

/// A scenario made from a harness file.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// TOML text of the scenario.
    pub scenario: String,
    /// Irregularities of the file and their treatment, equal ones together.
    pub findings: Vec<Finding>,
    /// What was done with each kind of element of the file.
    pub usage: Vec<Usage>,
    /// Its wires, in the order of the file; a cable has one for each core.
    pub wires: Vec<WireRun>,
    /// Where elements of the file are in the scenario, by their XML ids.
    pub places: HashMap<String, ElementPlace>,
}

/// Where an element of a file is in the scenario.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ElementPlace {
    /// At the vertex of this name.
    Vertex(String),
    /// On the branch of this name.
    Branch(String),
}

/// A wire on its way through the harness.
#[derive(Clone, Debug, PartialEq)]
pub struct WireRun {
    /// Its XML id.
    pub name: String,
    /// m².
    pub copper_area: Option<f64>,
    /// m.
    pub diameter: Option<f64>,
    /// Vertices where it ends.
    pub ends: Vec<String>,
    /// Length within the harness, without what it needs in connectors, m.
    pub length: f64,
}
