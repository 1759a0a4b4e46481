//! Errors of writing back.

use crate::error::ImportError;

/// Why a result cannot be written into a KBL file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] ImportError),
    /// No branch comes from a segment.
    #[error("no branch of the result has a `kbl`, the id of its segment: import the KBL file anew, or add these keys")]
    NoPartner,
    /// Branches come from segments that the file does not have.
    #[error(
        "the file has no segments {}: it is not the one that the scenario was imported from, or `kbl` of these \
         branches is wrong",
        .0.iter().map(|[id, branch]| format!("`{id}` (of branch `{branch}`)")).collect::<Vec<_>>().join(", ")
    )]
    Unknown(Vec<[String; 2]>),
    /// Branches of one segment that do not continue each other.
    #[error(
        "branches `{}` come from segment `{segment}` but do not run on from one to the next: give `kbl` only to \
         branches that together are the segment, from its start to its end",
        .branches.join("`, `")
    )]
    Split {
        /// The segment.
        segment: String,
        /// The branches.
        branches: Vec<String>,
    },
    /// Branches that end at one node do not end at one point.
    #[error(
        "branches `{}` and `{}` end at node `{node}` of the file but {:.3} mm apart: a node of KBL is a point, so arms \
         with an `offset`, and branches that were turned round or lead elsewhere, cannot be written",
        .branches[0], .branches[1], .distance * 1e3
    )]
    Apart {
        /// The node.
        node: String,
        /// Two of the branches.
        branches: [String; 2],
        /// m.
        distance: f64,
    },
    /// A branch has no shape.
    #[error("the result has no finite shape of branch `{0}`")]
    NotFinite(String),
    /// The tolerance cannot be kept.
    #[error(
        "the centre line of segment `{segment}` cannot be fitted to {} mm: the finest curve is {:.6} mm away; give a \
         larger tolerance", .tolerance * 1e3, .distance * 1e3
    )]
    Tolerance {
        /// The segment.
        segment: String,
        /// As asked, m.
        tolerance: f64,
        /// As reached, m.
        distance: f64,
    },
}
