//! Certificate of an equilibrium: forces and moments recomputed from the state, independently of the minimiser.

use crate::report::discretisation::{self, NodalErrors, Response, Samples};
use crate::steps::stability::{Inspection, Inspector};
use wireloom_core::equilibrium::BranchResult;
use wireloom_core::minimiser::Stop;
use wireloom_core::problem::Problem;
use wireloom_core::status::Status;
use wireloom_core::terms::constraints::ConstraintResidual;
use wireloom_core::{Network, State, Tangent};

/// Tolerance of held freedoms: distance (m) or turn (rad) from the target.
const VIOLATION: f64 = 1e-9;
/// Tolerance of equations and inequalities, in units of their scales, as a fraction of the force tolerance.
pub const FEASIBLE: f64 = 1e-2;
/// Tolerance of the shape: move of a converged harness in the next Newton step, as a fraction of the longest branch,
/// and turn (rad). Of 1,785 random harnesses the wrong ones with forces in balance had 2e-4 and more, ordinary ones
/// 2e-7 and less.
const SHAPE: f64 = 1e-5;

/// Status of a state as the certificate graded it. Only this module makes one that says converged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grade(Status);

impl Grade {
    /// The iteration limit was reached.
    pub const ITERATION_LIMIT: Self = Self(Status::IterationLimit);
    /// A part cannot continue, or motions could not be resolved.
    pub const FAILED: Self = Self(Status::Failed);
    /// A stop was requested.
    pub const INTERRUPTED: Self = Self(Status::Interrupted);

    /// The status.
    pub fn status(self) -> Status {
        self.0
    }
}

impl From<Grade> for Status {
    fn from(grade: Grade) -> Self {
        grade.0
    }
}

impl PartialEq<Status> for Grade {
    fn eq(&self, status: &Status) -> bool {
        self.0 == *status
    }
}

/// Result of the recomputation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// Largest free force relative to the force scale of its branch, or moment relative to its moment scale.
    pub residual: f64,
    /// Whether the residual exceeds the tolerance by round-off only.
    pub round_off: bool,
    /// Largest distance (m) or turn (rad) of a held freedom from its target.
    pub violation: f64,
    /// Equation or inequality with the largest violation, if any acts.
    pub constraint: Option<ConstraintResidual>,
    /// Largest violation of contact, in units of the tolerance ([`wireloom_core::terms::contact`]), if contact is
    /// possible.
    pub contact: Option<f64>,
    /// Converged if the numbers confirm it and no part has a fault; else the status of the minimiser, failed if that
    /// was converged.
    pub grade: Grade,
}

/// Certifies equilibria, with its workspace.
pub struct Certifier {
    /// Whole gradient at the state certified last; on held freedoms it is the reaction of the constraint.
    pub gradient: Tangent,
    scratch: Tangent,
    inspector: Option<Inspector>,
}

impl Certifier {
    /// Certifier for the states of a network.
    pub fn new(network: &Network) -> Self {
        Self { gradient: Tangent::zeros(network), scratch: Tangent::zeros(network), inspector: None }
    }

    /// Grades `state` as an equilibrium of `problem`. `claimed` is the status of the minimiser.
    pub fn certify(
        &mut self,
        problem: &mut Problem<'_>,
        state: &State,
        stop: &Stop,
        claimed: impl Into<Status>,
    ) -> Certificate {
        problem.update_held(state);
        problem.forget();
        let energy = problem.gradient(state, &mut self.gradient);
        problem.motion(state, &mut self.scratch);
        let moved = self.scratch.points.iter().chain(&self.scratch.frames);
        let violation = moved.map(|v| v.norm()).fold(0.0, f64::max);
        self.scratch.copy_from(&self.gradient);
        problem.free_part(&mut self.scratch);
        let (residual, above_round_off) = (problem.whole_residual(&self.scratch), problem.residual(&self.scratch));
        let constraint = problem.worst_residual(state);
        let feasible = constraint.is_none_or(|worst| worst.violation <= FEASIBLE * stop.force_tolerance);
        let contact = problem.contact_violation(state);
        let feasible = feasible && contact.is_none_or(|violation| violation <= 1.0);
        let sound = energy.is_finite() && state.is_finite() && problem.part_at_fault().is_none();
        let holds = above_round_off <= stop.force_tolerance && violation <= VIOLATION && feasible && sound;
        let status = match (holds, claimed.into()) {
            (true, _) => Status::Converged,
            (false, Status::Converged) => Status::Failed,
            (false, other) => other,
        };
        let round_off = status == Status::Converged && residual > stop.force_tolerance;
        Certificate { residual, round_off, violation, constraint, contact, grade: Grade(status) }
    }

    /// Inspects the second derivatives at `state`. Call after [`Self::certify`] at the same state.
    pub fn inspect(&mut self, problem: &mut Problem<'_>, state: &State) -> Inspection {
        let Self { inspector, gradient, .. } = self;
        inspector.get_or_insert_with(|| Inspector::new(problem)).inspect(problem, state, gradient)
    }

    /// Whether an equilibrium without a potential is certainly unstable; see [`Inspector::diverges`].
    pub fn diverges(&mut self, problem: &mut Problem<'_>, state: &State) -> bool {
        let Self { inspector, gradient, .. } = self;
        inspector.get_or_insert_with(|| Inspector::new(problem)).diverges(problem, state, gradient)
    }

    /// Estimated errors of these results of all branches at `state`, an equilibrium that was certified last; without
    /// `hessian` the estimate is local.
    pub fn discretisation(
        &mut self,
        problem: &mut Problem<'_>,
        state: &State,
        results: &[BranchResult],
        hessian: bool,
    ) -> Vec<NodalErrors> {
        problem.find_contacts(state);
        if !hessian {
            return discretisation::estimate(problem, state, &Samples::of(problem, state, results), None);
        }
        if !self.inspector.as_ref().is_some_and(|inspector| inspector.is_at(state)) {
            self.inspect(problem, state);
        }
        let inspector = self.inspector.as_mut().expect("the state was inspected");
        let samples = Samples::of(problem, state, results);
        let mut defect = discretisation::defect(problem, state, &samples, &inspector.hessian);
        // What is left of the forces moves the state as a defect of the energy with the opposite sign would.
        defect[1].add_scaled(-1.0, &self.gradient);
        let parts = inspector.responses(problem, state, &defect);
        let response = Response { parts: parts.each_ref(), hessian: &inspector.hessian };
        discretisation::estimate(problem, state, &samples, Some(response))
    }

    /// Whether the equilibrium at `state`, whose errors were estimated last, can move without a force; see
    /// [`Inspector::wanders`].
    pub fn wanders(&self, state: &State) -> bool {
        self.inspector.as_ref().is_some_and(|inspector| inspector.is_at(state) && inspector.wanders())
    }

    /// Status of a state after inspection; `graded` is its status by the forces. In contact the inspection does not
    /// bound the error of the shape, as contact and friction would end the next step early.
    pub fn grade_shape(graded: Grade, inspection: &Inspection) -> Grade {
        let holds = inspection.relative <= SHAPE || inspection.is_flat() || inspection.in_contact;
        if graded == Status::Converged && !holds { Grade(Status::Stalled) } else { graded }
    }

    /// Next Newton step from the state inspected last.
    ///
    /// # Panics
    /// If none was.
    pub fn next_step(&self) -> &Tangent {
        &self.inspector.as_ref().expect("a state was inspected").step
    }

    /// Direction along which the energy decreases from the equilibrium inspected last; see
    /// [`Inspector::descent_direction`].
    pub fn descent_direction(&mut self, problem: &Problem<'_>, state: &State) -> Option<&Tangent> {
        self.inspector.as_mut()?.descent_direction(problem, state)
    }
}
