//! Where something attaches to the harness.

/// Where something attaches.
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
    /// Unstressed arc length where it begins, m.
    pub from: f64,
    /// And where it ends, m.
    pub to: f64,
}

/// Stands for a place at fault.
pub(crate) const NOWHERE: At = At::Branch { branch: 0, s: 0.0 };
