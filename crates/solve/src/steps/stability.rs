//! Inspection of the second derivatives at an equilibrium: stability, and the move of the next Newton step.
//!
//! An equilibrium is stable if the Hessian A is positive definite. Round-off decides what counts as zero: the computed
//! factor is that of a matrix whose entries differ from those of A by less than `τ √(a_ii a_jj)` (Higham 2002,
//! Accuracy and Stability of Numerical Algorithms, theorem 10.3). So, with D the diagonal of A,
//!
//! ```text
//! A − τ D positive definite: stable;   A + τ D not positive definite: unstable;   else neutral
//! ```
//!
//! Each entry is compared with its own diagonal, so a soft wire is graded independently of stiff neighbours. Residual
//! forces r change the curvature of rotations by `r · lever`; this is added to τ D at the frames.

use crate::linear::assembly::System;
use crate::linear::border::{Border, Inertia};
use crate::linear::without_potential::WithoutPotential;
use wireloom_core::problem::{Hessian, Problem};
use wireloom_core::scales::nan_max;
use wireloom_core::{Network, State, Tangent, Vector};

/// τ: some rounding errors in every entry of the Hessian and of its factor.
const ROUND_OFF: f64 = 8.0 * f64::EPSILON;
/// Lever of the residual forces, in lengths of their branch.
const LEVERS: f64 = 4.0;
/// ε of [`Inspector::responses`]: far above τ, far below what other motions than neutral ones have.
const NEUTRAL_SHIFT: f64 = 1e-10;
/// Least change of a response from ε to 2 ε, relative to it, where it is that of a neutral motion; of that alone it is
/// one half.
const NEUTRAL_CHANGE: f64 = 0.25;
/// Share of the work along neutral motions that is the error of a gradient of a motion that changes no energy.
const NEUTRAL_WORK: f64 = 0.05;

/// Stability of an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// It returns after a small disturbance.
    Stable,
    /// A motion changes the energy by round-off only.
    Neutral,
    /// A small disturbance grows.
    Unstable,
}

impl Stability {
    /// Whether it is stable; `None` if neutral.
    pub fn flag(self) -> Option<bool> {
        match self {
            Self::Stable => Some(true),
            Self::Neutral => None,
            Self::Unstable => Some(false),
        }
    }
}

/// Result of an inspection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inspection {
    /// Stability; under loads without a potential that without them.
    pub stability: Stability,
    /// Largest move of a point in the next Newton step, m: an estimate of the error of the shape.
    pub move_left: f64,
    /// Largest move relative to the longest branch of the piece, or largest turn of a frame (rad), whichever is larger.
    pub relative: f64,
    /// Whether the decrease of the energy in the next step is round-off; never without a potential.
    pub is_negligible: bool,
    /// Whether it is neutral only because of the residual forces, else stable; never without a potential.
    pub is_uncertain: bool,
    /// Whether cables are in contact: contact or friction would end the next step early.
    pub in_contact: bool,
}

impl Inspection {
    /// Whether the next step is along a motion that changes the energy by round-off only: the position along it is
    /// undetermined.
    pub fn is_flat(&self) -> bool {
        self.stability == Stability::Neutral && self.is_negligible
    }
}

/// Inspects second derivatives, with its workspace.
pub struct Inspector {
    system: System,
    /// Second derivatives at the state inspected last.
    pub hessian: Hessian,
    border: Border,
    without: WithoutPotential,
    /// Scratch: free part of the gradient.
    free: Tangent,
    /// Next Newton step from the state inspected last.
    pub step: Tangent,
    /// Points of the state inspected last.
    at: Vec<Vector>,
    weights: Vec<f64>,
    /// Sum of the residual forces on each branch, N.
    residual_forces: Vec<f64>,
    /// Whether a motion from the state inspected last changes the energy by round-off only.
    is_neutral: bool,
    /// Whether such a motion moves points; known after [`Self::responses`].
    wanders: bool,
}

impl Inspector {
    /// Inspector for the states of a problem's network.
    pub fn new(problem: &Problem<'_>) -> Self {
        let network = problem.network;
        Self {
            system: System::new(problem),
            hessian: Hessian::new(network),
            border: Border::default(),
            without: WithoutPotential::default(),
            free: Tangent::zeros(network),
            step: Tangent::zeros(network),
            at: Vec::new(),
            weights: Vec::new(),
            residual_forces: vec![0.0; network.branches.len()],
            is_neutral: false,
            wanders: false,
        }
    }

    /// Inspects an equilibrium; `gradient` is the whole gradient there, evaluated last.
    pub fn inspect(&mut self, problem: &mut Problem<'_>, state: &State, gradient: &Tangent) -> Inspection {
        problem.hessian(state, None, &mut self.hessian);
        self.at.clone_from(&state.points);
        self.free.copy_from(gradient);
        problem.free_part(&mut self.free);
        self.sum_residual_forces(problem);
        let mut is_uncertain = false;
        let stability = if self.inertia(problem, state, gradient, -ROUND_OFF, -LEVERS).is_positive() {
            Stability::Stable
        } else if self.inertia(problem, state, gradient, -ROUND_OFF, 0.0).is_positive() {
            is_uncertain = true;
            Stability::Neutral
        } else if self.inertia(problem, state, gradient, ROUND_OFF, 0.0).is_not_negative()
            || self.inertia(problem, state, gradient, ROUND_OFF, LEVERS).is_not_negative()
        {
            Stability::Neutral
        } else {
            Stability::Unstable
        };
        self.is_neutral = stability == Stability::Neutral && !is_uncertain;
        self.wanders = false;
        self.border.step(&mut self.system, problem, state, gradient, None, &mut self.step);
        let has_potential = problem.has_potential();
        if !has_potential {
            let Self { system, border, without, step, .. } = self;
            without.prepare(system, border, problem, state);
            without.complete(system, border, problem, state, step);
        }
        let network = problem.network;
        let (mut move_left, mut relative) = (0.0_f64, largest(&self.step.frames));
        for (branch, scale) in network.branches.iter().zip(problem.local_scales()) {
            let moved = largest(&self.step.points[branch.points.clone()]);
            move_left = nan_max(move_left, moved);
            relative = nan_max(relative, moved / scale.length);
        }
        let in_contact = !problem.conditions().contact.records.is_empty();
        let is_negligible = has_potential && -self.free.dot(&self.step) <= problem.energy_noise(gradient);
        let is_uncertain = has_potential && is_uncertain;
        Inspection { stability, move_left, relative, is_negligible, is_uncertain, in_contact }
    }

    /// Whether the last [`Self::inspect`] was at `state`.
    pub fn is_at(&self, state: &State) -> bool {
        self.at == state.points
    }

    /// `−H⁻¹ g` at `state`, inspected last, for other gradients g of the points and frames; what slides stays at its
    /// arc length. Under loads without a potential H is the tangent of the residual.
    ///
    /// At a neutral equilibrium they are without neutral motions, which nothing determines. With A + ε D instead of H
    /// these have a share of 1/ε, so `2 (A + 2 ε D)⁻¹ − (A + ε D)⁻¹` has none, and 1/λ of other eigenvalues λ of D⁻¹ A.
    /// If g does work along the neutral motions, they stay: the equilibrium would be elsewhere, far away.
    pub fn responses<const N: usize>(
        &mut self,
        problem: &Problem<'_>,
        state: &State,
        gradients: &[Tangent; N],
    ) -> [Tangent; N] {
        if !self.is_neutral {
            return gradients.each_ref().map(|gradient| self.response(problem, state, gradient));
        }
        let any = any_forces(problem.network);
        let [(once, any_once), (mut responses, mut neutral)] = [1.0, 2.0].map(|factor| {
            self.factorise(problem, state, factor * NEUTRAL_SHIFT, 0.0);
            if !problem.has_potential() {
                self.without.prepare(&mut self.system, &self.border, problem, state);
            }
            let responses = gradients.each_ref().map(|gradient| self.response(problem, state, gradient));
            (responses, self.response(problem, state, &any))
        });
        neutral.add_scaled(-1.0, &any_once);
        self.wanders = problem.network.branches.iter().any(|branch| {
            let [change, whole] = [&neutral, &any_once].map(|own| largest(&own.points[branch.points.clone()]));
            change > NEUTRAL_CHANGE * whole
        });
        for ((response, once), gradient) in responses.iter_mut().zip(once).zip(gradients) {
            // Minus half the neutral part.
            let mut neutral = response.clone();
            neutral.add_scaled(-1.0, &once);
            if neutral.dot(gradient).abs() <= NEUTRAL_WORK * size_of_work(&neutral, gradient) {
                response.add_scaled(1.0, &neutral);
            } else {
                *response = once;
            }
        }
        responses
    }

    /// Whether the equilibrium inspected last can move without a force, so that nothing determines where it is: not
    /// whether a cable only rolls about its own centre line. Known after [`Self::responses`].
    pub fn wanders(&self) -> bool {
        self.wanders
    }

    /// `−H⁻¹ g` with the Hessian factorised last, of `state`.
    fn response(&mut self, problem: &Problem<'_>, state: &State, gradient: &Tangent) -> Tangent {
        let mut response = Tangent::zeros(problem.network);
        let Self { system, border, without, .. } = self;
        system.step(problem, state, gradient, None, &mut response);
        if !problem.has_potential() {
            without.complete(system, border, problem, state, &mut response);
        }
        response
    }

    /// Newton step from `state`, which is near the one inspected last, with the matrix factorised there: `problem` is
    /// the one inspected, `gradient` the whole gradient at `state`, and `motion` that of the prescribed directions.
    pub fn step_near(
        &mut self,
        problem: &Problem<'_>,
        state: &State,
        gradient: &Tangent,
        motion: Option<&Tangent>,
    ) -> &Tangent {
        let Self { system, border, without, step, .. } = self;
        border.step_again(system, problem, state, gradient, motion, step);
        if !problem.has_potential() {
            without.complete(system, border, problem, state, step);
        }
        step
    }

    /// Whether an equilibrium without a potential certainly diverges: the tangent of the residual has a negative
    /// determinant, so one of its real eigenvalues is negative, and a disturbance grows with any damping. Otherwise
    /// stability is unknown: without a potential the equilibrium may be unstable in an even number of directions, or
    /// flutter. Always false if cables slide, and under forces per length without a potential, where the determinant is
    /// not known. `gradient` is as for [`Self::inspect`].
    pub fn diverges(&mut self, problem: &mut Problem<'_>, state: &State, gradient: &Tangent) -> bool {
        if problem.has_slides() {
            return false;
        }
        problem.hessian(state, None, &mut self.hessian);
        self.free.copy_from(gradient);
        problem.free_part(&mut self.free);
        self.sum_residual_forces(problem);
        let Inertia { negative, .. } = self.inertia(problem, state, gradient, ROUND_OFF, LEVERS);
        let Self { system, border, without, .. } = self;
        without.prepare(system, border, problem, state);
        self.without.turns_determinant(negative) == Some(true)
    }

    /// Direction along which the energy decreases from the unstable equilibrium inspected last, with a largest turn of
    /// 1 rad (or, if no frame turns, a largest move of 1 m). `None` if there is none.
    pub fn descent_direction(&mut self, problem: &Problem<'_>, state: &State) -> Option<&Tangent> {
        let System { matrix, rhs, .. } = &mut self.system;
        if matrix.negative_direction(rhs) {
            self.step.clear();
            matrix.step(problem, state, rhs, None, &mut self.step);
        } else if !self.border.negative_direction(&mut self.step) {
            return None;
        }
        let turn = largest(&self.step.frames);
        let size = if turn > 0.0 { turn } else { largest(&self.step.points) };
        self.free.clear();
        self.free.add_scaled(1.0 / size, &self.step);
        size.is_normal().then_some(&self.free)
    }

    /// Inertia of `A + entries D + levers W`, with W the weights by the residual forces; leaves the matrix factorised.
    fn inertia(
        &mut self,
        problem: &mut Problem<'_>,
        state: &State,
        gradient: &Tangent,
        entries: f64,
        levers: f64,
    ) -> Inertia {
        let pivots = Inertia { negative: self.factorise(problem, state, entries, levers), flat: 0 };
        let Self { system, border, .. } = self;
        if pivots.negative > 0 || !problem.has_slides() {
            border.forget();
            return pivots;
        }
        border.inertia(system, problem, state, gradient)
    }

    /// Factorises the matrix of [`Self::inertia`], without what slides, and returns its number of negative pivots.
    fn factorise(&mut self, problem: &Problem<'_>, state: &State, entries: f64, levers: f64) -> usize {
        let Self { system, hessian, weights, residual_forces, .. } = self;
        system.fill(problem, state, hessian);
        let System { matrix, rhs, .. } = system;
        weights.resize(rhs.len(), 0.0);
        matrix.frame_weights(problem.network, |branch| residual_forces[branch], weights);
        matrix.grow_diagonal(entries);
        matrix.shift(levers, weights);
        matrix.eliminate_prescribed(problem);
        matrix.factorise()
    }

    /// Sums the residual forces on each branch and on the joints at its ends, and the moments divided by its length, N.
    fn sum_residual_forces(&mut self, problem: &Problem<'_>) {
        let network = problem.network;
        let sum = |all: &[Vector]| -> f64 { all.iter().map(Vector::norm).sum() };
        for (branch, sum_of_branch) in network.branches.iter().zip(&mut self.residual_forces) {
            let moments = sum(&self.free.frames[branch.frames.clone()]);
            *sum_of_branch = sum(&self.free.points[branch.points.clone()]) + moments / branch.rod.mesh().length();
        }
        for joint in &network.joints {
            let force = self.free.points[joint.point].norm();
            let moment = joint.frame.map_or(0.0, |c| self.free.frames[c].norm());
            for &b in &joint.branches {
                self.residual_forces[b] += force + moment / network.branches[b].rod.mesh().length();
            }
        }
    }
}

/// Forces (N) and moments (N m) that do work along any motion that is not made for them.
fn any_forces(network: &Network) -> Tangent {
    let mut any = Tangent::zeros(network);
    for (k, force) in any.points.iter_mut().chain(&mut any.frames).enumerate() {
        *force = Vector::from_fn(|axis, _| (1.0 + (3 * k + axis) as f64).cos());
    }
    any
}

/// Sum of the sizes of the work of a gradient at each point and frame, J.
fn size_of_work(step: &Tangent, gradient: &Tangent) -> f64 {
    let sum = |a: &[Vector], b: &[Vector]| -> f64 { a.iter().zip(b).map(|(a, b)| a.norm() * b.norm()).sum() };
    sum(&step.points, &gradient.points) + sum(&step.frames, &gradient.frames)
}

fn largest(all: &[Vector]) -> f64 {
    all.iter().map(Vector::norm_squared).fold(0.0, nan_max).sqrt()
}
