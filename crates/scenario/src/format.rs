//! The format of scenarios: tables of keys with their units and limits, and what is derived from them.
//!
//! The reader, the check for unknown keys, the JSON Schema and `wireloom explain` all use these tables.

pub mod explain;
pub(crate) mod form;
pub(crate) mod keys;
pub(crate) mod kinds;
pub(crate) mod limits;
pub(crate) mod schema;
pub(crate) mod units;
