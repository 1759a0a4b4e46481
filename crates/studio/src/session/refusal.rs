//! Refusals that several requests share.

use wireloom::session::Refusal;

/// The refusal while there is no initial equilibrium.
pub(super) fn no_start() -> Refusal {
    Refusal::new("no initial equilibrium was found", "change a setting, or undo the last change")
}
