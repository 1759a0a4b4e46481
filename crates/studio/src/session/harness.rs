//! What the studio asks of a harness.

use wireloom::geometry::Pose;
use wireloom::harness::{AttachedConstraint, Network};
use wireloom::parts::Action;

/// Whether the target of an initially active constraint changes during the first step.
pub(super) fn tightens_in_first_step(network: &Network) -> bool {
    let changes = |constraint: &AttachedConstraint| match constraint.model.action() {
        Action::Prescribed(_) => {
            let base = Pose::identity();
            constraint.model.target(&base, 0.0) != constraint.model.target(&base, 1.0)
        }
        // Only the constraint itself knows how it depends on the progress.
        _ => true,
    };
    network.constraints.iter().any(|constraint| constraint.from_start && changes(constraint))
}
