//! Changes to a scenario: values that replace those of the text, and steps and values written into the text.

pub mod adjust;
pub(crate) mod apply;
pub mod flat;
mod key_path;
pub mod number;
pub mod record;
pub mod structure;
