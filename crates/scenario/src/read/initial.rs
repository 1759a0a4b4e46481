//! Reads the pose of the rest shape.

use super::entry::Entry;
use super::names::{Names, lookup};
use super::places::facing;
use crate::scenario::Facing;
use wireloom_core::rotation::{frame_from, orthogonal};
use wireloom_core::steps::Initial;
use wireloom_core::{Pose, Vector};

/// The pose of the rest shape; by default along world x with d1 along world z.
pub(crate) fn initial(entry: &Entry<'_>, names: &mut Names<'_>) -> Option<Initial> {
    let position = entry.vector("position").unwrap_or_default();
    let orientation = match facing(entry) {
        Facing::Left => frame_from(&Vector::x(), &Vector::z()),
        Facing::Tangent(tangent) => frame_from(&tangent, &orthogonal(&tangent)),
        Facing::Orientation(orientation) => Some(orientation),
    };
    let branch = entry
        .word("branch")
        .and_then(|branch| lookup(entry, "branch", &names.branches, branch, entry.span_of("branch")).copied());
    names.broken |= branch.is_none();
    Some(Initial { branch: branch?, pose: Pose { position, orientation: orientation? } })
}
