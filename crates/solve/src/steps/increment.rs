//! One increment of a step: applies its plan, cuts it back where it does not converge, and follows snap-through.

use super::driver::{Driver, is_balanced};
use crate::report::clearance::Cables;
use crate::report::driven::{self, Driven, Places};
use crate::report::passage::Passage;
use crate::report::spans::Spans;
use crate::report::time_error::TimeError;
use crate::report::{self, Occurrence, TwistMonitor, events, result};
use crate::steps::certificate::Grade;
use crate::steps::operations;
use crate::steps::plan::Plan;
use crate::steps::progress::Interruption;
use wireloom_core::conditions::{Conditions, Sliding};
use wireloom_core::constraint::Action;
use wireloom_core::equilibrium::StepResult;
use wireloom_core::minimiser::Stop;
use wireloom_core::requirement::{Origin, Requirement};
use wireloom_core::status::Status;
use wireloom_core::steps::Step;
use wireloom_core::{EventKind, EventPlace, Moment, Problem};

/// An increment that fails is halved, its halves likewise, up to this many times.
const CUT_BACKS: u32 = 4;
/// Factor on the iteration limit of an increment where parts may snap through: at the initial equilibrium, and where
/// smaller increments did not converge.
const SNAP_THROUGH_FACTOR: usize = 20;
/// Iteration limits below this fraction of the default hold for snap-through, too: they are set to see them reached.
const SMALL_LIMIT: f64 = 0.5;
/// Smallest part of a step that is tried where an obstacle moves against a cable, or a cable passes one.
const SMALLEST_PART: f64 = 1e-4;
/// Fractions of a step that differ by less than this are the same.
const SAME_FRACTION: f64 = 1e-9;
/// Largest number of turns that a constraint or a body makes in one part: half a turn would be the same in either
/// sense.
const LARGEST_TURNS: f64 = 0.2;
/// Number of moments at which bodies and held places are looked at between two corners, or in a part of them in which
/// nothing makes more than [`LOOKED_AT_TURNS`].
const LOOKS: f64 = 3.0;
/// See [`LOOKS`].
const LOOKED_AT_TURNS: f64 = 1.0 / 24.0;
/// Largest number of them between two corners.
const MOST_LOOKS: f64 = 1000.0;

impl Driver<'_, '_> {
    /// Adds and releases the constraints of a step, and plans its motions.
    pub(crate) fn begin_step(&mut self, step: &Step, first: bool, notes: &mut Vec<String>) -> Plan {
        let network = self.problem.network;
        self.problem.change(|c| {
            for &f in &step.release {
                c.active[f] = false;
            }
            for &f in &step.add {
                c.active[f] = true;
            }
        });
        notes.extend(self.place_stations(&step.add).into_iter().map(|note| format!("step `{}`: {note}", step.name)));
        for &f in &step.add {
            self.problem.begin_constraint(f, &self.state);
        }
        self.operations = operations::begin(&step.operations, &self.problem, &self.state);
        let begun = |f: &usize| step.add.contains(f) || first && network.constraints[*f].from_start;
        let begun = (0..network.constraints.len()).filter(begun).collect();
        let plan = Plan::of_step(&self.problem, step, &step.add).beginning(begun);
        let network = self.problem.network;
        let leads = |f: &usize| matches!(network.constraints[*f].model.action(), Action::Prescribed(_));
        let leads_on = step.release.is_empty() && step.add.iter().all(leads);
        self.previous_move = leads_on.then_some(0.0);
        plan
    }

    /// Runs an increment (of this number, in the step of this number; whether the step ends with it) from one fraction
    /// of the step's plan to another, and logs the events at its end; with `all`, all clearances are kept, not only the
    /// required ones.
    ///
    /// Its end is kept in the memories of constraints and in friction anchors.
    ///
    /// # Errors
    /// If a part cannot continue, also after the increment was graded, or a stop was requested.
    pub(crate) fn run_increment(
        &mut self,
        (step, plan): (&Step, &Plan),
        (step_index, increment, ends_step): (usize, usize, bool),
        [a, b]: [f64; 2],
        all: bool,
        seconds: impl FnOnce() -> f64,
    ) -> Result<StepResult, Interruption> {
        self.all_clearances = all;
        // A run that is resumed here knows of no earlier states.
        self.problem.search_contacts_again();
        self.log.begin(Moment { step: step.name.clone(), step_index, increment });
        let _increment = tracing::info_span!("increment", index = increment).entered();
        let status = self.solve_increment(plan, a, b);
        tracing::info!(
            target: "wireloom::increment",
            status = status.status().word(),
            iterations = self.iterations,
            factorisations = self.factorisations,
            residual = self.residual,
        );
        if self.problem.monitor.is_stopped() && self.fault.is_none() {
            return Err(Interruption::Stopped);
        }
        if !is_balanced(status) && self.fault.is_none() {
            // Why no equilibrium was found.
            self.fault = self.problem.contradiction(&self.state);
        }
        if let Some(fault) = self.part_fault(step, increment) {
            return Err(Interruption::Fault(fault));
        }
        let mut end = self.step_result(step, increment, status, seconds());
        let cables = Cables::new(self.problem.network, &end.branches);
        let spans = Spans::new(&self.problem, &self.state);
        let measured = (&cables, &spans);
        self.check_at_end(&end, measured, ends_step);
        events::log_increment(&mut self.log, &mut self.problem, &self.state, &end, measured, (&self.stop, all));
        end.violations = self.log.violations().to_vec();
        if is_balanced(status) {
            self.problem.commit(&self.state, |constraint| result::tensions(constraint, &end.branches));
        }
        self.fault = self.problem.fault(false);
        self.part_fault(step, increment).map_or(Ok(end), |fault| Err(Interruption::Fault(fault)))
    }

    /// Finds the end of the increment from fraction `a` to fraction `b` of a plan; logs cut-back, lost twist and jumps.
    fn solve_increment(&mut self, plan: &Plan, a: f64, b: f64) -> Grade {
        self.began.copy_from(&self.state);
        self.driven.clear();
        self.convex = true;
        let (before, time_errors) = (self.problem.conditions().clone(), self.time_errors.clone());
        let at_first = plan.takes_time().then(|| self.results_of_branches());
        let (status, snapped) = self.reach(plan, a, b);
        if self.smallest_part < 1.0 {
            let parts = 1.0 / self.smallest_part;
            self.log.raise(Occurrence {
                kind: EventKind::CutBack,
                place: EventPlace::default(),
                value: Some(parts),
                limit: None,
                message: format!("did not converge at once; parts as small as 1/{parts:.0} were tried"),
            });
        }
        for lost in self.lost_twist.drain(..) {
            self.log.raise(lost);
        }
        let status = self.refine(status);
        if is_balanced(status) {
            if let Some(at_first) = at_first.filter(|_| snapped) {
                // When it snapped is known to the increment only.
                self.add_change_as_time_error(&at_first);
            }
            self.problem.commit_rods_and_joints(&self.state);
            self.problem.sum_dissipated(&before);
            self.driven = self.driven_on(plan, [a, b], &before);
            for driven in &self.driven {
                self.log.raise(events::driven_into_body(self.problem.network, driven));
            }
            self.log_jump(plan, [a, b], (&before, &time_errors), snapped);
        }
        status
    }

    /// Advances from fraction `a` to fraction `b` of a plan, through snap-throughs. Returns also whether there was one
    /// that smaller parts did not pass.
    pub(super) fn reach(&mut self, plan: &Plan, a: f64, b: f64) -> (Grade, bool) {
        self.smallest_part = 1.0;
        self.twist_monitor.get_or_insert_with(|| TwistMonitor::new(self.problem.network));
        self.prescribed_turns = plan.turns(1.0);
        let guided = if plan.takes_time() { None } else { self.follow_guide(plan, b) };
        let (mut status, mut to) = guided.unwrap_or_else(|| self.advance_in_time(plan, a, b));
        let mut snapped = false;
        while status == Status::IterationLimit && !self.is_over() && self.lost_twist.is_empty() {
            snapped = true;
            status = self.follow_snap_through();
            self.log_self_passing(status);
            if !is_balanced(status) {
                break;
            }
            self.update_operations(plan, to);
            if to < b {
                (status, to) = self.advance_in_time(plan, to, b);
            }
        }
        (status, snapped)
    }

    /// Logs a jump in the increment that has ended in balance. One that moved far is looked into if that is out of
    /// proportion, or, where a requirement is at stake, if the energy was not convex on the way and the speeds at both
    /// ends do not explain it.
    fn log_jump(&mut self, plan: &Plan, fractions: [f64; 2], beginning: (&Conditions, &[TimeError]), snapped: bool) {
        let (moved, length) = result::farthest_branch(self.problem.network, &self.began, &self.state);
        let conditions = self.problem.conditions();
        let before = beginning.0;
        let given = events::prescribed(&conditions.active, &before.targets, &conditions.targets);
        let longest = self.problem.scales().length;
        // A cable that ran out of a constraint has an event of its own.
        let previous =
            self.previous_move.filter(|_| conditions.active == before.active && moved > events::FAR * length);
        let may_have_jumped = previous.is_some_and(|previous| {
            let (requirements, step) = (&self.problem.network.requirements, self.log.now().step_index);
            let is_asked = |own: &Requirement| own.origin == Origin::Scenario;
            events::is_out_of_proportion(moved, previous, given, longest)
                || !self.convex
                    && self.log.sheet.kept(requirements, step).any(is_asked)
                    && !self.speeds_explain_move(plan, fractions, beginning)
        });
        let jump = if may_have_jumped || snapped { self.find_jump(plan, fractions, beginning) } else { None };
        match jump.or_else(|| snapped.then(|| events::jump_unseen(moved))) {
            // The next jump is not to be measured by this one.
            Some(jump) => self.log.raise(jump),
            None => self.previous_move = Some(moved),
        }
    }

    /// Constraints and bodies that are driven into each other between two fractions of a plan, which began under the
    /// conditions `before`.
    fn driven_on(&self, plan: &Plan, [a, b]: [f64; 2], before: &Conditions) -> Vec<Driven> {
        let network = self.problem.network;
        if network.obstacles.is_empty() {
            return Vec::new();
        }
        let mut trial = Problem::new(network, before.clone());
        let mut way = Vec::new();
        let corners = plan.corners.iter().copied().chain(plan.obstacle_corners());
        let inside = corners.filter(|t| a + SAME_FRACTION < *t && *t < b - SAME_FRACTION);
        let mut ends: Vec<f64> = inside.chain([b]).collect();
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|next, last| *next - *last < SAME_FRACTION);
        let mut from = a;
        for to in ends {
            let parts = (LOOKS * plan.parts(network, from, to, LOOKED_AT_TURNS)).min(MOST_LOOKS) as usize;
            let mut stretch = vec![Places::of(trial.conditions())];
            for k in 1..=parts {
                plan.apply(&mut trial, if k == parts { to } else { from + (to - from) * (k as f64 / parts as f64) });
                stretch.push(Places::of(trial.conditions()));
            }
            way.push(stretch);
            from = to;
        }
        let now = self.problem.conditions();
        driven::driven(network, |f| before.active[f] && now.active[f], &way)
    }

    /// Logs cables that have passed through themselves since `before`, in steps with prescribed turns.
    fn log_self_passing(&mut self, status: Grade) {
        if is_balanced(status) && self.twist_monitor.is_some() && self.prescribed_turns > 0.0 {
            for passing in report::self_passing(&self.problem, &self.before, &self.state) {
                self.log.raise(passing);
            }
        }
    }

    /// Continues downhill with a larger iteration limit: smaller increments did not converge, as the equilibrium path
    /// has passed a limit point and the harness snaps to another equilibrium.
    fn follow_snap_through(&mut self) -> Grade {
        let stop = self.stop;
        self.stop.max_iterations = snap_through_iterations(&stop);
        let status = self.solve();
        self.stop = stop;
        status
    }

    /// Ends the increment at fraction `b` of a plan, near the guide's equilibrium there. `None`, with the harness where
    /// it was, if there is none nearby.
    fn follow_guide(&mut self, plan: &Plan, b: f64) -> Option<(Grade, f64)> {
        let near = self.guide.as_ref()?.near(self.log.now(), self.problem.network)?;
        self.before.copy_from(&self.state);
        let began = self.problem.conditions().clone();
        // A monitor follows turns from one equilibrium to the next: this one is not reached in small turns.
        let twist_monitor = self.twist_monitor.replace(TwistMonitor::new(self.problem.network));
        plan.apply(&mut self.problem, b);
        self.place_near(near);
        self.settle_points();
        let status = self.solve();
        let found = status == Status::Converged && self.lost_twist.is_empty() && self.fault.is_none();
        if found || self.problem.monitor.is_stopped() {
            self.update_operations(plan, b);
            return Some((status, b));
        }
        // A part that cannot continue from there may do so on its own way.
        self.fault = None;
        self.go_back(&began);
        self.lost_twist.clear();
        self.twist_monitor = twist_monitor;
        None
    }

    /// Advances from fraction `a` to fraction `b` of a plan, in parts that resolve its turns and pass through every
    /// corner of its paths. Returns also the fraction that was reached; the plan beyond it was not tried.
    pub(super) fn advance_through(&mut self, plan: &Plan, a: f64, b: f64) -> (Grade, f64) {
        let mut corners: Vec<f64> =
            plan.corners.iter().copied().filter(|t| a + SAME_FRACTION < *t && *t < b - SAME_FRACTION).collect();
        // More equilibria on the way where a requirement wants to be checked in between.
        let parts = self.log.sheet.parts(&self.problem.network.requirements, self.log.now().step_index);
        corners.extend((1..parts).map(|k| a + (b - a) * (k as f64 / parts as f64)));
        corners.push(b);
        corners.sort_by(f64::total_cmp);
        corners.dedup_by(|next, last| *next - *last < SAME_FRACTION);
        let mut corners = corners.into_iter();
        let (mut from, mut corner, mut status) = (a, a, Grade::FAILED);
        // Parts are made one by one: their number may exceed the memory.
        loop {
            if from >= corner {
                let Some(next) = corners.next() else { break };
                corner = next;
            }
            let mut to = corner;
            // Repeated, as turns need not be uniform over the part.
            loop {
                let parts = plan.parts(self.problem.network, from, to, LARGEST_TURNS);
                if parts <= 1.0 {
                    break;
                }
                to = from + (to - from) / parts;
                if to - from < SAME_FRACTION {
                    // The turns cannot be resolved.
                    return (Grade::FAILED, from);
                }
            }
            (status, from) = self.advance(plan, from, to, CUT_BACKS);
            if !is_balanced(status) {
                break;
            }
            self.update_operations(plan, to);
            if to < b {
                self.check_on_the_way(false);
                // Friction goes by the way from one equilibrium to the next.
                self.problem.commit_contacts(&self.state);
            }
        }
        (status, from)
    }

    /// Updates the results of the plan's operations at this fraction of it.
    fn update_operations(&mut self, plan: &Plan, fraction: f64) {
        // In the axes in which the directions of operations are given: those of the body that carries the constraint.
        let body = |f: usize| {
            self.problem.conditions().body(self.problem.network, self.problem.network.constraints[f].mount).orientation
        };
        let reaction = |f: usize| body(f).inverse() * self.problem.reaction(f, &self.state, &self.certifier.gradient).0;
        operations::update(&plan.operations, &mut self.operations, fraction, reaction);
    }

    /// Advances from fraction `a` to fraction `b` of a plan; the part is halved if it does not converge, `cuts` times
    /// at most. It fails where an obstacle would pass through a cable in the smallest part. Returns also the fraction
    /// whose conditions act now, `b` if it is balanced.
    pub(super) fn advance(&mut self, plan: &Plan, a: f64, b: f64, cuts: u32) -> (Grade, f64) {
        self.before.copy_from(&self.state);
        let began = self.problem.conditions().clone();
        plan.apply(&mut self.problem, b);
        let divisible = b - a > SMALLEST_PART;
        let poses = plan.moves_obstacles(self.problem.network).then_some(began.contact.poses.as_slice());
        let collides = poses.is_some() && self.problem.collision_free_fraction(&self.before, &self.state, poses) < 1.0;
        if collides {
            // An obstacle would pass through the cable: in smaller parts it pushes the cable.
            if divisible {
                return self.halve(plan, &began, [a, b], cuts);
            }
            self.go_back(&began);
            self.log.raise(events::passes_through(b - a));
            return (Grade::FAILED, a);
        }
        let lost_twist = self.lost_twist.clone();
        let status = self.solve_from(&began);
        if is_balanced(status) && divisible && self.may_break_distance(&began) {
            // In smaller parts it is seen whether it does.
            self.lost_twist = lost_twist;
            return self.halve(plan, &began, [a, b], cuts);
        }
        self.log_self_passing(status);
        if is_balanced(status) || cuts == 0 || self.is_over() {
            return (status, b);
        }
        let (failed, lost_twist) = (self.state.clone(), self.lost_twist.clone());
        self.smallest_part = self.smallest_part.min(0.5_f64.powi((CUT_BACKS - cuts + 1) as i32));
        self.go_back(&began);
        let middle = 0.5 * (a + b);
        let half = self.advance(plan, a, middle, cuts - 1);
        if self.is_over() {
            return half;
        }
        if !is_balanced(half.0) {
            // Keep the last state of the whole part, which went farthest.
            self.state = failed;
            self.lost_twist = lost_twist;
            plan.apply(&mut self.problem, b);
            return (self.certify(status), b);
        }
        self.check_distances();
        self.advance(plan, middle, b, cuts - 1)
    }

    /// Advances as [`Self::advance`] through a part, which began under these conditions, in two halves.
    fn halve(&mut self, plan: &Plan, began: &Conditions, [a, b]: [f64; 2], cuts: u32) -> (Grade, f64) {
        self.go_back(began);
        let middle = 0.5 * (a + b);
        let half = self.advance(plan, a, middle, cuts);
        if !is_balanced(half.0) {
            return half;
        }
        self.check_distances();
        self.advance(plan, middle, b, cuts)
    }

    /// Goes back to the state before a part that began under these conditions, for a shorter part from there on.
    pub(super) fn go_back(&mut self, began: &Conditions) {
        self.restore(began, |_| false);
        for (obstacle, pose) in began.contact.poses.iter().enumerate() {
            self.problem.set_obstacle(obstacle, *pose);
        }
    }

    /// Checks clearances and contact forces at an equilibrium between two halves. The scenario does not ask for it, so
    /// what else it may break, such as a straight span that has not buckled yet, does not count.
    fn check_distances(&mut self) {
        self.check_on_the_way(true);
    }

    /// Whether a clearance or a limit of contact that has been kept so far may have been broken on the way through a
    /// part that began under these conditions.
    fn may_break_distance(&self, began: &Conditions) -> bool {
        let (network, now) = (self.problem.network, self.problem.conditions());
        let before = (&self.before, began.contact.poses.as_slice());
        let passage = Passage { network, before, after: (&self.state, now.contact.poses.as_slice()) };
        let sheet = &self.log.sheet;
        !self.starting && sheet.kept(&network.requirements, self.log.now().step_index).any(|own| passage.may_break(own))
    }

    /// Solves under the present conditions a part that began under others. Constraints that slipped then are assumed to
    /// slip on; those that would have to slip backward are restarted sticking, and all of them where no equilibrium is
    /// found.
    fn solve_from(&mut self, began: &Conditions) -> Grade {
        let mut sticks: Vec<bool> = (0..began.sliding.len()).map(|k| !self.problem.slips(k)).collect();
        loop {
            let status = self.solve();
            let balanced = is_balanced(status);
            let reversed = |k: usize| !balanced || self.problem.slips_backward(k, &self.before, &self.state);
            let found: Vec<usize> = (0..sticks.len()).filter(|&k| !sticks[k] && reversed(k)).collect();
            if found.is_empty() || self.is_over() {
                return status;
            }
            found.into_iter().for_each(|k| sticks[k] = true);
            self.restore(began, |k| sticks[k]);
        }
    }

    /// Restores the state before the part, under the present loads and poses; constraints that `sticks` selects begin
    /// sticking.
    fn restore(&mut self, began: &Conditions, sticks: impl Fn(usize) -> bool) {
        self.state.copy_from(&self.before);
        self.take_back(began);
        for (k, site) in self.problem.network.slides.iter().enumerate() {
            if site.friction > 0.0 && sticks(k) {
                self.problem.set_sliding(k, Sliding::Stuck);
            }
        }
    }

    /// Takes back what solving changes in the conditions: which constraints act, multipliers, contact and sliding.
    pub(super) fn take_back(&mut self, began: &Conditions) {
        if self.problem.conditions().active != began.active {
            self.problem.change(|c| c.active.clone_from(&began.active));
        }
        self.problem.set_multipliers(began);
        self.problem.set_contacts(began);
        for (k, sliding) in began.sliding.iter().enumerate() {
            self.problem.set_sliding(k, *sliding);
        }
    }
}

/// Iteration limit where parts may snap through.
pub(super) fn snap_through_iterations(stop: &Stop) -> usize {
    if (stop.max_iterations as f64) < SMALL_LIMIT * Stop::default().max_iterations as f64 {
        stop.max_iterations
    } else {
        SNAP_THROUGH_FACTOR * stop.max_iterations
    }
}
