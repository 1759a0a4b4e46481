//! Energies of the parts of a harness as coefficients, for evaluation elsewhere, for example on a GPU.
//!
//! A part that returns a law has the energy written here, to round-off; a part with another energy returns `None` and
//! is refused by name where the law is needed.

use crate::section::{SectionFriction, SectionLaws};
use crate::{Matrix, Rotation, Vector};

/// A rod on the staggered grid: a stretch-shear energy in every segment and a bend-twist energy in every coupling.
///
/// Segment: `E = ½ ℓ (Γᵀ C Γ + B min(Γ3 + 1 + ε, 0)²)`, `Γ = u − (1 + ε) e3`, `u − Σ β (u − Rᵀ R_Q u) = Rᵀ e/ℓ`, ε the
/// free strain, over the stations Q beside it ([`crate::rod::Beside`]). Coupling: see [`PairLaw`]; a pair of couplings
/// ([`crate::rod::CellPair`]) adds the energy of the variation of curvature between them, with the factor f, and then
/// β is 1/9 for a station, and 1/72 for the next segment where [`crate::rod::Beside::next`] names one, else 1/12;
/// friction adds `λ Σ H(|κ − κ° − p|)` over its elements, with `H(e) = ½ k e²` up to `e = M/k` and `M e − M²/(2 k)`
/// beyond, and p from the memory of the rod. An axial law adds `ℓ W(Γ3)`, a curve of bending `λ F(|κ − κ°|)` with
/// `F′` its moment, of the part of the curvature about d1 and d2, and creep `λ ½ k g |κ − κ° − p|²` over its elements,
/// with g and p as in the documentation of `wireloom_models::creep`.
#[derive(Clone, Debug, PartialEq)]
pub struct RodLaw {
    /// Each segment.
    pub segments: Vec<SegmentLaw>,
    /// C of each coupling about its axes, N m²: diag(EI1, EI2, GJ) where these are those of the frames.
    pub couplings: Vec<Vector>,
    /// Q of each coupling, which couples the frames `q Q` in place of q; empty: they are coupled as they are.
    pub axes: Vec<Rotation>,
    /// β of a station at an end of the branch, and of one within it, on meshes too coarse for pairs or without f.
    pub blends: [f64; 2],
    /// f; 0: a scheme of second order.
    pub variation: f64,
    /// κ°, 1/m; [`crate::BranchShape::extra_curvature`] is added to it.
    pub curvature: Vector,
    /// Friction. The memory of each coupling holds p of each element: two numbers (about d1, d2) in bending, then one
    /// in torsion, 1/m.
    pub friction: SectionFriction,
    /// Curves and creep; what yields stands with friction. In the memory of each coupling, behind that of friction,
    /// stand for creep the curvature at the end of the last increment (two numbers) and that of each dashpot in
    /// bending, and the same in torsion.
    pub laws: SectionLaws,
}

impl RodLaw {
    /// C of a coupling about the axes of its frames, N m².
    pub fn coupling_stiffness(&self, coupling: usize) -> Matrix {
        let diagonal = Matrix::from_diagonal(&self.couplings[coupling]);
        self.axes.get(coupling).map_or(diagonal, |axes| {
            let axes = axes.to_rotation_matrix().into_inner();
            axes * diagonal * axes.transpose()
        })
    }
}

/// Stiffness of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentLaw {
    /// C: diag(GA1, GA2, EA), N.
    pub stiffness: Vector,
    /// B, N: stiffness against an edge that points against its frame.
    pub overturned: f64,
}

/// A joint, without what it has where it continues rods ([`crate::JointModel::continue_rods`]).
#[derive(Clone, Debug, PartialEq)]
pub struct JointLaw {
    /// The pairs of coupled frames, by their index in what the energy depends on: arms, then a compliant hub. Empty on
    /// a rigid hub.
    pub pairs: Vec<PairLaw>,
}

/// Bending and twist between two frames: `E = ½ λ (κ−κ°)ᵀ C (κ−κ°)`, `κ = (2/λ) (1 + |v|²/6) v`, `v`
/// the imaginary part of `r = conj(q_a α) (q_b β)` with the sign that makes its real part ≥ 0.
#[derive(Clone, Debug, PartialEq)]
pub struct PairLaw {
    /// Index of the first frame.
    pub a: usize,
    /// Index of the second frame.
    pub b: usize,
    /// α.
    pub alpha: Rotation,
    /// β.
    pub beta: Rotation,
    /// λ, m.
    pub length: f64,
    /// C: diag(EI1, EI2, GJ), N m².
    pub stiffness: Vector,
    /// κ°, 1/m.
    pub curvature: Vector,
    /// Friction, with the energy that it has in a [`RodLaw`]. The memory of the joint holds p of each element of each
    /// pair, in the order of the pairs: two numbers (about d1, d2) for each in bending, then one in torsion, 1/m.
    pub friction: SectionFriction,
}

/// A spring between a station, at x and q, and its target: `½ k |x − x_target|²` and the energy of a
/// [`TurningLaw`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringLaw {
    /// k, N/m.
    pub stiffness: f64,
    /// Rotational energy.
    pub turning: TurningLaw,
}

/// Rotational energy of a station and its target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TurningLaw {
    /// Nothing.
    None,
    /// `½ k |d3 − d3_target|²`; k in N m/rad.
    Tangent(f64),
    /// The energy of a [`PairLaw`] from target to station with λ = 1 m, C = k I and κ° = 0; k in N m/rad.
    Frame(f64),
}
