//! Types of fixings by name: what an engineer calls them, what they hold, what they bear. Those shipped with the program stand in
//! `library/fixings.toml`; a scenario and its library files add their own.

use crate::files::NoFiles;
use crate::fixings;
use crate::keys::LIBRARY_FILE;
use crate::kinds;
use crate::reader::{Entry, included};
use std::collections::BTreeMap;
use wireloom_core::constraint::{Limits, Slide};
use wireloom_core::{HoldWord, Parameters, Registry};

/// The shipped file, as messages call it, and its text.
const SHIPPED: (&str, &str) = ("fixings.toml", include_str!("../library/fixings.toml"));

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

/// The shipped types whose kinds `registry` has.
pub(crate) fn shipped(registry: &Registry) -> Types {
    let (name, text) = SHIPPED;
    let read = |entry: &Entry<'_>| {
        let entries = entry.named_entries("fixings");
        entries.iter().filter_map(|(name, entry)| Some(((*name).to_owned(), Some(read(name, entry)?)))).collect()
    };
    included(name, text, &NoFiles, registry, &LIBRARY_FILE, read).0.unwrap_or_default()
}

/// A type out of a file or scenario.
pub(crate) fn read(name: &str, entry: &Entry<'_>) -> Option<FixingType> {
    let before = entry.reader.fault_count();
    let kind = kinds::read(entry);
    if entry.reader.registry.constraint(name).is_some() {
        let message = format!("\"{name}\" is a built-in kind of constraint, and cannot be a type too");
        entry.fault_here(message, "give the type a name of its own");
    }
    let doc = entry.word("doc").unwrap_or_default().to_owned();
    let hold = fixings::hold(entry);
    let needs = entry.choices("needs").into_iter().map(str::to_owned).collect();
    let (slides, friction) = (entry.flag("slide") == Some(true), entry.number("friction"));
    if entry.has("friction") && !slides {
        let message = format!("{} has `friction` but lets no cable through", entry.label);
        entry.fault_at("friction", message, "add slide = true, or leave `friction` out");
    }
    let slide = slides.then(|| Slide { friction: friction.unwrap_or(0.0) });
    let limits = fixings::limits(entry, &Limits::default());
    let kind = kind.filter(|_| entry.reader.fault_count() == before)?;
    Some(FixingType { doc, kind: kind.kind, parameters: kind.parameters, hold, slide, limits, needs })
}
