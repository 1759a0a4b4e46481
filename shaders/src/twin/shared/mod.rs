//! The twins of `shared/`: what several stages have in common.

pub(crate) mod algebra;
pub(crate) mod coupling;
pub(crate) mod gather;
pub(crate) mod inertia;
pub(crate) mod limits;
pub(crate) mod partials;
pub(crate) mod segment;
pub(crate) mod spring;
pub(crate) mod station_segment;
pub(crate) mod strain;
pub(crate) mod sum;
