//! Interactive driver: advances a harness by one increment at a time, from any checkpoint. The results are those of
//! [`crate::carry_out`] with the same steps, to the bit.

use crate::report::clearance::Cables;
use crate::report::discretisation::NodalErrors;
use crate::report::spans::Spans;
use crate::steps::certificate::Certifier;
use crate::steps::checkpoint::Checkpoint;
use crate::steps::driver::{Driver, is_balanced, unbalanced_start_note};
use crate::steps::guide::Guide;
use crate::steps::initial_equilibrium::start_near;
use crate::steps::nearby::{Moved, NotFound};
use crate::steps::plan::Plan;
use crate::steps::progress::Interruption;
use std::time::Instant;
use wireloom_core::conditions::Conditions;
use wireloom_core::equilibrium::{RequirementResult, StepResult, Violation};
use wireloom_core::minimiser::{Minimiser, Stop};
use wireloom_core::requirement::Measure;
use wireloom_core::status::Status;
use wireloom_core::steps::{Schedule, Step};
use wireloom_core::{Event, Monitor, Network, Pose};

/// Factor on the force tolerance of [`InteractiveDriver::balance`]: the visible result then does not depend on the
/// start.
const FINER: f64 = 1e-3;
/// Name of the result before all steps.
const START: &str = "start";

/// End of an increment.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    /// Result.
    pub end: StepResult,
    /// Checkpoint to continue from; only meaningful if the increment ended in balance.
    pub checkpoint: Checkpoint,
    /// The sheet so far: the worst value of each requirement over the increments up to here, of which none passes if
    /// the last one did not converge. At the start that of the initial equilibrium, which belongs to no step and does
    /// not count further on.
    pub requirements: Vec<RequirementResult>,
    /// The same over the increments of this step alone.
    pub requirements_of_step: Vec<RequirementResult>,
    /// Whether the worst value of each requirement was found between the ends of its increment; empty at the start.
    pub on_the_way: Vec<bool>,
    /// Estimated discretisation errors of this result, by branch.
    pub errors: Vec<NodalErrors>,
}

impl Ended {
    /// Whether another increment may follow.
    pub fn is_balanced(&self) -> bool {
        is_balanced(self.end.status)
    }
}

impl Checkpoint {
    /// Events so far.
    pub fn events(&self) -> &[Event] {
        self.log.events()
    }

    /// Remarks so far.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Index of the current step, from 0, and the number of its increments that are done.
    pub fn done(&self) -> (usize, usize) {
        (self.step_index, self.increment)
    }

    /// Approximate size in memory, bytes.
    pub fn weight(&self) -> usize {
        let state = &self.state;
        let points = state.points.len() * (2 * size_of_val(&state.points[0]) + size_of::<f64>());
        let Conditions { rods, joints, .. } = &self.conditions;
        let memories = rods.iter().map(|own| &own.memory).chain(joints.iter().map(|own| &own.memory));
        let memory: usize = memories.map(|memory| size_of_val(&memory[..])).sum();
        points + state.frames.len() * (size_of_val(&state.frames[0]) + size_of::<f64>()) + memory
    }

    /// Target of a constraint in the world: position (m) and orientation.
    pub fn target(&self, constraint: usize) -> Option<Pose> {
        Some(self.conditions.constraints.get(constraint)?.base)
    }

    /// Target of a constraint as in a scenario: of one that is mounted on a body, as the mechanism is drawn.
    pub fn drawn_target(&self, network: &Network, constraint: usize) -> Option<Pose> {
        Some(self.body_under(network, constraint).inverse().compose(&self.target(constraint)?))
    }

    /// Pose of the body on which a constraint is mounted; the identity for one that is mounted on none.
    pub fn body_under(&self, network: &Network, constraint: usize) -> Pose {
        self.conditions.body(network, network.constraints.get(constraint).and_then(|own| own.mount))
    }

    /// Poses of the obstacles.
    pub fn obstacle_poses(&self) -> &[Pose] {
        &self.conditions.contact.poses
    }

    /// Whether a constraint is active.
    pub fn acts(&self, constraint: usize) -> bool {
        self.conditions.active.get(constraint).copied().unwrap_or(false)
    }

    /// The checkpoint after the end of the current step, whose increments were open
    /// ([`InteractiveDriver::advance_open`]).
    pub fn with_step_ended(self) -> Self {
        if self.increment == 0 {
            return self;
        }
        Self { plan: None, step_index: self.step_index + 1, increment: 0, work: (0, 0, 0), seconds: 0.0, ..self }
    }
}

/// Driver of single increments, with its workspace. Every call begins from a checkpoint.
pub struct InteractiveDriver {
    minimiser: Box<dyn Minimiser>,
    stop: Stop,
    /// Whether all clearances are kept, not only the required ones.
    clearances: bool,
    monitor: Monitor,
    certifier: Option<(u64, Certifier)>,
    guide: Option<Guide>,
}

impl InteractiveDriver {
    /// Driver with this minimiser; `clearances` as in [`Schedule::clearances`], `monitor` to stop it.
    pub fn new(minimiser: Box<dyn Minimiser>, stop: Stop, clearances: bool, monitor: Monitor) -> Self {
        Self { minimiser, stop, clearances, monitor, certifier: None, guide: None }
    }

    /// The driver, which searches for the equilibria of planned increments near those of `guide`.
    pub fn guided(self, guide: Option<Guide>) -> Self {
        Self { guide, ..self }
    }

    /// Finds the initial equilibrium as [`crate::carry_out`] does.
    ///
    /// # Errors
    /// If a stop was requested, or a part cannot continue.
    pub fn start(
        &mut self,
        network: &Network,
        coarse: Option<&Network>,
        schedule: &Schedule,
    ) -> Result<Ended, Interruption> {
        let clock = Instant::now();
        let first = schedule.steps.first().map_or("equilibrium", |step| &step.name);
        let mut driver = Driver::at_start(network, &mut *self.minimiser, &self.stop, schedule, &self.monitor);
        let start = driver.find_start(coarse, schedule, first);
        let step = Step { name: START.to_owned(), increments: 1, ..Step::default() };
        if let Some(fault) = driver.part_fault(&step, 0) {
            return Err(Interruption::Fault(fault));
        }
        if start == Status::Interrupted {
            return Err(Interruption::Stopped);
        }
        let mut notes = Vec::new();
        if start != Status::Converged {
            notes.push(unbalanced_start_note(start));
        }
        notes.extend(driver.notes_on_start());
        let grade = driver.certify(start);
        let mut end = driver.step_result(&step, 0, grade, clock.elapsed().as_secs_f64());
        let requirements = driver.check_start(&mut end);
        driver.fault = driver.problem.fault(false);
        if let Some(fault) = driver.part_fault(&step, 0) {
            return Err(Interruption::Fault(fault));
        }
        driver.starting = false;
        driver.minimiser.forget();
        let checkpoint = Checkpoint { status: start.status(), notes, ..driver.snapshot((0, 0), None, 0.0) };
        let (requirements_of_step, on_the_way, errors) = (requirements.clone(), Vec::new(), driver.errors);
        Ok(Ended { end, checkpoint, requirements_of_step, requirements, on_the_way, errors })
    }

    /// Finds the initial equilibrium near that of a similar harness `other`, `start`; `None` if there is none nearby.
    pub fn start_near(
        &mut self,
        network: &Network,
        schedule: &Schedule,
        (other, start): (&Network, &Checkpoint),
    ) -> Option<Ended> {
        let (stop, monitor) = (self.stop, self.monitor.clone());
        let checkpoint = start_near(network, &mut *self.minimiser, &stop, schedule, (other, start), &monitor)?;
        self.minimiser.forget();
        let mut driver = self.driver(network, checkpoint.clone());
        let grade = driver.certify(Status::Converged);
        let step = Step { name: START.to_owned(), increments: 1, ..Step::default() };
        let mut end = driver.step_result(&step, 0, grade, 0.0);
        let requirements = driver.check_start(&mut end);
        let balanced = end.status == Status::Converged && !driver.is_over();
        let (requirements_of_step, on_the_way, errors) = (requirements.clone(), Vec::new(), driver.errors);
        balanced.then_some(Ended { end, checkpoint, requirements_of_step, requirements, on_the_way, errors })
    }

    /// Runs the next increment of a step; after the last one the checkpoint is at the beginning of the next step.
    ///
    /// # Errors
    /// If a stop was requested, or a part cannot continue.
    pub fn advance(&mut self, network: &Network, step: &Step, from: &Checkpoint) -> Result<Ended, Interruption> {
        self.increment(network, step, from, false)
    }

    /// Runs one more increment of an open step, whose path is not known beforehand: the increment ends at the targets
    /// of `step`, and further ones may follow. Together they equal one step through all these targets, at equal
    /// fractions of it.
    ///
    /// # Errors
    /// If a stop was requested, or a part cannot continue.
    pub fn advance_open(&mut self, network: &Network, step: &Step, from: &Checkpoint) -> Result<Ended, Interruption> {
        self.increment(network, step, from, true)
    }

    fn increment(
        &mut self,
        network: &Network,
        step: &Step,
        from: &Checkpoint,
        open: bool,
    ) -> Result<Ended, Interruption> {
        let clock = Instant::now();
        let (index, increment) = (from.step_index, from.increment + 1);
        let (mut notes, spent, plan) = (from.notes.clone(), from.seconds, from.plan.clone());
        let clearances = self.clearances;
        let guide = self.guide.clone().filter(|_| !open);
        let mut driver = self.driver(network, from.clone());
        driver.minimiser.forget();
        driver.guide = guide;
        let plan = match plan {
            Some(plan) => plan,
            None if increment > 1 => Plan::of_step(&driver.problem, step, &[]),
            None => driver.begin_step(step, index == 0, &mut notes),
        };
        let fraction = |k: usize| k as f64 / step.increments as f64;
        let fractions = if open { [0.0, 1.0] } else { [fraction(increment - 1), fraction(increment)] };
        let seconds = || spent + clock.elapsed().as_secs_f64();
        let last = !open && increment == step.increments;
        let end = driver.run_increment((step, &plan), (index, increment, last), fractions, clearances, seconds);
        let plan = (!open && !last).then_some(&plan);
        let checkpoint =
            Checkpoint { notes, ..driver.snapshot((index, increment), plan, spent + clock.elapsed().as_secs_f64()) };
        let status = end.as_ref().map_or(Status::Interrupted, |end| end.status);
        let requirements = driver.log.sheet.lines(network, status);
        let requirements_of_step = driver.log.sheet.lines_of_step(network, status);
        let on_the_way = driver.log.sheet.on_the_way();
        let (certifier, errors) = (driver.certifier, driver.errors);
        self.certifier = Some((network.id, certifier));
        let checkpoint = if last { checkpoint.with_step_ended() } else { checkpoint };
        end.map(|end| Ended { end, checkpoint, requirements, requirements_of_step, on_the_way, errors })
    }

    /// Ends an open step at its newest increment: what holds at the end of a step is checked there. Returns the
    /// checkpoint at the beginning of the next step, and the sheet so far.
    pub fn end_step(
        &mut self,
        network: &Network,
        from: Checkpoint,
        end: &mut StepResult,
    ) -> (Checkpoint, Vec<RequirementResult>) {
        let mut driver = self.driver(network, from.clone());
        driver.began.copy_from(&driver.state);
        // For the errors of the results, which are not part of them.
        let grade = driver.certify(end.status);
        let step = Step { name: end.name.clone(), increments: end.increments, ..Step::default() };
        driver.step_result(&step, end.increment, grade, 0.0);
        let cables = Cables::new(network, &end.branches);
        let spans = Spans::new(&driver.problem, &driver.state);
        driver.check_at_end(end, (&cables, &spans), true);
        // What was driven into each other belongs to the way of the increment.
        let on_the_way = |own: &Violation| own.measure == Measure::Overlap && own.place.constraint.is_some();
        end.violations.retain(on_the_way);
        end.violations.splice(0..0, driver.log.violations().iter().cloned());
        let requirements = driver.log.sheet.lines(network, end.status);
        let (log, certifier) = (driver.log, driver.certifier);
        self.certifier = Some((network.id, certifier));
        (Checkpoint { log, ..from }.with_step_ended(), requirements)
    }

    /// The checkpoint with the harness in equilibrium, to a smaller tolerance than usual; `None` if no equilibrium was
    /// found, or a stop was requested.
    pub fn balance(&mut self, network: &Network, from: Checkpoint) -> Option<Checkpoint> {
        let position = from.clone();
        let mut driver = self.driver(network, from);
        driver.minimiser.forget();
        let stop = driver.stop;
        driver.stop.force_tolerance *= FINER;
        let finer = driver.solve();
        driver.stop = stop;
        let balanced = !driver.is_over() && driver.certify(finer) == Status::Converged;
        let found = balanced.then(|| Checkpoint {
            plan: position.plan,
            notes: position.notes,
            ..driver.snapshot((position.step_index, position.increment), None, position.seconds)
        });
        let certifier = driver.certifier;
        self.certifier = Some((network.id, certifier));
        found
    }

    /// The equilibrium at a checkpoint, and those near it with a constraint moved.
    ///
    /// # Errors
    /// If it is no equilibrium that has neighbours.
    pub fn moved<'n>(&self, network: &'n Network, at: &Checkpoint) -> Result<Moved<'n>, NotFound> {
        Moved::new(network, &self.stop, at)
    }

    fn driver<'n>(&mut self, network: &'n Network, from: Checkpoint) -> Driver<'n, '_> {
        let (mut driver, _) = Driver::at_checkpoint(network, &mut *self.minimiser, &self.stop, from, &self.monitor);
        if let Some((_, certifier)) = self.certifier.take().filter(|(id, _)| *id == network.id) {
            driver.certifier = certifier;
        }
        driver
    }
}
