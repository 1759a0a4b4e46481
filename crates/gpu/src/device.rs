//! Devices: which there are, which one is taken, and what is wanted of it.

use crate::pipelines::Cache;
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::{
    Adapter, AdapterInfo, Backends, DeviceDescriptor, DeviceType, Features, Instance, InstanceDescriptor, Limits,
    MemoryHints,
};

/// A device as `wireloom devices` shows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Its number: what `--device` takes, as it takes part of its name.
    pub index: usize,
    /// Name.
    pub name: String,
    /// `vulkan` or `metal`.
    pub backend: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub kind: &'static str,
    /// Driver and its version.
    pub driver: String,
    /// Whether it computes in double precision.
    pub double: bool,
    /// Largest buffer that a shader reaches, bytes.
    pub largest_buffer: u64,
    /// Why it cannot be used, if so.
    pub refusal: Option<String>,
}

/// Why no device could be opened.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OpenError {
    /// There is none.
    #[error("there is no GPU that Vulkan (on a Mac, Metal) knows of on this machine")]
    None,
    /// None of that name or number.
    #[error("there is no device `{selector}`; there are: {}", .there.join(", "))]
    Unknown {
        /// What was asked for.
        selector: String,
        /// Names of all.
        there: Vec<String>,
    },
    /// Several of that name.
    #[error("`{selector}` may be any of these devices: {}", .there.join(", "))]
    Ambiguous {
        /// What was asked for.
        selector: String,
        /// Names of those it may be.
        there: Vec<String>,
    },
    /// Its limits are too small.
    #[error("device `{device}` is too small: {limit} is {has}, and {required} is needed")]
    Limit {
        /// Name.
        device: String,
        /// Name of the limit.
        limit: String,
        /// What it has.
        has: u64,
        /// What is needed.
        required: u64,
    },
    /// The driver refuses.
    #[error("device `{device}` cannot be opened: {reason}")]
    Refused {
        /// Name.
        device: String,
        /// What the driver says.
        reason: String,
    },
}

impl OpenError {
    /// What would be right.
    pub fn help(&self) -> &'static str {
        match self {
            OpenError::None => {
                "install its driver, or Mesa's device in software (Debian: mesa-vulkan-drivers); or take minimiser.kind = \"newton\""
            }
            OpenError::Unknown { .. } | OpenError::Ambiguous { .. } => {
                "`wireloom devices` lists all; give a number, or enough of one name"
            }
            OpenError::Limit { .. } | OpenError::Refused { .. } => {
                "choose another one with --device (`wireloom devices` lists all), or take minimiser.kind = \"newton\""
            }
        }
    }
}

/// A device that is open.
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// What `wireloom devices` says of it.
    pub info: DeviceInfo,
    /// The first thing that went wrong with it.
    failure: Arc<Mutex<Option<String>>>,
    pub(crate) pipelines: Cache,
}

impl Gpu {
    /// Opens the device of this number, or whose name contains `selector` in small or capital letters; where nothing is wished, the first of the
    /// fastest sort: a card of its own before one in the processor, software last.
    ///
    /// # Errors
    /// If there is none, or it cannot do what the stages need.
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
            required_features: adapter.features() & Features::SHADER_F64,
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
        // Without a handler of errors wgpu panics.
        let note = keep(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| note(error.to_string())));
        let note = keep(&failure);
        device.set_device_lost_callback(move |_, reason| note(format!("the device was lost: {reason}")));
        Ok(Self { device, queue, info, failure, pipelines: Cache::default() })
    }

    /// The first thing that went wrong with the device: from then on nothing it says may be relied on.
    pub fn failure(&self) -> Option<String> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Says that something went wrong with it.
    pub(crate) fn fail(&self, what: String) {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(what);
    }

    /// Gives the device up, as a driver does that is taken away: for tests of what happens then.
    pub fn destroy(&self) {
        self.device.destroy();
        // The driver tells when it is asked.
        let _ = self.device.poll(wgpu::PollType::Poll);
    }
}

/// All devices of the machine; none where there is no driver.
pub fn list() -> Vec<DeviceInfo> {
    adapters().into_iter().map(|(info, _)| info).collect()
}

fn adapters() -> Vec<(DeviceInfo, Adapter)> {
    let backends = Backends::VULKAN | Backends::METAL;
    let instance = Instance::new(InstanceDescriptor { backends, ..InstanceDescriptor::new_without_display_handle() });
    let all = pollster::block_on(instance.enumerate_adapters(backends));
    all.into_iter().enumerate().map(|(index, adapter)| (device_info(index, &adapter), adapter)).collect()
}

/// The limits of WebGPU, which every device is made to have, and the largest buffers this one can do.
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

/// See [`Gpu::open`].
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
