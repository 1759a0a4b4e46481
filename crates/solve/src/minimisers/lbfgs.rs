//! Minimiser `lbfgs`: limited-memory method of Broyden, Fletcher, Goldfarb and Shanno (Nocedal 1980) on the manifold of
//! positions and frames (Huang, Gallivan and Absil 2015).
//!
//! With the last m steps `s` and changes of the gradient `y`, all transported to the present state, the two-loop
//! recursion (Nocedal and Wright, 2nd ed., algorithm 7.4) applies the inverse of a matrix with `B s = y` for the last
//! pair. The metric is applied between the two loops.

use crate::minimisers::descent::{self, Method};
use crate::minimisers::transport::transport;
use std::collections::VecDeque;
use wireloom_core::registry::{Form, MinimiserKind, Parameter, Value};
use wireloom_core::{Network, Tangent};

/// Default of `memory`.
const MEMORY: usize = 8;
/// Default fraction of the first slope that may remain after a line search: large, as a step of length 1 is usually
/// good.
const SLOPE: f64 = 0.9;
/// Least curvature of a pair: pairs with `s·y` below this fraction of `|s| |y|` are discarded.
const LEAST_CURVATURE: f64 = 1e-12;

/// The kind `lbfgs`.
pub fn kind() -> MinimiserKind {
    let memory = Parameter {
        name: "memory".into(),
        doc: "how many steps it remembers".into(),
        form: Form::Count { minimum: 1 },
        default: Some(Value::Count(MEMORY)),
        required: false,
    };
    descent::kind(
        "limited-memory BFGS by gradients, in the metric of a Hessian that is factorised now and then; to compare with",
        SLOPE,
        memory,
        |given| Memory {
            size: given.count("memory").unwrap_or(MEMORY),
            metric: given.word("preconditioner") != Some("none"),
            pairs: VecDeque::new(),
            spare: Vec::new(),
            gradient: None,
        },
    )
}

/// A step and the change of the gradient along it.
struct Pair {
    s: Tangent,
    y: Tangent,
    /// 1/(s·y).
    rho: f64,
    /// Scratch of the two-loop recursion.
    a: f64,
}

/// Memory of the last steps.
struct Memory {
    size: usize,
    /// Whether there is a metric, which makes a step of length 1 about right.
    metric: bool,
    /// Pairs, oldest first.
    pairs: VecDeque<Pair>,
    /// Unused pairs.
    spare: Vec<Pair>,
    /// Scratch; `None` before [`Method::allocate`].
    gradient: Option<Tangent>,
}

impl Method for Memory {
    const NAME: &'static str = "lbfgs";

    fn allocate(&mut self, network: &Network) {
        let pair = || Pair { s: Tangent::zeros(network), y: Tangent::zeros(network), rho: 0.0, a: 0.0 };
        self.pairs = VecDeque::with_capacity(self.size);
        self.spare = (0..self.size).map(|_| pair()).collect();
        self.gradient = Some(Tangent::zeros(network));
    }

    fn restart(&mut self) {
        self.spare.extend(self.pairs.drain(..));
    }

    /// Does nothing: the pairs do not depend on the metric.
    fn metric_changes(&mut self) {}

    fn is_blank(&self) -> bool {
        self.pairs.is_empty()
    }

    fn knows_lengths(&self) -> bool {
        true
    }

    fn learn(&mut self, step: &Tangent, alpha: f64, gradient: &Tangent, before: &Tangent) {
        for pair in &mut self.pairs {
            transport(&mut pair.s, step, alpha);
            transport(&mut pair.y, step, alpha);
        }
        let pair = self.spare.pop().or_else(|| self.pairs.pop_front());
        let Some(mut pair) = pair else { return };
        pair.s.clear();
        pair.s.add_scaled(alpha, step);
        pair.y.copy_from(gradient);
        pair.y.add_scaled(-1.0, before);
        let curvature = pair.s.dot(&pair.y);
        if curvature > LEAST_CURVATURE * (pair.s.dot(&pair.s) * pair.y.dot(&pair.y)).sqrt() {
            pair.rho = 1.0 / curvature;
            self.pairs.push_back(pair);
        } else {
            self.spare.push(pair);
        }
    }

    fn direction(&mut self, gradient: &Tangent, solve: &mut dyn FnMut(&Tangent, &mut Tangent), step: &mut Tangent) {
        let Some(q) = &mut self.gradient else { return };
        q.copy_from(gradient);
        for pair in self.pairs.iter_mut().rev() {
            pair.a = pair.rho * pair.s.dot(q);
            q.add_scaled(-pair.a, &pair.y);
        }
        // step = −M⁻¹ q: the signs below are reversed.
        solve(q, step);
        if let (Some(last), false) = (self.pairs.back(), self.metric) {
            // γ = s·y/y·y, the inverse curvature along the last step.
            let gamma = 1.0 / (last.rho * last.y.dot(&last.y));
            q.copy_from(step);
            step.add_scaled(gamma - 1.0, q);
        }
        for pair in &self.pairs {
            let b = -pair.rho * pair.y.dot(step);
            step.add_scaled(b - pair.a, &pair.s);
        }
    }
}
