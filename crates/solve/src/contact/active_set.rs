//! Primal-dual active set for contact in the Newton model.
//!
//! The linear step d of Newton's method keeps the present contacts. It is wrong where contacts close or open, and a
//! line search would end at the first of them. So the step is the minimum of a model with all possible contacts,
//! `½ d·H d + g·d + Σ ½ ρ max(0, p − n·u)²`, with H and g without contact, u the motion of a contact point
//! relative to its partner, and `ρ p = λ − ρ gap`. The model is convex and piecewise quadratic where H is positive
//! definite. Its minimum is found by Newton's method in turn (primal-dual active set: Hintermüller, Ito and Kunisch
//! 2003), with an exact line search along each step, so that the model always decreases. `H d + g = Σ c n` holds at
//! every solution, with one number c per contact point, so the iteration needs these numbers only.

use wireloom_core::terms::contact::{Contact, Weights};
use wireloom_core::variable::{Block, Variable};
use wireloom_core::{Network, Problem, State, Tangent};

/// Bisections of the exact line search along a step.
const BISECTIONS: usize = 40;

/// Active set of contact in a linear step, with its workspace.
pub struct ActiveSet {
    candidates: Vec<Candidate>,
    /// d.
    reached: Tangent,
    /// Difference of the new solution and d.
    difference: Tangent,
    /// Fraction of g in `H d + g`: 1 at the beginning, 0 at a solution.
    gradient_fraction: f64,
}

/// A contact point that touches or approaches its partner.
struct Candidate {
    contact: Contact,
    /// Whether it touches at the beginning.
    touched: bool,
    /// Whether it is in the active set.
    active: bool,
    /// n·u, m.
    approach: f64,
    /// c, N.
    force: f64,
    /// `approach` and `force` at the new solution.
    next: (f64, f64),
}

impl Candidate {
    /// ρ (p − n·u), N: the contact force of the model, negative where it would pull.
    fn model_force(&self, approach: f64) -> f64 {
        self.contact.force - self.contact.penalty * approach
    }
}

impl ActiveSet {
    /// Empty set for the states of a network.
    pub fn new(network: &Network) -> Self {
        let zeros = || Tangent::zeros(network);
        Self { candidates: Vec::new(), reached: zeros(), difference: zeros(), gradient_fraction: 1.0 }
    }

    /// Whether no contact is possible.
    pub fn is_idle(&self) -> bool {
        self.candidates.is_empty()
    }

    /// Begins with the contacts found, and those approaching, at the state where contact was evaluated last.
    pub fn begin(&mut self, problem: &Problem<'_>) {
        let candidate = |contact: &Contact, active| Candidate {
            contact: *contact,
            touched: active,
            active,
            approach: 0.0,
            force: 0.0,
            next: (0.0, 0.0),
        };
        self.candidates.clear();
        self.candidates.extend(problem.contact().found().iter().map(|contact| candidate(contact, true)));
        self.candidates.extend(problem.contact().approaching().iter().map(|contact| candidate(contact, false)));
        self.reached.clear();
        self.gradient_fraction = 1.0;
    }

    /// Exact line search towards `step`, the solution at `state` with the present active set; `step` becomes the
    /// minimum found. If the active set changes there, `model` and `blocks` (of [`Problem::hessian_blocks`]) become the
    /// first and second derivatives of the model with the new one. Returns whether it changed; the step must then be
    /// solved for again. `gradient` is the gradient at `state`; `None` if the step contains a prescribed motion, which
    /// is then applied in full by the first solution.
    pub fn update(
        &mut self,
        problem: &Problem<'_>,
        state: &State,
        gradient: Option<&Tangent>,
        step: &mut Tangent,
        model: &mut Tangent,
        blocks: &mut Vec<Block>,
    ) -> bool {
        let Self { candidates, reached, difference, gradient_fraction } = self;
        for candidate in candidates.iter_mut() {
            let approach = approach(problem, &candidate.contact, step);
            candidate.next = (approach, if candidate.active { candidate.model_force(approach) } else { 0.0 });
        }
        difference.copy_from(step);
        difference.add_scaled(-1.0, reached);
        // g along the difference: the gradient contains the contacts at the beginning.
        let touched = candidates.iter().filter(|candidate| candidate.touched);
        let pushes: f64 = touched.map(|c| c.contact.force * (c.next.0 - c.approach)).sum();
        let descent = gradient.map(|gradient| *gradient_fraction * (gradient.dot(difference) + pushes));
        // ∂m/∂t at fraction t of the difference.
        let slope = |t: f64| -> f64 {
            let along = candidates.iter().map(|candidate| {
                let (approach, force) = candidate.next;
                let change = approach - candidate.approach;
                let own = candidate.force + t * (force - candidate.force);
                change * (own - candidate.model_force(candidate.approach + t * change).max(0.0))
            });
            (1.0 - t) * descent.unwrap_or(0.0) + along.sum::<f64>()
        };
        let whole = *gradient_fraction == 1.0 && gradient.is_none() || slope(1.0) <= 0.0;
        let t = if whole {
            1.0
        } else {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                if slope(middle) < 0.0 { low = middle } else { high = middle }
            }
            low
        };
        reached.add_scaled(t, difference);
        step.copy_from(reached);
        *gradient_fraction *= 1.0 - t;
        let mut changed = false;
        for candidate in candidates.iter_mut() {
            let (approach, force) = candidate.next;
            candidate.approach += t * (approach - candidate.approach);
            candidate.force += t * (force - candidate.force);
            let active = candidate.model_force(candidate.approach) > 0.0;
            if std::mem::replace(&mut candidate.active, active) != active {
                changed = true;
                let sign = if active { 1.0 } else { -1.0 };
                add_spring(problem, state, &candidate.contact, sign, model, blocks);
            }
        }
        changed
    }
}

/// n·u, m.
fn approach(problem: &Problem<'_>, contact: &Contact, step: &Tangent) -> f64 {
    let places = problem.contact().places(problem.system(), contact);
    places.iter().map(|(point, weights)| contact.normal.dot(&step.points[*point]) * weights.u).sum()
}

/// Adds `sign` times the first and second derivatives of ½ ρ (p − n·u)².
fn add_spring(
    problem: &Problem<'_>,
    state: &State,
    contact: &Contact,
    sign: f64,
    gradient: &mut Tangent,
    blocks: &mut Vec<Block>,
) {
    let Contact { normal, force, penalty, .. } = contact;
    let (term, system) = (problem.contact(), problem.system());
    let places = term.places(system, contact);
    for (point, Weights { u, .. }) in places.iter().filter(|(_, weights)| weights.u != 0.0) {
        for (variable, column) in term.columns(system, state, *point).into_iter().flatten() {
            let slope = column.tr_mul(normal) * (-sign * force * u);
            match variable {
                Variable::Point(i) => gradient.points[i] += slope,
                Variable::Frame(c) => gradient.frames[c] += slope,
            }
        }
    }
    let stiffness = normal * normal.transpose() * (sign * penalty);
    term.add_blocks(system, state, &places, |p, q| stiffness * (p.u * q.u), blocks);
}
