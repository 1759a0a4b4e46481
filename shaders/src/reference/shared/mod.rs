//! Reference of `shared/`: functions used by several stages.

pub(crate) mod algebra;
pub(crate) mod assembly;
mod bindings;
pub(crate) mod coupling;
pub(crate) mod inertia;
pub(crate) mod limits;
pub(crate) mod segment;
pub(crate) mod spring;
pub(crate) mod station_segment;
pub(crate) mod strain;
pub(crate) mod sum;
pub(crate) mod totals;
