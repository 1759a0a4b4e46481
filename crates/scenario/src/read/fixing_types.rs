//! Types of constraints: what an engineer calls a constraint, what it holds and what it bears.

use std::collections::BTreeMap;
use wireloom_core::constraint::{Limits, Slide};
use wireloom_core::{HoldWord, Parameters};

/// A type of fixing: a kind of the registry, and what is set for it. A constraint's own keys go before it.
#[derive(Clone, Debug)]
pub(crate) struct FixingType {
    /// What it is, in a few words.
    pub doc: String,
    /// The kind of the registry.
    pub kind: String,
    /// Parameters of that kind.
    pub parameters: Parameters,
    /// The freedoms it holds; `None`: those its kind holds.
    pub hold: Option<Vec<HoldWord>>,
    /// Whether and how the cable may run through.
    pub slide: Option<Slide>,
    /// What it bears.
    pub limits: Limits,
    /// Keys that every constraint of the type must give.
    pub needs: Vec<String>,
}

/// Types by name; `None` where one is at fault, which has been said.
pub(crate) type Types = BTreeMap<String, Option<FixingType>>;
