//! The description of a step operation.

use super::context::Context;
use crate::format::form::Key;
use crate::read::entry::Entry;
use wireloom_core::steps::Operation;

/// A step operation.
pub(crate) struct StepOperation {
    /// Its key in a step.
    pub key: Key,
    /// The constraint that an entry begins.
    pub begins: fn(&Entry<'_>) -> Begins,
    /// Reads an entry, with the index of the constraint that it begins. Returns the operation that the run reports.
    pub read: fn(&Entry<'_>, Option<usize>, &mut Context<'_, '_>) -> Option<Operation>,
}

/// The constraint that an entry of an operation begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Begins {
    /// None.
    Nothing,
    /// One at the place that the entry gives.
    AtPlace,
    /// One at that place, or at the nearest place of a branch.
    AtPlaceOrNearest,
}
