//! Errors of the import.

use super::unit::Quantity;
use wireloom_scenario::MAX_SEGMENTS;
use wireloom_scenario::fault::did_you_mean;

/// Errors of the import. Lines and columns count from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The text is not well-formed XML.
    #[error("{line}:{column}: not well-formed XML: {fault}")]
    Xml {
        /// Line.
        line: u32,
        /// Column.
        column: u32,
        /// Message of the parser.
        fault: String,
    },
    /// The root element is not that of a file of the format.
    #[error("{line}:{column}: the root element is `{found}`; a {format} file has `{expected}` there{help}")]
    Root {
        /// Line.
        line: u32,
        /// Column.
        column: u32,
        /// Name of the root element.
        found: String,
        /// The format.
        format: &'static str,
        /// Name of the root element of the format.
        expected: &'static str,
        /// The command that reads the file.
        help: String,
    },
    /// An element lacks a required child or attribute.
    #[error("{line}:{column}: {element} has no `{missing}`; {right}")]
    Missing {
        /// Line.
        line: u32,
        /// Column.
        column: u32,
        /// The element, with its id.
        element: String,
        /// Name of the missing child or attribute.
        missing: String,
        /// The correction.
        right: String,
    },
    /// A reference to nothing, or to the wrong kind of element.
    #[error("{line}:{column}: `{found}` is not the id of a `{expected}` of this file ({actual})")]
    Reference {
        /// Line.
        line: u32,
        /// Column.
        column: u32,
        /// The reference in the file.
        found: String,
        /// Kind of element that it should refer to.
        expected: String,
        /// Description of its target.
        actual: String,
    },
    /// A number cannot be read, or lies outside its range.
    #[error("{line}:{column}: `{found}` in `{element}` is not {expected}")]
    Number {
        /// Line.
        line: u32,
        /// Column.
        column: u32,
        /// Name of the element.
        element: String,
        /// The text in the file.
        found: String,
        /// The correction.
        expected: String,
    },
    /// Two elements have the same id.
    #[error("{line}:{column}: the id `{id}` is already that of the element at line {first_line}; ids must differ")]
    DuplicateId {
        /// Line of the second.
        line: u32,
        /// Column of the second.
        column: u32,
        /// The id.
        id: String,
        /// Line of the first.
        first_line: u32,
    },
    /// A segment starts and ends at the same node.
    #[error("{line}:{column}: segment `{id}` starts and ends at node `{node}`; a branch joins two different vertices")]
    Ring {
        /// Line.
        line: u32,
        /// Column.
        column: u32,
        /// Id of the segment.
        id: String,
        /// Id of the node.
        node: String,
    },
    /// The file has no segments.
    #[error("{line}:{column}: the file has no `{element}`: there is no topology to import (a list of parts alone?)")]
    NoSegments {
        /// Line.
        line: u32,
        /// Column.
        column: u32,
        /// Element of a segment.
        element: &'static str,
    },
    /// The file has a topology, and no geometry.
    #[error(
        "{line}:{column}: the file has no 3D geometry (GeometryNode3D), and does not say where its segments lie; as a \
         harness on a board (--as board) their lengths are enough"
    )]
    NoGeometry {
        /// Line of the first segment.
        line: u32,
        /// Column of the first segment.
        column: u32,
    },
    /// There is no module or variant of a name.
    #[error("there is no {what} \"{found}\"; {help}")]
    NoChoice {
        /// Module or variant.
        what: &'static str,
        /// The name.
        found: String,
        /// The names that there are.
        help: String,
    },
    /// A variant without modules.
    #[error("{line}:{column}: the variant \"{name}\" has no modules; choose some by their names")]
    EmptyVariant {
        /// Line.
        line: u32,
        /// Column.
        column: u32,
        /// Its name.
        name: String,
    },
    /// The chosen modules have no wires.
    #[error("the chosen modules have no wires that run through a segment; choose more of them")]
    NoWires,
    /// The harness has too many segments, or too long a branch.
    #[error(
        "the harness has {segments} segments of {max_segment} m, and its longest branch, `{id}`, has {length} m; a \
         scenario has at most {MAX_SEGMENTS} segments and branches of at most {longest} m: correct the lengths, or use \
         longer segments",
        longest = Quantity::Length.range()[1]
    )]
    TooLarge {
        /// Id of the longest segment of the file.
        id: String,
        /// Its length, m.
        length: f64,
        /// The option `max_segment`, m.
        max_segment: f64,
        /// Number of segments of that length.
        segments: f64,
    },
    /// The option `max_segment` is out of range.
    #[error("max_segment is {found}; it must be finite and above 0 m")]
    MaxSegment {
        /// Value found, m.
        found: f64,
    },
    /// The memory of the board is none.
    #[error("the memory must be between 0 (as drawn) and 1 (as on the board), not {found}")]
    Memory {
        /// As given.
        found: f64,
    },
}

impl ImportError {
    pub(super) fn choice<'n>(
        what: &'static str,
        found: &str,
        known: impl IntoIterator<Item = &'n str> + Clone,
    ) -> Self {
        Self::NoChoice { what, found: found.to_owned(), help: did_you_mean(found, known) }
    }
}
