//! Batches of harnesses that are minimised together, in one submission.
//!
//! Every minimiser of a program passes its harness to one batch and waits. Threads that compute together are its
//! members ([`Batch::join`]). When all members wait, the last one submits all harnesses to the device; those with the
//! same topology are variants of one plan. The result of a variant does not depend on the others, to the last bit:
//! stages compute every variant separately and skip finished ones. Without members every harness is computed alone.

use crate::device::Gpu;
use crate::session::{Session, TooLarge};
use std::collections::BTreeMap;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use wireloom_core::Monitor;
use wireloom_shaders::Real;
use wireloom_shaders::harness::{Harness, Shape, Stop};
use wireloom_shaders::layout::{Control, Phase};
use wireloom_shaders::memory::Memory;
use wireloom_shaders::plan::Plan;

/// Number of cycles in the first submission of a plan.
const FIRST_CYCLES: usize = 12;
/// Largest number of cycles of a submission: with a few hundred dispatches each, far below the time limits of drivers.
const MOST_CYCLES: usize = 64;
/// Intended duration of a submission: between submissions stop requests are checked.
const SUBMISSION: Duration = Duration::from_millis(500);
/// Cycles submitted in addition to those needed the last time.
const SPARE_CYCLES: usize = 2;
/// Number of cached plans: a harness, its coarse mesh, and earlier ones.
const PLANS: usize = 4;
/// Largest number of variants of a plan; more are split into several submissions.
const MOST_VARIANTS: usize = 4096;

/// A harness to be minimised.
pub struct Job {
    /// Precision on the device.
    pub real: Real,
    /// The harness under its conditions.
    pub harness: Harness,
    /// Its initial state.
    pub shape: Shape,
    /// Its stop criteria.
    pub stop: Stop,
    /// Stops the computation on request.
    pub monitor: Monitor,
}

/// Result of a job.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Outcome and work.
    pub control: Control<f64>,
    /// The final state.
    pub shape: Shape,
}

/// Collects jobs of several threads; see the module.
pub struct Batch {
    /// Largest number of variables that one invocation eliminates in sequence.
    leaf: usize,
    queue: Mutex<Queue>,
    changed: Condvar,
}

/// Membership of a thread, for which the others wait until it is dropped.
pub struct Member<'b>(&'b Batch);

impl Drop for Member<'_> {
    fn drop(&mut self) {
        self.0.lock().members -= 1;
        self.0.changed.notify_all();
    }
}

#[derive(Default)]
struct Queue {
    members: usize,
    waiting: Vec<(u64, Job)>,
    found: BTreeMap<u64, Result<Solution, String>>,
    next_ticket: u64,
    /// Whether a thread is using the device.
    busy: bool,
    plans: Vec<PreparedPlan>,
}

/// A plan with buffers on the device for a number of variants.
struct PreparedPlan {
    real: Real,
    plan: Plan,
    memory: Memory,
    session: Session,
    /// Number of cycles of the next submission.
    cycles: usize,
}

impl Batch {
    /// `leaf`: the largest number of variables that an invocation eliminates in sequence: few for single harnesses,
    /// unlimited for thousands.
    pub fn new(leaf: usize) -> Self {
        Self { leaf, queue: Mutex::default(), changed: Condvar::new() }
    }

    /// Adds this thread as a member; it must pass jobs, or drop the membership.
    pub fn join(&self) -> Member<'_> {
        self.lock().members += 1;
        Member(self)
    }

    fn lock(&self) -> MutexGuard<'_, Queue> {
        // No critical section panics.
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Minimises a harness, together with those of all members.
    ///
    /// # Errors
    /// The failure of the device.
    pub fn descend(&self, gpu: &Gpu, job: Job) -> Result<Solution, String> {
        let mut queue = self.lock();
        let ticket = queue.next_ticket;
        queue.next_ticket += 1;
        queue.waiting.push((ticket, job));
        loop {
            if let Some(found) = queue.found.remove(&ticket) {
                return found;
            }
            if queue.busy || queue.waiting.is_empty() || queue.waiting.len() < queue.members {
                queue = self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
                continue;
            }
            queue.busy = true;
            let (mut jobs, mut plans) = (std::mem::take(&mut queue.waiting), std::mem::take(&mut queue.plans));
            drop(queue);
            let mut found = Vec::new();
            while !jobs.is_empty() {
                self.minimise_same_plan(gpu, &mut jobs, &mut plans, &mut found);
            }
            plans.drain(..plans.len().saturating_sub(PLANS));
            queue = self.lock();
            queue.found.extend(found);
            (queue.plans, queue.busy) = (plans, false);
            self.changed.notify_all();
        }
    }

    /// Minimises all jobs with topology and precision of the first one, and removes them from the list.
    fn minimise_same_plan(
        &self,
        gpu: &Gpu,
        jobs: &mut Vec<(u64, Job)>,
        plans: &mut Vec<PreparedPlan>,
        found: &mut Vec<(u64, Result<Solution, String>)>,
    ) {
        let (real, topology) = (jobs[0].1.real, jobs[0].1.harness.topology());
        let alike: Vec<bool> =
            jobs.iter().map(|(_, job)| job.real == real && job.harness.topology() == topology).collect();
        let mut own = Vec::new();
        let mut others = Vec::new();
        for (job, alike) in jobs.drain(..).zip(alike) {
            if alike && own.len() < MOST_VARIANTS { own.push(job) } else { others.push(job) }
        }
        *jobs = others;
        let known = plans.iter().position(|known| known.real == real && known.plan.topology == topology);
        let mut prepared = match known.map(|k| plans.remove(k)) {
            Some(known) if known.memory.variants() >= own.len() => known,
            known => {
                let plan = known.map_or_else(|| Plan::new(topology, self.leaf), |known| known.plan);
                match PreparedPlan::new(gpu, real, plan, own.len()) {
                    Ok(prepared) => prepared,
                    Err(error) => {
                        found.extend(own.into_iter().map(|(ticket, _)| (ticket, Err(error.to_string()))));
                        return;
                    }
                }
            }
        };
        found.extend(prepared.descend(gpu, own));
        plans.push(prepared);
    }
}

impl PreparedPlan {
    /// Rounds the number of variants up, so that buffers are rarely reallocated.
    fn new(gpu: &Gpu, real: Real, plan: Plan, variants: usize) -> Result<Self, TooLarge> {
        let memory = Memory::new(&plan, variants.next_power_of_two());
        let session = Session::new(gpu, real, &plan, &memory)?;
        Ok(Self { real, plan, memory, session, cycles: FIRST_CYCLES })
    }

    fn descend(&mut self, gpu: &Gpu, jobs: Vec<(u64, Job)>) -> Vec<(u64, Result<Solution, String>)> {
        for control in &mut self.memory.control {
            control.phase = Phase::Done as u32;
        }
        let harnesses: Vec<_> = jobs.iter().map(|(_, job)| (&job.harness, &job.shape)).collect();
        self.memory.set_all(&self.plan, &harnesses).expect("all have the links of the plan");
        for (variant, (_, job)) in jobs.iter().enumerate() {
            self.memory.begin(variant, &job.stop, self.real);
        }
        self.session.upload(gpu, &self.memory);
        let mut cycles = self.cycles;
        let most = loop {
            let clock = Instant::now();
            if !self.session.run(gpu, cycles, &mut self.memory) {
                let failure = gpu.failure().unwrap_or_default();
                return jobs.into_iter().map(|(ticket, _)| (ticket, Err(failure.clone()))).collect();
            }
            let each = clock.elapsed().as_secs_f64() / cycles as f64;
            let most = ((SUBMISSION.as_secs_f64() / each) as usize).clamp(1, MOST_CYCLES);
            // A stopped job returns its current state.
            let stopped = jobs.iter().all(|(_, job)| job.monitor.is_stopped());
            if stopped || self.memory.control.iter().all(|control| control.phase == Phase::Done as u32) {
                break most;
            }
            cycles = (2 * cycles).min(most);
        };
        let needed = self.memory.control[..jobs.len()].iter().map(|control| control.cycles as usize).max();
        self.cycles = (needed.unwrap_or_default() + SPARE_CYCLES).clamp(FIRST_CYCLES / 2, MOST_CYCLES).min(most);
        let found = |(variant, (ticket, _)): (usize, (u64, Job))| {
            let control = self.memory.control[variant];
            (ticket, Ok(Solution { control, shape: self.memory.shape(&self.plan, variant) }))
        };
        jobs.into_iter().enumerate().map(found).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Batch;

    #[test]
    fn members_leave_when_they_are_dropped() {
        let batch = Batch::new(8);
        let (one, other) = (batch.join(), batch.join());
        assert_eq!(batch.lock().members, 2);
        drop(one);
        assert_eq!(batch.lock().members, 1);
        drop(other);
        assert_eq!(batch.lock().members, 0);
    }
}
