//! Places of the harness that something attaches to.

/// A place of the harness that something attaches to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum At {
    /// On a branch.
    Branch {
        /// Index of the branch.
        branch: usize,
        /// Unstressed arc length, m.
        s: f64,
    },
    /// On a joint, by index.
    Joint(usize),
}

/// A part of a branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Index of the branch.
    pub branch: usize,
    /// Unstressed arc length of its beginning, m.
    pub from: f64,
    /// Unstressed arc length of its end, m.
    pub to: f64,
}

/// Placeholder for a faulty place.
pub(crate) const NOWHERE: At = At::Branch { branch: 0, s: 0.0 };
