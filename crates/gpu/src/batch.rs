//! Batches of harnesses that are minimised together, in one submission.
//!
//! Every minimiser of a program passes its harness to one batch and waits. Threads that compute together are its
//! members ([`Batch::join`]). When all members wait, the last one submits all harnesses to the device; those with the
//! same topology are variants of one plan. The result of a variant does not depend on the others, to the last bit:
//! stages compute every variant separately and skip finished ones. Without members every harness is computed alone.

use crate::device::Gpu;
use crate::session::{Session, TooLarge};
use std::sync::mpsc::{self, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use wireloom_core::Monitor;
use wireloom_shaders::Real;
use wireloom_shaders::harness::{Stop, Topology};
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
/// Number of cached plans: a harness, its coarse mesh, and those of neighbours whose stations are at other nodes.
const PLANS: usize = 32;
/// Number of these whose buffers stay on the device.
const PREPARED_PLANS: usize = 4;
/// Largest number of variants of a plan; more are split into several submissions.
const MOST_VARIANTS: usize = 4096;

/// A harness to be minimised.
pub struct Job {
    /// Precision on the device.
    pub real: Real,
    /// The plan of its topology, from [`Batch::plan`].
    pub plan: Arc<Plan>,
    /// Whether its holds move; see [`wireloom_shaders::harness::Harness::moves`].
    pub moves: bool,
    /// Its conditions and its initial state, from [`wireloom_shaders::memory::pack`].
    pub packed: Vec<u8>,
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
    /// The final state, for [`wireloom_shaders::memory::unpack_shape`].
    pub state: Vec<u8>,
}

/// Collects jobs of several threads; see the module.
pub struct Batch {
    /// Largest number of variables that one invocation eliminates in sequence.
    leaf: usize,
    /// Plans of the last topologies, the newest last.
    plans: Mutex<Vec<Arc<Plan>>>,
    queue: Mutex<Queue>,
}

/// Membership of a thread, for which the others wait until it is dropped.
pub struct Member<'b>(&'b Batch);

impl Drop for Member<'_> {
    fn drop(&mut self) {
        let mut queue = self.0.lock();
        queue.members -= 1;
        queue.find_leader();
    }
}

#[derive(Default)]
struct Queue {
    members: usize,
    waiting: Vec<Waiting>,
    /// Whether a thread is using the device, or was told to.
    busy: bool,
    prepared: Vec<PreparedPlan>,
}

/// A job, and how its thread is told.
struct Waiting {
    job: Job,
    tell: Sender<Told>,
}

/// What a waiting thread is told. Each thread has its own channel: with thousands of them it takes longer to wake all
/// for each to look whether it is meant than to compute.
enum Told {
    /// Its job is done, or the device failed.
    Found(Box<Result<Solution, String>>),
    /// It is to submit all jobs that wait.
    Lead,
}

impl Queue {
    /// Whether all members wait and the device is free; if so, it is taken.
    fn take_device(&mut self) -> bool {
        let ready = !self.busy && !self.waiting.is_empty() && self.waiting.len() >= self.members;
        self.busy |= ready;
        ready
    }

    /// Tells a waiting thread to submit all jobs, if it is time.
    fn find_leader(&mut self) {
        if self.take_device() {
            // It waits for the answer to its own job.
            let _ = self.waiting[0].tell.send(Told::Lead);
        }
    }
}

/// A plan with buffers on the device for a number of variants.
struct PreparedPlan {
    real: Real,
    plan: Arc<Plan>,
    memory: Memory,
    session: Session,
    /// Number of cycles of the next submission.
    cycles: usize,
}

impl Batch {
    /// `leaf`: the largest number of variables that an invocation eliminates in sequence: few for single harnesses,
    /// unlimited for thousands.
    pub fn new(leaf: usize) -> Self {
        Self { leaf, plans: Mutex::default(), queue: Mutex::default() }
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

    /// The plan of a topology: the same one until many others were asked for.
    pub fn plan(&self, topology: Topology) -> Arc<Plan> {
        // Made under the lock: all members ask at once, and one of them makes it.
        let mut plans = self.plans.lock().unwrap_or_else(PoisonError::into_inner);
        let known = plans.iter().position(|plan| plan.topology == topology);
        let plan = known.map_or_else(|| Arc::new(Plan::new(topology, self.leaf)), |known| plans.remove(known));
        plans.push(Arc::clone(&plan));
        let old = plans.len().saturating_sub(PLANS);
        plans.drain(..old);
        plan
    }

    /// Minimises a harness, together with those of all members.
    ///
    /// # Errors
    /// The failure of the device.
    pub fn descend(&self, gpu: &Gpu, job: Job) -> Result<Solution, String> {
        let (tell, told) = mpsc::channel();
        let mut leads = {
            let mut queue = self.lock();
            queue.waiting.push(Waiting { job, tell });
            queue.take_device()
        };
        loop {
            if leads {
                self.submit(gpu);
            }
            match told.recv() {
                Ok(Told::Found(found)) => return *found,
                Ok(Told::Lead) => leads = true,
                Err(_) => return Err("the thread that submitted the harnesses has ended".to_owned()),
            }
        }
    }

    /// Minimises all jobs that wait, and tells their threads.
    fn submit(&self, gpu: &Gpu) {
        let _taken = Taken(self);
        let (mut jobs, mut prepared) = {
            let mut queue = self.lock();
            (std::mem::take(&mut queue.waiting), std::mem::take(&mut queue.prepared))
        };
        while !jobs.is_empty() {
            minimise_same_plan(gpu, &mut jobs, &mut prepared);
        }
        prepared.drain(..prepared.len().saturating_sub(PREPARED_PLANS));
        self.lock().prepared = prepared;
    }
}

/// The device while a thread submits; another one may when it is dropped, also by a panic.
struct Taken<'b>(&'b Batch);

impl Drop for Taken<'_> {
    fn drop(&mut self) {
        let mut queue = self.0.lock();
        queue.busy = false;
        queue.find_leader();
    }
}

/// Minimises all jobs with plan and precision of the first one, removes them from the list, and tells their threads.
fn minimise_same_plan(gpu: &Gpu, jobs: &mut Vec<Waiting>, prepared: &mut Vec<PreparedPlan>) {
    let (real, plan) = (jobs[0].job.real, Arc::clone(&jobs[0].job.plan));
    let (mut own, mut others) = (Vec::new(), Vec::new());
    for waiting in jobs.drain(..) {
        let job = &waiting.job;
        let alike = job.real == real && Arc::ptr_eq(&job.plan, &plan) && own.len() < MOST_VARIANTS;
        if alike { own.push(waiting) } else { others.push(waiting) }
    }
    *jobs = others;
    let known = prepared.iter().position(|known| known.real == real && Arc::ptr_eq(&known.plan, &plan));
    let ready = match known.map(|k| prepared.remove(k)) {
        Some(known) if known.memory.variants() >= own.len() => Ok(known),
        _ => PreparedPlan::new(gpu, real, plan, own.len()),
    };
    let found = match ready {
        Ok(mut ready) => {
            let jobs: Vec<&Job> = own.iter().map(|waiting| &waiting.job).collect();
            let found = ready.descend(gpu, &jobs);
            prepared.push(ready);
            found
        }
        Err(error) => Err(error.to_string()),
    };
    match found {
        Ok(solutions) => own.iter().zip(solutions).for_each(|(own, solution)| own.tell(Ok(solution))),
        Err(failure) => own.iter().for_each(|own| own.tell(Err(failure.clone()))),
    }
}

impl Waiting {
    fn tell(&self, found: Result<Solution, String>) {
        // It waits.
        let _ = self.tell.send(Told::Found(Box::new(found)));
    }
}

impl PreparedPlan {
    /// Rounds the number of variants up, so that buffers are rarely reallocated.
    fn new(gpu: &Gpu, real: Real, plan: Arc<Plan>, variants: usize) -> Result<Self, TooLarge> {
        let memory = Memory::new(&plan, variants.next_power_of_two());
        let session = Session::new(gpu, real, &plan, &memory)?;
        Ok(Self { real, plan, memory, session, cycles: FIRST_CYCLES })
    }

    fn descend(&mut self, gpu: &Gpu, jobs: &[&Job]) -> Result<Vec<Solution>, String> {
        let done = Control { phase: Phase::Done as u32, ..Control::default() };
        self.memory.control.fill(done);
        for (variant, job) in jobs.iter().enumerate() {
            self.memory.begin(variant, &job.stop, self.real, job.moves);
        }
        let packed: Vec<&[u8]> = jobs.iter().map(|job| job.packed.as_slice()).collect();
        let uploaded = self.session.upload(gpu, &self.memory, &packed);
        let mut cycles = self.cycles;
        let (most, states) = loop {
            let clock = Instant::now();
            let run = || self.session.run(gpu, cycles, &mut self.memory, jobs.len());
            let states = uploaded.then(run).flatten().ok_or_else(|| gpu.failure().unwrap_or_default())?;
            let each = clock.elapsed().as_secs_f64() / cycles as f64;
            let most = ((SUBMISSION.as_secs_f64() / each) as usize).clamp(1, MOST_CYCLES);
            // A stopped job returns its current state.
            let stopped = jobs.iter().all(|job| job.monitor.is_stopped());
            if stopped || self.memory.control.iter().all(|control| control.phase == Phase::Done as u32) {
                break (most, states);
            }
            cycles = (2 * cycles).min(most);
        };
        let needed = self.memory.control[..jobs.len()].iter().map(|control| control.cycles as usize).max();
        self.cycles = (needed.unwrap_or_default() + SPARE_CYCLES).clamp(FIRST_CYCLES / 2, MOST_CYCLES).min(most);
        let solutions = self.memory.control.iter().zip(states).map(|(&control, state)| Solution { control, state });
        Ok(solutions.collect())
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
