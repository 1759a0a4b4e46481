//! Options and result of an import.

use super::findings::Finding;

/// What the importer may be told.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Longest segment of the mesh and longest distance between the points of a `path`, m; above zero.
    pub max_segment: f64,
    /// Where the scenario begins, and where it goes.
    pub arrangement: Arrangement,
    /// In which order [`Arrangement::Assembly`] installs.
    pub order: Order,
    /// Name of the scenario; left out, the description or part number of the harness.
    pub name: Option<String>,
}

impl Default for Options {
    fn default() -> Self {
        Self { max_segment: 0.010, arrangement: Arrangement::Installed, order: Order::Outward, name: None }
    }
}

/// Where a scenario begins, and where it goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrangement {
    /// In the vehicle, as drawn.
    Installed,
    /// Flat on a formboard.
    Board,
    /// From the board into the vehicle, step by step.
    Assembly,
}

/// In which order connectors and clips are installed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Along the cable from the connector of the heaviest branch outward.
    Outward,
    /// Any; the same for equal seeds.
    Random(u64),
}

/// A scenario made from a KBL file.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// TOML text of the scenario.
    pub scenario: String,
    /// Everything odd in the file and what was done about it, equal things together.
    pub findings: Vec<Finding>,
}
