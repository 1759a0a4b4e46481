//! The minimiser `lbfgs`: the method of Broyden, Fletcher, Goldfarb and Shanno with limited memory (Nocedal 1980), on the manifold of
//! positions and frames (Huang, Gallivan and Absil 2015).
//!
//! With the last m steps `s` and changes of the gradient `y`, all carried to the state at hand, the two loops of Nocedal and Wright
//! (2nd ed., algorithm 7.4) apply the inverse of a matrix that has `B s = y` for the last of them; in their midst stands the metric.

use crate::minimisers::descent::{self, Method};
use crate::minimisers::transport::carry;
use std::collections::VecDeque;
use wireloom_core::registry::{Form, MinimiserKind, Parameter, Value};
use wireloom_core::{Network, Tangent};

/// Default of `memory`.
const MEMORY: usize = 8;
/// Default fraction of the slope that a line search may leave: a step of one need not be improved.
const SLOPE: f64 = 0.9;
/// Pairs with `s·y` below this fraction of `|s| |y|` say nothing of a curvature.
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

/// One step and what it did to the gradient.
struct Pair {
    s: Tangent,
    y: Tangent,
    /// 1/(s·y).
    rho: f64,
    /// Scratch of the two loops.
    a: f64,
}

/// The last steps.
struct Memory {
    size: usize,
    /// Whether there is a metric, in which a step of one is about right.
    metric: bool,
    /// Oldest first.
    pairs: VecDeque<Pair>,
    /// Room for pairs.
    spare: Vec<Pair>,
    /// Scratch; there once a network is.
    gradient: Option<Tangent>,
}

impl Method for Memory {
    const NAME: &'static str = "lbfgs";

    fn ready(&mut self, network: &Network) {
        let room = || Pair { s: Tangent::zeros(network), y: Tangent::zeros(network), rho: 0.0, a: 0.0 };
        self.pairs = VecDeque::with_capacity(self.size);
        self.spare = (0..self.size).map(|_| room()).collect();
        self.gradient = Some(Tangent::zeros(network));
    }

    fn restart(&mut self) {
        self.spare.extend(self.pairs.drain(..));
    }

    /// Steps and changes of the gradient are what they are in any metric.
    fn metric_changes(&mut self) {}

    fn is_blank(&self) -> bool {
        self.pairs.is_empty()
    }

    fn knows_lengths(&self) -> bool {
        true
    }

    fn learn(&mut self, step: &Tangent, alpha: f64, gradient: &Tangent, before: &Tangent) {
        for pair in &mut self.pairs {
            carry(&mut pair.s, step, alpha);
            carry(&mut pair.y, step, alpha);
        }
        let room = self.spare.pop().or_else(|| self.pairs.pop_front());
        let Some(mut pair) = room else { return };
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
        // step = −M⁻¹ q, so that below all signs are turned.
        solve(q, step);
        if let (Some(last), false) = (self.pairs.back(), self.metric) {
            // γ = s·y/y·y, the length of the last step's curvature.
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
