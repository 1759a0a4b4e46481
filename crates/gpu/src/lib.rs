//! The minimiser `gpu`. [`device`] lists and opens devices, [`flatten`] converts a problem for the shaders, [`session`]
//! owns buffers and submits work, [`batch`] combines harnesses of several threads, [`minimiser`] is the minimiser's
//! kind. Only this crate uses wgpu; the computation itself is in `shaders`, with a CPU reference of every stage.

pub mod batch;
pub mod device;
pub mod flatten;
pub mod minimiser;
mod pipelines;
pub mod policy;
pub mod session;

pub use device::{DeviceInfo, Gpu, OpenError, list};
pub use minimiser::{GpuMinimiser, SharedDevice, kind};
