//! Kinds of parts with the scheme of second order, which is that of the shaders.

use wireloom_core::Registry;
use wireloom_core::registry::RodKind;
use wireloom_models::rods::cosserat;
use wireloom_models::rods::staggered::{StaggeredRod, Stiffness};
use wireloom_models::{constraints, joints};

/// Registry with the rod `cosserat` of second order, all joints and constraints.
pub fn registry() -> Registry {
    let mut registry = Registry::default();
    let rod = RodKind {
        build: Box::new(|spec, _| {
            let stiffness = Stiffness { variation: 0.0, ..cosserat::stiffness(spec) };
            Ok(Box::new(StaggeredRod::new(spec.clone(), stiffness)))
        }),
        ..cosserat::kind()
    };
    let mut known = registry.add_rod(rod).is_ok();
    let hubs = [joints::hub::rigid_body(), joints::hub::fused(), joints::compliant_hub::kind()];
    for joint in hubs.into_iter().chain([joints::cosserat::kind()]) {
        known &= registry.add_joint(joint).is_ok();
    }
    for constraint in [constraints::connector(), constraints::collar(), constraints::handle()] {
        known &= registry.add_constraint(constraint).is_ok();
    }
    assert!(known, "a name is taken");
    registry
}
