//! Registry of the built-in kinds.

use wireloom_core::Registry;

/// Registry of all built-in kinds of rods, joints, constraints, shapes and minimisers. With the feature `gpu` the
/// minimiser `gpu` is among them; it uses the fastest device of the machine.
pub fn registry() -> Registry {
    #[cfg(feature = "gpu")]
    return registry_on(wireloom_gpu::SharedDevice::for_single_runs(None));
    #[cfg(not(feature = "gpu"))]
    on_cpu()
}

/// Registry of all built-in kinds, with the minimiser `gpu` on a given device.
///
/// # Panics
/// Never: built-in kinds have different names.
#[cfg(feature = "gpu")]
pub fn registry_on(devices: wireloom_gpu::SharedDevice) -> Registry {
    let mut registry = on_cpu();
    let gpu = wireloom_gpu::kind(devices, || Box::new(wireloom_solve::minimisers::newton::Newton::new()));
    registry.add_minimiser(gpu).map_err(|_| "built-ins are registered first").unwrap();
    registry
}

fn on_cpu() -> Registry {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    wireloom_shapes::register(&mut registry);
    wireloom_solve::register(&mut registry);
    registry
}
