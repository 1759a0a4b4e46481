//! Selection of the device for tests by the variable `WIRELOOM_GPU_TESTS`.
//!
//! | value | meaning |
//! | --- | --- |
//! | `auto`, or not set | any device; without one, tests that need a device are shown as ignored, with the reason |
//! | `require` | any device; without one, tests that need a device fail (set by `cargo xtask test`) |
//! | `hardware` | as `require`, but no software device: for measurements |
//! | `off` | none: tests that need a device are shown as ignored |

use crate::device::Gpu;
use std::sync::Arc;

/// Device of the tests, or the reason why there is none.
#[derive(Clone)]
pub enum TestDevice {
    /// Run on it.
    Device(Arc<Gpu>),
    /// Show as ignored, for this reason.
    Ignored(String),
    /// Fail, for this reason.
    Missing(String),
}

/// Selects the device for the variable's value.
pub fn device(policy: Option<&str>) -> TestDevice {
    let open = || Gpu::open(None).map_err(|error| error.to_string());
    let or_missing =
        |device: Result<Gpu, String>| device.map_or_else(TestDevice::Missing, |gpu| TestDevice::Device(Arc::new(gpu)));
    match policy.unwrap_or("auto") {
        "auto" => open().map_or_else(TestDevice::Ignored, |gpu| TestDevice::Device(Arc::new(gpu))),
        "require" => or_missing(open()),
        "hardware" => or_missing(open().and_then(|gpu| match gpu.info.kind {
            "software" => Err(format!("{} is in software", gpu.info.name)),
            _ => Ok(gpu),
        })),
        "off" => TestDevice::Ignored("switched off".to_owned()),
        other => TestDevice::Missing(format!("WIRELOOM_GPU_TESTS = {other}: auto, require, hardware or off is meant")),
    }
}
