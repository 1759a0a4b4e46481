//! The minimiser that runs on a GPU: [`device`] finds devices and opens one, [`flatten`] says a problem in the shaders' words. The only
//! crate that names wgpu; what is computed stands in `shaders`, with a twin on the CPU for every stage.

pub mod device;
pub mod flatten;
pub mod policy;

pub use device::{Gpu, Listed, OpenError, list};
