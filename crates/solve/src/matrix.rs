//! The Hessian as a sparse block matrix: gathering, and taking out what is held.

use crate::structure::{Structure, TIED};
use wireloom_core::problem::{Hessian, Problem, Variable};
use wireloom_core::rotation::skew;
use wireloom_core::{Matrix, Network, State, Tangent, Vector};

/// Place of an off-diagonal block; `turned` where it is stored transposed.
#[derive(Clone, Copy)]
struct Slot {
    index: u32,
    turned: bool,
}

/// Places of the six blocks of a segment between two points that are not tied.
struct SegmentPlan {
    a: u32,
    b: u32,
    f: u32,
    ba: Slot,
    fa: Slot,
    fb: Slot,
}

/// Places of the three blocks of a coupling between two frames that are not tied.
struct CouplingPlan {
    a: u32,
    b: u32,
    ba: Slot,
}

/// A segment at a joint: its edge is a linear function of other variables than its own end points.
struct TiedSegment {
    branch: usize,
    segment: usize,
    frame: u32,
}

/// One column of `e = Σ J_i u_i`.
type Lever = (u32, Matrix);

/// Blocks of the matrix and, after factorisation, of its factor.
pub struct BlockMatrix {
    /// Pattern.
    pub structure: Structure,
    /// Diagonal blocks, in elimination order.
    pub diagonal: Vec<Matrix>,
    /// Blocks below the diagonal.
    pub below: Vec<Matrix>,
    segments: Vec<Vec<SegmentPlan>>,
    first_regular: Vec<usize>,
    tied_segments: Vec<TiedSegment>,
    couplings: Vec<Vec<(usize, CouplingPlan)>>,
    tied_couplings: Vec<(usize, usize)>,
    /// For every position the blocks in its row, for the variables at which something can be held.
    rows_of: Vec<Option<Vec<(u32, u32)>>>,
    /// What [`Self::take_out`] removed: (held position, other position, block with rows other, columns held).
    removed: Vec<(u32, u32, Matrix)>,
}

impl BlockMatrix {
    /// Room for the Hessian of a network.
    pub fn new(network: &Network) -> Self {
        let structure = Structure::new(network);
        let s = &structure;
        let slot = |row: u32, column: u32| {
            if row > column {
                Slot { index: s.slot(row, column) as u32, turned: false }
            } else {
                Slot { index: s.slot(column, row) as u32, turned: true }
            }
        };
        let (mut segments, mut couplings, mut first_regular) = (vec![], vec![], vec![]);
        let (mut tied_segments, mut tied_couplings) = (vec![], vec![]);
        for (branch_index, branch) in network.branches.iter().enumerate() {
            let mesh = branch.rod.mesh();
            let mut regular = vec![];
            let mut first = None;
            for (j, frame) in mesh.segment_frames.iter().enumerate() {
                let (a, b) = (s.of_point[branch.points.start + j], s.of_point[branch.points.start + j + 1]);
                let f = s.of_frame[branch.frames.start + frame];
                if a.max(b) >= TIED {
                    tied_segments.push(TiedSegment { branch: branch_index, segment: j, frame: f });
                } else {
                    first.get_or_insert(j);
                    regular.push(SegmentPlan { a, b, f, ba: slot(b, a), fa: slot(f, a), fb: slot(f, b) });
                }
            }
            segments.push(regular);
            first_regular.push(first.unwrap_or(0));
            let mut regular = vec![];
            for c in 0..mesh.coupling_lengths.len() {
                let (a, b) = (s.of_frame[branch.frames.start + c], s.of_frame[branch.frames.start + c + 1]);
                if a.max(b) >= TIED {
                    tied_couplings.push((branch_index, c));
                } else {
                    regular.push((c, CouplingPlan { a, b, ba: slot(b, a) }));
                }
            }
            couplings.push(regular);
        }
        let mut rows_of = vec![None; structure.len()];
        for fixing in &network.fixings {
            let point = Some(Variable::Point(fixing.site.point));
            for variable in [point, fixing.site.frame.map(Variable::Frame)].into_iter().flatten() {
                rows_of[structure.position(variable) as usize] = Some(Vec::new());
            }
        }
        for column in 0..structure.len() {
            for slot in structure.starts[column]..structure.starts[column + 1] {
                if let Some(blocks) = &mut rows_of[structure.rows[slot as usize] as usize] {
                    blocks.push((slot, column as u32));
                }
            }
        }
        Self {
            diagonal: vec![Matrix::zeros(); structure.len()],
            below: vec![Matrix::zeros(); structure.rows.len()],
            structure,
            segments,
            first_regular,
            tied_segments,
            couplings,
            tied_couplings,
            rows_of,
            removed: Vec::new(),
        }
    }

    #[inline(always)]
    fn add_below(below: &mut [Matrix], slot: Slot, block: &Matrix) {
        if slot.turned {
            below[slot.index as usize] += block.transpose();
        } else {
            below[slot.index as usize] += block;
        }
    }

    /// Adds a block at any (row, column); blocks above the diagonal are left to their transposed twins.
    fn add(&mut self, row: u32, column: u32, block: &Matrix) {
        if row == column {
            self.diagonal[row as usize] += block;
        } else if row > column {
            let slot = self.structure.slot(row, column);
            self.below[slot] += block;
        }
    }

    /// Adds a block at (row, column), and its transpose at (column, row): whichever of them is below the diagonal.
    fn add_both(&mut self, row: u32, column: u32, block: &Matrix) {
        if row > column {
            self.add(row, column, block);
        } else {
            self.add(column, row, &block.transpose());
        }
    }

    /// The edge from `point` to the next as a linear function of independent variables: ends that are tied to a joint
    /// move with its point and, by the lever of their offset, with its frame.
    fn levers(&self, network: &Network, state: &State, point: usize) -> [Option<Lever>; 4] {
        let mut levers = [None; 4];
        for (end, sign) in [(0, -1.0), (1, 1.0)] {
            let own = self.structure.of_point[point + end];
            if own < TIED {
                levers[2 * end] = Some((own, Matrix::identity() * sign));
                continue;
            }
            let tie = &network.ties[(own - TIED) as usize];
            levers[2 * end] = Some((self.structure.of_point[tie.hub_point], Matrix::identity() * sign));
            if let Some(hub) = tie.hub_frame {
                let r = state.frames[hub].to_rotation_matrix();
                levers[2 * end + 1] = Some((self.structure.of_frame[hub], r.matrix() * skew(&tie.offset) * -sign));
            }
        }
        levers
    }

    /// The independent frame that carries `frame`, and the rotation A of a tied one in it: `θ = Aᵀ θ_hub`.
    fn turned(&self, network: &Network, frame: usize) -> (u32, Matrix) {
        let own = self.structure.of_frame[frame];
        if own < TIED {
            return (own, Matrix::identity());
        }
        let tie = &network.ties[(own - TIED) as usize];
        let hub = tie.hub_frame.expect("a tied frame has a hub");
        (self.structure.of_frame[hub], *tie.rest.to_rotation_matrix().matrix())
    }

    /// Gathers the parts' second derivatives at `state`.
    pub fn gather(&mut self, network: &Network, state: &State, hessian: &Hessian) {
        self.diagonal.fill(Matrix::zeros());
        self.below.fill(Matrix::zeros());
        let (diagonal, below) = (&mut self.diagonal, &mut self.below);
        for (b, branch) in hessian.branches.iter().enumerate() {
            for (plan, h) in self.segments[b].iter().zip(&branch.segments[self.first_regular[b]..]) {
                diagonal[plan.a as usize] += h.ee;
                diagonal[plan.b as usize] += h.ee;
                diagonal[plan.f as usize] += h.tt;
                // e = x_b − x_a
                below[plan.ba.index as usize] -= h.ee;
                if plan.fa.turned {
                    below[plan.fa.index as usize] -= h.te.transpose();
                } else {
                    below[plan.fa.index as usize] -= h.te;
                }
                Self::add_below(below, plan.fb, &h.te);
            }
            for (c, plan) in &self.couplings[b] {
                let h = &branch.couplings[*c];
                diagonal[plan.a as usize] += h.aa;
                diagonal[plan.b as usize] += h.bb;
                let block = Slot { turned: !plan.ba.turned, ..plan.ba };
                Self::add_below(below, block, &h.ab);
            }
        }
        self.gather_tied(network, state, hessian);
        for (joint, table) in network.joints.iter().zip(&hessian.joints) {
            let k = joint.arm_frames.len();
            for b in 0..k {
                for a in 0..=b {
                    let (row, column) =
                        (self.structure.of_frame[joint.arm_frames[b]], self.structure.of_frame[joint.arm_frames[a]]);
                    let block = table[b * k + a];
                    if row == column {
                        self.add(row, row, &block);
                    } else {
                        self.add_both(row, column, &block);
                    }
                }
            }
        }
        for (fixing, h) in network.fixings.iter().zip(&hessian.potentials) {
            let Some([xx, tx, tt]) = h else { continue };
            let x = self.structure.of_point[fixing.site.point];
            self.add(x, x, xx);
            if let Some(frame) = fixing.site.frame {
                let t = self.structure.of_frame[frame];
                self.add(t, t, tt);
                self.add_both(t, x, tx);
            }
        }
    }

    /// Parts that touch a joint: their end points and end stations are functions of the joint's variables.
    fn gather_tied(&mut self, network: &Network, state: &State, hessian: &Hessian) {
        for index in 0..self.tied_segments.len() {
            let TiedSegment { branch, segment, frame } = self.tied_segments[index];
            let h = hessian.branches[branch].segments[segment];
            let levers = self.levers(network, state, network.branches[branch].points.start + segment);
            self.add(frame, frame, &h.tt);
            for (row, ji) in levers.iter().flatten() {
                for (column, jk) in levers.iter().flatten() {
                    self.add(*row, *column, &(ji.transpose() * h.ee * jk));
                }
                self.add_both(frame, *row, &(h.te * ji));
            }
        }
        for (b, branch) in network.branches.iter().enumerate() {
            let mesh = branch.rod.mesh();
            for (beside, h) in mesh.beside.iter().zip(&hessian.branches[b].beside) {
                let frame = self.structure.of_frame[branch.frames.start + mesh.segment_frames[beside.segment]];
                let levers = self.levers(network, state, branch.points.start + beside.segment);
                let stations = beside.stations.map(|c| c.map(|c| self.turned(network, branch.frames.start + c)));
                for (k, (station, r)) in stations.iter().enumerate().filter_map(|(k, s)| s.as_ref().map(|s| (k, s))) {
                    self.add(*station, *station, &(r * h.ss[k] * r.transpose()));
                    self.add_both(*station, frame, &(r * h.st[k]));
                    for (row, j) in levers.iter().flatten() {
                        let block = r * h.se[k] * j;
                        if row == station {
                            // The station and the lever of its offset are the same hub.
                            self.add(*row, *row, &(block + block.transpose()));
                        } else {
                            self.add_both(*station, *row, &block);
                        }
                    }
                }
                if let [Some((s0, r0)), Some((s1, r1))] = &stations {
                    let block = r1 * h.s1s0 * r0.transpose();
                    if s0 == s1 {
                        self.add(*s0, *s0, &(block + block.transpose()));
                    } else {
                        self.add_both(*s1, *s0, &block);
                    }
                }
            }
        }
        for index in 0..self.tied_couplings.len() {
            let (branch, c) = self.tied_couplings[index];
            let h = hessian.branches[branch].couplings[c];
            let start = network.branches[branch].frames.start + c;
            let ((a, ra), (b, rb)) = (self.turned(network, start), self.turned(network, start + 1));
            self.add(a, a, &(ra * h.aa * ra.transpose()));
            self.add(b, b, &(rb * h.bb * rb.transpose()));
            let ab = ra * h.ab * rb.transpose();
            if a == b {
                self.add(a, a, &(ab + ab.transpose()));
            } else {
                self.add_both(a, b, &ab);
            }
        }
        for (tie, h) in network.ties.iter().zip(&hessian.ties) {
            if let Some(hub) = tie.hub_frame {
                let position = self.structure.of_frame[hub];
                self.add(position, position, h);
            }
        }
    }

    /// Rest length around each frame, m, in elimination order; 0 for points: what a shift is multiplied by.
    pub fn frame_weights(&self, network: &Network) -> Vec<f64> {
        let mut by_frame = vec![0.0; network.frames];
        for branch in &network.branches {
            let mesh = branch.rod.mesh();
            for (c, lambda) in mesh.coupling_lengths.iter().enumerate() {
                by_frame[branch.frames.start + c] += 0.5 * lambda;
                by_frame[branch.frames.start + c + 1] += 0.5 * lambda;
            }
            for (j, c) in mesh.segment_frames.iter().enumerate() {
                by_frame[branch.frames.start + c] += 0.5 * mesh.rest_lengths[j];
            }
        }
        for tie in &network.ties {
            if let (Some(hub), Some(own)) = (tie.hub_frame, tie.frame) {
                by_frame[hub] += by_frame[own] + tie.offset.norm();
            }
        }
        self.structure
            .variables
            .iter()
            .map(|variable| match variable {
                Variable::Point(_) => 0.0,
                Variable::Frame(c) => by_frame[*c],
            })
            .collect()
    }

    /// Adds `sigma` times the weight to the diagonal of every frame: enough of it makes the matrix positive
    /// definite, for the energy is convex in the positions once the frames are given.
    pub fn shift(&mut self, sigma: f64, weights: &[f64]) {
        for (block, weight) in self.diagonal.iter_mut().zip(weights) {
            let x = sigma * weight;
            block[(0, 0)] += x;
            block[(1, 1)] += x;
            block[(2, 2)] += x;
        }
    }

    /// Takes the held directions out: their rows and columns become those of the identity, in the basis of each
    /// held variable. What is removed is kept for [`Self::right_hand_side`].
    pub fn take_out(&mut self, problem: &Problem<'_>) {
        let structure = &self.structure;
        let blocks = |p: u32| {
            let own = structure.starts[p as usize]..structure.starts[p as usize + 1];
            let crossing = self.rows_of[p as usize].as_deref().unwrap_or_default();
            (own, crossing)
        };
        self.removed.clear();
        for held in problem.held() {
            let p = structure.position(held.variable);
            let (own, crossing) = blocks(p);
            self.removed.push((p, p, self.diagonal[p as usize]));
            self.removed.extend(own.map(|s| (p, structure.rows[s as usize], self.below[s as usize])));
            self.removed.extend(crossing.iter().map(|&(s, column)| (p, column, self.below[s as usize].transpose())));
        }
        for held in problem.held() {
            let p = structure.position(held.variable);
            let b = &held.basis;
            let (own, crossing) = blocks(p);
            for s in own {
                let block = &mut self.below[s as usize];
                *block *= b;
                block.columns_mut(0, held.count).fill(0.0);
            }
            for &(s, _) in crossing {
                let block = &mut self.below[s as usize];
                *block = b.tr_mul(block);
                block.rows_mut(0, held.count).fill(0.0);
            }
            let d = &mut self.diagonal[p as usize];
            *d = b.tr_mul(d) * b;
            d.rows_mut(0, held.count).fill(0.0);
            d.columns_mut(0, held.count).fill(0.0);
            for k in 0..held.count {
                d[(k, k)] = 1.0;
            }
        }
    }

    /// Right-hand side `−g − H_fp δ_p` in elimination order and in the bases of the held variables, whose held
    /// entries become zero; `motion` is δ_p.
    pub fn right_hand_side(&self, problem: &Problem<'_>, g: &Tangent, motion: Option<&Tangent>, rhs: &mut [Vector]) {
        for (r, variable) in rhs.iter_mut().zip(&self.structure.variables) {
            *r = match variable {
                Variable::Point(i) => -g.points[*i],
                Variable::Frame(c) => -g.frames[*c],
            };
        }
        if let Some(motion) = motion {
            for (held, other, block) in &self.removed {
                let d = match self.structure.variables[*held as usize] {
                    Variable::Point(i) => &motion.points[i],
                    Variable::Frame(c) => &motion.frames[c],
                };
                rhs[*other as usize] -= block * d;
            }
        }
        for held in problem.held() {
            let r = &mut rhs[self.structure.position(held.variable) as usize];
            *r = held.basis.tr_mul(r);
            for k in 0..held.count {
                r[k] = 0.0;
            }
        }
    }

    /// A solution in elimination order as a step of the whole harness, with the prescribed motion added.
    pub fn step(
        &self,
        problem: &Problem<'_>,
        state: &State,
        solution: &mut [Vector],
        motion: Option<&Tangent>,
        step: &mut Tangent,
    ) {
        for held in problem.held() {
            let u = &mut solution[self.structure.position(held.variable) as usize];
            *u = held.basis * *u;
        }
        for (u, variable) in solution.iter().zip(&self.structure.variables) {
            match variable {
                Variable::Point(i) => step.points[*i] = *u,
                Variable::Frame(c) => step.frames[*c] = *u,
            }
        }
        if let Some(motion) = motion {
            for held in problem.held() {
                match held.variable {
                    Variable::Point(i) => step.points[i] += motion.points[i],
                    Variable::Frame(c) => step.frames[c] += motion.frames[c],
                }
            }
        }
        problem.network.push_forward(state, step);
    }
}
