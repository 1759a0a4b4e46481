//! Tests that need a device, a GPU or a software device. The variable WIRELOOM_GPU_TESTS selects it
//! ([`wireloom_gpu::policy`]).

mod batches;
#[path = "../common/mod.rs"]
mod common;
mod conformance;
mod parity;

use libtest_mimic::{Arguments, Failed, Trial};
use std::sync::Arc;
use wireloom_gpu::policy::{self, TestDevice};
use wireloom_gpu::{Gpu, OpenError};

type Check = fn(&Arc<Gpu>) -> Result<(), Failed>;

const CHECKS: &[(&str, Check)] = &[
    ("it is found by its number and by its name", is_found),
    ("an unknown name is refused with those there are", unknown_is_refused),
    ("a device that is lost says so and nothing panics", lost_says_so),
    ("members of a batch end as if each were alone", batches::end_as_if_alone),
    ("a moved end is part of the first step", batches::moved_end_is_part_of_the_first_step),
    ("single precision keeps the rounding errors of sums", batches::single_precision_keeps_the_rounding_errors_of_sums),
    ("every stage agrees with its CPU reference, in double precision", parity::double),
    ("every stage agrees with its CPU reference, in single precision", parity::single),
];

fn main() {
    let arguments = Arguments::from_args();
    let found = policy::device(std::env::var("WIRELOOM_GPU_TESTS").ok().as_deref());
    let trials = CHECKS.iter().chain(conformance::CHECKS).map(|&(name, check)| match found.clone() {
        TestDevice::Device(gpu) => Trial::test(name, move || check(&gpu)),
        TestDevice::Ignored(reason) => {
            Trial::test(format!("{name} (ignored: {reason})"), || Ok(())).with_ignored_flag(true)
        }
        TestDevice::Missing(reason) => Trial::test(name, move || Err(reason.into())),
    });
    libtest_mimic::run(&arguments, trials.collect()).exit();
}

fn is_found(gpu: &Arc<Gpu>) -> Result<(), Failed> {
    let there = wireloom_gpu::list();
    assert!(there.contains(&gpu.info), "{there:?}");
    for selector in [gpu.info.index.to_string(), gpu.info.name.to_uppercase()] {
        assert_eq!(Gpu::open(Some(&selector))?.info, gpu.info);
    }
    Ok(())
}

fn unknown_is_refused(gpu: &Arc<Gpu>) -> Result<(), Failed> {
    let refusal = Gpu::open(Some("no such card")).err().ok_or("it was opened")?;
    assert!(matches!(refusal, OpenError::Unknown { .. }), "{refusal}");
    assert!(refusal.to_string().contains(&gpu.info.name), "{refusal}");
    Ok(())
}

fn lost_says_so(_: &Arc<Gpu>) -> Result<(), Failed> {
    let own = Gpu::open(None)?;
    assert_eq!(own.failure(), None);
    own.destroy();
    let failure = own.failure().ok_or("it did not notice")?;
    assert!(failure.contains("lost"), "{failure}");
    Ok(())
}
