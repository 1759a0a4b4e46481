//! Preconditioner of the gradient minimisers: a Hessian that is refactorised now and then.

use super::step_control::{RAISE, raised};
use crate::linear::assembly::System;
use crate::linear::border::Border;
use wireloom_core::problem::{Hessian, Problem};
use wireloom_core::{State, Tangent};

/// Metric M of the preconditioner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Metric {
    /// Hessian at the state of the last factorisation, shifted until it is positive definite.
    Hessian,
    /// Identity, in metres and radians.
    None,
}

impl Metric {
    /// Names of the metrics in scenarios.
    pub(crate) const WORDS: [&str; 2] = ["hessian", "none"];

    pub(crate) fn from_word(word: &str) -> Option<Self> {
        let all = [Self::Hessian, Self::None];
        Self::WORDS.into_iter().zip(all).find_map(|(known, metric)| (known == word).then_some(metric))
    }
}

/// Factorised M, with its workspace.
pub(crate) struct Preconditioner {
    metric: Metric,
    system: System,
    border: Border,
    hessian: Hessian,
    /// Number of factorisations so far.
    pub factorisations: usize,
}

impl Preconditioner {
    pub(crate) fn new(problem: &Problem<'_>, metric: Metric) -> Self {
        Self {
            metric,
            system: System::new(problem),
            border: Border::default(),
            hessian: Hessian::new(problem.network),
            factorisations: 0,
        }
    }

    /// Recomputes M from the Hessian at `state`, where the gradient was evaluated last.
    pub(crate) fn refresh(&mut self, problem: &mut Problem<'_>, state: &State) {
        problem.hessian(state, None, &mut self.hessian);
        let (mut sigma, mut convex) = (0.0_f64, false);
        while !self.factorise(problem, state, sigma) && sigma.is_finite() && !problem.monitor.is_stopped() {
            if std::mem::replace(&mut convex, true) || !problem.make_convex(state, &mut self.hessian) {
                sigma = raised(sigma, RAISE);
            }
        }
    }

    /// Recomputes the weights of shifts from the present scales of `problem`.
    pub(crate) fn update_weights(&mut self, problem: &Problem<'_>) {
        self.system.update_weights(problem);
    }

    fn factorise(&mut self, problem: &Problem<'_>, state: &State, sigma: f64) -> bool {
        self.system.fill(problem, state, &self.hessian);
        let System { matrix, weights, .. } = &mut self.system;
        if sigma > 0.0 {
            matrix.shift(sigma, weights);
        }
        matrix.eliminate_prescribed(problem);
        self.factorisations += 1;
        matrix.factorise_if_positive()
    }

    /// `step = −M⁻¹ gradient`.
    pub(crate) fn solve(&mut self, problem: &mut Problem<'_>, state: &State, gradient: &Tangent, step: &mut Tangent) {
        if self.metric == Metric::None {
            step.clear();
            step.add_scaled(-1.0, gradient);
            problem.free_part(step);
            return;
        }
        self.solve_moving(problem, state, gradient, None, step);
    }

    /// [`Self::solve`] with the prescribed motion in the step.
    pub(crate) fn solve_moving(
        &mut self,
        problem: &mut Problem<'_>,
        state: &State,
        gradient: &Tangent,
        motion: Option<&Tangent>,
        step: &mut Tangent,
    ) {
        self.border.step(&mut self.system, problem, state, gradient, motion, step);
    }
}
