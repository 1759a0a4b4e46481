//! What will touch after a linear step.
//!
//! The linear step d of Newton's method takes what touches now for what will: where spots come to touch, or leave, it is far off, and a line search
//! cuts it where the first of them does. So the step is that to the minimum of the model with all of them, `½ d·H d + g·d + Σ ½ ρ max(0, p − n·u)²`
//! with H and g those of all but contact, u how a spot moves against what it may touch, and `ρ p = λ − ρ gap`: a convex, piecewise quadratic
//! function where H is positive definite. Its minimum is found by Newton's method in turn (the primal-dual active set method: Hintermüller, Ito and
//! Kunisch 2003), along each of whose steps the model is minimised exactly, so that it always goes down. As `H d + g = Σ c n` at every solution, with
//! one number c for each spot, that takes these numbers alone.

use super::Contact;
use crate::fixings::Block;
use crate::problem::{Problem, Variable};
use crate::{Network, State, Tangent};

/// Halvings in the search along a step.
const HALVINGS: usize = 40;

/// What a linear step will bring into contact; keeps its workspace.
pub struct Foresight {
    contacts: Vec<Foreseen>,
    /// d, and the way from there to the new solution.
    reached: Tangent,
    way: Tangent,
    /// Share of g in `H d + g`, which is 1 at the beginning and 0 at a solution.
    start: f64,
}

/// A spot that touches, or may come to.
struct Foreseen {
    contact: Contact,
    /// Whether it touches at the beginning.
    touched: bool,
    /// Whether it is taken to touch.
    touches: bool,
    /// n·u, m.
    approach: f64,
    /// c, N.
    share: f64,
    /// Both at the new solution.
    next: (f64, f64),
}

impl Foreseen {
    /// ρ (p − n·u), N: with which it would be pushed, or pulled.
    fn push(&self, approach: f64) -> f64 {
        self.contact.force - self.contact.penalty * approach
    }
}

impl Foresight {
    /// For the states of a network.
    pub fn new(network: &Network) -> Self {
        let zeros = || Tangent::zeros(network);
        Self { contacts: Vec::new(), reached: zeros(), way: zeros(), start: 1.0 }
    }

    /// Whether nothing may come to touch.
    pub fn is_idle(&self) -> bool {
        self.contacts.is_empty()
    }
}

impl Problem<'_> {
    /// Notes what touches and what may come to, where contact was evaluated last.
    pub fn begin_foresight(&self, foresight: &mut Foresight) {
        let contacts = &mut foresight.contacts;
        contacts.clear();
        let note = |contact: &Contact, touches| Foreseen {
            contact: *contact,
            touched: touches,
            touches,
            approach: 0.0,
            share: 0.0,
            next: (0.0, 0.0),
        };
        contacts.extend(self.contacts.found.iter().map(|contact| note(contact, true)));
        contacts.extend(self.contacts.coming.iter().map(|contact| note(contact, false)));
        foresight.reached.clear();
        foresight.start = 1.0;
    }

    /// With a step that was solved for at `state`, what was noted being taken to touch as it is: goes along it to where the model is least, and
    /// makes `step` the whole step so far. Where something else touches there than was taken to, `model` and `blocks` (those of
    /// [`Self::fixing_hessian`]) become first and second derivatives of the model in which it does; returns whether, so that the
    /// step must be solved for anew. `gradient` is that at `state`; none where the step carries a prescribed motion, which is gone in one.
    pub fn foresee(
        &self,
        state: &State,
        foresight: &mut Foresight,
        gradient: Option<&Tangent>,
        step: &mut Tangent,
        model: &mut Tangent,
        blocks: &mut Vec<Block>,
    ) -> bool {
        let Foresight { contacts, reached, way, start } = foresight;
        for foreseen in contacts.iter_mut() {
            let approach = self.approach(&foreseen.contact, step);
            foreseen.next = (approach, if foreseen.touches { foreseen.push(approach) } else { 0.0 });
        }
        way.copy_from(step);
        way.add_scaled(-1.0, reached);
        // g along the way: the gradient has what touches in it.
        let touched = contacts.iter().filter(|foreseen| foreseen.touched);
        let pushes: f64 = touched.map(|f| f.contact.force * (f.next.0 - f.approach)).sum();
        let falls = gradient.map(|gradient| *start * (gradient.dot(way) + pushes));
        // ∂m/∂t at share t of the way.
        let slope = |t: f64| -> f64 {
            let along = contacts.iter().map(|foreseen| {
                let (approach, share) = foreseen.next;
                let way = approach - foreseen.approach;
                let own = foreseen.share + t * (share - foreseen.share);
                way * (own - foreseen.push(foreseen.approach + t * way).max(0.0))
            });
            (1.0 - t) * falls.unwrap_or(0.0) + along.sum::<f64>()
        };
        let whole = *start == 1.0 && gradient.is_none() || slope(1.0) <= 0.0;
        let t = if whole {
            1.0
        } else {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if slope(middle) < 0.0 { low = middle } else { high = middle }
            }
            low
        };
        reached.add_scaled(t, way);
        step.copy_from(reached);
        *start *= 1.0 - t;
        let mut changed = false;
        for foreseen in contacts.iter_mut() {
            let (approach, share) = foreseen.next;
            foreseen.approach += t * (approach - foreseen.approach);
            foreseen.share += t * (share - foreseen.share);
            let touches = foreseen.push(foreseen.approach) > 0.0;
            if std::mem::replace(&mut foreseen.touches, touches) != touches {
                changed = true;
                let sign = if touches { 1.0 } else { -1.0 };
                self.add_spring(state, &foreseen.contact, sign, model, blocks);
            }
        }
        changed
    }

    /// n·u.
    fn approach(&self, contact: &Contact, step: &Tangent) -> f64 {
        let places = self.places(contact);
        places.iter().map(|(point, u, _)| contact.normal.dot(&step.points[*point]) * u).sum()
    }

    /// Adds `sign` times the first and second derivatives of ½ ρ (p − n·u)².
    fn add_spring(&self, state: &State, contact: &Contact, sign: f64, gradient: &mut Tangent, blocks: &mut Vec<Block>) {
        let Contact { normal, force, penalty, .. } = contact;
        let places = self.places(contact);
        for (point, u, _) in places.iter().filter(|(_, u, _)| *u != 0.0) {
            for (variable, column) in self.columns(state, *point).into_iter().flatten() {
                let slope = column.tr_mul(normal) * (-sign * force * u);
                match variable {
                    Variable::Point(i) => gradient.points[i] += slope,
                    Variable::Frame(c) => gradient.frames[c] += slope,
                }
            }
        }
        let stiffness = normal * normal.transpose() * (sign * penalty);
        self.add_blocks(state, &places, |u, v, _, _| stiffness * (u * v), blocks);
    }
}
