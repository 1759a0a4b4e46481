//! Which device tests run on: what the variable `WIRELOOM_GPU_TESTS` means.
//!
//! | value | meaning |
//! | --- | --- |
//! | `auto`, or not set | any device; where there is none, tests that need one show as ignored, with the reason |
//! | `require` | any device; where there is none, tests that need one fail (`cargo xtask test` says so once it has installed one) |
//! | `hardware` | as `require`, and a device in software is none: for times |
//! | `off` | none: tests that need one show as ignored |

use crate::device::Gpu;
use std::sync::Arc;

/// What a test that needs a device is to do.
#[derive(Clone)]
pub enum TestDevice {
    /// Run on it.
    Device(Arc<Gpu>),
    /// Show as ignored, for this reason.
    Ignored(String),
    /// Fail, for this reason.
    Missing(String),
}

/// The device of tests under the variable's value.
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
