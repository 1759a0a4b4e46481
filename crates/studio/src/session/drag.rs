//! State of a drag: one step, whose increments follow the newest target.

use super::snapshot::Snapshot;
use wireloom::session::drag::{self, Goal};

/// A drag.
pub(super) struct Drag {
    /// What is recorded of it.
    pub motion: drag::Drag,
    /// The target not reached yet.
    pub goal: Option<Goal>,
    /// Whether the drag ends at the target.
    pub ends: bool,
    /// Whether the last frame is not in equilibrium.
    pub unbalanced: bool,
    /// The snapshot before the drag.
    pub before: Snapshot,
}
