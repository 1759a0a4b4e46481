//! The minimiser satisfies the contract of [`wireloom_core::Minimiser`], in double precision and without polishing.

use super::common::registry;
use libtest_mimic::Failed;
use std::sync::Arc;
use wireloom_core::Minimiser;
use wireloom_gpu::batch::Batch;
use wireloom_gpu::{Gpu, GpuMinimiser};
use wireloom_shaders::Real;
use wireloom_testkit::conformance::minimiser;

type Suite = fn(&minimiser::Factory<'_>, &minimiser::Registries<'_>);

fn hold(gpu: &Arc<Gpu>, suite: Suite) -> Result<(), Failed> {
    if !gpu.info.double {
        return Err(
            "the device has no double precision: the contract is not held to what single precision finds".into()
        );
    }
    let batch = Arc::new(Batch::new(8));
    let make =
        || Box::new(GpuMinimiser::new(Arc::clone(gpu), Arc::clone(&batch), Real::F64, None)) as Box<dyn Minimiser>;
    suite(&make, &registry);
    Ok(())
}

macro_rules! checks {
    ($($name:ident)+) => {
        /// One check for each clause.
        pub const CHECKS: &[(&str, super::Check)] = &[$((stringify!($name), |gpu| hold(gpu, minimiser::$name))),+];
    };
}

checks! {
    carries_a_clamped_cable_whose_end_is_moved
    carries_every_joint_of_the_registry
    carries_a_closed_ring
    never_raises_the_energy
    comes_down_from_a_crumpled_start
    repeats_to_the_last_bit
    stops_at_the_iteration_limit
    is_interrupted_when_stopped
    fails_on_a_start_that_is_not_finite
    goes_from_network_to_network
    forgets_when_told
}
