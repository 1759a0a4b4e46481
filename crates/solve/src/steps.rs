//! The step driver: carries out the assembly in increments, each of which ends in an equilibrium.

mod homing;
mod refine;

pub use homing::start_near;

use crate::certificate::{Certifier, FEASIBLE};
use crate::checkpoint::{Checkpoint, Observer, Resumed};
use crate::events::{self, EventLog, Occurrence};
use crate::lost_turns::LostTurns;
use crate::plan::{self, Plan};
use crate::stability::Inspection;
use crate::{clips, link, operations, result, start};
use std::time::Instant;
use wireloom_core::contact::Rounds;
use wireloom_core::equilibrium::{MinimiserResult, OperationResult, PartFamily, PartFault, Run, StepResult};
use wireloom_core::minimiser::{Minimiser, Report, Status, Stop};
use wireloom_core::problem::{Conditions, Problem};
use wireloom_core::sliding::{SlideStop, Sliding};
use wireloom_core::steps::{Journey, Schedule, Step};
use wireloom_core::{EventKind, EventPlace, Moment, Monitor, Network, State};

/// An increment that fails is halved, its halves likewise, up to this many times.
const CUT_BACKS: u32 = 4;
/// So many times the iterations of an increment are allowed where parts may snap: in homing, and where smaller
/// increments did not help.
const SNAP_ITERATIONS: usize = 20;
/// Smallest part of a step that is tried where an obstacle moves against a cable.
const SMALLEST_PART: f64 = 1e-4;
/// Force tolerance above which contact is not met strictly either: nobody sees such a state.
const STRICT: f64 = 1e-3;
/// Friction is settled in so many rounds, or the increment is cut back.
const FRICTION_ROUNDS: usize = 40;
/// The multipliers of equations are updated so many times, or the increment is cut back.
const MULTIPLIER_ROUNDS: usize = 40;
/// Arc lengths that differ by less than this share of the branch are the same.
const SAME_PLACE: f64 = 1e-12;
/// Shares of a step that differ by less than this are the same.
const SAME_SHARE: f64 = 1e-9;
/// Turns that a fixing may make at once: half a turn would look the same either way round.
const LARGEST_TURNS: f64 = 0.2;

/// What is said where forces are in balance but for what double precision makes of stiff parts.
const ROUND_OFF: &str = "forces are in balance up to round-off, which is above force_tolerance: parts of the harness are very stiff beside \
                         what acts on them";

/// How far a run is.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// Name of the step.
    pub step: String,
    /// Which step, from 0.
    pub step_index: usize,
    /// Number of steps.
    pub steps: usize,
    /// Which increment of it, from 1.
    pub increment: usize,
    /// Increments of the step.
    pub increments: usize,
    /// Iterations spent in the step so far.
    pub iterations: usize,
}

/// What an observer wants next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Go on.
    Continue,
    /// Stop here; what has been computed is kept.
    Stop,
}

/// The run of a schedule.
pub(crate) struct Driver<'n, 'm> {
    pub(crate) problem: Problem<'n>,
    pub(crate) minimiser: &'m mut dyn Minimiser,
    pub(crate) stop: Stop,
    pub(crate) certifier: Certifier,
    pub(crate) state: State,
    before: State,
    iterations: usize,
    polish: usize,
    factorisations: usize,
    residual: f64,
    /// Whether what is left of forces is above the tolerance, but round-off.
    round_off: bool,
    /// What the second derivatives say of the state, where they were looked at.
    inspection: Option<Inspection>,
    /// How far equations of fixings are from being met, in units of their scales.
    unmet: Option<f64>,
    /// A fixing, a joint or the minimiser that cannot go on, and why.
    pub(crate) fault: Option<(PartFamily, usize, String)>,
    /// While the start is being found nothing slides.
    pub(crate) homing: bool,
    log: EventLog,
    /// Follows the twist, once the start is found: which way that was turned nobody has asked.
    turns: Option<LostTurns>,
    /// Most turns that a fixing makes in the step at hand.
    turns_asked: f64,
    /// What was lost of the twist where the harness stands.
    lost: Vec<Occurrence>,
    /// The smallest part of an increment at hand that was carried out at once.
    smallest: f64,
    /// How far the harness moved in the increment before, m; `None` in the first of a step that lets go of something, takes hold or
    /// changes loads: there any motion may be.
    pace: Option<f64>,
    /// What the operations of the step at hand came to so far.
    operations: Vec<OperationResult>,
}

/// What a checkpoint says of the run, beside where the harness is.
pub(crate) struct Stood {
    plan: Option<Plan>,
    step_index: usize,
    increment: usize,
    seconds: f64,
    status: Status,
    notes: Vec<String>,
    kept: usize,
}

/// Whether an increment may be followed by another one.
pub(crate) fn is_balanced(status: Status) -> bool {
    matches!(status, Status::Converged | Status::Stalled)
}

/// What is said of a start that was not found.
pub(crate) fn unbalanced(status: Status) -> String {
    format!("the start was not balanced: {}", status.word())
}

/// Nothing is done yet.
fn begun(schedule: &Schedule) -> Run {
    Run {
        scenario: schedule.scenario.clone(),
        status: Status::Converged,
        notes: Vec::new(),
        events: Vec::new(),
        steps: Vec::new(),
        clearances: Vec::new(),
        fault: None,
        plugins: Vec::new(),
    }
}

/// Carries out a schedule; where there is the same harness on a `coarse` mesh, its start is looked for there first. The observer sees
/// every increment's end, may stop the run, and may keep checkpoints; from `resumed` it goes on with a run that one of them kept. The
/// status of the run is that of the first increment that did not converge.
///
/// # Panics
/// If the checkpoint does not fit the network ([`Checkpoint::fits`]) or the schedule.
pub fn carry_out(
    network: &Network,
    coarse: Option<&Network>,
    minimiser: &mut dyn Minimiser,
    stop: &Stop,
    schedule: &Schedule,
    resumed: Option<Resumed>,
    observer: &mut dyn Observer,
) -> Run {
    let mut run = begun(schedule);
    let alone = [Step { name: "equilibrium".into(), increments: 1, ..Step::default() }];
    let steps = if schedule.steps.is_empty() { &alone[..] } else { &schedule.steps };
    let monitor = observer.monitor();
    let mut clock = Instant::now();
    let (mut spent, mut first, mut done, mut begun) = (0.0, 0, 0, None);
    let mut driver = match resumed {
        None => {
            let mut driver = Driver::at_start(network, minimiser, stop, schedule, &monitor);
            let homed = {
                let _step = tracing::info_span!("step", name = steps[0].name, index = 0).entered();
                let _start = tracing::info_span!("increment", index = 0).entered();
                driver.find_start(coarse, schedule, &steps[0].name)
            };
            if homed == Status::Interrupted || driver.fault.is_some() {
                run.status = driver.unless_faulty(homed);
                run.fault = driver.named_fault(&steps[0], 0);
                return run;
            }
            if homed != Status::Converged {
                run.notes.push(unbalanced(homed));
            }
            driver
        }
        Some(Resumed { checkpoint, steps }) => {
            let (driver, stood) = Driver::at(network, minimiser, stop, checkpoint, &monitor);
            (run.status, run.notes, run.steps) = (stood.status, stood.notes, steps);
            run.steps.truncate(stood.kept);
            (spent, first, done, begun) = (stood.seconds, stood.step_index, stood.increment, stood.plan);
            driver
        }
    };
    for (index, step) in steps.iter().enumerate().skip(first) {
        let _span = tracing::info_span!("step", name = step.name, index).entered();
        let plan = begun.take().unwrap_or_else(|| {
            driver.minimiser.forget();
            observer.checkpoint(&driver.checkpoint(&run, (index, 0), None, 0.0));
            driver.begin(step, index == 0, &mut run.notes)
        });
        // The last increment's end, where it is not kept for its own sake.
        let mut passed = (done > 0 && !schedule.increments).then(|| {
            let status = driver.certify(Status::Stalled);
            driver.step_result(step, done, status, spent)
        });
        for increment in std::mem::take(&mut done) + 1..=step.increments {
            let share = |k: usize| k as f64 / step.increments as f64;
            let shares = [share(increment - 1), share(increment)];
            let seconds = || spent + clock.elapsed().as_secs_f64();
            let end = match driver.carry((step, &plan), (index, increment), shares, schedule.clearances, seconds) {
                Ok(end) => end,
                Err(status) => {
                    run.steps.extend(passed);
                    run.status = status;
                    run.fault = driver.named_fault(step, increment);
                    driver.log.tell(&mut run);
                    return run;
                }
            };
            let status = end.status;
            let progress = Progress {
                step: step.name.clone(),
                step_index: index,
                steps: steps.len(),
                increment,
                increments: step.increments,
                iterations: driver.iterations,
            };
            let lost = !is_balanced(status);
            let kept = schedule.increments || increment == step.increments || lost;
            let stopped = observer.increment(&progress, &end, kept) == Control::Stop;
            if run.status == Status::Converged {
                run.status = status;
            }
            let all = index + 1 == steps.len() && increment == step.increments;
            // What went wrong before is worth more than that somebody stopped it.
            if stopped && is_balanced(run.status) && !all {
                run.status = Status::Interrupted;
            }
            passed = if kept || stopped {
                run.steps.push(end);
                None
            } else {
                Some(end)
            };
            if lost || stopped {
                driver.log.tell(&mut run);
                return run;
            }
            if driver.round_off && !run.notes.iter().any(|note| note == ROUND_OFF) {
                run.notes.push(ROUND_OFF.to_owned());
            }
            driver.problem.commit(&driver.state);
            driver.fault = driver.problem.fault(false);
            if driver.fault.is_some() {
                run.steps.extend(passed.take());
                run.status = Status::Failed;
                run.fault = driver.named_fault(step, increment);
                driver.log.tell(&mut run);
                return run;
            }
            if increment < step.increments {
                driver.minimiser.forget();
                let seconds = spent + clock.elapsed().as_secs_f64();
                observer.checkpoint(&driver.checkpoint(&run, (index, increment), Some(&plan), seconds));
            }
        }
        tracing::info!(target: "wireloom::step", iterations = driver.iterations, factorisations = driver.factorisations);
        (clock, spent) = (Instant::now(), 0.0);
        (driver.iterations, driver.polish, driver.factorisations) = (0, 0, 0);
    }
    driver.log.tell(&mut run);
    run
}

impl<'n, 'm> Driver<'n, 'm> {
    fn new(
        network: &'n Network,
        minimiser: &'m mut dyn Minimiser,
        stop: &Stop,
        state: State,
        conditions: Conditions,
        monitor: &Monitor,
    ) -> Self {
        let mut problem = Problem::new(network, conditions);
        problem.monitor = monitor.clone();
        Self {
            problem,
            minimiser,
            stop: *stop,
            certifier: Certifier::new(network),
            before: state.clone(),
            state,
            iterations: 0,
            polish: 0,
            factorisations: 0,
            residual: f64::INFINITY,
            round_off: false,
            inspection: None,
            unmet: None,
            fault: None,
            homing: true,
            log: EventLog::default(),
            turns: None,
            turns_asked: 0.0,
            lost: Vec::new(),
            smallest: 1.0,
            pace: None,
            operations: Vec::new(),
        }
    }

    /// The harness laid out, but not in balance.
    pub(crate) fn at_start(
        network: &'n Network,
        minimiser: &'m mut dyn Minimiser,
        stop: &Stop,
        schedule: &Schedule,
        monitor: &Monitor,
    ) -> Self {
        let state = start::place(network, schedule);
        let conditions = Conditions::new(network, schedule.gravity, &state);
        let mut driver = Self::new(network, minimiser, stop, state, conditions, monitor);
        driver.problem.note_overlaps(&driver.state);
        driver
    }

    /// Where a checkpoint stands, and what it says of the run.
    pub(crate) fn at(
        network: &'n Network,
        minimiser: &'m mut dyn Minimiser,
        stop: &Stop,
        checkpoint: Checkpoint,
        monitor: &Monitor,
    ) -> (Self, Stood) {
        let Checkpoint {
            conditions,
            state,
            log,
            plan,
            operations,
            pace,
            step_index,
            increment,
            work,
            seconds,
            status,
            notes,
            kept,
        } = checkpoint;
        let mut driver = Driver::new(network, minimiser, stop, state, conditions, monitor);
        (driver.iterations, driver.polish, driver.factorisations) = work;
        (driver.log, driver.operations, driver.pace, driver.homing) = (log, operations, pace, false);
        (driver, Stood { plan, step_index, increment, seconds, status, notes, kept })
    }

    /// Whether nothing more is to be computed: something cannot go on, or somebody asked to stop.
    pub(crate) fn is_over(&self) -> bool {
        self.fault.is_some() || self.problem.monitor.is_stopped()
    }

    /// From where the harness is laid out to the balanced start of this first step.
    pub(crate) fn find_start(&mut self, coarse: Option<&Network>, schedule: &Schedule, first: &str) -> Status {
        self.log.begin(Moment { step: first.to_owned(), step_index: 0, increment: 0 });
        let nested = coarse.and_then(|coarse| self.come_from(coarse, schedule));
        let status = nested.unwrap_or_else(|| self.bring_home());
        if self.problem.monitor.is_stopped() { Status::Interrupted } else { status }
    }

    /// An increment (of this number, in the step of this number) from one share of the step's plan to another, and its end, looked over; with
    /// `all`, clearances of everything from everything.
    ///
    /// # Errors
    /// A status, where something cannot go on or somebody asked to stop.
    pub(crate) fn carry(
        &mut self,
        (step, plan): (&Step, &Plan),
        (step_index, increment): (usize, usize),
        [a, b]: [f64; 2],
        all: bool,
        seconds: impl FnOnce() -> f64,
    ) -> Result<StepResult, Status> {
        let _span = tracing::info_span!("increment", index = increment).entered();
        self.log.begin(Moment { step: step.name.clone(), step_index, increment });
        let status = self.increment(plan, a, b);
        tracing::info!(
            target: "wireloom::increment",
            status = status.word(),
            iterations = self.iterations,
            factorisations = self.factorisations,
            residual = self.residual,
        );
        if self.fault.is_some() {
            return Err(self.unless_faulty(status));
        }
        if self.problem.monitor.is_stopped() {
            return Err(Status::Interrupted);
        }
        let end = self.step_result(step, increment, status, seconds());
        events::watch(&mut self.log, &mut self.problem, &self.state, &end, &self.stop, all);
        Ok(end)
    }

    /// A status, unless a part cannot go on: what was graded before it broke down counts no more.
    fn unless_faulty(&self, status: Status) -> Status {
        if self.fault.is_some() { Status::Failed } else { status }
    }

    /// What must be kept to go on with a run from here.
    fn checkpoint(&self, run: &Run, done: (usize, usize), plan: Option<&Plan>, seconds: f64) -> Checkpoint {
        let (notes, kept) = (run.notes.clone(), run.steps.len());
        Checkpoint { status: run.status, notes, kept, ..self.stands(done, plan, seconds) }
    }

    /// Where the harness stands: everything of the driver is named, so that nothing new is forgotten.
    pub(crate) fn stands(&self, done: (usize, usize), plan: Option<&Plan>, seconds: f64) -> Checkpoint {
        let Self {
            problem,
            state,
            iterations,
            polish,
            factorisations,
            log,
            operations,
            pace,
            // Made anew by the next increment, or the same in every run:
            minimiser: _,
            stop: _,
            certifier: _,
            before: _,
            residual: _,
            round_off: _,
            inspection: _,
            unmet: _,
            fault: _,
            homing: _,
            turns: _,
            turns_asked: _,
            lost: _,
            smallest: _,
        } = self;
        Checkpoint {
            conditions: problem.conditions().clone(),
            state: state.clone(),
            log: log.clone(),
            plan: plan.cloned(),
            operations: operations.clone(),
            pace: *pace,
            step_index: done.0,
            increment: done.1,
            work: (*iterations, *polish, *factorisations),
            seconds,
            status: Status::Converged,
            notes: Vec::new(),
            kept: 0,
        }
    }

    /// One increment, from share `a` to share `b` of a plan, and what had to be done to find its end.
    fn increment(&mut self, plan: &Plan, a: f64, b: f64) -> Status {
        self.smallest = 1.0;
        self.turns.get_or_insert_with(|| LostTurns::new(self.problem.network));
        self.turns_asked = plan.turns(1.0);
        let began = self.state.clone();
        let before = self.problem.conditions().clone();
        let (mut status, mut to) = self.advance_through(plan, a, b);
        let mut fallen = false;
        while status == Status::IterationLimit && !self.is_over() && self.lost.is_empty() {
            fallen = true;
            status = self.let_snap();
            self.look_for_passing(status);
            if !is_balanced(status) {
                break;
            }
            self.watch_operations(plan, to);
            if to < b {
                (status, to) = self.advance_through(plan, to, b);
            }
        }
        if self.smallest < 1.0 {
            let parts = 1.0 / self.smallest;
            self.log.raise(Occurrence {
                kind: EventKind::CutBack,
                place: EventPlace::default(),
                value: Some(parts),
                limit: None,
                message: format!("did not converge at once; parts as small as 1/{parts:.0} were tried"),
            });
        }
        for lost in self.lost.drain(..) {
            self.log.raise(lost);
        }
        status = self.refine(status);
        if matches!(status, Status::Converged | Status::Stalled) {
            let moved = result::farthest(&began, &self.state);
            let given = events::prescribed(&self.problem, &before.targets);
            let length = self.problem.scales().length;
            // What falls out of a fixing has an event of its own.
            let pace = self.pace.filter(|_| self.problem.conditions().active == before.active);
            if let Some(jump) = events::jump(moved, pace, given, length, fallen) {
                self.log.raise(jump);
            }
            self.pace = Some(moved);
        }
        status
    }

    /// Where something goes round, tells of cables that have passed through themselves since `before`.
    fn look_for_passing(&mut self, status: Status) {
        if is_balanced(status) && self.turns.is_some() && self.turns_asked > 0.0 {
            for passed in link::passed(&self.problem, &self.before, &self.state) {
                self.log.raise(passed);
            }
        }
    }

    /// Smaller increments did not help: the equilibrium that was followed has ceased to exist, and the harness falls to
    /// another one. Goes on downhill, however far that is.
    fn let_snap(&mut self) -> Status {
        let stop = self.stop;
        self.stop.max_iterations = snap_iterations(&stop);
        let status = self.solve();
        self.stop = stop;
        status
    }

    /// Adds and releases what the step says, and plans its motions.
    pub(crate) fn begin(&mut self, step: &Step, first: bool, notes: &mut Vec<String>) -> Plan {
        let network = self.problem.network;
        self.problem.change(|c| {
            for &f in &step.release {
                c.active[f] = false;
            }
            for &f in &step.add {
                c.active[f] = true;
            }
        });
        notes.extend(self.put_in_place(&step.add).into_iter().map(|note| format!("step `{}`: {note}", step.name)));
        for &f in &step.add {
            self.problem.begin_fixing(f, &self.state);
        }
        self.operations = operations::begin(&step.operations, &self.problem, &self.state);
        let fixings = &self.problem.conditions().fixings;
        let mut journeys: Vec<Journey> = step.moves.iter().flat_map(|m| m.journeys(|f| fixings[f].base)).collect();
        for &f in &step.add {
            if !journeys.iter().any(|journey| journey.fixing() == f) {
                journeys.push(plan::home(f, &network.fixings[f], fixings[f].base));
            }
        }
        let begun = |f: &usize| step.add.contains(f) || first && network.fixings[*f].from_start;
        let begun = (0..network.fixings.len()).filter(begun).collect();
        let plan = Plan::new(&self.problem, step, journeys).beginning(begun);
        let moves_only = step.add.is_empty() && step.release.is_empty() && !plan.changes_loads();
        self.pace = moves_only.then_some(0.0);
        plan
    }

    /// From share `a` to share `b` of a plan, in as many parts as it takes to follow its turns and to pass through every
    /// point of its paths. Returns also the share of the plan that was come to; what lies behind it was not tried.
    fn advance_through(&mut self, plan: &Plan, a: f64, b: f64) -> (Status, f64) {
        let mut corners: Vec<f64> =
            plan.corners.iter().copied().filter(|t| a + SAME_SHARE < *t && *t < b - SAME_SHARE).collect();
        corners.push(b);
        corners.sort_by(f64::total_cmp);
        corners.dedup_by(|next, last| *next - *last < SAME_SHARE);
        let mut corners = corners.into_iter();
        let (mut from, mut corner, mut status) = (a, a, Status::Converged);
        // There may be more parts than memory has room for.
        loop {
            if from >= corner {
                let Some(next) = corners.next() else { break };
                corner = next;
            }
            let mut to = corner;
            // Not everything goes round evenly.
            loop {
                let parts = plan.parts(from, to, LARGEST_TURNS);
                if parts <= 1.0 {
                    break;
                }
                to = from + (to - from) / parts;
                if to - from < SAME_SHARE {
                    // More turns than can be followed.
                    return (Status::Failed, from);
                }
            }
            status = self.advance(plan, from, to, CUT_BACKS);
            from = to;
            if !is_balanced(status) {
                break;
            }
            self.watch_operations(plan, to);
        }
        (status, from)
    }

    /// Looks at the operations of a plan where this share of it is done.
    fn watch_operations(&mut self, plan: &Plan, share: f64) {
        let reaction = |f: usize| self.problem.reaction(f, &self.state, &self.certifier.gradient).0;
        operations::watch(&plan.operations, &mut self.operations, self.problem.network, share, reaction);
    }

    /// From share `a` to share `b` of a plan; halved where it does not converge.
    fn advance(&mut self, plan: &Plan, a: f64, b: f64, cuts: u32) -> Status {
        self.before.copy_from(&self.state);
        let began = self.problem.conditions().clone();
        plan.apply(&mut self.problem, b);
        let poses = plan.moves_obstacles().then_some(began.contact.poses.as_slice());
        let run_over = poses.is_some() && self.problem.free_share(&self.before, &self.state, poses) < 1.0;
        if run_over && b - a > SMALLEST_PART {
            // An obstacle would go through the cable: in smaller parts it pushes it.
            self.go_back(&began, |_| false);
            let middle = 0.5 * (a + b);
            let half = self.advance(plan, a, middle, cuts);
            let balanced = matches!(half, Status::Converged | Status::Stalled);
            return if balanced { self.advance(plan, middle, b, cuts) } else { half };
        }
        let status = self.solve_from(&began);
        self.look_for_passing(status);
        if matches!(status, Status::Converged | Status::Stalled) || cuts == 0 || self.is_over() {
            return status;
        }
        let (failed, lost) = (self.state.clone(), self.lost.clone());
        self.smallest = self.smallest.min(0.5_f64.powi((CUT_BACKS - cuts + 1) as i32));
        self.go_back(&began, |_| false);
        let middle = 0.5 * (a + b);
        let half = self.advance(plan, a, middle, cuts - 1);
        if self.is_over() {
            return half;
        }
        if !matches!(half, Status::Converged | Status::Stalled) {
            // Keep what got furthest: the whole increment's last state.
            self.state = failed;
            self.lost = lost;
            plan.apply(&mut self.problem, b);
            return self.certify(status);
        }
        self.advance(plan, middle, b, cuts - 1)
    }

    /// The equilibrium under the conditions at hand, where the increment began under others. What slipped then is taken to slip on; where
    /// it turns out that it would have to slip backward, it sticks to begin with, and all does where no balance is found.
    fn solve_from(&mut self, began: &Conditions) -> Status {
        let mut sticks: Vec<bool> = (0..began.sliding.len()).map(|k| !self.problem.slips(k)).collect();
        loop {
            let status = self.solve();
            let balanced = matches!(status, Status::Converged | Status::Stalled);
            let turned = |k: usize| !balanced || self.problem.slips_backward(k, &self.before, &self.state);
            let found: Vec<usize> = (0..sticks.len()).filter(|&k| !sticks[k] && turned(k)).collect();
            if found.is_empty() || self.is_over() {
                return status;
            }
            found.into_iter().for_each(|k| sticks[k] = true);
            self.go_back(began, |k| sticks[k]);
        }
    }

    /// Back to where the increment began, under the conditions at hand; what `sticks` does so to begin with.
    fn go_back(&mut self, began: &Conditions, sticks: impl Fn(usize) -> bool) {
        self.state.copy_from(&self.before);
        if self.problem.conditions().active != began.active {
            self.problem.change(|c| c.active.clone_from(&began.active));
        }
        self.problem.set_multipliers(began);
        self.problem.set_contacts(began);
        for (k, sliding) in began.sliding.iter().enumerate() {
            let with_friction = self.problem.network.slides[k].friction > 0.0;
            self.problem.set_sliding(k, if with_friction && sticks(k) { Sliding::Stuck } else { *sliding });
        }
    }

    /// The equilibrium under the conditions at hand, friction and what runs out of its fixing included.
    pub(crate) fn solve(&mut self) -> Status {
        let mut status = self.minimise();
        for _ in 0..FRICTION_ROUNDS {
            if self.homing || !matches!(status, Status::Converged | Status::Stalled) {
                return status;
            }
            let ran_out = self.drop_what_ran_out();
            if !(self.problem.update_friction(&self.state, &self.certifier.gradient) || ran_out) {
                return status;
            }
            status = self.minimise();
        }
        Status::IterationLimit
    }

    /// The least energy under the conditions at hand. Where fixings set equations, or cables touch obstacles, multipliers are updated around
    /// the minimiser until everything is met (Hestenes 1969, Powell 1969).
    fn minimise(&mut self) -> Status {
        let (mut last, mut rounds) = (Vec::new(), Rounds::default());
        let let_pass = (self.stop.force_tolerance / STRICT).max(1.0);
        for round in 1..=MULTIPLIER_ROUNDS {
            let report = self.minimise_once();
            self.iterations += report.iterations;
            self.polish += report.polish;
            self.factorisations += report.factorisations;
            if self.problem.monitor.is_stopped() {
                return Status::Interrupted;
            }
            let balanced = matches!(report.status, Status::Converged | Status::Stalled);
            let tolerance = FEASIBLE * self.stop.force_tolerance;
            let met = self.problem.unmet(&self.state).is_none_or(|unmet| unmet.value <= tolerance)
                && self.problem.contact_unmet(&self.state).is_none_or(|unmet| unmet <= let_pass);
            // Only what is met everywhere else is worth looking at between spots.
            let more = balanced
                && met
                && round < MULTIPLIER_ROUNDS
                && self.lost.is_empty()
                && self.problem.refine_spots(&self.state);
            if more {
                continue;
            }
            if !balanced || met || round == MULTIPLIER_ROUNDS || !self.lost.is_empty() {
                let status = self.certify(if balanced && !met { Status::IterationLimit } else { report.status });
                let found = self.problem.fault(!matches!(status, Status::Converged | Status::Stalled));
                let own = self.minimiser.fault().map(|message| (PartFamily::Minimiser, 0, message));
                self.fault = self.fault.take().or(found).or(own);
                return if self.fault.is_some() { Status::Failed } else { status };
            }
            self.problem.update_multipliers(&self.state, tolerance, &mut last);
            self.problem.update_contacts(&self.state, &mut rounds);
        }
        Status::IterationLimit
    }

    /// One call of the minimiser, in which the twist is followed.
    fn minimise_once(&mut self) -> Report {
        self.lost.clear();
        let Some(turns) = &mut self.turns else {
            return self.minimiser.minimise(&mut self.problem, &mut self.state, &self.stop);
        };
        turns.begin(&self.problem, &self.state);
        let report = self.minimiser.minimise(&mut self.problem, &mut self.state, &self.stop);
        if turns.end(&self.problem, &self.state) {
            self.lost = turns.occurrences(&self.problem, &self.before, self.turns_asked);
        }
        report
    }

    /// The fault that ended the run.
    pub(crate) fn named_fault(&self, step: &Step, increment: usize) -> Option<PartFault> {
        let (family, index, message) = self.fault.clone()?;
        let network = self.problem.network;
        let (name, kind) = match family {
            PartFamily::Constraint => (network.fixings[index].name.as_str(), network.fixings[index].kind.as_str()),
            PartFamily::Joint => (network.joints[index].name.as_str(), network.joints[index].kind.as_str()),
            PartFamily::Minimiser => (self.minimiser.name(), self.minimiser.name()),
        };
        let (name, kind, step) = (name.to_owned(), kind.to_owned(), step.name.clone());
        Some(PartFault { family, name, kind, step, increment, message })
    }

    /// Takes away the fixings that the cable has run out of. Returns whether there was one.
    fn drop_what_ran_out(&mut self) -> bool {
        let network = self.problem.network;
        let mut dropped = false;
        for (k, site) in network.slides.iter().enumerate() {
            if self.problem.slide_stop(k, &self.certifier.gradient) == Some(SlideStop::End) {
                self.problem.change(|c| c.active[site.fixing] = false);
                let s = self.state.arc_lengths(network, site.branch);
                let knots: Vec<_> = self.problem.knots(site.branch).into_iter().map(|node| (node, s[node])).collect();
                self.move_mesh(site.branch, &knots);
                dropped = true;
                let fixing = &network.fixings[site.fixing].name;
                let branch = &network.branches[site.branch].name;
                self.log.raise(Occurrence {
                    kind: EventKind::LeftRing,
                    place: EventPlace { fixing: Some(fixing.clone()), ..EventPlace::branch(branch, s[site.node]) },
                    value: None,
                    limit: None,
                    message: "the cable ran out of it over its end: it no longer acts".into(),
                });
            }
        }
        dropped
    }

    /// Brings the stations of fixings that begin to the arc lengths they were given, or to the nearest ones: where the mesh has moved along
    /// the cable since, it moves once more. Returns remarks.
    fn put_in_place(&mut self, added: &[usize]) -> Vec<String> {
        let network = self.problem.network;
        let mut notes = Vec::new();
        for (b, _) in network.branches.iter().enumerate().filter(|(_, branch)| branch.mesh_moves) {
            let s = self.state.arc_lengths(network, b);
            let mut knots: Vec<_> = self.problem.knots(b).into_iter().map(|node| (node, s[node])).collect();
            notes.extend(clips::put_in_place(network, &self.state, b, added, &mut knots));
            if knots.iter().any(|&(node, to)| (to - s[node]).abs() > SAME_PLACE * s[s.len() - 1]) {
                let moved = self.move_mesh(b, &knots);
                debug_assert!(moved, "arc lengths increase: {knots:?}");
            }
        }
        notes
    }

    /// Moves the mesh of a branch along it; see [`Network::move_mesh`].
    fn move_mesh(&mut self, branch: usize, knots: &[(usize, f64)]) -> bool {
        let network = self.problem.network;
        let before = result::twist_turns(self.state.branch(network, branch).frames);
        let moved = network.move_mesh(branch, knots, &mut self.state);
        let gone = before - result::twist_turns(self.state.branch(network, branch).frames);
        if gone.abs() > 0.5 {
            self.log.raise(Occurrence {
                kind: EventKind::TwistLost,
                place: EventPlace { branch: Some(network.branches[branch].name.clone()), ..EventPlace::default() },
                value: Some(gone.abs().round()),
                limit: None,
                message: "its mesh, moved along the cable, does not hold the twist any more: more segments may".into(),
            });
        }
        moved
    }

    /// Grades the state as it is now.
    pub(crate) fn certify(&mut self, claimed: Status) -> Status {
        let certificate = self.certifier.certify(&mut self.problem, &self.state, &self.stop, claimed);
        self.residual = certificate.residual;
        self.round_off = certificate.round_off;
        self.unmet = certificate.unmet.map(|unmet| unmet.value);
        // In balance, but with other twist than was asked for.
        if self.lost.is_empty() || !is_balanced(certificate.status) { certificate.status } else { Status::Failed }
    }

    pub(crate) fn step_result(&mut self, step: &Step, increment: usize, status: Status, seconds: f64) -> StepResult {
        // A state that is not balanced is neither, and under dead moments only some instability can be told.
        let known = status == Status::Converged && !self.problem.has_dead_moments();
        let inspect = || self.certifier.inspect(&mut self.problem, &self.state);
        let inspection = self.inspection.take().or_else(|| known.then(inspect));
        let stable = match status {
            Status::Converged if !known => self.certifier.diverges(&mut self.problem, &self.state).then_some(false),
            _ => inspection.filter(|_| known).and_then(|inspection| inspection.stability.flag()),
        };
        let (problem, state) = (&mut self.problem, &self.state);
        let network = problem.network;
        let touching = problem.touching_points(state);
        let branch = |b: usize| result::branch(problem, b, state, &touching);
        let branches: Vec<_> = (0..network.branches.len()).map(branch).collect();
        StepResult {
            name: step.name.clone(),
            increment,
            increments: step.increments,
            status,
            joints: network.joints.iter().map(|j| result::joint(problem, j, state, &touching)).collect(),
            constraints: result::constraints(problem, state, &self.certifier.gradient),
            obstacles: result::obstacles(problem, state),
            operations: self.operations.clone(),
            energy: problem.energy(state),
            min_bend_radius: result::tightest_bend(&branches),
            branches,
            stable,
            minimiser: MinimiserResult {
                kind: self.minimiser.name().to_owned(),
                device: self.minimiser.device(),
                iterations: self.iterations,
                polish: self.polish,
                factorisations: self.factorisations,
                seconds,
                force_residual: self.residual,
                shape_error: inspection.map(|inspection| inspection.move_left),
                constraint_residual: self.unmet,
            },
        }
    }
}

/// Iterations allowed where parts may snap. Who allows few wants to see them used up.
fn snap_iterations(stop: &Stop) -> usize {
    if stop.max_iterations < Stop::default().max_iterations / 2 {
        stop.max_iterations
    } else {
        SNAP_ITERATIONS * stop.max_iterations
    }
}
