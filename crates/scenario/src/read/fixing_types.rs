//! Types of constraints: catalogue parts with the freedoms that they hold, their friction and their load limits.

use std::collections::BTreeMap;
use wireloom_core::constraint::{Limits, Slide};
use wireloom_core::{HoldWord, Parameters};

/// A type of fixing: a kind of the registry, and values for it. A constraint's own keys take precedence.
#[derive(Clone, Debug)]
pub(crate) struct FixingType {
    /// Short description.
    pub doc: String,
    /// The kind of the registry.
    pub kind: String,
    /// Parameters of that kind.
    pub parameters: Parameters,
    /// The freedoms it holds; `None`: those its kind holds.
    pub hold: Option<Vec<HoldWord>>,
    /// Sliding of the cable through it, if the cable may slide.
    pub slide: Option<Slide>,
    /// Its load limits.
    pub limits: Limits,
    /// Keys that every constraint of the type must give.
    pub needs: Vec<String>,
}

/// Types by name; `None` for a faulty one, whose fault has been noted.
pub(crate) type Types = BTreeMap<String, Option<FixingType>>;
