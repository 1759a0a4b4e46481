//! Points in balance for given frames.
//!
//! A step moves points straight and turns frames; for a turn θ the segments are then longer by the fraction `½ θ²`, which in a cable
//! that hardly stretches is a force far above all others: the line search would stop there and the next Hessian would be indefinite.
//! With the frames given the energy is a convex quadratic function of the points (but for what constraints add: nearly, and for contact, which is
//! model), so one linear solve brings them to where every point is in balance; where that does not lower the energy, it is taken back. Newton's method then works on the frames alone, the points always following
//! ("variable projection", Golub and Pereyra 1973).

use super::step_control::ACTIVE_SET_UPDATES;
use crate::contact::active_set::ActiveSet;
use crate::linear::matrix::BlockMatrix;
use crate::linear::symbolic::Structure;
use wireloom_core::problem::Problem;
use wireloom_core::variable::Block;
use wireloom_core::{Matrix, State, Tangent, Vector};

/// Positions of a segment's ends in the matrix, and where the block between them is; both ends at one joint: none.
struct SegmentPlan {
    a: u32,
    b: u32,
    slot: Option<u32>,
}

/// The linear solve for all points; keeps its workspace.
pub struct Condensation {
    /// Which pattern of contact it is for; see [`Problem::contact_pattern`].
    version: u64,
    matrix: BlockMatrix,
    segments: Vec<Vec<SegmentPlan>>,
    /// Scratch, for one branch.
    stiffness: Vec<Matrix>,
    rhs: Vec<Vector>,
    step: Tangent,
    active_set: ActiveSet,
    /// Forces of the model in which what will touch does ([`ActiveSet`]).
    model: Tangent,
    blocks: Vec<Block>,
    /// The points before.
    points: Vec<Vector>,
    compensation: Vec<Vector>,
}

impl Condensation {
    /// For the states of a problem's network.
    pub fn new(problem: &Problem<'_>) -> Self {
        let network = problem.network;
        let (version, touching) = problem.contact_pattern();
        let matrix = BlockMatrix::new(Structure::of_points(network, touching), network);
        let of_point = &matrix.structure.of_point;
        let plan = |ends: &[u32]| {
            let (a, b) = (ends[0], ends[1]);
            let slot = (a != b).then(|| matrix.structure.pattern.slot(a.max(b), a.min(b)) as u32);
            SegmentPlan { a, b, slot }
        };
        let segments = network.branches.iter().map(|b| of_point[b.points.clone()].windows(2).map(plan).collect());
        let longest = network.branches.iter().map(|b| b.rod.mesh().segments()).max().unwrap_or(0);
        Self {
            version,
            segments: segments.collect(),
            stiffness: vec![Matrix::zeros(); longest],
            rhs: vec![Vector::zeros(); matrix.structure.len()],
            step: Tangent::zeros(network),
            active_set: ActiveSet::new(network),
            model: Tangent::zeros(network),
            blocks: Vec::new(),
            points: vec![Vector::zeros(); network.points],
            compensation: vec![Vector::zeros(); network.points],
            matrix,
        }
    }

    /// Moves the points of `state`, where `gradient` was evaluated, into balance, the frames being as they are, unless no free force
    /// is above `least` (N). Returns whether it did; not where the energy is not convex in the points.
    pub fn condense(&mut self, problem: &mut Problem<'_>, state: &mut State, gradient: &Tangent, least: f64) -> bool {
        let network = problem.network;
        if problem.contact_pattern().0 != self.version {
            *self = Self::new(problem);
        }
        self.matrix.right_hand_side(problem, gradient, None, &mut self.rhs);
        if self.rhs.iter().all(|force| force.norm_squared() <= least * least) {
            return false;
        }
        let definite =
            self.factorise(problem, state, false) || !self.blocks.is_empty() && self.factorise(problem, state, true);
        if !definite {
            return false;
        }
        self.solve(problem, state);
        self.active_set.begin(problem);
        if !self.active_set.is_idle() {
            self.model.copy_from(gradient);
            for left in (0..ACTIVE_SET_UPDATES).rev() {
                let Self { active_set, step, model, blocks, .. } = self;
                let changed = active_set.update(problem, state, Some(gradient), step, model, blocks);
                if !changed || left == 0 || !self.refactorise(problem, state) {
                    break;
                }
                self.matrix.right_hand_side(problem, &self.model, None, &mut self.rhs);
                self.solve(problem, state);
            }
        }
        self.points.copy_from_slice(&state.points);
        self.compensation.copy_from_slice(&state.compensation);
        network.shift_points(state, &self.step);
        problem.place_held(state);
        true
    }

    /// Solves for the step with the matrix and the right-hand side at hand.
    fn solve(&mut self, problem: &Problem<'_>, state: &State) {
        self.matrix.solve(&mut self.rhs);
        self.matrix.step(problem, state, &mut self.rhs, None, &mut self.step);
    }

    /// Gathers and factorises the second derivatives in the points, with `convex` those of [`Problem::make_convex`]. Returns whether they
    /// are positive definite.
    fn factorise(&mut self, problem: &mut Problem<'_>, state: &State, convex: bool) -> bool {
        problem.hessian_blocks(state, convex, &mut self.blocks);
        self.refactorise(problem, state)
    }

    /// Gathers and factorises them with other blocks.
    fn refactorise(&mut self, problem: &mut Problem<'_>, state: &State) -> bool {
        self.matrix.clear();
        for (b, plans) in self.segments.iter().enumerate() {
            let stiffness = &mut self.stiffness[..plans.len()];
            problem.edge_stiffness(state, b, stiffness);
            for (plan, k) in plans.iter().zip(stiffness) {
                if let Some(slot) = plan.slot {
                    self.matrix.diagonal[plan.a as usize] += *k;
                    self.matrix.diagonal[plan.b as usize] += *k;
                    self.matrix.below[slot as usize] -= *k;
                }
            }
        }
        for block in &self.blocks {
            self.matrix.add_block(block);
        }
        self.matrix.eliminate_prescribed(problem);
        self.matrix.factorise() == 0
    }

    /// Takes the last [`Self::settle`] back.
    pub fn undo(&mut self, state: &mut State) {
        std::mem::swap(&mut state.points, &mut self.points);
        std::mem::swap(&mut state.compensation, &mut self.compensation);
    }
}
