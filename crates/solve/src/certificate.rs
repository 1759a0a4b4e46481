//! No minimiser grades its own work: forces and moments are recomputed here from the state alone.

use crate::border::Border;
use crate::gather::System;
use wireloom_core::fixings::Unmet;
use wireloom_core::minimiser::{Status, Stop};
use wireloom_core::problem::{Hessian, Problem};
use wireloom_core::{Network, State, Tangent};

/// Distance (m) or turn (rad) by which a held freedom may be off its target.
const VIOLATION: f64 = 1e-9;
/// Share of the force tolerance to which equations and inequalities are met, in units of their scales.
pub const FEASIBLE: f64 = 1e-2;
/// Pivots above minus this share of the force scale count as not negative: an equilibrium that may turn freely,
/// as a cable hung from one point may about the vertical, is not unstable.
const NEUTRAL: f64 = 1e-5;

/// What recomputation found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// Largest free force relative to the force scale, or moment relative to the moment scale.
    pub residual: f64,
    /// Largest distance (m) or turn (rad) by which a held freedom is off its target.
    pub violation: f64,
    /// The equation or inequality that is furthest from being met, where any acts.
    pub unmet: Option<Unmet>,
    /// How far contact is from being met, in units of what is let pass ([`wireloom_core::contact`]), where anything can touch.
    pub contact: Option<f64>,
    /// Converged, or what the minimiser said if the numbers do not bear it out.
    pub status: Status,
}

/// Recomputes what minimisers claim; keeps its workspace.
pub struct Certifier {
    /// The whole gradient at the state certified last; on held freedoms it is what the fixing exerts.
    pub gradient: Tangent,
    scratch: Tangent,
    stability: Option<Stability>,
}

/// What it takes to count negative pivots.
struct Stability {
    system: System,
    hessian: Hessian,
    border: Border,
}

impl Certifier {
    /// For the states of a network.
    pub fn new(network: &Network) -> Self {
        Self { gradient: Tangent::zeros(network), scratch: Tangent::zeros(network), stability: None }
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
        let residual = problem.residual(&self.scratch, &problem.scales());
        let unmet = problem.unmet(state);
        let feasible = unmet.is_none_or(|unmet| unmet.value <= FEASIBLE * stop.force_tolerance);
        let contact = problem.contact_unmet(state);
        let feasible = feasible && contact.is_none_or(|unmet| unmet <= 1.0);
        let holds = residual <= stop.force_tolerance && violation <= VIOLATION && feasible && state.is_finite();
        let status = match (holds, claimed) {
            (true, _) => Status::Converged,
            (false, Status::Converged) => Status::Failed,
            (false, other) => other,
        };
        Certificate { residual, violation, unmet, contact, status }
    }

    /// Whether no motion lowers the energy to second order, from the inertia of the Hessian at `state`. Call after
    /// [`Self::certify`] at the same state.
    pub fn stable(&mut self, problem: &mut Problem<'_>, state: &State) -> bool {
        let Stability { system, hessian, border } = self.stability.get_or_insert_with(|| Stability {
            system: System::new(problem),
            hessian: Hessian::new(problem.network),
            border: Border::default(),
        });
        problem.hessian(state, None, hessian);
        system.fill(problem, state, hessian);
        let System { matrix, weights, rhs, .. } = system;
        matrix.shift(NEUTRAL * problem.scales().force, weights);
        matrix.take_out(problem);
        let negative = matrix.factorise();
        if negative > 0 || !problem.slides_any() {
            return negative == 0;
        }
        border.negative(matrix, problem, state, &self.gradient, rhs) == 0
    }
}
