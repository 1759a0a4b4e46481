//! The twins of `shared/`: what several stages have in common.

pub(crate) mod algebra;
pub(crate) mod assembly;
pub(crate) mod coupling;
pub(crate) mod inertia;
pub(crate) mod limits;
pub(crate) mod segment;
pub(crate) mod spring;
pub(crate) mod station_segment;
pub(crate) mod strain;
pub(crate) mod sum;
pub(crate) mod totals;
