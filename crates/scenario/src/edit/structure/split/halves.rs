//! Where a branch is split, and what lies on which half.

use super::super::lengths::{length_like, metres};
use toml_edit::{Item, TableLike, Value};

/// Arc lengths nearer than this, relative to the branch, are the same.
pub(super) const SAME: f64 = 1e-9;
/// What a parts list says of a branch: it is one part, so its second half does not have it.
pub(super) const IDENTITY: [&str; 4] = ["part", "description", "supplier", "colour"];

/// A split.
#[derive(Clone, Copy)]
pub(super) struct Split<'a> {
    /// The branch; its first half keeps this name.
    pub branch: &'a str,
    /// Where, m.
    pub s: f64,
    /// Length of the branch, m.
    pub length: f64,
    /// Name of the second half.
    pub second: &'a str,
    /// Name of the vertex between them.
    pub joint: &'a str,
}

/// On which half a part of a branch lies.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Side {
    First,
    Second,
    Both,
}

impl Split<'_> {
    /// The side of the part between the arc lengths `from` and `to` of an entry.
    pub(super) fn side(&self, entry: &dyn TableLike) -> Side {
        let same = SAME * self.length;
        if metres(entry.get("from")).is_some_and(|from| from >= self.s - same) {
            Side::Second
        } else if metres(entry.get("to")).is_some_and(|to| to <= self.s + same) {
            Side::First
        } else {
            Side::Both
        }
    }

    /// An arc length of the branch as one of its second half.
    pub(super) fn behind(&self, written: Option<&Item>) -> Option<Value> {
        metres(written).map(|own| length_like(written.and_then(Item::as_str), (own - self.s).max(0.0)))
    }
}
