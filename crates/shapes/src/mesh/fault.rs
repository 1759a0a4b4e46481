//! Faults of a mesh.

use wireloom_core::Vector;
use wireloom_core::registry::BuildError;

/// Fault of triangles that are not a body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshFault {
    /// There are no triangles.
    #[error("it has no triangles")]
    Empty,
    /// All triangles have no area.
    #[error("all its {triangles} triangles have no area")]
    Degenerate {
        /// Number of triangles.
        triangles: usize,
    },
    /// A triangle names a corner that is not there.
    #[error("triangle {triangle} has corner {corner}, of {corners}")]
    NoSuchCorner {
        /// Index of the triangle.
        triangle: usize,
        /// Index of the corner.
        corner: u32,
        /// Number of corners.
        corners: usize,
    },
    /// A coordinate is no number.
    #[error("corner {corner} has a coordinate that is not finite")]
    NotFinite {
        /// Index of the corner.
        corner: usize,
    },
    /// The body is implausibly large.
    #[error("it is {size:.1} m large")]
    Gigantic {
        /// Longest side of a box about it, m.
        size: f64,
    },
    /// It has holes, or is a sheet.
    #[error("its surface is open: {} a triangle on one side only, one of them at {}", some(*edges), place(at))]
    Open {
        /// Number of edges.
        edges: usize,
        /// Middle of one of them, m.
        at: Vector,
    },
    /// More than two triangles meet in an edge.
    #[error("{} more than two triangles, one of them, with {triangles}, at {}", some(*edges), place(at))]
    NonManifold {
        /// Number of edges.
        edges: usize,
        /// Number of triangles of one of them.
        triangles: usize,
        /// Middle of one of them, m.
        at: Vector,
    },
    /// Its sides cannot be told from each other.
    #[error(
        "its surface has one side only, like a Möbius strip; it closes on itself the wrong way round at {}",
        place(at)
    )]
    OneSided {
        /// Middle of an edge where this shows, m.
        at: Vector,
    },
}

fn some(edges: usize) -> String {
    if edges == 1 { "1 edge has".into() } else { format!("{edges} edges have") }
}

fn place(at: &Vector) -> String {
    format!("[{:.4}, {:.4}, {:.4}]", at.x, at.y, at.z)
}

impl MeshFault {
    /// Remedy.
    fn help(&self) -> String {
        match self {
            Self::Empty | Self::Degenerate { .. } => "export the body again, as a surface of triangles".into(),
            Self::NoSuchCorner { .. } | Self::NotFinite { .. } => "the file is damaged: export the body again".into(),
            Self::Gigantic { size } => format!(
                "at most {LARGEST} m are taken for meant; if the file is in millimetres, write scale = 0.001: {:.1} m",
                size * 1e-3
            ),
            Self::Open { .. } => {
                "close its holes where it is drawn; or write open = true for a sheet that is solid on both sides".into()
            }
            Self::NonManifold { .. } => {
                "export bodies that touch each other as files of their own, without walls between them; wireloom \
                 import step makes a file of each part of a STEP file"
                    .into()
            }
            Self::OneSided { .. } => "export the body again, as a surface with an inside and an outside".into(),
        }
    }
}

/// Size of a body, m, above which its units are taken to be wrong.
pub(crate) const LARGEST: f64 = 1000.0;

impl From<MeshFault> for BuildError {
    fn from(fault: MeshFault) -> Self {
        let key = if matches!(fault, MeshFault::Gigantic { .. }) { "scale" } else { "mesh" };
        BuildError::new(fault.to_string(), fault.help()).at(key)
    }
}
