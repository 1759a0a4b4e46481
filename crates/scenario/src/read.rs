//! From text to a checked document: values, names and references, entry by entry.

pub(crate) mod branches;
pub(crate) mod constraints;
pub(crate) mod document;
pub(crate) mod entry;
pub(crate) mod files;
pub(crate) mod fixing_types;
pub(crate) mod include;
pub(crate) mod initial;
pub(crate) mod joints;
pub(crate) mod kinds;
pub(crate) mod library;
pub(crate) mod loads;
pub(crate) mod minimiser;
pub(crate) mod names;
pub(crate) mod nearest;
pub(crate) mod obstacles;
pub(crate) mod optimise;
pub(crate) mod places;
pub(crate) mod plugins;
pub(crate) mod poses;
pub(crate) mod reader;
mod requirements;
pub(crate) mod sections;
pub(crate) mod steps;
pub(crate) mod sweep;
pub(crate) mod sweep_outputs;
pub(crate) mod toml_text;
