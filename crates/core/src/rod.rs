//! Trait of a rod, one object for each branch, and its mesh.

use crate::BuildError;
use crate::constitutive::{ConstitutiveLaws, Derivatives};
use crate::law::RodLaw;
use crate::terms::slope::Contradiction;
use crate::{Matrix, Rotation, Section, Sections, Vector};

/// Mesh of a branch: its segments, nodes, stations and frames.
///
/// The frames of a branch form one row in the order of arc length: those of its segments and, between them, those of
/// its stations. A branch of n segments with stations at both ends and one in between has n + 3 frames
/// `[Q q … q Q q … q Q]`; neighbours in the row are coupled.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// ℓ_j, m; one for each segment.
    pub rest_lengths: Vec<f64>,
    /// Nodes that have a frame of their own, increasing.
    pub stations: Vec<usize>,
    /// Index of each segment's frame in the row of frames.
    pub segment_frames: Vec<usize>,
    /// Index of each station's frame in the row of frames.
    pub station_frames: Vec<usize>,
    /// λ_c, m: length of the coupling between frames c and c + 1; half a segment beside a station.
    pub coupling_lengths: Vec<f64>,
    /// Node of coupling c.
    pub coupling_nodes: Vec<usize>,
    /// The segments that have a station at one of their nodes, increasing.
    pub beside: Vec<Beside>,
    /// Pairs of couplings with the frame of a segment between them, in the order of the row, where the mesh is fine
    /// enough for a scheme of fourth order: in spans between stations of at least [`Mesh::FINE`] segments.
    pub pairs: Vec<CellPair>,
}

/// A segment with a station at one or both of its nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Beside {
    /// The segment.
    pub segment: usize,
    /// Indices in the row of frames of the stations at its first and second node.
    pub stations: [Option<usize>; 2],
    /// Index in the row of frames of the next segment, on the side away from the only station; where this segment and
    /// the next two are of one length and the mesh is fine enough for a scheme of fourth order.
    pub next: Option<usize>,
}

impl Beside {
    /// Frames that the energy of the segment may depend on beside its own: before and after it in the row.
    pub fn neighbours(&self) -> [Option<usize>; 2] {
        let [first, second] = self.stations;
        [first.or(self.next), second.or(self.next)]
    }
}

/// Couplings `frame − 1` and `frame` of the row, on both sides of the frame of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellPair {
    /// Index of the frame between them.
    pub frame: usize,
    /// Share of each coupling that belongs to this pair: 1 beside a station, else half.
    pub shares: [f64; 2],
}

impl Mesh {
    /// Fewest segments of a span between stations for a scheme of fourth order. On coarser ones its wider differences
    /// know no more of the curvature than the plain scheme.
    pub const FINE: usize = 6;

    /// A mesh from rest lengths (m, positive) and the nodes that are stations (increasing).
    pub fn new(rest_lengths: Vec<f64>, stations: Vec<usize>) -> Self {
        let n = rest_lengths.len();
        let mut mesh = Self {
            rest_lengths,
            stations: Vec::new(),
            segment_frames: Vec::with_capacity(n),
            station_frames: Vec::new(),
            coupling_lengths: Vec::new(),
            coupling_nodes: Vec::new(),
            beside: Vec::new(),
            pairs: Vec::new(),
        };
        let mut frames = 0;
        for node in 0..=n {
            let before = (node > 0).then(|| mesh.rest_lengths[node - 1]);
            let after = (node < n).then(|| mesh.rest_lengths[node]);
            if stations.contains(&node) {
                for length in [before, after].into_iter().flatten() {
                    mesh.coupling_lengths.push(0.5 * length);
                    mesh.coupling_nodes.push(node);
                }
                mesh.station_frames.push(frames);
                frames += 1;
            } else if let (Some(before), Some(after)) = (before, after) {
                mesh.coupling_lengths.push(0.5 * (before + after));
                mesh.coupling_nodes.push(node);
            }
            if node < n {
                mesh.segment_frames.push(frames);
                frames += 1;
            }
        }
        mesh.stations = stations;
        for segment in 0..n {
            let stations = [mesh.station_frame(segment), mesh.station_frame(segment + 1)];
            let next = mesh.next(segment, stations);
            if stations != [None, None] {
                mesh.beside.push(Beside { segment, stations, next });
            }
            let frame = mesh.segment_frames[segment];
            if frame > 0 && frame < mesh.coupling_lengths.len() && mesh.is_fine(segment) {
                let share = |station: Option<usize>| if station.is_some() { 1.0 } else { 0.5 };
                mesh.pairs.push(CellPair { frame, shares: stations.map(share) });
            }
        }
        mesh
    }

    /// Whether the span of a segment, from station to station, has [`Self::FINE`] segments. One that goes on beyond a
    /// joint, where the branch has no station, has half of them in each branch.
    pub fn is_fine(&self, segment: usize) -> bool {
        let k = self.stations.partition_point(|&node| node <= segment);
        let start = k.checked_sub(1).map(|before| self.stations[before]);
        let end = self.stations.get(k).copied();
        let least = if start.is_some() && end.is_some() { Self::FINE } else { Self::FINE / 2 };
        end.unwrap_or(self.segments()) - start.unwrap_or(0) >= least
    }

    /// [`Beside::next`] of a segment with these stations.
    fn next(&self, segment: usize, stations: [Option<usize>; 2]) -> Option<usize> {
        let [next, beyond] = match stations {
            [Some(_), None] => [segment + 1, segment + 2],
            [None, Some(_)] => [segment.checked_sub(1)?, segment.checked_sub(2)?],
            _ => return None,
        };
        let own = self.rest_lengths[segment];
        let alike = |j: usize| self.rest_lengths.get(j).is_some_and(|other| (own - other).abs() <= 1e-6 * own);
        (alike(next) && alike(beyond) && self.is_fine(segment)).then(|| self.segment_frames[next])
    }

    /// Writes the coupling lengths λ_c (m) for given rest lengths (m): half a segment beside a station, otherwise half
    /// of both segments. Linear in the rest lengths.
    pub fn couple(&self, rest_lengths: &[f64], coupling_lengths: &mut [f64]) {
        for (c, lambda) in coupling_lengths.iter_mut().enumerate() {
            let node = self.coupling_nodes[c];
            let first = c > 0 && self.coupling_nodes[c - 1] == node;
            let second = self.coupling_nodes.get(c + 1) == Some(&node);
            let before = if node > 0 && !first { rest_lengths[node - 1] } else { 0.0 };
            let after = if node < rest_lengths.len() && !second { rest_lengths[node] } else { 0.0 };
            *lambda = 0.5 * (before + after);
        }
    }

    /// The segment in whose half a coupling is; of two halves that are coupled, the second one's.
    pub fn coupling_segment(&self, coupling: usize) -> usize {
        let node = self.coupling_nodes[coupling];
        // The first of two at a station, or that of a station at the end.
        let before = self.coupling_nodes.get(coupling + 1) == Some(&node) || node == self.segments();
        if before { node - 1 } else { node }
    }

    /// Number of segments.
    pub fn segments(&self) -> usize {
        self.rest_lengths.len()
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.rest_lengths.len() + 1
    }

    /// Number of frames: segments and stations.
    pub fn frames(&self) -> usize {
        self.rest_lengths.len() + self.stations.len()
    }

    /// Arc length of every node, m.
    pub fn arc_lengths(&self) -> Vec<f64> {
        let mut s = 0.0;
        let mut all = vec![0.0];
        for length in &self.rest_lengths {
            s += length;
            all.push(s);
        }
        all
    }

    /// Arc length of every frame of the row (m) for nodes at these arc lengths; the frame of a segment is at its
    /// middle.
    pub fn frame_places(&self, arc_lengths: &[f64]) -> Vec<f64> {
        let mut places = vec![0.0; self.frames()];
        for (j, &c) in self.segment_frames.iter().enumerate() {
            places[c] = 0.5 * (arc_lengths[j] + arc_lengths[j + 1]);
        }
        for (&c, &node) in self.station_frames.iter().zip(&self.stations) {
            places[c] = arc_lengths[node];
        }
        places
    }

    /// Unstressed length, m.
    pub fn length(&self) -> f64 {
        self.rest_lengths.iter().sum()
    }

    /// Index in the row of frames of the station at `node`, if it is one.
    pub fn station_frame(&self, node: usize) -> Option<usize> {
        self.stations.binary_search(&node).ok().map(|k| self.station_frames[k])
    }
}

/// Input of a rod factory.
#[derive(Clone, Debug)]
pub struct RodSpec {
    /// Name of the branch.
    pub name: String,
    /// The section, or those of its spans.
    pub sections: Sections,
    /// The mesh.
    pub mesh: Mesh,
    /// Rest curvature about d1, d2 and rest twist, 1/m.
    pub curvature: Vector,
}

impl RodSpec {
    /// Section of every coupling.
    pub fn of_couplings(&self) -> impl Iterator<Item = &Section> {
        (0..self.mesh.coupling_lengths.len()).map(|c| self.sections.of(self.mesh.coupling_segment(c)))
    }

    /// The section of a branch of a kind of rod that knows only one. Fails where it changes along the branch.
    pub fn only_section(&self) -> Result<&Section, BuildError> {
        self.sections.only().ok_or_else(|| {
            let message = "its section changes along it, which this kind of rod does not know";
            BuildError::new(message, "rod = \"cosserat\" and rod = \"kirchhoff\" know it").at("sections")
        })
    }
}

/// Shape of a branch: slices of a [`crate::State`].
#[derive(Clone, Copy, Debug)]
pub struct BranchShape<'a> {
    /// x_i, m; one for each node.
    pub points: &'a [Vector],
    /// Low-order parts of the positions, m: the position is `points + compensation`, unevaluated.
    pub compensation: &'a [Vector],
    /// q_c in the order of the mesh's row of frames.
    pub frames: &'a [Rotation],
    /// ℓ_j, m; one for each segment: those of the mesh, unless a constraint slides and the mesh has moved along the
    /// cable.
    pub rest_lengths: &'a [f64],
    /// λ_c, m; one for each coupling; see [`Mesh::couple`].
    pub coupling_lengths: &'a [f64],
    /// Axial strain without force: the expansion by temperature. The stretch of a segment is measured from it.
    pub free_strain: f64,
    /// Curvature added to the rest curvature of each coupling, 1/m; empty: none.
    pub extra_curvature: &'a [Vector],
    /// Memory of the rod; see [`RodSegment::memory`]. Where only the geometry is looked at it may be empty.
    pub memory: &'a [f64],
    /// Time that the increment takes, s: since the memory was updated.
    pub duration: f64,
}

impl BranchShape<'_> {
    /// `x_{j+1} − x_j`, m, with the low-order parts, so without the round-off of large coordinates.
    #[inline(always)]
    pub fn edge(&self, j: usize) -> Vector {
        (self.points[j + 1] - self.points[j]) + (self.compensation[j + 1] - self.compensation[j])
    }
}

/// Energy of a rod by effect, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RodEnergy {
    /// Stretch.
    pub stretch: f64,
    /// Shear.
    pub shear: f64,
    /// Bending.
    pub bend: f64,
    /// Twist.
    pub twist: f64,
}

impl RodEnergy {
    /// Sum of all effects, J.
    pub fn total(&self) -> f64 {
        self.stretch + self.shear + self.bend + self.twist
    }
}

/// Second derivatives of one segment's energy in its edge `e = x_{j+1} − x_j` and rotation θ_j.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SegmentHessian {
    /// ∂²E/∂e², N/m; symmetric.
    pub ee: Matrix,
    /// ∂²E/∂θ∂e, N: rows θ, columns e.
    pub te: Matrix,
    /// ∂²E/∂θ², N m; symmetric.
    pub tt: Matrix,
}

/// Second derivatives of the energy of a segment beside stations in the rotations of its neighbours
/// ([`Beside::neighbours`]); zero where there is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NeighbourHessian {
    /// Rows the neighbour before (after) the segment, columns the edge, N.
    pub se: [Matrix; 2],
    /// Rows the neighbour, columns the segment's rotation, N m.
    pub st: [Matrix; 2],
    /// Rows and columns the neighbour, N m; symmetric.
    pub ss: [Matrix; 2],
    /// Rows the second neighbour, columns the first, N m.
    pub s1s0: Matrix,
}

/// All second derivatives of a branch's energy, part by part.
#[derive(Clone, Debug, PartialEq)]
pub struct BranchHessian {
    /// One for each segment.
    pub segments: Vec<SegmentHessian>,
    /// One for each coupling.
    pub couplings: Vec<CouplingHessian>,
    /// One for each entry of [`Mesh::beside`].
    pub beside: Vec<NeighbourHessian>,
    /// One for each entry of [`Mesh::pairs`] if the rod couples them ([`RodSegment::couples_pairs`]): rows the frame
    /// before that of the pair, columns the frame after it, N m.
    pub pairs: Vec<Matrix>,
}

impl BranchHessian {
    /// Zero Hessian of a branch.
    pub fn new(rod: &dyn RodSegment) -> Self {
        let mesh = rod.mesh();
        Self {
            segments: vec![SegmentHessian::default(); mesh.segments()],
            couplings: vec![CouplingHessian::default(); mesh.coupling_lengths.len()],
            beside: vec![NeighbourHessian::default(); mesh.beside.len()],
            pairs: vec![Matrix::zeros(); if rod.couples_pairs() { mesh.pairs.len() } else { 0 }],
        }
    }
}

/// Second derivatives of one coupling's energy in the rotations of the frames it joins, N m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CouplingHessian {
    /// Rows and columns first frame; symmetric.
    pub aa: Matrix,
    /// Rows first frame, columns second.
    pub ab: Matrix,
    /// Rows and columns second frame; symmetric.
    pub bb: Matrix,
}

/// One branch as a rod with energy
/// `E = Σ_j E_j(x_{j+1} − x_j, q_j) + Σ_c E_c(q_c, q_{c+1}) + Σ_p E_p(q_{p−1}, q_p, q_{p+1})`, where beside a station
/// E_j may depend on the frames of the neighbours too, and E_p belongs to pairs of couplings ([`Mesh::pairs`]).
///
/// A rod may remember ([`Self::memory`]). E is then the incremental potential of its law for the memory z at the start
/// of the increment, `E(x, z) = min over z' of stored(x, z') + dissipated(z → z')`: its minimum in x is the
/// equilibrium at the end of the increment, and its derivatives are forces and moments there (Ortiz and Stainier 1999,
/// The variational formulation of viscoplastic constitutive updates, Computer Methods in Applied Mechanics and
/// Engineering 171). Of a rod that creeps it depends on the duration of the increment, too.
///
/// Contract: E ≥ 0, and E = 0 at rest with the initial memory (stretched by [`BranchShape::free_strain`] and bent by
/// [`BranchShape::extra_curvature`], where these are given); E is unchanged by rigid motion of all points and frames
/// (objectivity) and by reversing the direction of the branch (reversal); derivatives are taken along `x + δ`, `q ∘
/// exp(θ)` with θ in the body frame. Methods neither allocate nor fail; output slices have one entry for each node,
/// frame, segment or coupling and are overwritten. Non-finite input gives non-finite output.
pub trait RodSegment: Send + Sync {
    /// Its mesh.
    fn mesh(&self) -> &Mesh;

    /// Whether its energy has parts E_p.
    fn couples_pairs(&self) -> bool {
        false
    }

    /// Energy by effect, J.
    fn energy(&self, shape: &BranchShape<'_>) -> RodEnergy;

    /// Overwrites `frames` with ∂/∂θ_c (N m, body frame) of the parts E_c and E_p, which do not depend on the points:
    /// as long as the frames stay it is not called again. Returns their energy, J.
    fn coupling_gradient(&self, shape: &BranchShape<'_>, frames: &mut [Vector]) -> f64;

    /// Overwrites `points` with ∂/∂x_i (N) of the parts E_j, and adds their ∂/∂θ_c (N m, body frame) to `frames`.
    /// Returns their energy, J.
    fn segment_gradient(&self, shape: &BranchShape<'_>, points: &mut [Vector], frames: &mut [Vector]) -> f64;

    /// Second derivatives, part by part. Where `forces` is given (one for each segment,
    /// N, body frame) it replaces `C Γ` in the geometric part ("mixed integration points",
    /// Magisano, Leonetti, Garcea 2017); at equilibrium both are the same.
    fn hessian(&self, shape: &BranchShape<'_>, forces: Option<&[Vector]>, hessian: &mut BranchHessian);

    /// ∂²E/∂e² of each segment, N/m, the same as in [`Self::hessian`]; without a law of stretch it does not depend on
    /// the points as long as no edge points against its frame: with the frames fixed the energy is then a convex
    /// quadratic function of the points. With such a law it is convex, and quadratic near any points.
    fn edge_stiffness(&self, shape: &BranchShape<'_>, stiffness: &mut [Matrix]);

    /// `C (Γ + δΓ)` for each segment (N, body frame): the force to first order after the step
    /// `(δx, θ)`.
    fn predicted_forces(&self, shape: &BranchShape<'_>, points: &[Vector], frames: &[Vector], forces: &mut [Vector]);

    /// n_j for each segment, N, world axes.
    fn forces(&self, shape: &BranchShape<'_>, forces: &mut [Vector]);

    /// m_c for each coupling, N m, world axes: the moment that the part with larger s exerts on the part with smaller
    /// s.
    fn moments(&self, shape: &BranchShape<'_>, moments: &mut [Vector]);

    /// Derivatives of the energy in the lengths, with frames and points fixed: for each segment
    /// `[∂E/∂ℓ_j (N), ∂²E/∂ℓ_j² (N/m)]`, for each coupling `[∂E/∂λ_c, ∂²E/∂λ_c², ∂²E/∂λ_c∂λ_{c+1}]`; there are no other
    /// mixed derivatives. `∂E/∂ℓ` is the configurational force that governs sliding constraints.
    fn length_terms(&self, shape: &BranchShape<'_>, segments: &mut [[f64; 2]], couplings: &mut [[f64; 3]]);

    /// Mixed derivatives of the energy in lengths that change at these rates and in the variables: adds
    /// `Σ_j a_j ∂²E/∂ℓ_j∂x_i + Σ_c b_c ∂²E/∂λ_c∂x_i` (N/m where the rates are per metre) to
    /// `points`, and likewise in θ to `frames`.
    fn length_mixed(
        &self,
        shape: &BranchShape<'_>,
        segment_rates: &[f64],
        coupling_rates: &[f64],
        points: &mut [Vector],
        frames: &mut [Vector],
    );

    /// Rotation of frame c + 1 relative to frame c at rest, for coupling c.
    fn rest_rotation(&self, coupling: usize) -> Rotation;

    /// The coefficients of the energy, if it is of this form.
    fn law(&self) -> Option<RodLaw> {
        None
    }

    /// The coefficients of a linear rod near it, of the same scheme and with its stiffness at rest: error estimates
    /// rest on it. `None`: it is not known.
    fn linear_law(&self) -> Option<RodLaw> {
        self.law()
    }

    /// Its constitutive laws, where these are not what its section states.
    fn constitutive(&self) -> Option<&ConstitutiveLaws> {
        None
    }

    /// The first derivatives of its constitutive laws, in this shape, that are not those of their values. `None`
    /// without such laws.
    fn contradiction(&self, _shape: &BranchShape<'_>) -> Option<(Derivatives, Contradiction)> {
        None
    }

    /// Initial memory: state variables, the same number for each coupling, in the order of the couplings; empty for an
    /// elastic rod. It is that of the rod at rest, and held fixed while the minimum of an increment is searched for.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Updates the memory, on entry that of `shape`, to the equilibrium `shape` that ends an increment. Returns the
    /// energy dissipated in it, J, never negative. With the new memory and no [`BranchShape::duration`] the rod has the
    /// same forces and moments; a second call then changes no bit and returns 0. Never called for a trial that is
    /// discarded.
    fn commit(&self, _shape: &BranchShape<'_>, _memory: &mut [f64]) -> f64 {
        0.0
    }

    /// Curvature and twist of a coupling with this memory (its own part) under this moment (N m, body frame) at the end
    /// of an increment of this duration (s), 1/m; 0: the moment acts at once. `None` where
    /// [`crate::Section::bend_diagonal`] tells it.
    fn curvature_under(&self, _moment: &Vector, _memory: &[f64], _duration: f64) -> Option<Vector> {
        None
    }
}
