//! Built-in rods, joints and constraints, registered in the same way as those of plugins.

pub mod constraints;
pub mod coupling_law;
pub mod creep;
pub mod friction;
pub mod joints;
pub mod kernel;
pub mod rods;
pub mod variation;

use wireloom_core::Registry;

/// Adds all built-in rods, joints and constraints.
///
/// # Panics
/// If one of their names is taken: built-ins are registered first.
pub fn register(registry: &mut Registry) {
    const FIRST: &str = "built-ins are registered first";
    registry.add_rod(rods::cosserat::kind()).map_err(|_| FIRST).unwrap();
    registry.add_rod(rods::kirchhoff::kind()).map_err(|_| FIRST).unwrap();
    registry.add_rod(rods::mass_spring::kind()).map_err(|_| FIRST).unwrap();
    registry.add_joint(joints::cosserat::kind()).map_err(|_| FIRST).unwrap();
    registry.add_joint(joints::hub::rigid_body()).map_err(|_| FIRST).unwrap();
    registry.add_joint(joints::hub::fused()).map_err(|_| FIRST).unwrap();
    registry.add_joint(joints::compliant_hub::kind()).map_err(|_| FIRST).unwrap();
    registry.add_constraint(constraints::connector()).map_err(|_| FIRST).unwrap();
    registry.add_constraint(constraints::collar()).map_err(|_| FIRST).unwrap();
    registry.add_constraint(constraints::handle()).map_err(|_| FIRST).unwrap();
}
