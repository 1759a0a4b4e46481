//! Devices: enumeration, selection and requirements.

use crate::pipelines::Cache;
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::{
    Adapter, AdapterInfo, Backends, DeviceDescriptor, DeviceType, Features, Instance, InstanceDescriptor, Limits,
    MemoryHints,
};

/// A device as `wireloom devices` lists it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Its index; `--device` accepts it, or a part of the name.
    pub index: usize,
    /// Name.
    pub name: String,
    /// `vulkan` or `metal`.
    pub backend: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub kind: &'static str,
    /// Driver and its version.
    pub driver: String,
    /// Whether it supports double precision.
    pub double: bool,
    /// Largest storage buffer, bytes.
    pub largest_buffer: u64,
    /// Why it cannot be used, if so.
    pub refusal: Option<String>,
}

/// Reason why no device was opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OpenError {
    /// There is no device.
    #[error("there is no GPU that Vulkan (on a Mac, Metal) knows of on this machine")]
    None,
    /// No device has that name or index.
    #[error("there is no device `{selector}`; there are: {}", .there.join(", "))]
    Unknown {
        /// The requested device.
        selector: String,
        /// Names of all devices.
        there: Vec<String>,
    },
    /// Several devices have that name.
    #[error("`{selector}` may be any of these devices: {}", .there.join(", "))]
    Ambiguous {
        /// The requested device.
        selector: String,
        /// Names of the candidates.
        there: Vec<String>,
    },
    /// Its limits are too small.
    #[error("device `{device}` is too small: {limit} is {has}, and {required} is needed")]
    Limit {
        /// Name of the device.
        device: String,
        /// Name of the limit.
        limit: String,
        /// The device's limit.
        has: u64,
        /// The required limit.
        required: u64,
    },
    /// The driver refuses to open it.
    #[error("device `{device}` cannot be opened: {reason}")]
    Refused {
        /// Name of the device.
        device: String,
        /// Message of the driver.
        reason: String,
    },
}

impl OpenError {
    /// A hint how to correct it.
    pub fn help(&self) -> &'static str {
        match self {
            OpenError::None => {
                "install its driver, or Mesa's software device (Debian: mesa-vulkan-drivers); \
                 or use minimiser.kind = \"newton\""
            }
            OpenError::Unknown { .. } | OpenError::Ambiguous { .. } => {
                "`wireloom devices` lists all; give a number, or enough of one name"
            }
            OpenError::Limit { .. } | OpenError::Refused { .. } => {
                "choose another one with --device (`wireloom devices` lists all), or use minimiser.kind = \"newton\""
            }
        }
    }
}

/// An open device.
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// Its entry in the list of devices.
    pub info: DeviceInfo,
    /// The first error of the device.
    failure: Arc<Mutex<Option<String>>>,
    pub(crate) pipelines: Cache,
}

impl Gpu {
    /// Opens the device with this index, or whose name contains `selector` (case-insensitive). Without a selector the
    /// first of the fastest type: discrete, integrated, ..., software.
    ///
    /// # Errors
    /// If there is no such device, or it does not meet the requirements of the stages.
    pub fn open(selector: Option<&str>) -> Result<Self, OpenError> {
        let (info, adapter) = choose(adapters(), selector)?;
        let refused = |reason: String| OpenError::Refused { device: info.name.clone(), reason };
        let limits = required_limits(&adapter);
        let mut lacks = None;
        limits.check_limits_with_fail_fn(&adapter.limits(), false, |limit, required, has| {
            let device = info.name.clone();
            lacks.get_or_insert(OpenError::Limit { device, limit: limit.to_owned(), has, required });
        });
        if let Some(lacks) = lacks {
            return Err(lacks);
        }
        let descriptor = DeviceDescriptor {
            label: Some("wireloom"),
            required_features: adapter.features() & (Features::SHADER_F64 | Features::TIMESTAMP_QUERY),
            required_limits: limits,
            memory_hints: MemoryHints::Performance,
            ..DeviceDescriptor::default()
        };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| refused(error.to_string()))?;
        let failure = Arc::new(Mutex::new(None));
        let keep = |failure: &Arc<Mutex<Option<String>>>| {
            let failure = Arc::clone(failure);
            move |what: String| {
                failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(what);
            }
        };
        // Without an error handler wgpu panics.
        let note = keep(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| note(error.to_string())));
        let note = keep(&failure);
        device.set_device_lost_callback(move |_, reason| note(format!("the device was lost: {reason}")));
        Ok(Self { device, queue, info, failure, pipelines: Cache::default() })
    }

    /// The first error of the device; after it no result is reliable.
    pub fn failure(&self) -> Option<String> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Records an error.
    pub(crate) fn fail(&self, what: String) {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(what);
    }

    /// Destroys the device, as a driver that is removed: for tests.
    pub fn destroy(&self) {
        self.device.destroy();
        // The loss is reported at the next poll.
        let _ = self.device.poll(wgpu::PollType::Poll);
    }
}

/// All devices of the machine; empty without a driver.
pub fn list() -> Vec<DeviceInfo> {
    adapters().into_iter().map(|(info, _)| info).collect()
}

fn adapters() -> Vec<(DeviceInfo, Adapter)> {
    let backends = Backends::VULKAN | Backends::METAL;
    let instance = Instance::new(InstanceDescriptor { backends, ..InstanceDescriptor::new_without_display_handle() });
    let all = pollster::block_on(instance.enumerate_adapters(backends));
    all.into_iter().enumerate().map(|(index, adapter)| (device_info(index, &adapter), adapter)).collect()
}

/// Required limits: those of WebGPU, and the largest buffers of this device.
fn required_limits(adapter: &Adapter) -> Limits {
    let has = adapter.limits();
    let base = Limits::default();
    Limits {
        max_buffer_size: has.max_buffer_size.max(base.max_buffer_size),
        max_storage_buffer_binding_size: has.max_storage_buffer_binding_size.max(base.max_storage_buffer_binding_size),
        ..base
    }
}

fn device_info(index: usize, adapter: &Adapter) -> DeviceInfo {
    let AdapterInfo { name, device_type, driver, driver_info, backend, .. } = adapter.get_info();
    let mut refusal = None;
    let limits = adapter.limits();
    required_limits(adapter).check_limits_with_fail_fn(&limits, false, |limit, required, has| {
        refusal.get_or_insert(format!("{limit} is {has}, and {required} is needed"));
    });
    DeviceInfo {
        index,
        name,
        backend: backend.to_str().to_owned(),
        kind: match device_type {
            DeviceType::DiscreteGpu => "discrete",
            DeviceType::IntegratedGpu => "integrated",
            DeviceType::VirtualGpu => "virtual",
            DeviceType::Cpu => "software",
            DeviceType::Other => "other",
        },
        driver: format!("{driver} {driver_info}").trim().to_owned(),
        double: adapter.features().contains(Features::SHADER_F64),
        largest_buffer: limits.max_buffer_size.min(limits.max_storage_buffer_binding_size),
        refusal,
    }
}

/// Selects a device; see [`Gpu::open`].
fn choose<T>(mut all: Vec<(DeviceInfo, T)>, selector: Option<&str>) -> Result<(DeviceInfo, T), OpenError> {
    let names = |chosen: &[&(DeviceInfo, T)]| chosen.iter().map(|(d, _)| format!("{} `{}`", d.index, d.name)).collect();
    if all.is_empty() {
        return Err(OpenError::None);
    }
    let Some(selector) = selector else {
        let sorts = ["discrete", "integrated", "virtual", "other", "software"];
        let rank = |d: &DeviceInfo| (d.refusal.is_some(), sorts.iter().position(|sort| *sort == d.kind), d.index);
        all.sort_by_key(|(d, _)| rank(d));
        return Ok(all.swap_remove(0));
    };
    let meant = |d: &DeviceInfo| match selector.parse::<usize>() {
        Ok(index) => d.index == index,
        Err(_) => d.name.to_lowercase().contains(&selector.to_lowercase()),
    };
    let found: Vec<usize> = (0..all.len()).filter(|&k| meant(&all[k].0)).collect();
    match found.as_slice() {
        [one] => Ok(all.swap_remove(*one)),
        [] => Err(OpenError::Unknown { selector: selector.to_owned(), there: names(&all.iter().collect::<Vec<_>>()) }),
        several => {
            let several: Vec<&(DeviceInfo, T)> = several.iter().map(|&k| &all[k]).collect();
            Err(OpenError::Ambiguous { selector: selector.to_owned(), there: names(&several) })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{DeviceInfo, OpenError, choose};

    fn machine() -> Vec<(DeviceInfo, ())> {
        let device = |(index, (name, kind)): (usize, (&str, &'static str))| DeviceInfo {
            index,
            name: name.into(),
            backend: "vulkan".into(),
            kind,
            driver: String::new(),
            double: true,
            largest_buffer: 1 << 30,
            refusal: None,
        };
        let all = [("llvmpipe", "software"), ("Arc A770", "discrete"), ("Arc Graphics", "integrated")];
        all.into_iter().enumerate().map(|pair| (device(pair), ())).collect()
    }

    fn chosen(selector: Option<&str>) -> Result<usize, OpenError> {
        choose(machine(), selector).map(|(device, ())| device.index)
    }

    #[test]
    fn a_card_comes_before_the_processor_and_software_last() {
        assert_eq!(chosen(None), Ok(1));
        let mut all = machine();
        all.remove(1);
        assert_eq!(choose(all, None).map(|(device, ())| device.index), Ok(2));
        assert_eq!(choose::<()>(vec![], None), Err(OpenError::None));
    }

    #[test]
    fn a_wish_is_a_number_or_part_of_one_name() {
        assert_eq!(chosen(Some("0")), Ok(0));
        assert_eq!(chosen(Some("LLVM")), Ok(0));
        assert_eq!(chosen(Some("a770")), Ok(1));
        let error = chosen(Some("arc")).unwrap_err();
        assert_eq!(error.to_string(), "`arc` may be any of these devices: 1 `Arc A770`, 2 `Arc Graphics`");
        let error = chosen(Some("7")).unwrap_err();
        let words = "there is no device `7`; there are: 0 `llvmpipe`, 1 `Arc A770`, 2 `Arc Graphics`";
        assert_eq!(error.to_string(), words);
    }
}
