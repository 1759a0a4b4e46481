//! Energy of the rods, branch by branch: `E = Σ ½ ℓ Γᵀ C Γ + ½ λ (κ − κ°)ᵀ D (κ − κ°)` on the staggered grid
//! (Lang, Linn, Arnold 2011), with the derivatives `∂E/∂x_i = n_{i−1} − n_i`, `n_j = ∂E/∂(x_{j+1} − x_j)`, and
//! `∂E/∂θ_c` of each [`crate::RodSegment`].

use crate::conditions::{RodState, System};
use crate::constitutive::Derivatives;
use crate::equilibrium::Energy;
use crate::network::{Branch, WORTHWHILE};
use crate::rod::{BranchHessian, BranchShape, RodSegment};
use crate::terms::slope::Contradiction;
use crate::{Matrix, Network, Rotation, State, Tangent, Vector};

/// Term of the rods; keeps its workspace.
pub struct RodTerm {
    /// Difference of the drawn curvature and the rest curvature, indexed by the first frame of each coupling, 1/m;
    /// empty if the drawn shape is not held.
    drawn: Vec<Vector>,
    /// Fraction of it that is added to the rest curvature.
    drawn_fraction: f64,
    /// Curvature added to the rest curvature, indexed as `drawn`, 1/m: of the drawn shape and by temperature; empty if
    /// there is neither.
    extra_curvature: Vec<Vector>,
    /// Of each branch.
    evaluated: Vec<Evaluated>,
}

/// Last evaluation of a branch. A minimiser moves the points of a trial at the same frames, and begins an increment
/// where it ended the one before: what couplings exert is then known.
#[derive(Default)]
struct Evaluated {
    /// Energy, J.
    energy: f64,
    /// Frames and lengths (m) of the couplings at which the rest is known; empty: nowhere.
    frames: Vec<Rotation>,
    coupling_lengths: Vec<f64>,
    /// Energy of the couplings, J.
    coupling_energy: f64,
    /// Its derivatives in the frames, N m.
    moments: Vec<Vector>,
}

impl Evaluated {
    /// Evaluates a branch.
    fn gradient(
        &mut self,
        rod: &dyn RodSegment,
        shape: &BranchShape<'_>,
        points: &mut [Vector],
        frames: &mut [Vector],
    ) {
        // What a rod that remembers exerts depends on more than its shape.
        if !shape.memory.is_empty() {
            self.coupling_energy = rod.coupling_gradient(shape, frames);
        } else {
            if !self.is_at(shape) {
                self.moments.resize(frames.len(), Vector::zeros());
                self.coupling_energy = rod.coupling_gradient(shape, &mut self.moments);
                copy(shape.frames, &mut self.frames);
                copy(shape.coupling_lengths, &mut self.coupling_lengths);
            }
            frames.copy_from_slice(&self.moments);
        }
        self.energy = self.coupling_energy + rod.segment_gradient(shape, points, frames);
    }

    /// Whether the couplings are, to the bit, where they were.
    fn is_at(&self, shape: &BranchShape<'_>) -> bool {
        let bits = |q: &Rotation| q.coords.data.0[0].map(f64::to_bits);
        self.frames.len() == shape.frames.len()
            && self.frames.iter().zip(shape.frames).all(|(known, q)| bits(known) == bits(q))
            && self.coupling_lengths == shape.coupling_lengths
    }
}

fn copy<T: Copy>(from: &[T], to: &mut Vec<T>) {
    to.clear();
    to.extend_from_slice(from);
}

impl RodTerm {
    /// Term of the rods of a network, with their own rest curvature.
    pub fn new(network: &Network) -> Self {
        Self {
            drawn: Vec::new(),
            drawn_fraction: 0.0,
            extra_curvature: Vec::new(),
            evaluated: network.branches.iter().map(|_| Evaluated::default()).collect(),
        }
    }

    /// Recomputes the curvature added to the rest curvature, after a change of the conditions or of the fraction of the
    /// drawn curvature.
    pub fn update(&mut self, system: System<'_>) {
        self.forget();
        let bends =
            |(branch, change): (&Branch, &f64)| *change != 0.0 && branch.sections.at_end(true).bends_with_temperature();
        let with_temperatures = || system.network.branches.iter().zip(&system.conditions.temperatures);
        self.extra_curvature.clear();
        self.extra_curvature.extend(self.drawn.iter().map(|drawn| drawn * self.drawn_fraction));
        if with_temperatures().any(bends) {
            self.extra_curvature.resize(system.network.frames, Vector::zeros());
            for (branch, change) in with_temperatures().filter(|pair| bends(*pair)) {
                let bent = branch.sections.at_end(true).thermal_curvature * *change;
                self.extra_curvature[branch.frames.clone()].iter_mut().for_each(|extra| *extra += bent);
            }
        }
    }

    /// Forgets earlier evaluations: the next one is from scratch.
    pub fn forget(&mut self) {
        self.evaluated.iter_mut().for_each(|known| known.frames.clear());
    }

    /// Curvature added to the rest curvature, indexed by the first frame of each coupling, 1/m; empty: none.
    pub fn extra_curvature(&self) -> &[Vector] {
        &self.extra_curvature
    }

    /// Uses the curvature and twist of the branches at `state` as their rest curvature, until
    /// [`Self::set_drawn_fraction`] removes it: a continuation from the drawn shape to the equilibrium.
    pub fn hold_drawn_shape(&mut self, system: System<'_>, state: &State) {
        let network = system.network;
        self.drawn = vec![Vector::zeros(); network.frames];
        for branch in &network.branches {
            for c in 0..branch.rod.mesh().coupling_lengths.len() {
                let lambda = &state.coupling_lengths[branch.frames.start + c];
                let frames = &state.frames[branch.frames.start + c..];
                let now = (frames[0].inverse() * frames[1]).scaled_axis();
                let rest = branch.rod.rest_rotation(c).scaled_axis();
                self.drawn[branch.frames.start + c] = (now - rest) / *lambda;
            }
        }
        self.set_drawn_fraction(system, 1.0);
    }

    /// Sets the fraction, 1 to 0, of the drawn curvature that is added to the rest curvature; at 0 it is discarded.
    pub fn set_drawn_fraction(&mut self, system: System<'_>, fraction: f64) {
        if fraction == 0.0 {
            self.drawn.clear();
        }
        self.drawn_fraction = fraction;
        self.update(system);
    }

    /// Shape of one branch.
    #[inline]
    pub fn shape<'s>(&'s self, system: System<'s>, state: &'s State, branch: usize) -> BranchShape<'s> {
        let frames = system.network.branches[branch].frames.clone();
        BranchShape {
            free_strain: system.network.branches[branch].sections.at_end(true).thermal_expansion
                * system.conditions.temperatures[branch],
            extra_curvature: self.extra_curvature.get(frames).unwrap_or_default(),
            memory: &system.conditions.rods[branch].memory,
            duration: system.conditions.time - system.conditions.committed_time,
            ..state.branch(system.network, branch)
        }
    }

    /// Adds the energies of the rods by effect, J.
    pub fn energy(&self, system: System<'_>, state: &State, energy: &mut Energy) {
        for (b, branch) in system.network.branches.iter().enumerate() {
            let rod = branch.rod.energy(&self.shape(system, state, b));
            energy.stretch += rod.stretch;
            energy.shear += rod.shear;
            energy.bend += rod.bend;
            energy.twist += rod.twist;
        }
    }

    /// Writes the first derivatives ∂E/∂x (N) and ∂E/∂θ (N m) in the points and frames of the branches, tied
    /// ones included; returns the energy, J.
    pub fn gradient(&mut self, system: System<'_>, state: &State, gradient: &mut Tangent) -> f64 {
        let mut evaluated = std::mem::take(&mut self.evaluated);
        self.branch_gradients(system, state, 0, &mut evaluated, &mut gradient.points, &mut gradient.frames);
        self.evaluated = evaluated;
        // Summed in the order of the branches: the same bits for any number of threads.
        self.evaluated.iter().map(|branch| branch.energy).sum()
    }

    /// Energies and gradients of the branches from `first` on, one for each entry of `evaluated`; `points` and `frames`
    /// are their slices.
    fn branch_gradients(
        &self,
        system: System<'_>,
        state: &State,
        first: usize,
        evaluated: &mut [Evaluated],
        points: &mut [Vector],
        frames: &mut [Vector],
    ) {
        let branches = &system.network.branches[first..first + evaluated.len()];
        let (Some(start), Some(end)) = (branches.first(), branches.last()) else { return };
        let all = start.points.start..end.points.end;
        if branches.len() > 1 && all.len() >= 2 * WORTHWHILE {
            let half = branches.partition_point(|branch| branch.points.end <= all.start + all.len() / 2);
            let half = half.clamp(1, branches.len() - 1);
            let (evaluated, others) = evaluated.split_at_mut(half);
            let (points, other_points) = points.split_at_mut(branches[half].points.start - all.start);
            let (frames, other_frames) = frames.split_at_mut(branches[half].frames.start - start.frames.start);
            rayon::join(
                || self.branch_gradients(system, state, first, evaluated, points, frames),
                || self.branch_gradients(system, state, first + half, others, other_points, other_frames),
            );
            return;
        }
        let (mut points, mut frames) = (points, frames);
        for (k, (branch, evaluated)) in branches.iter().zip(evaluated).enumerate() {
            let (own_points, later_points) = points.split_at_mut(branch.points.len());
            let (own_frames, later_frames) = frames.split_at_mut(branch.frames.len());
            let shape = self.shape(system, state, first + k);
            evaluated.gradient(&*branch.rod, &shape, own_points, own_frames);
            (points, frames) = (later_points, later_frames);
        }
    }

    /// Writes the second derivatives, branch by branch. `forces` (N, body frame; one vector for each branch, one entry
    /// for each segment) replaces the rods' own forces in the geometric stiffness; see [`crate::RodSegment::hessian`].
    pub fn hessian(
        &self,
        system: System<'_>,
        state: &State,
        forces: Option<&[Vec<Vector>]>,
        hessian: &mut [BranchHessian],
    ) {
        system.network.for_branches(hessian, |b, branch, own| {
            branch.rod.hessian(&self.shape(system, state, b), forces.map(|f| f[b].as_slice()), own);
        });
    }

    /// Second derivatives in the edges of a branch, N/m; see [`crate::RodSegment::edge_stiffness`].
    pub fn edge_stiffness(&self, system: System<'_>, state: &State, branch: usize, stiffness: &mut [Matrix]) {
        system.network.branches[branch].rod.edge_stiffness(&self.shape(system, state, branch), stiffness);
    }

    /// First rod with a constitutive law whose derivatives at `state` are not those of its values.
    pub fn contradiction(&self, system: System<'_>, state: &State) -> Option<(usize, Derivatives, Contradiction)> {
        system.network.branches.iter().enumerate().find_map(|(b, branch)| {
            let (which, found) = branch.rod.contradiction(&self.shape(system, state, b))?;
            Some((b, which, found))
        })
    }

    /// Memory of every rod that has one, by branch, updated to `state`, the equilibrium that ends an increment; with
    /// the energy dissipated in the increment, J.
    pub fn memories(&self, system: System<'_>, state: &State) -> Vec<(usize, Vec<f64>, f64)> {
        let remember = |(_, own): &(usize, &RodState)| !own.memory.is_empty();
        let updated = |(b, own): (usize, &RodState)| {
            let mut memory = own.memory.clone();
            let dissipated = system.network.branches[b].rod.commit(&self.shape(system, state, b), &mut memory);
            (b, memory, dissipated)
        };
        system.conditions.rods.iter().enumerate().filter(remember).map(updated).collect()
    }
}
