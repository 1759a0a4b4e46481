//! Batches of several harnesses.

use super::common::registry;
use libtest_mimic::Failed;
use std::sync::Arc;
use wireloom_core::{Minimiser, State, Status, Stop, Vector};
use wireloom_gpu::batch::Batch;
use wireloom_gpu::{Gpu, GpuMinimiser};
use wireloom_shaders::Real;
use wireloom_testkit::conformance::networks::cable;

/// Number of members of the batch.
const MEMBERS: usize = 5;

/// Final state of a cable whose end moves in steps; the number of steps depends on the member, so that some finish
/// earlier.
fn follow(gpu: &Arc<Gpu>, batch: &Arc<Batch>, member: usize) -> Result<State, String> {
    let sample = cable(&registry(), 12);
    let real = if gpu.info.double { Real::F64 } else { Real::F32 };
    let mut minimiser = GpuMinimiser::new(Arc::clone(gpu), Arc::clone(batch), real, None);
    let (mut problem, mut state) = (sample.problem(), sample.state.clone());
    let mut target = problem.conditions().targets[1];
    for step in 0..=member {
        target.position -= Vector::new(0.02, 0.01 * member as f64, 0.0);
        problem.set_target(1, target);
        let report = minimiser.minimise(&mut problem, &mut state, &Stop { force_tolerance: 1e-3, ..Stop::default() });
        if report.status != Status::Converged {
            return Err(format!("member {member}, step {step}: {report:?}, {:?}", minimiser.fault()));
        }
    }
    Ok(state)
}

/// Members of a batch end with the same bits as alone, although some leave earlier.
pub fn end_as_if_alone(gpu: &Arc<Gpu>) -> Result<(), Failed> {
    let (together, alone) = (Arc::new(Batch::new(usize::MAX)), Arc::new(Batch::new(usize::MAX)));
    let found: Vec<Result<State, String>> = std::thread::scope(|scope| {
        // All threads are members before the first one waits.
        let members: Vec<_> = (0..MEMBERS).map(|_| together.join()).collect();
        let work = members.into_iter().enumerate().map(|(k, member)| {
            let together = &together;
            scope.spawn(move || {
                let _member = member;
                follow(gpu, together, k)
            })
        });
        let work: Vec<_> = work.collect();
        work.into_iter().map(|thread| thread.join().expect("nothing panics")).collect()
    });
    for (member, found) in found.into_iter().enumerate() {
        if found? != follow(gpu, &alone, member)? {
            return Err(format!("member {member} came to another state than alone").into());
        }
    }
    Ok(())
}
