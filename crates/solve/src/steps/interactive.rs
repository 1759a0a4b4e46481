//! A harness in hands: carried from one equilibrium to the next, one increment at a time, from any checkpoint. What becomes of it is what
//! [`crate::carry_out`] makes of the same steps, to the bit.

use crate::steps::certificate::Certifier;
use crate::steps::checkpoint::Checkpoint;
use crate::steps::driver::{Driver, is_balanced};
use crate::steps::plan::Plan;
use std::time::Instant;
use wireloom_core::equilibrium::{PartFault, StepResult};
use wireloom_core::minimiser::{Minimiser, Stop};
use wireloom_core::status::Status;
use wireloom_core::steps::{Journey, Schedule, Step};
use wireloom_core::{Event, Monitor, Network};

/// Where a harness is brought into balance again, forces are as much smaller than the tolerance: what is seen from outside then does not
/// depend on how it came there.
const FINER: f64 = 1e-3;
/// Name of what comes before all steps.
const START: &str = "start";

/// The end of an increment.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    /// As results have it.
    pub end: StepResult,
    /// From here it goes on; where the increment did not end in balance there is no going on.
    pub checkpoint: Checkpoint,
}

/// Why there is no end.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Trouble {
    /// Somebody stopped it.
    #[error("stopped")]
    Stopped,
    /// Something cannot go on.
    #[error("{0}")]
    Fault(PartFault),
}

impl Checkpoint {
    /// What happened so far.
    pub fn events(&self) -> &[Event] {
        self.log.events()
    }

    /// Remarks so far.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Which step is at hand, from 0, and how many increments of it are done.
    pub fn done(&self) -> (usize, usize) {
        (self.step_index, self.increment)
    }

    /// Bytes that it takes, about.
    pub fn weight(&self) -> usize {
        let state = &self.state;
        let points = state.points.len() * (2 * size_of_val(&state.points[0]) + size_of::<f64>());
        points + state.frames.len() * (size_of_val(&state.frames[0]) + size_of::<f64>())
    }

    /// Where its constraints are to be: position (m) and orientation as the scenario would give them.
    pub fn target(&self, constraint: usize) -> Option<wireloom_core::Pose> {
        Some(self.conditions.constraints.get(constraint)?.base)
    }

    /// Whether a constraint acts.
    pub fn acts(&self, constraint: usize) -> bool {
        self.conditions.active.get(constraint).copied().unwrap_or(false)
    }

    /// The same where the step at hand, whose increments come one by one ([`Hands::follow`]), has ended.
    pub fn with_step_ended(self) -> Self {
        if self.increment == 0 {
            return self;
        }
        Self { plan: None, step_index: self.step_index + 1, increment: 0, work: (0, 0, 0), seconds: 0.0, ..self }
    }
}

/// What carries a harness. Keeps its workspace from call to call; every call has a checkpoint to begin from.
pub struct Hands {
    minimiser: Box<dyn Minimiser>,
    stop: Stop,
    /// Whether clearances of everything from everything are kept.
    clearances: bool,
    monitor: Monitor,
    certifier: Option<(u64, Certifier)>,
}

impl Hands {
    /// With this minimiser; `clearances` as in [`Schedule::clearances`], and `monitor` to stop it.
    pub fn new(minimiser: Box<dyn Minimiser>, stop: Stop, clearances: bool, monitor: Monitor) -> Self {
        Self { minimiser, stop, clearances, monitor, certifier: None }
    }

    /// The balanced start, as [`crate::carry_out`] finds it.
    ///
    /// # Errors
    /// Where there is none: somebody stopped it, or a part cannot go on.
    pub fn start(
        &mut self,
        network: &Network,
        coarse: Option<&Network>,
        schedule: &Schedule,
    ) -> Result<Ended, Trouble> {
        let clock = Instant::now();
        let first = schedule.steps.first().map_or("equilibrium", |step| &step.name);
        let mut driver = Driver::at_start(network, &mut *self.minimiser, &self.stop, schedule, &self.monitor);
        let homed = driver.find_start(coarse, schedule, first);
        let step = Step { name: START.to_owned(), increments: 1, ..Step::default() };
        if let Some(fault) = driver.named_fault(&step, 0) {
            return Err(Trouble::Fault(fault));
        }
        if homed == Status::Interrupted {
            return Err(Trouble::Stopped);
        }
        let mut notes = Vec::new();
        if homed != Status::Converged {
            notes.push(crate::steps::driver::unbalanced(homed));
        }
        let status = driver.certify(homed);
        driver.starting = false;
        let end = driver.step_result(&step, 0, status, clock.elapsed().as_secs_f64());
        driver.minimiser.forget();
        let checkpoint = Checkpoint { notes, ..driver.stands((0, 0), None, 0.0) };
        Ok(Ended { end, checkpoint })
    }

    /// The next increment of a step whose way is known; behind the last one the checkpoint is that of the step after it.
    ///
    /// # Errors
    /// Where there is no end: somebody stopped it, or a part cannot go on.
    pub fn carry(&mut self, network: &Network, step: &Step, from: &Checkpoint) -> Result<Ended, Trouble> {
        self.increment(network, step, from, false)
    }

    /// One more increment of a step whose way is not known beforehand: what moves goes where the step says, and may go on from there. So
    /// many increments are one step through so many places, at equal fractions of it.
    ///
    /// # Errors
    /// Where there is no end: somebody stopped it, or a part cannot go on.
    pub fn follow(&mut self, network: &Network, step: &Step, from: &Checkpoint) -> Result<Ended, Trouble> {
        self.increment(network, step, from, true)
    }

    fn increment(&mut self, network: &Network, step: &Step, from: &Checkpoint, open: bool) -> Result<Ended, Trouble> {
        let clock = Instant::now();
        let (index, increment) = (from.step_index, from.increment + 1);
        let (mut notes, spent, plan) = (from.notes.clone(), from.seconds, from.plan.clone());
        let clearances = self.clearances;
        let mut driver = self.driver(network, from.clone());
        driver.minimiser.forget();
        let plan = match plan {
            Some(plan) => plan,
            None if increment > 1 => {
                let constraints = &driver.problem.conditions().constraints;
                let journeys: Vec<Journey> =
                    step.moves.iter().flat_map(|m| m.journeys(|f| constraints[f].base)).collect();
                Plan::new(&driver.problem, step, journeys)
            }
            None => driver.begin(step, index == 0, &mut notes),
        };
        let fraction = |k: usize| k as f64 / step.increments as f64;
        let fractions = if open { [0.0, 1.0] } else { [fraction(increment - 1), fraction(increment)] };
        let seconds = || spent + clock.elapsed().as_secs_f64();
        let end = driver.carry((step, &plan), (index, increment), fractions, clearances, seconds);
        if let Ok(end) = &end
            && is_balanced(end.status)
        {
            driver.problem.commit(&driver.state);
            driver.fault = driver.problem.fault(false);
        }
        let fault = driver.named_fault(step, increment);
        let last = !open && increment == step.increments;
        let plan = (!open && !last).then_some(&plan);
        let checkpoint =
            Checkpoint { notes, ..driver.stands((index, increment), plan, spent + clock.elapsed().as_secs_f64()) };
        let certifier = driver.certifier;
        self.certifier = Some((network.id, certifier));
        match (fault, end) {
            (Some(fault), _) => Err(Trouble::Fault(fault)),
            (None, Ok(end)) => {
                Ok(Ended { end, checkpoint: if last { checkpoint.with_step_ended() } else { checkpoint } })
            }
            (None, Err(_)) => Err(Trouble::Stopped),
        }
    }

    /// The same checkpoint with the harness in balance, more finely than usual; `None` where no balance is found from there, or somebody
    /// stopped it.
    pub fn balance(&mut self, network: &Network, from: Checkpoint) -> Option<Checkpoint> {
        let stood = from.clone();
        let mut driver = self.driver(network, from);
        driver.minimiser.forget();
        let stop = driver.stop;
        driver.stop.force_tolerance *= FINER;
        let finer = driver.solve();
        driver.stop = stop;
        let balanced = !driver.is_over() && driver.certify(finer) == Status::Converged;
        let found = balanced.then(|| Checkpoint {
            plan: stood.plan,
            notes: stood.notes,
            ..driver.stands((stood.step_index, stood.increment), None, stood.seconds)
        });
        let certifier = driver.certifier;
        self.certifier = Some((network.id, certifier));
        found
    }

    fn driver<'n>(&mut self, network: &'n Network, from: Checkpoint) -> Driver<'n, '_> {
        let (mut driver, _) = Driver::at(network, &mut *self.minimiser, &self.stop, from, &self.monitor);
        if let Some((_, certifier)) = self.certifier.take().filter(|(id, _)| *id == network.id) {
            driver.certifier = certifier;
        }
        driver
    }
}
