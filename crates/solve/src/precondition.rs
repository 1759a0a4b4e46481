//! What turns a gradient into a direction: a metric in which the energy is nearly round.

use crate::border::Border;
use crate::gather::Gather;
use crate::matrix::BlockMatrix;
use crate::newton::{FIRST_SHIFT, RAISE};
use crate::structure::Structure;
use wireloom_core::problem::{Hessian, Problem};
use wireloom_core::{Network, State, Tangent, Vector};

/// Which metric M.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Metric {
    /// The Hessian where it was factorised last, shifted until it is positive definite.
    Hessian,
    /// None: metres and radians as they are.
    None,
}

impl Metric {
    /// The words of scenarios.
    pub(crate) const WORDS: [&str; 2] = ["hessian", "none"];

    pub(crate) fn from_word(word: &str) -> Option<Self> {
        let all = [Self::Hessian, Self::None];
        Self::WORDS.into_iter().zip(all).find_map(|(known, metric)| (known == word).then_some(metric))
    }
}

/// M, factorised; keeps its workspace.
pub(crate) struct Preconditioner {
    metric: Metric,
    gather: Gather,
    matrix: BlockMatrix,
    border: Border,
    hessian: Hessian,
    weights: Vec<f64>,
    rhs: Vec<Vector>,
    /// Matrices factorised so far.
    pub factorisations: usize,
}

impl Preconditioner {
    pub(crate) fn new(network: &Network, metric: Metric) -> Self {
        let matrix = BlockMatrix::new(Structure::new(network), network);
        Self {
            metric,
            gather: Gather::new(network, &matrix.structure),
            border: Border::default(),
            hessian: Hessian::new(network),
            weights: matrix.frame_weights(network),
            rhs: vec![Vector::zeros(); matrix.structure.len()],
            matrix,
            factorisations: 0,
        }
    }

    /// Takes M, the Hessian's, from `state`, where the gradient was evaluated last.
    pub(crate) fn make(&mut self, problem: &mut Problem<'_>, state: &State) {
        problem.hessian(state, None, &mut self.hessian);
        let first = FIRST_SHIFT * problem.scales().force;
        let (mut sigma, mut convex) = (0.0_f64, false);
        while self.factorise(problem, state, sigma) > 0 && sigma.is_finite() {
            if std::mem::replace(&mut convex, true) || !problem.make_convex(state, &mut self.hessian) {
                sigma = (RAISE * sigma).max(first);
            }
        }
    }

    fn factorise(&mut self, problem: &Problem<'_>, state: &State, sigma: f64) -> usize {
        self.gather.run(&mut self.matrix, problem.network, state, &self.hessian);
        if sigma > 0.0 {
            self.matrix.shift(sigma, &self.weights);
        }
        self.matrix.take_out(problem);
        self.factorisations += 1;
        self.matrix.factorise()
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

    /// The same with the prescribed motion in it.
    pub(crate) fn solve_moving(
        &mut self,
        problem: &mut Problem<'_>,
        state: &State,
        gradient: &Tangent,
        motion: Option<&Tangent>,
        step: &mut Tangent,
    ) {
        self.matrix.right_hand_side(problem, gradient, motion, &mut self.rhs);
        self.matrix.solve(&mut self.rhs);
        self.matrix.step(problem, state, &mut self.rhs, motion, step);
        if problem.slides_any() {
            self.border.complete(&self.matrix, problem, state, gradient, &mut self.rhs, step);
        }
    }
}
