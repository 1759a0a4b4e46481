//! The second derivatives at an equilibrium: whether it is stable, and how far the next Newton step would move the harness.
//!
//! An equilibrium is stable where the Hessian A is positive definite. What counts as zero is what round-off can make of it: the
//! factorisation is that of a matrix whose entries differ from A by less than `τ √(a_ii a_jj)` (Higham 2002, Accuracy and Stability of
//! Numerical Algorithms, theorem 10.3), so with D the diagonal of A
//!
//! ```text
//! A − τ D positive definite: stable;   A + τ D not positive definite: unstable;   else neutral
//! ```
//!
//! Each entry is measured by its own diagonal, so a soft wire is judged by itself, whatever it is joined to. Forces that are left, r, make
//! a rotation about them appear with the curvature `r · lever`: that much is added to τ D at the frames, too.

use crate::linear::assembly::System;
use crate::linear::border::{Border, Inertia};
use crate::linear::dead_moments::DeadMoments;
use wireloom_core::problem::{Hessian, Problem};
use wireloom_core::scales::nan_max;
use wireloom_core::{State, Tangent, Vector};

/// τ: a few roundings in every entry of the Hessian and of its factor.
const ROUND_OFF: f64 = 8.0 * f64::EPSILON;
/// Levers of the forces that are left, in lengths of their branch.
const LEVERS: f64 = 4.0;

/// What a disturbance makes of an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// It comes back.
    Stable,
    /// There is a motion that costs nothing, or nothing that could be told from round-off.
    Neutral,
    /// It leaves.
    Unstable,
}

impl Stability {
    /// Whether it is stable; `None` where that cannot be told from round-off.
    pub fn flag(self) -> Option<bool> {
        match self {
            Self::Stable => Some(true),
            Self::Neutral => None,
            Self::Unstable => Some(false),
        }
    }
}

/// What the second derivatives say of an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inspection {
    /// Whether it is one that stays.
    pub stability: Stability,
    /// The largest move of a point in the next Newton step, m: an estimate of how far the shape is off.
    pub move_left: f64,
    /// The same relative to the longest branch of the piece, or the largest turn of a frame (rad), whichever is larger.
    pub relative: f64,
    /// Whether the energy that the step would save is round-off.
    pub is_worthless: bool,
    /// Whether it would be stable, but for the forces that are left.
    pub is_blurred: bool,
    /// Whether cables touch something: the next step does not know where contact or friction would end it.
    pub touches: bool,
}

impl Inspection {
    /// Whether the next step goes along a motion that costs nothing, by round-off: where on it the harness stands is not told by its energy.
    pub fn is_flat(&self) -> bool {
        self.stability == Stability::Neutral && self.is_worthless
    }
}

/// Looks at second derivatives; keeps its workspace.
pub struct Inspector {
    system: System,
    hessian: Hessian,
    border: Border,
    /// Scratch: the gradient without its held part.
    free: Tangent,
    /// The next Newton step from the state inspected last.
    pub step: Tangent,
    weights: Vec<f64>,
    /// By branch: the sum of the forces that are left, N.
    left: Vec<f64>,
}

impl Inspector {
    /// For the states of a problem's network.
    pub fn new(problem: &Problem<'_>) -> Self {
        let network = problem.network;
        Self {
            system: System::new(problem),
            hessian: Hessian::new(network),
            border: Border::default(),
            free: Tangent::zeros(network),
            step: Tangent::zeros(network),
            weights: Vec::new(),
            left: vec![0.0; network.branches.len()],
        }
    }

    /// Looks at an equilibrium; `gradient` is the whole gradient there, evaluated last.
    pub fn inspect(&mut self, problem: &mut Problem<'_>, state: &State, gradient: &Tangent) -> Inspection {
        problem.hessian(state, None, &mut self.hessian);
        self.free.copy_from(gradient);
        problem.free_part(&mut self.free);
        self.sum_what_is_left(problem);
        let mut is_blurred = false;
        let stability = if self.inertia(problem, state, gradient, -ROUND_OFF, -LEVERS).is_positive() {
            Stability::Stable
        } else if self.inertia(problem, state, gradient, -ROUND_OFF, 0.0).is_positive() {
            is_blurred = true;
            Stability::Neutral
        } else if self.inertia(problem, state, gradient, ROUND_OFF, 0.0).is_not_negative()
            || self.inertia(problem, state, gradient, ROUND_OFF, LEVERS).is_not_negative()
        {
            Stability::Neutral
        } else {
            Stability::Unstable
        };
        self.next_step(problem, state, gradient);
        let network = problem.network;
        let (mut move_left, mut relative) = (0.0_f64, largest(&self.step.frames));
        for (branch, scale) in network.branches.iter().zip(problem.local_scales()) {
            let moved = largest(&self.step.points[branch.points.clone()]);
            move_left = nan_max(move_left, moved);
            relative = nan_max(relative, moved / scale.length);
        }
        let touches = !problem.conditions().contact.records.is_empty();
        let is_worthless = -self.free.dot(&self.step) <= problem.energy_noise(gradient);
        Inspection { stability, move_left, relative, is_worthless, is_blurred, touches }
    }

    /// Whether an equilibrium under dead moments is certainly unstable: the tangent of the residual has a negative determinant, so one of its real
    /// eigenvalues is negative, and something grows without end however it is damped (divergence). Otherwise nothing is known: what has no
    /// potential may be unstable in pairs of directions, or flutter. Where cables slide, nothing is said. `gradient` is as for [`Self::inspect`].
    pub fn diverges(&mut self, problem: &mut Problem<'_>, state: &State, gradient: &Tangent) -> bool {
        if problem.has_slides() {
            return false;
        }
        problem.hessian(state, None, &mut self.hessian);
        self.free.copy_from(gradient);
        problem.free_part(&mut self.free);
        self.sum_what_is_left(problem);
        let Inertia { negative, .. } = self.inertia(problem, state, gradient, ROUND_OFF, LEVERS);
        let Self { system: System { matrix, rhs, .. }, border, .. } = self;
        let mut moments = DeadMoments::default();
        moments.prepare(matrix, border, problem, state, rhs);
        moments.turns_determinant(negative)
    }

    /// A direction along which the energy falls from the unstable equilibrium inspected last, its largest turn 1 rad (or, where no frame
    /// turns, its largest move 1 m). `None` where there is none.
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

    /// Signs of the pivots of `A + entries D + levers W`, with W the weights by the forces that are left; the matrix is factorised then.
    fn inertia(
        &mut self,
        problem: &mut Problem<'_>,
        state: &State,
        gradient: &Tangent,
        entries: f64,
        levers: f64,
    ) -> Inertia {
        let Self { system, hessian, border, weights, left, .. } = self;
        system.fill(problem, state, hessian);
        let System { matrix, rhs, .. } = system;
        weights.resize(rhs.len(), 0.0);
        matrix.frame_weights(problem.network, |branch| left[branch], weights);
        matrix.grow_diagonal(entries);
        matrix.shift(levers, weights);
        matrix.eliminate_prescribed(problem);
        let pivots = Inertia { negative: matrix.factorise(), flat: 0 };
        if pivots.negative > 0 || !problem.has_slides() {
            border.forget();
            return pivots;
        }
        border.inertia(matrix, problem, state, gradient, rhs)
    }

    /// The next Newton step, with the matrix that was factorised last.
    fn next_step(&mut self, problem: &mut Problem<'_>, state: &State, gradient: &Tangent) {
        let Self { system: System { matrix, rhs, .. }, border, step, .. } = self;
        matrix.right_hand_side(problem, gradient, None, rhs);
        matrix.solve(rhs);
        step.clear();
        matrix.step(problem, state, rhs, None, step);
        if problem.has_slides() {
            border.complete(matrix, problem, state, gradient, rhs, step);
        }
    }

    /// By branch what is left of the forces on it and on the joints at its ends, and of moments over its length, N.
    fn sum_what_is_left(&mut self, problem: &Problem<'_>) {
        let network = problem.network;
        let sum = |all: &[Vector]| -> f64 { all.iter().map(Vector::norm).sum() };
        for (branch, left) in network.branches.iter().zip(&mut self.left) {
            let moments = sum(&self.free.frames[branch.frames.clone()]);
            *left = sum(&self.free.points[branch.points.clone()]) + moments / branch.rod.mesh().length();
        }
        for joint in &network.joints {
            let force = self.free.points[joint.point].norm();
            let moment = joint.frame.map_or(0.0, |c| self.free.frames[c].norm());
            for &b in &joint.branches {
                self.left[b] += force + moment / network.branches[b].rod.mesh().length();
            }
        }
    }
}

fn largest(all: &[Vector]) -> f64 {
    all.iter().map(Vector::norm_squared).fold(0.0, nan_max).sqrt()
}
