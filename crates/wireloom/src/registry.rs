//! Registry of the built-in kinds.

use wireloom_core::{Monitor, Registry};
use wireloom_shapes::mesh::StepReader;

/// Registry of all built-in kinds of rods, joints, constraints, shapes and minimisers. With the feature `gpu` the
/// minimiser `gpu` is among them; it uses the fastest device of the machine. With the feature `step` meshes may be STEP
/// files.
pub fn registry() -> Registry {
    #[cfg(feature = "gpu")]
    return registry_on(wireloom_gpu::SharedDevice::for_single_runs(None), &Monitor::default());
    #[cfg(not(feature = "gpu"))]
    on_cpu(&Monitor::default())
}

/// Registry of all built-in kinds, with the minimiser `gpu` on a given device. Stopping the monitor also ends the
/// process that reads a STEP file.
///
/// # Panics
/// Never: built-in kinds have different names.
#[cfg(feature = "gpu")]
pub fn registry_on(devices: wireloom_gpu::SharedDevice, monitor: &Monitor) -> Registry {
    let mut registry = on_cpu(monitor);
    let gpu = wireloom_gpu::kind(devices, || Box::new(wireloom_solve::minimisers::newton::Newton::new()));
    registry.add_minimiser(gpu).map_err(|_| "built-ins are registered first").unwrap();
    registry
}

fn on_cpu(monitor: &Monitor) -> Registry {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    wireloom_shapes::register(&mut registry, step(monitor));
    wireloom_solve::register(&mut registry);
    registry
}

#[cfg(feature = "step")]
fn step(monitor: &Monitor) -> Option<StepReader> {
    Some(crate::step::shapes(crate::step::Reader::from_environment(monitor.clone())))
}

#[cfg(not(feature = "step"))]
fn step(_: &Monitor) -> Option<StepReader> {
    None
}
