//! A branch as the estimate of its error reads it.

use crate::report::result::shift_length;
use wireloom_core::equilibrium::BranchResult;
use wireloom_core::network::{Branch, BranchEnd};
use wireloom_core::problem::Problem;
use wireloom_core::rod::BranchShape;
use wireloom_core::{Matrix, State, Vector};

/// Node of a mesh with curvature samples: those of its couplings.
pub(crate) struct Samples<'a> {
    pub(super) branch: &'a Branch,
    pub(super) shape: BranchShape<'a>,
    pub(super) result: &'a BranchResult,
    /// κ of each coupling, 1/m.
    pub(super) curvature: Vec<Vector>,
    /// κ°, 1/m.
    pub(super) rest: Vector,
    /// Arc length to which it belongs, m: that of the node, beside a station β ℓ away from it.
    pub(super) place: Vec<f64>,
    /// κ′ of each segment, 1/m²; `None` where a coupling of it is that of a joint.
    pub(super) rate: Vec<Option<Vector>>,
    /// C of the section of each segment, N m².
    pub(super) stiffness: Vec<Matrix>,
    /// C of each coupling, N m².
    pub(super) discrete_stiffness: Vec<Matrix>,
    /// Inverse of the stiffness, by segment, 1/(N m²).
    pub(super) compliance: Vec<Matrix>,
    /// β of the stations at the two ends of the branch, and within, where the scheme is of second order.
    pub(super) blends: [f64; 2],
    /// Whether the scheme is of fourth order, by segment.
    pub(super) fine: Vec<bool>,
    /// Factor on the variation of curvature; another one than 1 is for a rod that has further errors of second order.
    pub(super) variation: f64,
    /// f − 1 of a rod whose frames are aligned with their edges: the alignment has the compliance `(f − 1) (ℓ²/12)/EI`.
    pub(super) alignment: f64,
    /// ℓ of `(ℓ²/24) x″`, by which the centre line is beside the node of the joint in a point at each end of the
    /// branch, m.
    pub(super) joint_lengths: [f64; 2],
    /// n of each segment, N, world.
    pub(super) forces: Vec<Vector>,
    /// x″ at the start and at the end of each segment, 1/m, world.
    pub(super) bends: Vec<[Vector; 2]>,
    /// ∂D/∂κ of the couplings, N m²: without edges and weight, and of these alone.
    pub(super) cell_moments: Vec<Vector>,
    pub(super) edge_moments: Vec<Vector>,
}

impl<'a> Samples<'a> {
    /// Of all branches with these results at `state`.
    pub(crate) fn of(problem: &'a Problem<'_>, state: &'a State, results: &'a [BranchResult]) -> Vec<Self> {
        let touches = touches(problem);
        problem.network.map(results.len(), |index| Self::new(problem, state, index, &results[index], touches))
    }

    fn new(problem: &'a Problem<'_>, state: &'a State, index: usize, result: &'a BranchResult, touches: bool) -> Self {
        let branch = &problem.network.branches[index];
        let shape = problem.shape(state, index);
        let mesh = branch.rod.mesh();
        let n = mesh.segments();
        // Where friction sticks; where it slips the stiffness is less, and so is the defect.
        let (mut stiffness, mut compliance) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for span in branch.sections.spans() {
            let sticking = span.section.sticking_stiffness();
            let inverse = sticking.try_inverse().unwrap_or(Matrix::repeat(f64::NAN));
            let end = span.segments.end.min(n);
            stiffness.resize(end, sticking);
            compliance.resize(end, inverse);
        }
        let of_friction = |c: usize| {
            let section = branch.sections.of(mesh.coupling_segment(c));
            Matrix::from_diagonal(&(section.sticking_diagonal() - section.lasting_diagonal()))
        };
        let law = branch.rod.linear_law();
        let blends = law.as_ref().map_or([0.0, 0.0], |law| law.blends);
        let rest = law.as_ref().map_or_else(Vector::zeros, |law| law.curvature);
        // The same all along a branch.
        let rest = shape.extra_curvature.first().map_or(rest, |extra| rest + extra);
        let variation = law.as_ref().map_or(0.0, |law| law.variation);
        let couplings = shape.coupling_lengths.len();
        let discrete_stiffness: Vec<Matrix> = match law {
            Some(law) => (0..couplings).map(|c| law.coupling_stiffness(c) + of_friction(c)).collect(),
            None => (0..couplings).map(|c| stiffness[mesh.coupling_segment(c)]).collect(),
        };
        let curvature: Vec<Vector> = shape
            .coupling_lengths
            .iter()
            .enumerate()
            .map(|(c, lambda)| (shape.frames[c].inverse() * shape.frames[c + 1]).scaled_axis() / *lambda)
            .collect();
        let mut samples = Self {
            branch,
            shape,
            result,
            place: Vec::with_capacity(couplings),
            curvature,
            rest,
            rate: Vec::with_capacity(n),
            stiffness,
            compliance,
            discrete_stiffness,
            blends,
            variation,
            alignment: (variation - 1.0).max(0.0),
            // In contact the polygon is what touches: the error is of second order.
            fine: (0..n).map(|j| branch.rod.couples_pairs() && mesh.is_fine(j) && !touches).collect(),
            joint_lengths: [branch.start, branch.end].map(|end| match end {
                BranchEnd::Joint { joint, .. } => shift_length(problem, &problem.network.joints[joint]),
                BranchEnd::Free => 0.0,
            }),
            forces: vec![Vector::zeros(); n],
            bends: Vec::with_capacity(n),
            cell_moments: Vec::new(),
            edge_moments: Vec::new(),
        };
        branch.rod.forces(&samples.shape, &mut samples.forces);
        for c in 0..couplings {
            let node = mesh.coupling_nodes[c];
            let side = match mesh.station_frame(node) {
                Some(station) if station == c => samples.blend(node, node) * shape.rest_lengths[node],
                Some(_) => -samples.blend(node - 1, node) * shape.rest_lengths[node - 1],
                None => 0.0,
            };
            samples.place.push(result.s[node] + side);
        }
        for j in 0..n {
            let [start, end] = samples.couplings(j);
            samples.rate.push(start.zip(end).map(|(start, end)| {
                let change = samples.curvature[end] - samples.curvature[start];
                change / (samples.place[end] - samples.place[start])
            }));
        }
        for j in 0..n {
            let bends = [0, 1].map(|end| {
                let node = j + end;
                let kappa = samples.at_node(j, end).unwrap_or_else(|| {
                    samples.rest + samples.compliance[j] * (result.frame[node].inverse() * result.moment[node])
                });
                result.frame[node] * kappa.cross(&Vector::z())
            });
            samples.bends.push(bends);
        }
        samples.cell_moments = samples.moments_of_cells();
        samples.edge_moments = samples.moments_of_edges();
        samples
    }

    /// Distance from a node to the place to which the curvature of its coupling beside segment j belongs, as a fraction
    /// of the segment: at a station β, or in a scheme of fourth order the middle of its cell.
    pub(super) fn blend(&self, j: usize, node: usize) -> f64 {
        let mesh = self.branch.rod.mesh();
        let inner = usize::from(node > 0 && node < mesh.segments());
        match mesh.station_frame(node) {
            None => 0.0,
            Some(_) if self.fine[j] => 0.25,
            Some(_) => self.blends[inner],
        }
    }

    /// The curvature (1/m) that a moment (N m) causes at a coupling.
    pub(super) fn bent(&self, c: usize, moment: &Vector) -> Vector {
        self.compliance[self.branch.rod.mesh().coupling_segment(c)] * moment
    }

    /// C of the section of a coupling, N m².
    pub(super) fn of_coupling(&self, c: usize) -> &Matrix {
        &self.stiffness[self.branch.rod.mesh().coupling_segment(c)]
    }

    /// The segments beside a node; at an end of the branch one of them twice.
    pub(super) fn beside(&self, node: usize) -> [usize; 2] {
        [node.saturating_sub(1), node.min(self.stiffness.len() - 1)]
    }

    /// Order of the scheme all along the branch.
    pub(super) fn order(&self) -> u32 {
        let (mesh, l) = (self.branch.rod.mesh(), self.shape.rest_lengths);
        let graded = |node: usize| mesh.station_frame(node).is_none() && (l[node] - l[node - 1]).abs() > 1e-6 * l[node];
        // What acts on a joint in a point that is held acts beside the centre line.
        let ends = [(self.branch.start, 0), (self.branch.end, l.len() - 1)];
        let beside = ends.into_iter().enumerate().any(|(end, (at, j))| {
            let in_a_point = matches!(at, BranchEnd::Joint { .. }) && self.couplings(j)[end].is_none();
            in_a_point && (l[j] - self.joint_lengths[end]).abs() > 1e-6 * l[j]
        });
        let differs = |(c, own): (usize, &Matrix)| {
            let section = self.of_coupling(c);
            (own - section).norm() > 1e-9 * section.norm()
        };
        if self.discrete_stiffness.iter().enumerate().any(differs) {
            1
        } else if self.variation == 1.0 && self.fine.iter().all(|fine| *fine) && !(1..l.len()).any(graded) && !beside {
            4
        } else {
            2
        }
    }

    /// Number of segments of the span from station to station that a coupling is in.
    pub(super) fn span_of(&self, c: usize) -> usize {
        let mesh = self.branch.rod.mesh();
        let node = mesh.coupling_nodes[c];
        let before = node == mesh.segments() || mesh.station_frame(node) == Some(c + 1);
        self.span(if before { node - 1 } else { node })
    }

    /// Number of segments of the span from station to station that a segment is in.
    pub(super) fn span(&self, j: usize) -> usize {
        let mesh = self.branch.rod.mesh();
        let k = mesh.stations.partition_point(|station| *station <= j);
        let start = k.checked_sub(1).map_or(0, |before| mesh.stations[before]);
        mesh.stations.get(k).map_or(mesh.segments(), |end| *end) - start
    }

    /// Couplings of a segment with the frames before and after it.
    pub(super) fn couplings(&self, j: usize) -> [Option<usize>; 2] {
        let frame = self.branch.rod.mesh().segment_frames[j];
        [frame.checked_sub(1), (frame < self.shape.coupling_lengths.len()).then_some(frame)]
    }

    /// κ at the start (0) or end (1) of a segment, 1/m.
    pub(super) fn at_node(&self, j: usize, end: usize) -> Option<Vector> {
        let c = self.couplings(j)[end]?;
        let beyond = self.blend(j, j + end) * self.shape.rest_lengths[j] * (2.0 * end as f64 - 1.0);
        Some(self.curvature[c] + self.rate[j].unwrap_or_default() * beyond)
    }
}

/// Whether the harness touches something, or itself, where contact was evaluated last. A contact that the penalty
/// alone bears well enough has no record.
pub(super) fn touches(problem: &Problem<'_>) -> bool {
    !problem.conditions().contact.records.is_empty() || !problem.contact().found().is_empty()
}
