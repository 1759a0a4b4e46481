//! The search for a small board: simulated annealing over the directions of branches, and their bends where the board
//! is too small for straight ones.
//!
//! The objective is, with the weights below,
//!
//! ```text
//! breaches of clearance + part that lies beyond the board + bends and turns of the trunk + bends of branches
//!   + area of the board / area of the start + squares of the deviations of angles from the drawn ones
//! ```
//!
//! The first two must become zero: a layout that has them is none. A move turns a branch with all that it carries,
//! turns it alone, reflects what it carries, or bends it. Of the breaches and deviations only those that it may change
//! are computed anew. The same harness gives the same board: the generator of random numbers has a fixed seed, and no
//! clock is read.

use crate::clearance::Rules;
use crate::line::{Point, wrapped};
use crate::tree::{Limb, Tree};
use std::f64::consts::PI;

/// Directions are multiples of this, rad: 5°, as they are set on a board.
pub(crate) const STEP: f64 = PI / 36.0;

/// Bends are multiples of this, rad.
const BEND_STEP: f64 = PI / 12.0;

/// Largest bend of a branch from end to end, rad: an arc of less than that does not come back to itself.
const MOST_BEND: f64 = PI;

/// Weights of the objective.
const BREACH: [f64; 2] = [0.3, 10.0];
const BEYOND: [f64; 2] = [2.0, 30.0];
const TRUNK: f64 = 0.5;
const BEND: f64 = 0.05;
/// With a straight trunk, and on a board that is too small for it.
const DEVIATION: [f64; 2] = [3.0, 0.1];

/// Temperatures at the begin and the end.
const TEMPERATURES: [f64; 2] = [0.05, 2e-5];

/// Moves for each branch, and pairs of branches that all moves together may look at.
const MOVES: usize = 2500;
const PAIRS: usize = 300_000_000;

/// Moves after which sums are computed anew.
const RENEW: usize = 4096;

/// What the search must keep to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    pub rules: Rules,
    /// Largest width and height of what is laid, m.
    pub board: Option<[f64; 2]>,
}

/// A layout that breaks no rule, if one is found.
pub(crate) fn search(start: &Tree, limits: &Limits, seed: u64) -> Option<Tree> {
    let n = start.limbs.len();
    let mut state = State::new(start.clone(), *limits);
    let mut best = state.feasible().then(|| (state.objective(), state.tree.clone()));
    let movable: Vec<usize> = (0..n).filter(|&k| state.may_move(k)).collect();
    // A move looks at the pairs of a limb and all that it carries with everything else.
    let carried: usize = start.limbs.iter().enumerate().map(|(k, limb)| limb.last - k).sum();
    let moves = (MOVES * n).min(PAIRS / carried.max(1));
    if movable.is_empty() || n == 1 && !state.may_bend() {
        return best.map(|(_, tree)| tree);
    }
    let mut random = fastrand::Rng::with_seed(seed);
    for step in 0..moves {
        let progress = step as f64 / moves as f64;
        let between = |[from, to]: [f64; 2]| from * (to / from).powf(progress);
        let temperature = between(TEMPERATURES);
        state.weights = [between(BREACH), between(BEYOND)];
        let limb = movable[random.usize(..movable.len())];
        if step % RENEW == 0 {
            state.renew();
        }
        let action = state.propose(limb, &mut random);
        let before = state.total();
        state.apply(limb, action);
        let rise = state.total() - before;
        if rise > 0.0 && random.f64() >= (-rise / temperature).exp() {
            state.undo();
        } else if state.feasible() {
            let objective = state.objective();
            if best.as_ref().is_none_or(|(least, _)| objective < *least - 1e-12) {
                best = Some((objective, state.tree.clone()));
            }
        }
    }
    // Sums of many changes carry round-off: the rules are checked from scratch.
    best.map(|(_, tree)| tree).filter(|tree| tree.breaches(&limits.rules).is_empty())
}

#[derive(Clone, Copy, Debug)]
enum Action {
    Turn(f64),
    TurnAlone(f64),
    Reflect,
    Bend(f64),
}

struct State {
    tree: Tree,
    limits: Limits,
    /// Weights of a breach, and of what lies beyond the board.
    weights: [f64; 2],
    /// Sum of all breaches, and the number of pairs that have one.
    breaches: f64,
    broken: usize,
    /// Sum of the squares of deviations.
    deviations: f64,
    /// Area of the start, m².
    area: f64,
    saved: Saved,
}

/// What was there before the last move.
#[derive(Default)]
struct Saved {
    /// The first limb that it changed.
    first: usize,
    limbs: Vec<Limb>,
    breaches: f64,
    broken: usize,
    deviations: f64,
}

impl State {
    fn new(tree: Tree, limits: Limits) -> Self {
        let [low, high] = tree.extent();
        let size = high - low;
        let area = size.max().powi(2);
        let mut state = Self {
            tree,
            limits,
            weights: [1.0; 2],
            breaches: 0.0,
            broken: 0,
            deviations: 0.0,
            area,
            saved: Saved::default(),
        };
        state.renew();
        state
    }

    /// Computes the sums anew: changes leave round-off in them.
    fn renew(&mut self) {
        let found = self.tree.breaches(&self.limits.rules);
        (self.breaches, self.broken) = (found.iter().map(|(_, breach)| breach).sum(), found.len());
        self.deviations = (0..self.tree.limbs.len()).map(|k| self.tree.deviation(k)).sum();
    }

    fn size(&self) -> Point {
        let [low, high] = self.tree.extent();
        high - low
    }

    /// Part of the size that lies beyond the board.
    fn beyond(&self) -> f64 {
        let size = self.size();
        self.limits
            .board
            .map_or(0.0, |[width, height]| (size.x / width - 1.0).max(0.0) + (size.y / height - 1.0).max(0.0))
    }

    fn feasible(&self) -> bool {
        self.broken == 0 && self.beyond() == 0.0
    }

    /// Whether branches may bend, and the trunk turn: where a straight trunk is longer than the board.
    fn may_bend(&self) -> bool {
        self.limits.board.is_some()
    }

    fn may_move(&self, limb: usize) -> bool {
        !self.tree.limbs[limb].trunk || self.may_bend()
    }

    fn objective(&self) -> f64 {
        let size = self.size();
        let mut value = size.x * size.y / self.area
            + DEVIATION[usize::from(self.may_bend())] * self.deviations / self.tree.limbs.len() as f64;
        if self.may_bend() {
            for limb in &self.tree.limbs {
                let bends = limb.line.curvature != 0.0;
                value += f64::from(u8::from(bends)) * BEND;
                if limb.trunk {
                    let before = limb.parent.map_or(limb.line.direction, |p| {
                        let parent = &self.tree.limbs[p].line;
                        parent.direction_at(parent.length)
                    });
                    let turns = wrapped(limb.line.direction - before).abs() > 1e-9;
                    value += f64::from(u8::from(turns || bends)) * TRUNK;
                }
            }
        }
        value
    }

    fn total(&self) -> f64 {
        self.objective() + self.weights[0] * self.breaches + self.weights[1] * self.beyond()
    }

    fn propose(&self, limb: usize, random: &mut fastrand::Rng) -> Action {
        const TURNS: [f64; 6] = [1.0, 2.0, 3.0, 6.0, 9.0, 18.0];
        let own = &self.tree.limbs[limb];
        let turn = |random: &mut fastrand::Rng| {
            if random.u8(..4) == 0 {
                let aim = f64::from(random.u8(..72)) * STEP;
                return wrapped(aim - own.line.direction);
            }
            let sign = if random.bool() { STEP } else { -STEP };
            sign * TURNS[random.usize(..TURNS.len())]
        };
        let carries = own.last > limb + 1;
        match random.u8(..8) {
            0 if self.may_bend() => {
                let most = (own.line.length / own.bend).min(MOST_BEND);
                let steps = (most / BEND_STEP).floor() as i32;
                Action::Bend(f64::from(random.i32(-steps..=steps)) * BEND_STEP)
            }
            1 | 2 if carries => Action::TurnAlone(turn(random)),
            3 if carries => Action::Reflect,
            _ => Action::Turn(turn(random)),
        }
    }

    /// Breaches of the pairs that a change of a limb and what it carries may change: sum and number. `within`: also
    /// those of the limb with what it carries.
    fn breaches_of(&self, limb: usize, within: bool) -> (f64, usize) {
        let last = self.tree.limbs[limb].last;
        let (mut sum, mut count) = (0.0, 0);
        let mut add = |a: usize, b: usize| {
            let breach = self.tree.breach(a, b, &self.limits.rules);
            sum += breach;
            count += usize::from(breach > 0.0);
        };
        for k in limb..last {
            (0..limb).chain(last..self.tree.limbs.len()).for_each(|other| add(k, other));
        }
        if within {
            (limb + 1..last).for_each(|other| add(limb, other));
        }
        (sum, count)
    }

    /// Deviations that a change of a limb may change: its own, and those of the limbs that leave its outer vertex.
    fn deviations_of(&self, limb: usize) -> f64 {
        let mut sum = self.tree.deviation(limb);
        let mut next = limb + 1;
        while next < self.tree.limbs[limb].last {
            sum += self.tree.deviation(next);
            next = self.tree.limbs[next].last;
        }
        sum
    }

    fn apply(&mut self, limb: usize, action: Action) {
        let within = matches!(action, Action::TurnAlone(_) | Action::Bend(_));
        let last = self.tree.limbs[limb].last;
        self.saved.first = limb;
        self.saved.limbs.clear();
        self.saved.limbs.extend_from_slice(&self.tree.limbs[limb..last]);
        (self.saved.breaches, self.saved.broken, self.saved.deviations) = (self.breaches, self.broken, self.deviations);
        let (sum, count) = self.breaches_of(limb, within);
        // A reflection changes the deviation of everything that is reflected.
        let deviations = |state: &Self| match action {
            Action::Reflect => (limb..last).map(|k| state.tree.deviation(k)).sum(),
            _ => state.deviations_of(limb),
        };
        let before = deviations(self);
        match action {
            Action::Turn(angle) => self.tree.turn(limb, angle, false),
            Action::TurnAlone(angle) => self.tree.turn(limb, angle, true),
            Action::Reflect => self.tree.reflect(limb),
            Action::Bend(angle) => self.tree.bend(limb, angle),
        }
        let (new_sum, new_count) = self.breaches_of(limb, within);
        self.breaches += new_sum - sum;
        self.broken = (self.broken + new_count).saturating_sub(count);
        if self.broken == 0 {
            self.breaches = 0.0;
        }
        self.deviations += deviations(self) - before;
    }

    /// Takes the last move back.
    fn undo(&mut self) {
        let Saved { first, limbs, breaches, broken, deviations } = &self.saved;
        self.tree.limbs[*first..first + limbs.len()].copy_from_slice(limbs);
        (self.breaches, self.broken, self.deviations) = (*breaches, *broken, *deviations);
    }
}
