//! Homing: from where a harness is laid out to the balanced start of its first step.

use super::driver::{Driver, begun, is_balanced, snap_iterations};
use crate::minimisers::condensation::Condensation;
use crate::start::prolongation;
use crate::steps::checkpoint::Checkpoint;
use crate::steps::plan::{self, Plan};
use crate::steps::stability::Stability;
use wireloom_core::conditions::Sliding;
use wireloom_core::minimiser::{Minimiser, Stop};
use wireloom_core::status::Status;
use wireloom_core::steps::{Schedule, Step};
use wireloom_core::{Monitor, Network, State, Vector};

/// Least number of increments in which the start shape gives way and the constraints are brought to where the scenario puts
/// them.
const START_INCREMENTS: f64 = 10.0;
/// One increment of starting for so much of the longest branch's length.
const START_DISTANCE: f64 = 0.1;
/// One increment of starting for so many radians.
const START_TURN: f64 = 0.3;
/// Nobody sees the increments of starting: they need only be near a balance.
const START_TOLERANCE: f64 = 0.1;
/// Turns (rad) by which a start that is balanced on an edge is disturbed, one after the other until it falls: where it falls slowly, small
/// ones have died away in all other directions first, and it stands again.
const DISTURBANCES: [f64; 3] = [1e-3, 1e-2, 1e-1];
/// Largest turn (rad) of any frame on the way from the start of another harness for that harness to be near: beyond it this one's own
/// start may be another equilibrium.
const NEAR: f64 = 0.5;

/// The balanced start of a harness, found from that of `other`, which is the same but for a little: for [`super::carry_out`] to go on from.
/// `None` where they are not alike, where no balance is found from there, or where it is not near: then the start is to be looked for
/// afresh.
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
    driver.starting = false;
    near.then(|| driver.checkpoint(&begun(schedule), (0, 0), None, 0.0))
}

impl Driver<'_, '_> {
    /// From the start shape to a balanced state with the constraints that act from the start where the scenario puts them. Dead moments come last,
    /// for only what has an energy can go down to a stable start.
    pub(super) fn find_initial_equilibrium(&mut self) -> Status {
        if !self.problem.has_dead_moments() {
            return self.find_equilibrium_without_moments();
        }
        self.problem.set_moment_fraction(0.0);
        let status = self.find_equilibrium_without_moments();
        let mut plan = Plan::new(&self.problem, &Step::default(), Vec::new());
        plan.take_up_moments = true;
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

    /// A drawn shape is first taken for the rest shape, without weight; then it gives way to the true one and the weight
    /// comes, while the constraints move. No edge is left to balance on.
    fn find_equilibrium_without_moments(&mut self) -> Status {
        let network = self.problem.network;
        let mut journeys = Vec::new();
        let mut increments = START_INCREMENTS;
        let length = self.problem.scales().length;
        for (f, constraint) in network.constraints.iter().enumerate().filter(|(_, constraint)| constraint.from_start) {
            let from = self.problem.conditions().constraints[f].base;
            let journey = plan::home(f, constraint, from);
            let to = journey.at(1.0);
            increments = increments
                .max((to.position - from.position).norm() / (START_DISTANCE * length))
                .max(to.orientation.angle_to(&from.orientation) / START_TURN);
            journeys.push(journey);
        }
        let increments = increments.min(100.0).ceil() as usize;
        let gravity = self.problem.conditions().gravity;
        let weightless = !network.branches.iter().all(|b| b.path.is_empty());
        if weightless {
            self.problem.change(|c| c.gravity = Vector::zeros());
            self.problem.hold_drawn_shape(&self.state);
        }
        let step = Step { gravity: Some(gravity), ..Step::default() };
        let mut plan = Plan::new(&self.problem, &step, journeys);
        plan.undraw = weightless;
        let stop = self.stop;
        // A part that snaps on the way needs more iterations, not smaller increments.
        self.stop.max_iterations = snap_iterations(&stop);
        self.stop.force_tolerance = stop.force_tolerance.max(START_TOLERANCE);
        let mut status = self.advance(&plan, 0.0, 0.0, 0);
        for k in 1..=increments {
            if k == increments {
                self.stop.force_tolerance = stop.force_tolerance;
            }
            let (a, b) = ((k - 1) as f64 / increments as f64, k as f64 / increments as f64);
            (status, _) = self.advance_through(&plan, a, b);
            if !matches!(status, Status::Converged | Status::Stalled) {
                break;
            }
        }
        if self.is_over() {
            return status;
        }
        if !matches!(status, Status::Converged | Status::Stalled) {
            // The way is barred: go down from here without it.
            self.stop.force_tolerance = stop.force_tolerance;
            plan.apply(&mut self.problem, 1.0);
            status = self.solve();
        }
        self.release_slides();
        if !network.slides.is_empty() {
            status = self.solve();
        }
        status = self.leave_unstable_start(status);
        self.stop = stop;
        status
    }

    /// The balanced start of a coarse mesh, carried over to this one. `None` where that leads to no balance: the harness then lies as
    /// it did.
    pub(super) fn start_from_coarse(&mut self, coarse: &Network, schedule: &Schedule) -> Option<Status> {
        let monitor = &self.problem.monitor;
        let mut rough = Driver::at_start(coarse, &mut *self.minimiser, &self.stop, schedule, monitor);
        let status = rough.find_initial_equilibrium();
        let (state, work) = (rough.state, (rough.iterations, rough.polish, rough.factorisations));
        self.iterations += work.0;
        self.polish += work.1;
        self.factorisations += work.2;
        if self.problem.monitor.is_stopped() {
            return Some(Status::Interrupted);
        }
        if status != Status::Converged {
            return None;
        }
        let network = self.problem.network;
        let (began, conditions) = (self.state.clone(), self.problem.conditions().clone());
        let stop = self.stop;
        self.stop.max_iterations = snap_iterations(&stop);
        let status = self.relax_from(prolongation::prolonged(coarse, &state, network));
        self.stop = stop;
        if status != Status::Converged {
            self.state = began;
            self.problem.set_multipliers(&conditions);
            self.problem.set_contacts(&conditions);
            for (f, own) in conditions.constraints.into_iter().enumerate() {
                self.problem.set_target(f, own.base);
            }
            return None;
        }
        self.starting = false;
        Some(status)
    }

    /// From a state that is balanced but for a little, with the constraints that act from the start where the scenario puts them.
    fn relax_from(&mut self, state: State) -> Status {
        let network = self.problem.network;
        self.state = state;
        for (f, constraint) in network.constraints.iter().enumerate().filter(|(_, constraint)| constraint.from_start) {
            let from = self.problem.conditions().constraints[f].base;
            self.problem.set_target(f, plan::home(f, constraint, from).at(1.0));
        }
        self.problem.update_held(&self.state);
        self.problem.place_held(&mut self.state);
        self.problem.allow_overlaps(&self.state);
        if self.problem.monitor.is_stopped() {
            return Status::Interrupted;
        }
        self.problem.gradient(&self.state, &mut self.certifier.gradient);
        let mut settle = Condensation::new(&self.problem);
        settle.condense(&mut self.problem, &mut self.state, &self.certifier.gradient, 0.0);
        let status = self.solve();
        self.leave_unstable_start(status)
    }

    /// Lets the cable run through what slides without friction.
    fn release_slides(&mut self) {
        self.starting = false;
        self.problem.enable_friction();
        for (k, _) in self.problem.network.slides.iter().enumerate().filter(|(_, site)| site.friction == 0.0) {
            self.problem.set_sliding(k, Sliding::Running { force: 0.0 });
        }
    }

    /// Where the start is balanced on an edge, or the way down is not to be found from it, disturbs it a little along a direction in which
    /// the energy falls (the same every time) and lets it fall.
    fn leave_unstable_start(&mut self, status: Status) -> Status {
        let judged = matches!(status, Status::Converged | Status::Failed) && !self.problem.has_dead_moments();
        if self.is_over() || !judged || self.problem.network.constraints.is_empty() {
            return status;
        }
        let (began, conditions) = (self.state.clone(), self.problem.conditions().clone());
        let mut fallen = status;
        for disturbance in DISTURBANCES {
            let stability = self.certifier.inspect(&mut self.problem, &self.state).stability;
            if fallen == Status::Converged && stability != Stability::Unstable {
                return fallen;
            }
            let Some(direction) = self.certifier.descent_direction(&self.problem, &self.state) else { break };
            self.before.copy_from(&self.state);
            self.problem.retract(&self.before, direction, disturbance, &mut self.state);
            self.problem.network.follow_ties(&mut self.state);
            fallen = self.solve();
        }
        if fallen == Status::Converged
            && self.certifier.inspect(&mut self.problem, &self.state).stability != Stability::Unstable
        {
            return fallen;
        }
        self.state = began;
        self.problem.set_multipliers(&conditions);
        self.problem.set_contacts(&conditions);
        self.certify(status);
        status
    }
}
