//! Checks of the whole harness: constraints that contradict each other, parts that nothing holds.

pub(crate) mod conflicts;
pub(crate) mod freedoms;
pub(crate) mod laws;
pub(crate) mod limits;
pub(crate) mod optimise;
pub(crate) mod temperature;
mod timeline;
