//! Increments in which time passes: parts so short that what creeps is accurate, and the error that they leave.
//!
//! The law of creep takes the curvature to change evenly over an increment (`models::creep`), which is exact where it
//! is held and of second order in time elsewhere; after a sudden change it is of first order. So a part of an increment
//! is computed twice: in one piece, and in two halves with what has crept by the middle. The halves are kept. Their
//! difference from the one piece is three times (after a sudden change: once) their own error, so it bounds that. Where
//! it exceeds [`TOLERANCE`] the part is made shorter, as in any integration with error control (Hairer,
//! Norsett & Wanner 1993, Solving Ordinary Differential Equations I, section II.4). Differences are added up over the
//! run, as what creeps forgets an error only slowly, and are a part of the errors of all results.

use super::driver::{Driver, is_balanced};
use crate::report::discretisation::NodalErrors;
use crate::report::nodes::{curvatures, twists};
use crate::report::time_error::TimeError;
use crate::report::{EventLog, Occurrence, TwistMonitor, branch};
use crate::steps::certificate::Grade;
use crate::steps::plan::Plan;
use wireloom_core::State;
use wireloom_core::conditions::Conditions;
use wireloom_core::equilibrium::{BranchResult, OperationResult};

/// Largest difference between a part in one piece and in two halves: of curvature and moment, as a fraction of the
/// largest of the harness.
const TOLERANCE: f64 = 5e-4;
/// Least size of what a difference is a fraction of, in units of what the tolerance of forces leaves.
const ABOVE_ROUND_OFF: f64 = 1e3;
/// Curvature that is none, as a fraction of that of a circle of the longest branch.
const STRAIGHT: f64 = 1e-3;
/// Smallest part of an increment.
const SMALLEST: f64 = 1e-6;
/// Least and greatest factor on the length of the next part.
const FACTORS: [f64; 2] = [0.1, 4.0];
/// Factor by which a part is shorter than its difference asks for.
const SAFETY: f64 = 0.9;
/// Order of the error of a part.
const ORDER: i32 = 3;
/// A difference that is not less than this fraction of that of a part at least twice as long is round-off.
const PROGRESS: f64 = 0.9;

/// What a part of an increment begins with.
struct Beginning {
    state: State,
    conditions: Conditions,
    log: EventLog,
    operations: Vec<OperationResult>,
    twist_monitor: Option<TwistMonitor>,
    lost_twist: Vec<Occurrence>,
    smallest_part: f64,
}

impl Driver<'_, '_> {
    /// Advances as [`Self::advance_through`], where time passes in parts that are short enough.
    pub(super) fn advance_in_time(&mut self, plan: &Plan, a: f64, b: f64) -> (Grade, f64) {
        if !plan.takes_time() {
            return self.advance_through(plan, a, b);
        }
        let (mut from, mut part) = (a, b - a);
        let mut rejected: Option<f64> = None;
        loop {
            let to = if from + part >= b - SMALLEST * (b - a) { b } else { from + part };
            let beginning = self.beginning();
            let (status, reached) = self.advance_through(plan, from, to);
            if !is_balanced(status) || reached < to || self.is_over() {
                return (status, reached);
            }
            let whole = self.results_of_branches();
            self.begin_again(&beginning);
            let Some(status) = self.advance_in_halves(plan, from, to) else {
                self.begin_again(&beginning);
                if self.is_over() {
                    return (Grade::FAILED, from);
                }
                // In one piece, then, and what changes in it is not known better than that.
                let before = self.results_of_branches();
                let (status, reached) = self.advance_through(plan, from, to);
                self.add_time_error(&before, &whole);
                if !is_balanced(status) || to >= b {
                    return (status, reached);
                }
                self.commit_part();
                rejected = None;
                from = to;
                continue;
            };
            let halves = self.results_of_branches();
            let excess = self.excess(&whole, &halves);
            let factor = SAFETY * excess.powf(-1.0 / f64::from(ORDER));
            let improves = rejected.is_none_or(|before| excess < PROGRESS * before);
            if excess > 1.0 && improves && to - from > SMALLEST * (b - a) {
                self.begin_again(&beginning);
                rejected = Some(excess);
                part = (to - from) * factor.clamp(FACTORS[0], 0.5);
                continue;
            }
            self.add_time_error(&whole, &halves);
            if to >= b {
                return (status, to);
            }
            self.commit_part();
            rejected = None;
            part = (to - from) * factor.clamp(FACTORS[0], FACTORS[1]);
            from = to;
        }
    }

    /// Commits the memories and the friction of contact at the end of a part of time.
    fn commit_part(&mut self) {
        self.problem.commit_rods_and_joints(&self.state);
        self.problem.commit_contacts(&self.state);
    }

    /// Adds what changed from these results to the present ones to the errors that time leaves.
    pub(super) fn add_change_as_time_error(&mut self, before: &[BranchResult]) {
        let now = self.results_of_branches();
        self.add_time_error(before, &now);
    }

    /// Results of all branches at the present state.
    pub(super) fn results_of_branches(&mut self) -> Vec<BranchResult> {
        let touching = self.problem.touching_points(&self.state);
        let branches = 0..self.problem.network.branches.len();
        branches.map(|b| branch::result(&self.problem, b, &self.state, &touching)).collect()
    }

    /// Errors of the results of all branches, of mesh and time.
    pub(super) fn all_errors(&self) -> Vec<NodalErrors> {
        let mut all = self.errors.clone();
        all.iter_mut().zip(&self.time_errors).for_each(|(own, time)| time.add_to(own));
        all
    }

    fn advance_in_halves(&mut self, plan: &Plan, from: f64, to: f64) -> Option<Grade> {
        let middle = 0.5 * (from + to);
        for (from, to) in [(from, middle), (middle, to)] {
            let (status, reached) = self.advance_through(plan, from, to);
            if !is_balanced(status) || reached < to || self.is_over() {
                return None;
            }
            if to > middle {
                return Some(status);
            }
            self.commit_part();
        }
        None
    }

    fn add_time_error(&mut self, one: &[BranchResult], other: &[BranchResult]) {
        for (own, (one, other)) in self.time_errors.iter_mut().zip(one.iter().zip(other)) {
            own.add(&TimeError::between(one, other));
        }
    }

    /// Largest difference between two results of the harness, in units of what is allowed.
    fn excess(&self, one: &[BranchResult], other: &[BranchResult]) -> f64 {
        let scales = self.problem.scales();
        let (mut curvature, mut moment) =
            (STRAIGHT / scales.length, ABOVE_ROUND_OFF * self.stop.force_tolerance * scales.moment);
        for branch in other {
            let bent = curvatures(branch).into_iter().chain(twists(branch).into_iter().map(f64::abs));
            curvature = bent.fold(curvature, f64::max);
            moment = branch.moment.iter().map(|m| m.norm()).fold(moment, f64::max);
        }
        let of_branch = |(one, other): (&BranchResult, &BranchResult)| {
            let error = TimeError::between(one, other);
            (error.curvature.max(error.twist) / curvature).max(error.moment / moment)
        };
        one.iter().zip(other).map(of_branch).fold(0.0, f64::max) / TOLERANCE
    }

    fn beginning(&self) -> Beginning {
        Beginning {
            state: self.state.clone(),
            conditions: self.problem.conditions().clone(),
            log: self.log.clone(),
            operations: self.operations.clone(),
            twist_monitor: self.twist_monitor.clone(),
            lost_twist: self.lost_twist.clone(),
            smallest_part: self.smallest_part,
        }
    }

    /// Goes back to the beginning of a part.
    fn begin_again(&mut self, beginning: &Beginning) {
        self.before.copy_from(&beginning.state);
        self.go_back(&beginning.conditions);
        let Conditions { rods, joints, committed_time, time, .. } = &beginning.conditions;
        self.problem.change(|now| {
            now.rods.clone_from(rods);
            now.joints.clone_from(joints);
            (now.committed_time, now.time) = (*committed_time, *time);
        });
        self.log = beginning.log.clone();
        self.operations.clone_from(&beginning.operations);
        self.twist_monitor.clone_from(&beginning.twist_monitor);
        self.lost_twist.clone_from(&beginning.lost_twist);
        self.smallest_part = beginning.smallest_part;
    }
}
