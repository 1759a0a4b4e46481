//! Sparse block matrix of second derivatives: elimination of prescribed variables, right-hand sides and steps.

use crate::linear::symbolic::{Structure, TIED};
use wireloom_core::prescribed::Held;
use wireloom_core::problem::Problem;
use wireloom_core::variable::Block;
use wireloom_core::variable::Variable;
use wireloom_core::{Matrix, Network, State, Tangent, Vector};

/// Blocks of the matrix and, after factorisation, of its factor.
pub struct BlockMatrix {
    /// Pattern.
    pub structure: Structure,
    /// Diagonal blocks, in elimination order.
    pub diagonal: Vec<Matrix>,
    /// Blocks below the diagonal.
    pub below: Vec<Matrix>,
    /// For the position of every variable that can be held, the blocks in its row: (index, column).
    rows_of: Vec<Option<Vec<(u32, u32)>>>,
    /// Blocks removed by [`Self::eliminate_prescribed`]: (held position, other position, block with rows other, columns
    /// held).
    removed: Vec<(u32, u32, Matrix)>,
}

impl BlockMatrix {
    /// Zero matrix with a pattern.
    pub fn new(structure: Structure, network: &Network) -> Self {
        let mut rows_of = vec![None; structure.len()];
        for constraint in &network.constraints {
            // Constraints that prescribe have one station.
            let point = Some(Variable::Point(constraint.site.point));
            let variables = [point, constraint.site.frame.map(Variable::Frame)].into_iter().flatten();
            for position in variables.filter_map(|variable| structure.position(variable)) {
                rows_of[position as usize] = Some(Vec::new());
            }
        }
        let pattern = &structure.pattern;
        for column in 0..structure.len() {
            for slot in pattern.starts[column]..pattern.starts[column + 1] {
                if let Some(blocks) = &mut rows_of[pattern.rows[slot as usize] as usize] {
                    blocks.push((slot, column as u32));
                }
            }
        }
        Self {
            diagonal: vec![Matrix::zeros(); structure.len()],
            below: vec![Matrix::zeros(); pattern.rows.len()],
            structure,
            rows_of,
            removed: Vec::new(),
        }
    }

    /// Sets every block to zero.
    pub fn clear(&mut self) {
        self.diagonal.fill(Matrix::zeros());
        self.below.fill(Matrix::zeros());
    }

    /// Adds a block at (row, column); blocks above the diagonal are ignored, as their transposes are added too.
    pub fn add(&mut self, row: u32, column: u32, block: &Matrix) {
        if row == column {
            self.diagonal[row as usize] += block;
        } else if row > column {
            let slot = self.structure.pattern.slot(row, column);
            self.below[slot] += block;
        }
    }

    /// Adds a block at its variables, if the matrix has them.
    pub fn add_block(&mut self, block: &Block) {
        if let (Some(row), Some(column)) = (self.structure.position(block.row), self.structure.position(block.column)) {
            self.add(row, column, &block.matrix);
        }
    }

    /// Adds a block at (row, column) and its transpose at (column, row); the one below the diagonal is stored.
    pub fn add_both(&mut self, row: u32, column: u32, block: &Matrix) {
        if row > column {
            self.add(row, column, block);
        } else {
            self.add(column, row, &block.transpose());
        }
    }

    /// Weights of [`Self::shift`], in elimination order: rest length around each frame (m) times the force of its
    /// branch (N); 0 for points. A hub has the sum over its arms; a compliant one that of half a segment of each, too.
    pub fn frame_weights(&self, network: &Network, force: impl Fn(usize) -> f64, weights: &mut [f64]) {
        let Structure { of_frame, .. } = &self.structure;
        weights.fill(0.0);
        for (b, branch) in network.branches.iter().enumerate() {
            let (mesh, force) = (branch.rod.mesh(), force(b));
            let of_frame = &of_frame[branch.frames.clone()];
            let mut add = |frame: usize, length: f64| {
                let tie = of_frame[frame].checked_sub(TIED).map(|t| &network.ties[t as usize]);
                let place =
                    tie.map_or(Some(of_frame[frame]), |tie| tie.hub_frame.map(|hub| self.structure.of_frame[hub]));
                if let Some(place) = place {
                    weights[place as usize] += force * length;
                }
            };
            for (c, lambda) in mesh.coupling_lengths.iter().enumerate() {
                add(c, 0.5 * lambda);
                add(c + 1, 0.5 * lambda);
            }
            for (j, c) in mesh.segment_frames.iter().enumerate() {
                add(*c, 0.5 * mesh.rest_lengths[j]);
            }
        }
        for joint in &network.joints {
            if let Some(hub) = joint.frame {
                let arms = joint.arms.iter().zip(&joint.branches);
                let levers = arms.map(|(arm, &b)| joint.lever(arm) * force(b));
                weights[of_frame[hub] as usize] += levers.sum::<f64>();
            }
        }
    }

    /// Adds `sigma` times the weight to the diagonal of every frame. A sufficient shift makes the matrix positive
    /// definite, as the energy is convex in the positions at fixed frames.
    pub fn shift(&mut self, sigma: f64, weights: &[f64]) {
        for (block, weight) in self.diagonal.iter_mut().zip(weights) {
            let x = sigma * weight;
            block[(0, 0)] += x;
            block[(1, 1)] += x;
            block[(2, 2)] += x;
        }
    }

    /// Adds `fraction` times its magnitude to every scalar diagonal entry.
    pub fn grow_diagonal(&mut self, fraction: f64) {
        for block in &mut self.diagonal {
            for k in 0..3 {
                block[(k, k)] += fraction * block[(k, k)].abs();
            }
        }
    }

    /// Eliminates the prescribed directions: their rows and columns become those of the identity, in the basis of each
    /// held variable. The removed blocks are kept for [`Self::right_hand_side`].
    pub fn eliminate_prescribed(&mut self, problem: &Problem<'_>) {
        let structure = &self.structure;
        let pattern = &structure.pattern;
        let blocks = |p: u32| {
            let own = pattern.starts[p as usize]..pattern.starts[p as usize + 1];
            let crossing = self.rows_of[p as usize].as_deref().unwrap_or_default();
            (own, crossing)
        };
        self.removed.clear();
        for (p, _) in held(structure, problem) {
            let (own, crossing) = blocks(p);
            self.removed.push((p, p, self.diagonal[p as usize]));
            self.removed.extend(own.map(|s| (p, pattern.rows[s as usize], self.below[s as usize])));
            self.removed.extend(crossing.iter().map(|&(s, column)| (p, column, self.below[s as usize].transpose())));
        }
        for (p, held) in held(structure, problem) {
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
        for (p, held) in held(&self.structure, problem) {
            let r = &mut rhs[p as usize];
            *r = held.basis.tr_mul(r);
            for k in 0..held.count {
                r[k] = 0.0;
            }
        }
    }

    /// Converts a solution in elimination order to a step of the whole harness, and adds the prescribed motion.
    pub fn step(
        &self,
        problem: &Problem<'_>,
        state: &State,
        solution: &mut [Vector],
        motion: Option<&Tangent>,
        step: &mut Tangent,
    ) {
        for (p, held) in held(&self.structure, problem) {
            let u = &mut solution[p as usize];
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

/// Held variables of a problem that are variables of the matrix, with their positions.
fn held<'p>(structure: &Structure, problem: &'p Problem<'_>) -> impl Iterator<Item = (u32, &'p Held)> {
    problem.held().iter().filter_map(|held| structure.position(held.variable).map(|p| (p, held)))
}
