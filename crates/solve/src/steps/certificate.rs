//! No minimiser grades its own work: forces and moments are recomputed here from the state alone.

use crate::steps::stability::{Inspection, Inspector};
use wireloom_core::minimiser::Stop;
use wireloom_core::problem::Problem;
use wireloom_core::status::Status;
use wireloom_core::terms::constraints::ConstraintResidual;
use wireloom_core::{Network, State, Tangent};

/// Distance (m) or turn (rad) by which a held freedom may be off its target.
const VIOLATION: f64 = 1e-9;
/// Share of the force tolerance to which equations and inequalities are met, in units of their scales.
pub const FEASIBLE: f64 = 1e-2;
/// Share of the longest branch, and turn (rad), by which the next Newton step may move a converged harness. Of 1,785 random harnesses those
/// that were wrong with forces in balance had 2e-4 and more left, ordinary ones 2e-7 and less.
const SHAPE: f64 = 1e-5;

/// Result of the recomputation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// Largest free force relative to the force scale of its branch, or moment relative to its moment scale.
    pub residual: f64,
    /// Whether what is left above the tolerance is round-off.
    pub round_off: bool,
    /// Largest distance (m) or turn (rad) by which a held freedom is off its target.
    pub violation: f64,
    /// The equation or inequality with the largest violation, where any acts.
    pub constraint: Option<ConstraintResidual>,
    /// Largest violation of contact, in units of the tolerance ([`wireloom_core::terms::contact`]), where anything can touch.
    pub contact: Option<f64>,
    /// Converged, or the status of the minimiser if the numbers do not confirm convergence.
    pub status: Status,
}

/// Recomputes what minimisers claim; keeps its workspace.
pub struct Certifier {
    /// The whole gradient at the state certified last; on held freedoms it is what the constraint exerts.
    pub gradient: Tangent,
    scratch: Tangent,
    inspector: Option<Inspector>,
}

impl Certifier {
    /// For the states of a network.
    pub fn new(network: &Network) -> Self {
        Self { gradient: Tangent::zeros(network), scratch: Tangent::zeros(network), inspector: None }
    }

    /// Grades `state` as an equilibrium of `problem`. `claimed` is what the minimiser says of it.
    pub fn certify(&mut self, problem: &mut Problem<'_>, state: &State, stop: &Stop, claimed: Status) -> Certificate {
        problem.update_held(state);
        problem.gradient(state, &mut self.gradient);
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
        let holds = above_round_off <= stop.force_tolerance && violation <= VIOLATION && feasible && state.is_finite();
        let status = match (holds, claimed) {
            (true, _) => Status::Converged,
            (false, Status::Converged) => Status::Failed,
            (false, other) => other,
        };
        let round_off = status == Status::Converged && residual > stop.force_tolerance;
        Certificate { residual, round_off, violation, constraint, contact, status }
    }

    /// What the second derivatives at `state` say of it. Call after [`Self::certify`] at the same state.
    pub fn inspect(&mut self, problem: &mut Problem<'_>, state: &State) -> Inspection {
        let Self { inspector, gradient, .. } = self;
        inspector.get_or_insert_with(|| Inspector::new(problem)).inspect(problem, state, gradient)
    }

    /// Whether an equilibrium under dead moments is certainly unstable; see [`Inspector::diverges`].
    pub fn diverges(&mut self, problem: &mut Problem<'_>, state: &State) -> bool {
        let Self { inspector, gradient, .. } = self;
        inspector.get_or_insert_with(|| Inspector::new(problem)).diverges(problem, state, gradient)
    }

    /// The status of a state whose forces were graded so, where the second derivatives were looked at, too. Where cables touch something they
    /// say nothing of the shape: contact and friction end a step on its way.
    pub fn grade_shape(graded: Status, inspection: &Inspection) -> Status {
        let holds = inspection.relative <= SHAPE || inspection.is_flat() || inspection.touches;
        if graded == Status::Converged && !holds { Status::Stalled } else { graded }
    }

    /// The next Newton step from the state inspected last.
    ///
    /// # Panics
    /// If none was.
    pub fn next_step(&self) -> &Tangent {
        &self.inspector.as_ref().expect("a state was inspected").step
    }

    /// A direction along which the energy falls from the equilibrium inspected last; see [`Inspector::descent_direction`].
    pub fn descent_direction(&mut self, problem: &Problem<'_>, state: &State) -> Option<&Tangent> {
        self.inspector.as_mut()?.descent_direction(problem, state)
    }
}
