//! Static condensation of the points: their equilibrium at given frames.
//!
//! A step moves points along straight lines and turns frames. A turn θ so lengthens segments by the fraction
//! `½ θ²`, which in a nearly inextensible cable causes a force far above all others: the line search would stop
//! early and the next Hessian would be indefinite. At fixed frames the energy is a convex quadratic function of the
//! points (nearly, with constraints; contact enters by its model), so one linear solve finds their equilibrium. It is
//! undone if it does not lower the energy. Newton's method then acts on the frames only, and the points follow
//! (variable projection, Golub and Pereyra 1973).
//!
//! Between two points that joints or constraints act on (anchors) the segments are a chain of springs, and its forces
//! follow from statics: with the edges' stiffnesses K_j, compliances `F_j = K_j⁻¹` and the forces r_i on the
//! points between them, segment j changes its force by `t_j = t₀ − s_j`, `s_j = r_1 + … + r_j`, and its edge by
//! `F_j t_j`. The sum of the edges, `δx_b − δx_a = F t₀ − p` with `F = Σ F_j` and `p = Σ F_j s_j`, gives t₀. To its
//! anchors the chain is one spring of stiffness `F⁻¹`, and only the anchors are unknowns of a matrix.

use super::step_control::ACTIVE_SET_UPDATES;
use crate::contact::active_set::ActiveSet;
use crate::linear::factor::invert;
use crate::linear::matrix::BlockMatrix;
use crate::linear::symbolic::Structure;
use std::ops::Range;
use wireloom_core::problem::Problem;
use wireloom_core::variable::{Block, Variable};
use wireloom_core::{Matrix, Network, State, Tangent, Vector};

/// Segments between two anchors.
struct Chain {
    /// Its points, from anchor to anchor, at the ends of joined branches the tied ones.
    points: Range<usize>,
    /// Positions of its anchors in the matrix.
    ends: [u32; 2],
    /// Index of the block between them; `None` if both are the same joint.
    slot: Option<usize>,
    /// `F⁻¹`, N/m.
    stiffness: Matrix,
}

/// Linear solve for all points, with its workspace.
pub struct Condensation {
    /// What [`anchors`] depend on: the version of the contact pattern (see [`Problem::contact_pattern`]), and whether
    /// all points are anchors.
    version: (u64, bool),
    /// Matrix of the anchors.
    matrix: BlockMatrix,
    /// Chains of each branch.
    chains: Vec<Vec<Chain>>,
    /// Compliance of every segment, at the index of its first point, m/N.
    compliances: Vec<Matrix>,
    /// Gradient in the anchors, chains included.
    anchored: Tangent,
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

/// Whether something besides its two segments and dead forces acts on each point: constraints, and joints at the ends
/// of branches; on `all` points contact may act, or the pull of rotating axes.
fn anchors(network: &Network, all: bool) -> Vec<bool> {
    let mut anchors = vec![all; network.points];
    for branch in &network.branches {
        anchors[branch.points.start] = true;
        anchors[branch.points.end - 1] = true;
    }
    for joint in &network.joints {
        anchors[joint.point] = true;
    }
    for constraint in &network.constraints {
        for site in constraint.stations.iter().chain([&constraint.site]) {
            anchors[site.point] = true;
        }
        for point in constraint.span.iter().flat_map(|span| span.points.clone()) {
            anchors[point] = true;
        }
    }
    anchors
}

fn version(problem: &Problem<'_>) -> (u64, bool) {
    (problem.contact_pattern().0, !problem.contact().is_idle() || problem.conditions().rotation.is_moving())
}

impl Condensation {
    /// Condensation for the states of a problem's network.
    pub fn new(problem: &Problem<'_>) -> Self {
        let network = problem.network;
        let version = version(problem);
        let (_, touching) = problem.contact_pattern();
        let anchors = anchors(network, version.1);
        let matrix = BlockMatrix::new(Structure::of_points(network, touching, &anchors), network);
        let Structure { of_point, pattern, .. } = &matrix.structure;
        let chain = |[a, b]: [usize; 2]| {
            let ends = [of_point[a], of_point[b]];
            let slot = (ends[0] != ends[1]).then(|| pattern.slot(ends[0].max(ends[1]), ends[0].min(ends[1])));
            Chain { points: a..b + 1, ends, slot, stiffness: Matrix::zeros() }
        };
        let chains = network.branches.iter().map(|branch| {
            let anchors: Vec<usize> = branch.points.clone().filter(|&i| anchors[i]).collect();
            anchors.array_windows().map(|ends| chain(*ends)).collect()
        });
        Self {
            version,
            chains: chains.collect(),
            compliances: vec![Matrix::zeros(); network.points],
            anchored: Tangent::zeros(network),
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
        if version(problem) != self.version {
            *self = Self::new(problem);
        }
        self.matrix.right_hand_side(problem, gradient, None, &mut self.rhs);
        let within = self.chains.iter().flatten().flat_map(|chain| &gradient.points[chain.between()]);
        if self.rhs.iter().chain(within).all(|force| force.norm_squared() <= least * least) {
            return false;
        }
        let definite =
            self.factorise(problem, state, false) || !self.blocks.is_empty() && self.factorise(problem, state, true);
        if !definite {
            return false;
        }
        self.solve(problem, state, Some(gradient));
        self.active_set.begin(problem);
        if !self.active_set.is_idle() {
            self.model.copy_from(gradient);
            for left in (0..ACTIVE_SET_UPDATES).rev() {
                let Self { active_set, step, model, blocks, .. } = self;
                let changed = active_set.update(problem, state, Some(gradient), step, model, blocks);
                if !changed || left == 0 || !self.refactorise(problem) {
                    break;
                }
                self.solve(problem, state, None);
            }
        }
        self.points.copy_from_slice(&state.points);
        self.compensation.copy_from_slice(&state.compensation);
        network.shift_points(state, &self.step);
        problem.place_held(state);
        true
    }

    /// Assembles and factorises the second derivatives with respect to the points; with `convex`, those of
    /// [`Problem::make_convex`]. Returns whether they are positive definite.
    fn factorise(&mut self, problem: &mut Problem<'_>, state: &State, convex: bool) -> bool {
        problem.hessian_blocks(state, convex, &mut self.blocks);
        for (b, chains) in self.chains.iter_mut().enumerate() {
            let points = problem.network.branches[b].points.clone();
            problem.edge_stiffness(state, b, &mut self.compliances[points.start..points.end - 1]);
            for chain in chains {
                let own = &mut self.compliances[chain.segments()];
                if let [stiffness] = own {
                    chain.stiffness = *stiffness;
                    continue;
                }
                let mut sum = Matrix::zeros();
                for compliance in own {
                    let (inverse, signs) = invert(compliance);
                    if signs.negative + signs.zero > 0 {
                        return false;
                    }
                    *compliance = inverse;
                    sum += inverse;
                }
                chain.stiffness = invert(&sum).0;
            }
        }
        self.refactorise(problem)
    }

    /// Assembles and factorises the matrix of the anchors with the present chains and blocks. Returns whether it is
    /// positive definite.
    fn refactorise(&mut self, problem: &Problem<'_>) -> bool {
        self.matrix.clear();
        for Chain { ends: [a, b], slot, stiffness, .. } in self.chains.iter().flatten() {
            if let Some(slot) = slot {
                self.matrix.diagonal[*a as usize] += stiffness;
                self.matrix.diagonal[*b as usize] += stiffness;
                self.matrix.below[*slot] -= stiffness;
            }
        }
        for block in &self.blocks {
            self.matrix.add_block(block);
        }
        self.matrix.eliminate_prescribed(problem);
        self.matrix.factorise_if_positive()
    }

    /// Solves for the step under a gradient, `None` for that of the model, with the present compliances and factor.
    fn solve(&mut self, problem: &Problem<'_>, state: &State, gradient: Option<&Tangent>) {
        let Self { matrix, chains, compliances, anchored, rhs, step, model, .. } = self;
        let gradient = gradient.unwrap_or(model);
        let point = |position: u32| match matrix.structure.variables[position as usize] {
            Variable::Point(i) => i,
            Variable::Frame(_) => unreachable!("only points are unknowns"),
        };
        anchored.points.copy_from_slice(&gradient.points);
        for chain in chains.iter().flatten() {
            let (from_edges, sum) = chain.forces_within(gradient, compliances);
            let at_start = chain.stiffness * from_edges;
            anchored.points[point(chain.ends[0])] -= at_start;
            anchored.points[point(chain.ends[1])] += at_start - sum;
        }
        matrix.right_hand_side(problem, anchored, None, rhs);
        matrix.solve(rhs);
        matrix.step(problem, state, rhs, None, step);
        for chain in chains.iter().flatten() {
            let [first, last] = [chain.points.start, chain.points.end - 1];
            let (from_edges, _) = chain.forces_within(gradient, compliances);
            let mut force = chain.stiffness * (step.points[last] - step.points[first] + from_edges);
            let mut moved = step.points[first];
            for i in chain.between() {
                moved += compliances[i - 1] * force;
                step.points[i] = moved;
                force += gradient.points[i];
            }
        }
    }

    /// Undoes the last [`Self::condense`].
    pub fn undo(&mut self, state: &mut State) {
        std::mem::swap(&mut state.points, &mut self.points);
        std::mem::swap(&mut state.compensation, &mut self.compensation);
    }
}

impl Chain {
    /// Its points without the anchors.
    fn between(&self) -> Range<usize> {
        self.points.start + 1..self.points.end - 1
    }

    /// Its segments, by their first points.
    fn segments(&self) -> Range<usize> {
        self.points.start..self.points.end - 1
    }

    /// p (m) and the last s (N) of the forces on the points between the anchors, which are `−gradient`.
    fn forces_within(&self, gradient: &Tangent, compliances: &[Matrix]) -> (Vector, Vector) {
        let (mut p, mut s) = (Vector::zeros(), Vector::zeros());
        for i in self.between() {
            s -= gradient.points[i];
            p += compliances[i] * s;
        }
        (p, s)
    }
}
