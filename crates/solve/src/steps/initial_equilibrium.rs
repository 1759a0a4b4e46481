//! Initial equilibrium: from the layout of a harness to the beginning of its first step.

use super::driver::{Driver, is_balanced};
use super::increment::snap_through_iterations;
use crate::minimisers::condensation::Condensation;
use crate::report::EventLog;
use crate::start::prolongation;
use crate::steps::certificate::Grade;
use crate::steps::checkpoint::Checkpoint;
use crate::steps::plan::{self, Plan};
use crate::steps::stability::Stability;
use wireloom_core::conditions::{Conditions, Partner, Sliding};
use wireloom_core::minimiser::{Minimiser, Stop};
use wireloom_core::network::Branch;
use wireloom_core::status::Status;
use wireloom_core::steps::{Schedule, Step};
use wireloom_core::{Moment, Monitor, Network, State, Vector};

/// Least number of increments in which the drawn shape is released and the constraints move to their poses in the
/// scenario.
const START_INCREMENTS: f64 = 10.0;
/// Largest number of increments: they are a means of robustness, and need not resolve the motion.
const MOST_START_INCREMENTS: f64 = 100.0;
/// Motion of a constraint per increment, in lengths of the longest branch.
const START_DISTANCE: f64 = 0.1;
/// Turn of a constraint per increment, rad.
const START_TURN: f64 = 0.3;
/// Force tolerance of all increments but the last: intermediate states need only be near an equilibrium.
const START_TOLERANCE: f64 = 0.1;
/// Turns (rad) by which an unstable equilibrium is disturbed, one after the other until the harness leaves it: with a
/// slow instability the minimiser may return after a small disturbance.
const DISTURBANCES: [f64; 3] = [1e-3, 1e-2, 1e-1];
/// Largest turn (rad) of any frame from the initial equilibrium of another harness: beyond it the harness's own initial
/// equilibrium may be a different one.
const NEAR: f64 = 0.5;
/// Sum of the forces of obstacles, in weights of the harness on earth, above which cables may be caught behind them:
/// what lies on something has 1, what its own bends press to it some, a loop caught around a block had 4,000.
const CAUGHT: f64 = 10.0;
const GRAVITY: f64 = 9.81;
/// Part of the energy by which that of another start must be less.
const LESS: f64 = 1e-3;

/// Initial equilibrium of a harness, found from that of a similar harness `other`, as a checkpoint for
/// [`super::carry_out`]. `None` if the harnesses are not alike, or no equilibrium was found nearby.
pub fn start_near(
    network: &Network,
    minimiser: &mut dyn Minimiser,
    stop: &Stop,
    schedule: &Schedule,
    (other, start): (&Network, &Checkpoint),
    monitor: &Monitor,
) -> Option<Checkpoint> {
    if !prolongation::alike(other, network) {
        return None;
    }
    let mut driver = Driver::at_start(network, minimiser, stop, schedule, monitor);
    let prolonged = prolongation::prolonged(other, &start.state, network);
    let status = driver.relax_from(prolonged.clone());
    let turns = prolonged.frames.iter().zip(&driver.state.frames).map(|(a, b)| a.angle_to(b));
    let near = status == Status::Converged && !driver.is_over() && turns.fold(0.0, f64::max) <= NEAR;
    driver.commit_start(status);
    let notes = driver.notes_on_start();
    near.then(|| Checkpoint { notes, ..driver.snapshot((0, 0), None, 0.0) })
}

/// What a trial begins with.
struct Kept {
    state: State,
    conditions: Conditions,
    log: EventLog,
    starting: bool,
}

impl Driver<'_, '_> {
    /// Finds the initial equilibrium for the first step, by way of a `coarse` mesh if there is one.
    pub(crate) fn find_start(&mut self, coarse: Option<&Network>, schedule: &Schedule, first: &str) -> Grade {
        let _step = tracing::info_span!("step", index = 0, name = first).entered();
        let _increment = tracing::info_span!("increment", index = 0).entered();
        self.log.begin(Moment { step: first.to_owned(), step_index: 0, increment: 0 });
        let from_coarse = coarse.and_then(|coarse| self.start_from_coarse(coarse, schedule));
        let status = from_coarse.unwrap_or_else(|| self.find_initial_equilibrium(schedule));
        self.commit_start(status);
        if self.problem.monitor.is_stopped() { Grade::INTERRUPTED } else { status }
    }

    /// Commits the memories of rods and joints at the initial equilibrium. While it is searched for they are those at
    /// rest, so it does not depend on the way there: the harness was bent from its rest shape as if along a straight
    /// line.
    fn commit_start(&mut self, status: Grade) {
        if is_balanced(status) {
            self.problem.commit_rods_and_joints(&self.state);
        }
    }

    /// Finds an equilibrium from the layout, with the constraints that act from the start at their poses in the
    /// scenario. Loads without a potential are applied last, as only a system with a potential can descend to a stable
    /// equilibrium.
    pub(super) fn find_initial_equilibrium(&mut self, schedule: &Schedule) -> Grade {
        if self.problem.has_potential() {
            return self.find_equilibrium_with_potential(schedule);
        }
        self.problem.set_fraction_without_potential(0.0);
        let status = self.find_equilibrium_with_potential(schedule);
        let mut plan = Plan::new(&self.problem, &Step::default(), Vec::new());
        plan.apply_without_potential = true;
        if self.is_over() {
            plan.apply(&mut self.problem, 1.0);
            return status;
        }
        let fraction = |k: usize| k as f64 / START_INCREMENTS;
        for k in 1..=START_INCREMENTS as usize {
            let (status, _) = self.advance_through(&plan, fraction(k - 1), fraction(k));
            if !is_balanced(status) {
                break;
            }
            if fraction(k) == 1.0 {
                return status;
            }
        }
        plan.apply(&mut self.problem, 1.0);
        self.solve()
    }

    /// Finds an equilibrium of the loads with a potential. Where obstacles block the way there, or cables are caught
    /// behind them, and no path says on which side of them cables run, one is found without obstacles, and with them
    /// from there on. An equilibrium near `initial` stays.
    fn find_equilibrium_with_potential(&mut self, schedule: &Schedule) -> Grade {
        let network = self.problem.network;
        if network.obstacles.is_empty() || network.branches.iter().any(|branch| !branch.path.is_empty()) {
            return self.go_from_layout();
        }
        let beginning = self.keep();
        let status = self.go_from_layout();
        let is_in_the_way =
            status != Status::Converged && self.problem.contact().is_beside_obstacle() || self.is_caught();
        let is_placed = is_balanced(status) && schedule.initial.is_some();
        if !is_in_the_way || self.is_over() || is_placed {
            return status;
        }
        let energy = is_balanced(status).then(|| self.problem.energy(&self.state).total());
        let first = self.keep();
        self.go_back_to(&beginning);
        self.problem.set_obstacles_act(false);
        let free = self.go_from_layout();
        self.problem.set_obstacles_act(true);
        if free == Status::Converged && !self.is_over() {
            let stop = self.stop;
            self.stop.max_iterations = snap_through_iterations(&stop);
            let solved = self.solve();
            let status = self.leave_unstable_start(solved);
            self.stop = stop;
            let now = self.problem.energy(&self.state).total();
            let has_less = energy.is_none_or(|first| now < first - LESS * first.abs());
            if status == Status::Converged && !self.is_over() && has_less {
                self.started_without_obstacles = true;
                return status;
            }
        }
        self.go_back_to(&first);
        self.certify(status)
    }

    /// Whether obstacles push as hard as if cables were caught behind them.
    fn is_caught(&self) -> bool {
        let network = self.problem.network;
        let mass: f64 =
            network.branches.iter().map(Branch::mass).chain(network.joints.iter().map(|own| own.mass)).sum();
        let records = self.problem.conditions().contact.records.iter();
        let pushes = records.filter(|record| matches!(record.partner, Partner::Obstacle { .. }));
        pushes.map(|record| record.multiplier).sum::<f64>() > CAUGHT * GRAVITY * mass
    }

    /// Goes from the layout to an equilibrium. A drawn shape is at first the rest shape, without weight; while the
    /// constraints move, it is replaced by the true rest shape, and the weight is applied. An unstable equilibrium is
    /// left at the end.
    fn go_from_layout(&mut self) -> Grade {
        let stop = self.stop;
        let status = self.go_from_layout_to(stop.force_tolerance);
        self.stop = stop;
        status
    }

    /// See [`Self::go_from_layout`]; changes how minimisations end.
    fn go_from_layout_to(&mut self, force_tolerance: f64) -> Grade {
        let network = self.problem.network;
        let mut journeys = Vec::new();
        let mut increments = START_INCREMENTS;
        let length = self.problem.scales().length;
        for (f, constraint) in network.constraints.iter().enumerate().filter(|(_, constraint)| constraint.from_start) {
            let from = self.problem.conditions().constraints[f].base;
            let journey = plan::journey_to_target(f, constraint, from);
            let to = journey.at(1.0);
            increments = increments
                .max((to.position - from.position).norm() / (START_DISTANCE * length))
                .max(to.orientation.angle_to(&from.orientation) / START_TURN);
            journeys.push(journey);
        }
        let increments = increments.min(MOST_START_INCREMENTS).ceil() as usize;
        let gravity = self.problem.conditions().gravity;
        let weightless = !network.branches.iter().all(|b| b.path.is_empty());
        if weightless {
            self.problem.change(|c| c.gravity = Vector::zeros());
            self.problem.hold_drawn_shape(&self.state);
        }
        let step = Step { gravity: Some(gravity), ..Step::default() };
        let mut plan = Plan::new(&self.problem, &step, journeys);
        plan.release_drawn_shape = weightless;
        // Snap-through needs more iterations, not smaller increments.
        self.stop.max_iterations = snap_through_iterations(&self.stop);
        self.stop.force_tolerance = force_tolerance.max(START_TOLERANCE);
        let (mut status, _) = self.advance(&plan, 0.0, 0.0, 0);
        for k in 1..=increments {
            if k == increments {
                self.stop.force_tolerance = force_tolerance;
            }
            let (a, b) = ((k - 1) as f64 / increments as f64, k as f64 / increments as f64);
            (status, _) = self.advance_through(&plan, a, b);
            if !is_balanced(status) {
                break;
            }
        }
        if self.is_over() {
            return status;
        }
        if !is_balanced(status) {
            // The path is blocked: apply the final conditions and descend from here.
            self.stop.force_tolerance = force_tolerance;
            plan.apply(&mut self.problem, 1.0);
            status = self.solve();
        }
        self.end_start(status)
    }

    /// Finds the initial equilibrium from that on a coarse mesh. `None` if that fails; the harness then is in its
    /// layout again.
    pub(super) fn start_from_coarse(&mut self, coarse: &Network, schedule: &Schedule) -> Option<Grade> {
        let monitor = &self.problem.monitor;
        let mut coarse_driver = Driver::at_start(coarse, &mut *self.minimiser, &self.stop, schedule, monitor);
        let status = coarse_driver.find_initial_equilibrium(schedule);
        let (state, work) =
            (coarse_driver.state, (coarse_driver.iterations, coarse_driver.polish, coarse_driver.factorisations));
        let without_obstacles = coarse_driver.started_without_obstacles;
        self.iterations += work.0;
        self.polish += work.1;
        self.factorisations += work.2;
        if self.problem.monitor.is_stopped() {
            return Some(Grade::INTERRUPTED);
        }
        if status != Status::Converged {
            return None;
        }
        let network = self.problem.network;
        let beginning = self.keep();
        let stop = self.stop;
        self.stop.max_iterations = snap_through_iterations(&stop);
        let status = self.relax_from(prolongation::prolonged(coarse, &state, network));
        self.stop = stop;
        if status != Status::Converged {
            self.go_back_to(&beginning);
            return None;
        }
        self.started_without_obstacles = without_obstacles;
        Some(status)
    }

    /// What a trial begins with.
    fn keep(&self) -> Kept {
        let (state, conditions) = (self.state.clone(), self.problem.conditions().clone());
        Kept { state, conditions, log: self.log.clone(), starting: self.starting }
    }

    /// Goes back to where a trial began, which need not succeed: nor does a fault of it count.
    fn go_back_to(&mut self, kept: &Kept) {
        self.state.copy_from(&kept.state);
        for (f, own) in kept.conditions.constraints.iter().enumerate() {
            self.problem.set_target(f, own.base);
        }
        self.take_back(&kept.conditions);
        self.log.clone_from(&kept.log);
        self.starting = kept.starting;
        self.lost_twist.clear();
        self.fault = None;
    }

    /// Finds an equilibrium near `state`, with the constraints that act from the start at their poses in the scenario.
    fn relax_from(&mut self, state: State) -> Grade {
        let network = self.problem.network;
        for (f, constraint) in network.constraints.iter().enumerate().filter(|(_, constraint)| constraint.from_start) {
            let from = self.problem.conditions().constraints[f].base;
            self.problem.set_target(f, plan::journey_to_target(f, constraint, from).at(1.0));
        }
        self.place_near(state);
        self.problem.allow_overlaps(&self.state);
        if self.problem.monitor.is_stopped() {
            return Grade::INTERRUPTED;
        }
        self.settle_points();
        let status = self.solve();
        if self.is_over() { status } else { self.end_start(status) }
    }

    /// Takes a state in which what is prescribed need not hold yet.
    pub(super) fn place_near(&mut self, state: State) {
        self.state = state;
        self.problem.update_held(&self.state);
        self.problem.place_held(&mut self.state);
    }

    /// Brings the points into equilibrium for the frames.
    pub(super) fn settle_points(&mut self) {
        self.problem.gradient(&self.state, &mut self.certifier.gradient);
        let mut condensation = Condensation::new(&self.problem);
        condensation.condense(&mut self.problem, &mut self.state, &self.certifier.gradient, 0.0);
    }

    /// Remarks on how the initial equilibrium was found.
    pub(super) fn notes_on_start(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.started_without_obstacles {
            notes.push(
                "obstacles blocked the way to the start, or caught cables on it, so it was found without them first: \
                 where a cable has to run on another side of one, give its branch a `path`"
                    .to_owned(),
            );
        }
        if self.problem.conditions().contact.records.iter().any(|record| record.anchor.is_some()) {
            notes.push(
                "the start is an equilibrium without friction, which acts from there on: where a cable has to be held \
                 by friction, let a step bring the weight or the obstacle"
                    .to_owned(),
            );
        }
        notes
    }

    /// Ends the search for the initial equilibrium: finds it with friction and with what slides, and leaves it if it is
    /// unstable.
    fn end_start(&mut self, mut status: Grade) -> Grade {
        self.release_slides();
        let network = self.problem.network;
        if !network.slides.is_empty() || network.has_rough_contact() {
            status = self.solve();
        }
        self.leave_unstable_start(status)
    }

    /// Enables friction, and lets the cable run through the constraints that slide without it.
    fn release_slides(&mut self) {
        self.starting = false;
        self.problem.enable_friction();
        for (k, _) in self.problem.network.slides.iter().enumerate().filter(|(_, site)| site.friction == 0.0) {
            self.problem.set_sliding(k, Sliding::Running { force: 0.0 });
        }
    }

    /// Leaves an unstable equilibrium, or a state where the minimiser failed: disturbs it along a direction in which
    /// the energy decreases (deterministic) and minimises again. Without success the state is restored.
    fn leave_unstable_start(&mut self, status: Grade) -> Grade {
        let applicable = matches!(status.status(), Status::Converged | Status::Failed) && self.problem.has_potential();
        if self.is_over() || !applicable || self.problem.network.constraints.is_empty() {
            return status;
        }
        let kept = self.keep();
        let mut after = status;
        for disturbance in DISTURBANCES {
            let stability = self.certifier.inspect(&mut self.problem, &self.state).stability;
            if after == Status::Converged && stability != Stability::Unstable {
                return after;
            }
            let Some(direction) = self.certifier.descent_direction(&self.problem, &self.state) else { break };
            self.before.copy_from(&self.state);
            self.problem.retract(&self.before, direction, disturbance, &mut self.state);
            self.problem.network.follow_ties(&mut self.state);
            after = self.solve();
            if self.fault.is_some() {
                self.go_back_to(&kept);
                after = status;
            }
        }
        if after == Status::Converged
            && self.certifier.inspect(&mut self.problem, &self.state).stability != Stability::Unstable
        {
            return after;
        }
        self.go_back_to(&kept);
        self.certify(status)
    }
}
