//! Batches of several harnesses, and the work and the residual of one.

use super::common::registry;
use libtest_mimic::Failed;
use std::sync::Arc;
use wireloom_core::minimiser::Report;
use wireloom_core::{Minimiser, State, Status, Stop, Vector};
use wireloom_gpu::batch::Batch;
use wireloom_gpu::{Gpu, GpuMinimiser};
use wireloom_shaders::Real;
use wireloom_solve::minimisers::newton::Newton;
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

/// A cable hangs, and its end moves by 5 mm: the report of the last step, without help by the CPU.
fn drag(gpu: &Arc<Gpu>, segments: usize, real: Real, tolerance: f64) -> Result<Report, Failed> {
    let sample = cable(&registry(), segments);
    let batch = Arc::new(Batch::new(8));
    let (mut newton, mut minimiser) = (Newton::new(), GpuMinimiser::new(Arc::clone(gpu), batch, real, None));
    let (mut problem, mut state) = (sample.problem(), sample.state.clone());
    let mut target = problem.conditions().targets[1];
    for _ in 0..15 {
        target.position += Vector::new(-0.1, 0.05, 0.0) / 15.0;
        problem.set_target(1, target);
        let report = newton.minimise(&mut problem, &mut state, &Stop { force_tolerance: 1e-8, max_iterations: 1_000 });
        assert_eq!(report.status, Status::Converged);
    }
    target.position.x += 5e-3;
    problem.set_target(1, target);
    let report =
        minimiser.minimise(&mut problem, &mut state, &Stop { force_tolerance: tolerance, max_iterations: 200 });
    if report.status != Status::Converged {
        return Err(format!("{report:?}, {:?}", minimiser.fault()).into());
    }
    Ok(report)
}

/// The prescribed motion is part of the first step. If the held end jumps instead, 14 factorisations are needed for 3.
pub fn moved_end_is_part_of_the_first_step(gpu: &Arc<Gpu>) -> Result<(), Failed> {
    let real = if gpu.info.double { Real::F64 } else { Real::F32 };
    let report = drag(gpu, 1_000, real, if gpu.info.double { 1e-8 } else { 1e-3 })?;
    if report.factorisations > 4 {
        return Err(format!("{report:?}").into());
    }
    Ok(())
}

/// The sums that need twice the digits have them. A compiler that simplifies their rounding errors leaves a residual of
/// about 1, which one real card did; with them it is about 1e-5.
pub fn single_precision_keeps_the_rounding_errors_of_sums(gpu: &Arc<Gpu>) -> Result<(), Failed> {
    drag(gpu, 100, Real::F32, 1e-3).map(|_| ())
}
