//! State of a drag: one step, whose increments follow the newest target.

use super::snapshot::Snapshot;
use wireloom::geometry::{Pose, columns};
use wireloom::scenario::record::{Passed, Turned, Way, Written};
use wireloom::session::drag::{Goal, Turning, quaternion};

/// A drag.
pub(super) struct Drag {
    /// Name of its step.
    pub step: String,
    pub constraint: String,
    pub index: usize,
    pub turning: Option<Turning>,
    /// Whether it has rotated so far.
    pub turned: bool,
    /// Poses that it has passed: as recorded, and as reached.
    pub passed: Vec<(Passed, Pose)>,
    /// The target not reached yet.
    pub goal: Option<Goal>,
    /// Whether the drag ends at the target.
    pub ends: bool,
    /// Whether the last frame is not in equilibrium.
    pub unbalanced: bool,
    /// The snapshot before the drag.
    pub before: Snapshot,
}

impl Drag {
    /// Whether any increment has been recorded.
    pub fn has_begun(&self) -> bool {
        !self.passed.is_empty()
    }

    /// The step as recorded in the scenario.
    pub fn written(&self) -> Option<Written> {
        if self.passed.is_empty() {
            return None;
        }
        let place = |(passed, stood): &(Passed, Pose)| {
            let turn = || match self.turning? {
                Turning::Frame => Some(Turned::Orientation(quaternion(&stood.orientation))),
                Turning::Tangent => Some(Turned::Tangent(columns(&stood.orientation)[2].into())),
            };
            let turn = if self.turned { passed.turn.or_else(turn) } else { None };
            Passed { turn, ..*passed }
        };
        let way = Way { constraint: self.constraint.clone(), places: self.passed.iter().map(place).collect() };
        Some(Written { name: self.step.clone(), way: Some(way), ..Written::default() })
    }
}
