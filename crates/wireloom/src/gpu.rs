//! Devices for the minimiser `gpu`.
//!
//! [`registry_on`](crate::registry_on) chooses one of them; [`registry`](crate::registry) uses the fastest.
//!
//! ```
//! use wireloom::gpu::SharedDevice;
//! use wireloom::session::Monitor;
//!
//! for device in wireloom::gpu::list() {
//!     println!("{} ({})", device.name, device.kind);
//! }
//! let registry = wireloom::registry_on(SharedDevice::for_single_runs(Some("my card")), &Monitor::default());
//! assert!(registry.minimiser("gpu").is_some(), "a device is opened when a harness is built for it");
//! ```

pub use wireloom_gpu::batch::Batch;
pub use wireloom_gpu::policy;
pub use wireloom_gpu::{DeviceInfo, Gpu, OpenError, SharedDevice, list};
