//! Gathering of the Hessian: where the second derivatives of every part go in the matrix.

use crate::matrix::BlockMatrix;
use crate::structure::{Structure, TIED};
use wireloom_core::problem::Hessian;
use wireloom_core::rotation::skew;
use wireloom_core::{Matrix, Network, State};

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

/// The places of a network's second derivatives in a matrix with [`Structure::new`].
pub struct Gather {
    segments: Vec<Vec<SegmentPlan>>,
    first_regular: Vec<usize>,
    tied_segments: Vec<TiedSegment>,
    couplings: Vec<Vec<(usize, CouplingPlan)>>,
    tied_couplings: Vec<(usize, usize)>,
}

impl Gather {
    /// For a network, whose [`Structure::new`] is `s`.
    pub fn new(network: &Network, s: &Structure) -> Self {
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
        Self { segments, first_regular, tied_segments, couplings, tied_couplings }
    }

    #[inline(always)]
    fn add_below(below: &mut [Matrix], slot: Slot, block: &Matrix) {
        if slot.turned {
            below[slot.index as usize] += block.transpose();
        } else {
            below[slot.index as usize] += block;
        }
    }

    /// The edge from `point` to the next as a linear function of independent variables: ends that are tied to a joint
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

    /// The independent frame that carries `frame`, and the rotation A of a tied one in it: `θ = Aᵀ θ_hub`.
    fn turned(structure: &Structure, network: &Network, frame: usize) -> (u32, Matrix) {
        let own = structure.of_frame[frame];
        if own < TIED {
            return (own, Matrix::identity());
        }
        let tie = &network.ties[(own - TIED) as usize];
        let hub = tie.hub_frame.expect("a tied frame has a hub");
        (structure.of_frame[hub], *tie.rest.to_rotation_matrix().matrix())
    }

    /// Gathers the parts' second derivatives at `state`.
    pub fn run(&self, matrix: &mut BlockMatrix, network: &Network, state: &State, hessian: &Hessian) {
        matrix.clear();
        let (diagonal, below) = (&mut matrix.diagonal, &mut matrix.below);
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
        self.gather_tied(matrix, network, state, hessian);
        for (joint, table) in network.joints.iter().zip(&hessian.joints) {
            let k = joint.arm_frames.len();
            for b in 0..k {
                for a in 0..=b {
                    let (row, column) = (
                        matrix.structure.of_frame[joint.arm_frames[b]],
                        matrix.structure.of_frame[joint.arm_frames[a]],
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
        for (fixing, h) in network.fixings.iter().zip(&hessian.potentials) {
            let Some([xx, tx, tt]) = h else { continue };
            let x = matrix.structure.of_point[fixing.site.point];
            matrix.add(x, x, xx);
            if let Some(frame) = fixing.site.frame {
                let t = matrix.structure.of_frame[frame];
                matrix.add(t, t, tt);
                matrix.add_both(t, x, tx);
            }
        }
    }

    /// Parts that touch a joint: their end points and end stations are functions of the joint's variables.
    fn gather_tied(&self, matrix: &mut BlockMatrix, network: &Network, state: &State, hessian: &Hessian) {
        for index in 0..self.tied_segments.len() {
            let TiedSegment { branch, segment, frame } = self.tied_segments[index];
            let h = hessian.branches[branch].segments[segment];
            let levers =
                Self::levers(&matrix.structure, network, state, network.branches[branch].points.start + segment);
            matrix.add(frame, frame, &h.tt);
            for (row, ji) in levers.iter().flatten() {
                for (column, jk) in levers.iter().flatten() {
                    matrix.add(*row, *column, &(ji.transpose() * h.ee * jk));
                }
                matrix.add_both(frame, *row, &(h.te * ji));
            }
        }
        for (b, branch) in network.branches.iter().enumerate() {
            let mesh = branch.rod.mesh();
            for (beside, h) in mesh.beside.iter().zip(&hessian.branches[b].beside) {
                let frame = matrix.structure.of_frame[branch.frames.start + mesh.segment_frames[beside.segment]];
                let levers = Self::levers(&matrix.structure, network, state, branch.points.start + beside.segment);
                let stations = beside
                    .stations
                    .map(|c| c.map(|c| Self::turned(&matrix.structure, network, branch.frames.start + c)));
                for (k, (station, r)) in stations.iter().enumerate().filter_map(|(k, s)| s.as_ref().map(|s| (k, s))) {
                    matrix.add(*station, *station, &(r * h.ss[k] * r.transpose()));
                    matrix.add_both(*station, frame, &(r * h.st[k]));
                    for (row, j) in levers.iter().flatten() {
                        let block = r * h.se[k] * j;
                        if row == station {
                            // The station and the lever of its offset are the same hub.
                            matrix.add(*row, *row, &(block + block.transpose()));
                        } else {
                            matrix.add_both(*station, *row, &block);
                        }
                    }
                }
                if let [Some((s0, r0)), Some((s1, r1))] = &stations {
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
            let ((a, ra), (b, rb)) =
                (Self::turned(&matrix.structure, network, start), Self::turned(&matrix.structure, network, start + 1));
            matrix.add(a, a, &(ra * h.aa * ra.transpose()));
            matrix.add(b, b, &(rb * h.bb * rb.transpose()));
            let ab = ra * h.ab * rb.transpose();
            if a == b {
                matrix.add(a, a, &(ab + ab.transpose()));
            } else {
                matrix.add_both(a, b, &ab);
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
