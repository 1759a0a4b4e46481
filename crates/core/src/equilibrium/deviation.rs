//! Distance of a branch from its drawn centre line.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Distance of the computed centre line of a branch from the drawn one: of each node from the nearest point of the
/// drawn line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Deviation {
    /// Half of the length of the branch is nearer than this, m.
    pub median: f64,
    /// Largest distance, m.
    pub max: f64,
    /// Arc length where it is largest, m.
    pub s: f64,
    /// Why it is larger than the diameter of the branch; `None` where it is not.
    pub cause: Option<DeviationCause>,
}

/// Why a branch does not lie where it is drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum DeviationCause {
    /// A constraint next to the place holds the cable at least half as far from the drawn line: the harness is held
    /// elsewhere than it is drawn.
    HeldElsewhere {
        /// Name of the constraint.
        constraint: String,
    },
    /// The constraints next to the place lie on the drawn line, and nothing holds the cable between them: with so few
    /// constraints it cannot keep the drawn shape.
    FewConstraints {
        /// Names of the constraints on both sides.
        between: [String; 2],
        /// Length of the cable between them, m.
        free_length: f64,
        /// Farthest that a point of a cable of this length can be from the straight line between both of them, m:
        /// `√(L² − c²)/2` with their distance c.
        room: f64,
    },
    /// Nothing holds the cable on one side of the place: its end is free.
    FreeEnd {
        /// Name of the constraint on the other side; `None` if there is none either.
        from: Option<String>,
        /// Length of the cable from that constraint to the place, m.
        free_length: f64,
    },
}

impl DeviationCause {
    /// Word used in results.
    pub fn word(&self) -> &'static str {
        match self {
            Self::HeldElsewhere { .. } => "held elsewhere",
            Self::FewConstraints { .. } => "few constraints",
            Self::FreeEnd { .. } => "free end",
        }
    }
}

/// Example: "too few constraints: none between `clip-1` and `plug-B`, 812 mm of cable that may lie up to 210 mm aside".
impl fmt::Display for DeviationCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::HeldElsewhere { constraint } => write!(f, "`{constraint}` holds it beside the drawn line"),
            Self::FewConstraints { between: [a, b], free_length, room } => write!(
                f,
                "too few constraints: none between `{a}` and `{b}`, {:.0} mm of cable that may lie up to {:.0} mm \
                 aside",
                1e3 * free_length,
                1e3 * room
            ),
            Self::FreeEnd { from: Some(from), free_length } => {
                write!(f, "free end: nothing holds it beyond `{from}`, {:.0} mm before this place", 1e3 * free_length)
            }
            Self::FreeEnd { from: None, .. } => f.write_str("nothing holds it"),
        }
    }
}
