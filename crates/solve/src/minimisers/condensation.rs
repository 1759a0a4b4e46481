//! Static condensation of the points: their equilibrium at given frames.
//!
//! A step moves points along straight lines and turns frames. A turn θ so lengthens segments by the fraction
//! `½ θ²`, which in a nearly inextensible cable causes a force far above all others: the line search would stop
//! early and the next Hessian would be indefinite. At fixed frames the energy is a convex quadratic function of the
//! points (nearly, with constraints; contact enters by its model), so one linear solve finds their equilibrium. It is
//! undone if it does not lower the energy. Newton's method then acts on the frames only, and the points follow
//! (variable projection, Golub and Pereyra 1973).

use super::step_control::ACTIVE_SET_UPDATES;
use crate::contact::active_set::ActiveSet;
use crate::linear::matrix::BlockMatrix;
use crate::linear::symbolic::Structure;
use wireloom_core::problem::Problem;
use wireloom_core::variable::Block;
use wireloom_core::{Matrix, State, Tangent, Vector};

/// Positions of a segment's ends in the matrix, and the index of the block between them; `None` if both ends are at one
/// joint.
struct SegmentPlan {
    a: u32,
    b: u32,
    slot: Option<u32>,
}

/// Linear solve for all points, with its workspace.
pub struct Condensation {
    /// Version of the contact pattern it was made for; see [`Problem::contact_pattern`].
    version: u64,
    matrix: BlockMatrix,
    segments: Vec<Vec<SegmentPlan>>,
    /// Scratch for one branch.
    stiffness: Vec<Matrix>,
    rhs: Vec<Vector>,
    step: Tangent,
    active_set: ActiveSet,
    /// Gradient of the model with the active set of contact ([`ActiveSet`]).
    model: Tangent,
    blocks: Vec<Block>,
    /// Points before the last [`Self::condense`].
    points: Vec<Vector>,
    compensation: Vec<Vector>,
}

impl Condensation {
    /// Condensation for the states of a problem's network.
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

    /// Moves the points of `state`, where `gradient` was evaluated, to their equilibrium at fixed frames. Does nothing
    /// if no free force is above `least` (N) or the energy is not convex in the points. Returns whether the points were
    /// moved.
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

    /// Solves for the step with the present matrix and right-hand side.
    fn solve(&mut self, problem: &Problem<'_>, state: &State) {
        self.matrix.solve(&mut self.rhs);
        self.matrix.step(problem, state, &mut self.rhs, None, &mut self.step);
    }

    /// Assembles and factorises the second derivatives with respect to the points; with `convex`, those of
    /// [`Problem::make_convex`]. Returns whether they are positive definite.
    fn factorise(&mut self, problem: &mut Problem<'_>, state: &State, convex: bool) -> bool {
        problem.hessian_blocks(state, convex, &mut self.blocks);
        self.refactorise(problem, state)
    }

    /// Assembles and factorises them with the present blocks.
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
        self.matrix.factorise_if_positive()
    }

    /// Undoes the last [`Self::condense`].
    pub fn undo(&mut self, state: &mut State) {
        std::mem::swap(&mut state.points, &mut self.points);
        std::mem::swap(&mut state.compensation, &mut self.compensation);
    }
}
