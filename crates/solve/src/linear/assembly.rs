//! Assembly of the Hessian: positions in the matrix of the second derivatives of all parts.

use crate::linear::matrix::BlockMatrix;
use crate::linear::symbolic::{Pattern, Structure, TIED};
use std::ops::Range;
use wireloom_core::problem::{Hessian, Problem};
use wireloom_core::rotation::skew;
use wireloom_core::{Matrix, Network, State, Tangent, Vector};

/// Index of an off-diagonal block, and whether it is stored transposed.
#[derive(Clone, Copy)]
struct Slot {
    index: u32,
    transposed: bool,
}

impl Slot {
    /// For the transposed block.
    fn turned(self) -> Self {
        Self { transposed: !self.transposed, ..self }
    }
}

/// Positions of the six blocks of a segment between two points that are not tied.
struct SegmentPlan {
    a: u32,
    b: u32,
    f: u32,
    ba: Slot,
    fa: Slot,
    fb: Slot,
}

/// Positions of the three blocks of a coupling between two frames that are not tied.
struct CouplingPlan {
    a: u32,
    b: u32,
    ba: Slot,
}

/// Plans of consecutive segments, couplings or pairs of couplings of a branch.
struct Run<P> {
    branch: usize,
    first: usize,
    plans: Vec<P>,
}

/// Segments, couplings and pairs of couplings whose blocks lie in a range of columns; positions are relative to the
/// first of them.
struct Group {
    columns: Range<usize>,
    blocks: Range<usize>,
    segments: Vec<Run<SegmentPlan>>,
    couplings: Vec<Run<CouplingPlan>>,
    /// The one block of each pair: row the frame after it, column the frame before it.
    pairs: Vec<Run<Slot>>,
}

impl Group {
    fn new(columns: Range<usize>, pattern: &Pattern) -> Self {
        let blocks = pattern.starts[columns.start] as usize..pattern.starts[columns.end] as usize;
        Self { columns, blocks, segments: vec![], couplings: vec![], pairs: vec![] }
    }

    /// Index of the block at two positions.
    fn slot(&self, pattern: &Pattern, row: u32, column: u32) -> Slot {
        let index = pattern.slot(row.max(column), row.min(column)) - self.blocks.start;
        Slot { index: index as u32, transposed: row < column }
    }

    fn place(&self, position: u32) -> u32 {
        position - self.columns.start as u32
    }

    fn add_segment(&mut self, pattern: &Pattern, branch: usize, j: usize, [a, b, f]: [u32; 3]) {
        let plan = SegmentPlan {
            a: self.place(a),
            b: self.place(b),
            f: self.place(f),
            ba: self.slot(pattern, b, a),
            fa: self.slot(pattern, f, a),
            fb: self.slot(pattern, f, b),
        };
        push(&mut self.segments, branch, j, plan);
    }

    fn add_coupling(&mut self, pattern: &Pattern, branch: usize, c: usize, [a, b]: [u32; 2]) {
        let plan = CouplingPlan { a: self.place(a), b: self.place(b), ba: self.slot(pattern, b, a) };
        push(&mut self.couplings, branch, c, plan);
    }

    /// Adds the second derivatives to the blocks of the group.
    fn fill(&self, hessian: &Hessian, diagonal: &mut [Matrix], below: &mut [Matrix]) {
        for run in &self.segments {
            for (plan, h) in run.plans.iter().zip(&hessian.branches[run.branch].segments[run.first..]) {
                diagonal[plan.a as usize] += h.ee;
                diagonal[plan.b as usize] += h.ee;
                diagonal[plan.f as usize] += h.tt;
                // e = x_b − x_a
                below[plan.ba.index as usize] -= h.ee;
                if plan.fa.transposed {
                    below[plan.fa.index as usize] -= h.te.transpose();
                } else {
                    below[plan.fa.index as usize] -= h.te;
                }
                add_below(below, plan.fb, &h.te);
            }
        }
        for run in &self.couplings {
            for (plan, h) in run.plans.iter().zip(&hessian.branches[run.branch].couplings[run.first..]) {
                diagonal[plan.a as usize] += h.aa;
                diagonal[plan.b as usize] += h.bb;
                add_below(below, plan.ba.turned(), &h.ab);
            }
        }
        for run in &self.pairs {
            for (slot, block) in run.plans.iter().zip(&hessian.branches[run.branch].pairs[run.first..]) {
                add_below(below, slot.turned(), block);
            }
        }
    }
}

/// Appends a plan to the last run, or begins a new run if it does not follow.
fn push<P>(runs: &mut Vec<Run<P>>, branch: usize, index: usize, plan: P) {
    match runs.last_mut() {
        Some(run) if run.branch == branch && run.first + run.plans.len() == index => run.plans.push(plan),
        _ => runs.push(Run { branch, first: index, plans: vec![plan] }),
    }
}

#[inline(always)]
fn add_below(below: &mut [Matrix], slot: Slot, block: &Matrix) {
    if slot.transposed {
        below[slot.index as usize] += block.transpose();
    } else {
        below[slot.index as usize] += block;
    }
}

/// Clears and fills the blocks of consecutive groups in parallel.
fn fill_all(groups: &[Group], hessian: &Hessian, diagonal: &mut [Matrix], below: &mut [Matrix]) {
    match groups {
        [] => return,
        [group] => {
            diagonal.fill(Matrix::zeros());
            below.fill(Matrix::zeros());
            return group.fill(hessian, diagonal, below);
        }
        _ => {}
    }
    let (groups, others) = groups.split_at(groups.len() / 2);
    let (diagonal, other_diagonal) = diagonal.split_at_mut(others[0].columns.start - groups[0].columns.start);
    let (below, other_below) = below.split_at_mut(others[0].blocks.start - groups[0].blocks.start);
    rayon::join(
        || fill_all(groups, hessian, diagonal, below),
        || fill_all(others, hessian, other_diagonal, other_below),
    );
}

/// Segment at a joint: its edge is a linear function of other variables than its end points.
struct TiedSegment {
    branch: usize,
    segment: usize,
    frame: u32,
}

/// One column of `e = Σ J_i u_i`.
type Lever = (u32, Matrix);

/// Matrix of the Hessian with its assembly, weights and right-hand side.
pub struct System {
    /// Version of the contact pattern it was made for; see [`Problem::contact_pattern`].
    version: u64,
    /// Assembly into the matrix.
    pub assembly: Assembly,
    /// The matrix.
    pub matrix: BlockMatrix,
    /// Weight of a shift of each variable, in elimination order, N m: the rest length around a frame times the force
    /// scale of its branch; 0 for points. See [`Self::update_weights`].
    pub weights: Vec<f64>,
    /// Scratch for a right-hand side.
    pub rhs: Vec<Vector>,
}

impl System {
    /// System for the present contact pattern of a problem.
    pub fn new(problem: &Problem<'_>) -> Self {
        let (version, touching) = problem.contact_pattern();
        let matrix = BlockMatrix::new(Structure::new(problem.network, touching), problem.network);
        Self {
            version,
            assembly: Assembly::new(problem.network, &matrix.structure),
            weights: vec![0.0; matrix.structure.len()],
            rhs: vec![Vector::zeros(); matrix.structure.len()],
            matrix,
        }
    }

    /// Recomputes the weights of shifts from the present scales ([`Problem::local_scales`]).
    pub fn update_weights(&mut self, problem: &Problem<'_>) {
        let scales = problem.local_scales();
        self.matrix.frame_weights(problem.network, |branch| scales[branch].force, &mut self.weights);
    }

    /// sᵀWs of a step s, N m, with the weights W of shifts.
    pub fn weighted_square(&self, step: &Tangent) -> f64 {
        let places = self.matrix.structure.of_frame.iter().zip(&step.frames).filter(|(place, _)| **place < TIED);
        places.map(|(&place, turn)| self.weights[place as usize] * turn.norm_squared()).sum()
    }

    /// Assembles the second derivatives of `problem` at `state`; makes itself anew if the contact pattern has changed.
    pub fn fill(&mut self, problem: &Problem<'_>, state: &State, hessian: &Hessian) {
        if problem.contact_pattern().0 != self.version {
            *self = Self::new(problem);
            self.update_weights(problem);
        }
        self.assembly.run(&mut self.matrix, problem.network, state, hessian);
    }

    /// Newton step `−A⁻¹ g` of points and frames from `state` with the factorised matrix A; `gradient` is g, and
    /// `motion` that of the prescribed directions, which becomes part of the step.
    pub fn step(
        &mut self,
        problem: &Problem<'_>,
        state: &State,
        gradient: &Tangent,
        motion: Option<&Tangent>,
        step: &mut Tangent,
    ) {
        let Self { matrix, rhs, .. } = self;
        matrix.right_hand_side(problem, gradient, motion, rhs);
        matrix.solve(rhs);
        matrix.step(problem, state, rhs, motion, step);
    }
}

/// Positions of a network's second derivatives in a matrix with [`Structure::new`].
pub struct Assembly {
    /// One group for each of [`crate::linear::elimination_tree::Part::ranges`].
    groups: Vec<Group>,
    /// Segments, couplings and pairs with variables in several groups.
    across: Group,
    tied_segments: Vec<TiedSegment>,
    tied_couplings: Vec<(usize, usize)>,
    tied_pairs: Vec<(usize, usize)>,
}

impl Assembly {
    /// Assembly for a network, whose [`Structure::new`] is `s`.
    pub fn new(network: &Network, s: &Structure) -> Self {
        let pattern = &s.pattern;
        let mut groups: Vec<Group> = s.parts.ranges().into_iter().map(|range| Group::new(range, pattern)).collect();
        let mut across = Group::new(0..s.len(), pattern);
        let (mut tied_segments, mut tied_couplings, mut tied_pairs) = (vec![], vec![], vec![]);
        for (branch_index, branch) in network.branches.iter().enumerate() {
            let mesh = branch.rod.mesh();
            for (j, frame) in mesh.segment_frames.iter().enumerate() {
                let (a, b) = (s.of_point[branch.points.start + j], s.of_point[branch.points.start + j + 1]);
                let f = s.of_frame[branch.frames.start + frame];
                if a.max(b) >= TIED {
                    tied_segments.push(TiedSegment { branch: branch_index, segment: j, frame: f });
                } else {
                    group_of(&mut groups, &mut across, &[a, b, f]).add_segment(pattern, branch_index, j, [a, b, f]);
                }
            }
            for c in 0..mesh.coupling_lengths.len() {
                let (a, b) = (s.of_frame[branch.frames.start + c], s.of_frame[branch.frames.start + c + 1]);
                if a.max(b) >= TIED {
                    tied_couplings.push((branch_index, c));
                } else {
                    group_of(&mut groups, &mut across, &[a, b]).add_coupling(pattern, branch_index, c, [a, b]);
                }
            }
            for (k, pair) in mesh.pairs.iter().enumerate().filter(|_| branch.rod.couples_pairs()) {
                let [a, b] = [pair.frame - 1, pair.frame + 1].map(|c| s.of_frame[branch.frames.start + c]);
                if a.max(b) >= TIED {
                    tied_pairs.push((branch_index, k));
                } else {
                    let group = group_of(&mut groups, &mut across, &[a, b]);
                    let slot = group.slot(pattern, b, a);
                    push(&mut group.pairs, branch_index, k, slot);
                }
            }
        }
        Self { groups, across, tied_segments, tied_couplings, tied_pairs }
    }

    /// Edge from `point` to the next one as a linear function of independent variables: ends that are tied to a joint
    /// move with its point and, by the lever of their offset, with its frame.
    fn levers(structure: &Structure, network: &Network, state: &State, point: usize) -> [Option<Lever>; 4] {
        let mut levers = [None; 4];
        for (end, sign) in [(0, -1.0), (1, 1.0)] {
            let own = structure.of_point[point + end];
            if own < TIED {
                levers[2 * end] = Some((own, Matrix::identity() * sign));
                continue;
            }
            let tie = &network.ties[(own - TIED) as usize];
            levers[2 * end] = Some((structure.of_point[tie.hub_point], Matrix::identity() * sign));
            if let Some(hub) = tie.hub_frame {
                let r = state.frames[hub].to_rotation_matrix();
                levers[2 * end + 1] = Some((structure.of_frame[hub], r.matrix() * skew(&tie.offset) * -sign));
            }
        }
        levers
    }

    /// Position of the independent frame that `frame` follows, and the rotation A of a tied frame in it:
    /// `θ = Aᵀ θ_hub`.
    fn independent_frame(structure: &Structure, network: &Network, frame: usize) -> (u32, Matrix) {
        let own = structure.of_frame[frame];
        if own < TIED {
            return (own, Matrix::identity());
        }
        let tie = &network.ties[(own - TIED) as usize];
        let hub = tie.hub_frame.expect("a tied frame has a hub");
        (structure.of_frame[hub], *tie.rest.to_rotation_matrix().matrix())
    }

    /// Assembles the second derivatives at `state`.
    pub fn run(&self, matrix: &mut BlockMatrix, network: &Network, state: &State, hessian: &Hessian) {
        fill_all(&self.groups, hessian, &mut matrix.diagonal, &mut matrix.below);
        self.across.fill(hessian, &mut matrix.diagonal, &mut matrix.below);
        self.add_tied(matrix, network, state, hessian);
        for (joint, table) in network.joints.iter().zip(&hessian.joints) {
            let k = joint.coupled_frames.len();
            for b in 0..k {
                for a in 0..=b {
                    let (row, column) = (
                        matrix.structure.of_frame[joint.coupled_frames[b]],
                        matrix.structure.of_frame[joint.coupled_frames[a]],
                    );
                    let block = table[b * k + a];
                    if row == column {
                        matrix.add(row, row, &block);
                    } else {
                        matrix.add_both(row, column, &block);
                    }
                }
            }
        }
        for block in &hessian.blocks {
            matrix.add_block(block);
        }
    }

    /// Adds the segments and couplings at joints: their end points and end stations are functions of the joint's
    /// variables.
    fn add_tied(&self, matrix: &mut BlockMatrix, network: &Network, state: &State, hessian: &Hessian) {
        for index in 0..self.tied_segments.len() {
            let TiedSegment { branch, segment, frame } = self.tied_segments[index];
            let h = hessian.branches[branch].segments[segment];
            let levers =
                Self::levers(&matrix.structure, network, state, network.branches[branch].points.start + segment);
            matrix.add(frame, frame, &h.tt);
            for (row, ji) in levers.iter().flatten() {
                let half = ji.transpose() * h.ee;
                for (column, jk) in levers.iter().flatten().filter(|(column, _)| column <= row) {
                    matrix.add(*row, *column, &(half * jk));
                }
                matrix.add_both(frame, *row, &(h.te * ji));
            }
        }
        for (b, branch) in network.branches.iter().enumerate() {
            let mesh = branch.rod.mesh();
            for (beside, h) in mesh.beside.iter().zip(&hessian.branches[b].beside) {
                let frame = matrix.structure.of_frame[branch.frames.start + mesh.segment_frames[beside.segment]];
                let levers = Self::levers(&matrix.structure, network, state, branch.points.start + beside.segment);
                let neighbours = beside
                    .neighbours()
                    .map(|c| c.map(|c| Self::independent_frame(&matrix.structure, network, branch.frames.start + c)));
                for (k, (own, r)) in
                    neighbours.iter().enumerate().filter_map(|(k, own)| own.as_ref().map(|own| (k, own)))
                {
                    matrix.add(*own, *own, &(r * h.ss[k] * r.transpose()));
                    matrix.add_both(*own, frame, &(r * h.st[k]));
                    for (row, j) in levers.iter().flatten() {
                        let block = r * h.se[k] * j;
                        if row == own {
                            // The station and the lever of its offset are the same hub.
                            matrix.add(*row, *row, &(block + block.transpose()));
                        } else {
                            matrix.add_both(*own, *row, &block);
                        }
                    }
                }
                if let [Some((s0, r0)), Some((s1, r1))] = &neighbours {
                    let block = r1 * h.s1s0 * r0.transpose();
                    if s0 == s1 {
                        matrix.add(*s0, *s0, &(block + block.transpose()));
                    } else {
                        matrix.add_both(*s1, *s0, &block);
                    }
                }
            }
        }
        for index in 0..self.tied_couplings.len() {
            let (branch, c) = self.tied_couplings[index];
            let h = hessian.branches[branch].couplings[c];
            let start = network.branches[branch].frames.start + c;
            let ((a, ra), (b, rb)) = (
                Self::independent_frame(&matrix.structure, network, start),
                Self::independent_frame(&matrix.structure, network, start + 1),
            );
            matrix.add(a, a, &(ra * h.aa * ra.transpose()));
            matrix.add(b, b, &(rb * h.bb * rb.transpose()));
            let ab = ra * h.ab * rb.transpose();
            if a == b {
                matrix.add(a, a, &(ab + ab.transpose()));
            } else {
                matrix.add_both(a, b, &ab);
            }
        }
        for &(branch, k) in &self.tied_pairs {
            let block = hessian.branches[branch].pairs[k];
            let mesh = network.branches[branch].rod.mesh();
            let frame = network.branches[branch].frames.start + mesh.pairs[k].frame;
            let [(a, ra), (b, rb)] =
                [frame - 1, frame + 1].map(|c| Self::independent_frame(&matrix.structure, network, c));
            let block = ra * block * rb.transpose();
            if a == b {
                matrix.add(a, a, &(block + block.transpose()));
            } else {
                matrix.add_both(a, b, &block);
            }
        }
        for (tie, h) in network.ties.iter().zip(&hessian.ties) {
            if let Some(hub) = tie.hub_frame {
                let position = matrix.structure.of_frame[hub];
                matrix.add(position, position, h);
            }
        }
    }
}

/// Group that contains all these positions; `across` if no single one does.
fn group_of<'g>(groups: &'g mut [Group], across: &'g mut Group, positions: &[u32]) -> &'g mut Group {
    let index = groups.partition_point(|group| group.columns.end <= positions[0] as usize);
    let group = &mut groups[index];
    if positions.iter().all(|&p| group.columns.contains(&(p as usize))) { group } else { across }
}
