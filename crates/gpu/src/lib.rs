//! The minimiser that runs on a GPU: [`device`] finds devices and opens one, [`flatten`] says a problem in the shaders' words, [`session`] keeps
//! buffers and submits, [`batch`] brings harnesses together to the device, [`minimiser`] is the kind `gpu`. The only crate that names wgpu; what is computed stands in
//! `shaders`, with a twin on the CPU for every stage.

pub mod batch;
pub mod device;
pub mod flatten;
pub mod minimiser;
mod pipelines;
pub mod policy;
pub mod session;

pub use device::{DeviceInfo, Gpu, OpenError, list};
pub use minimiser::{GpuMinimiser, SharedDevice, kind};
