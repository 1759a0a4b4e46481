//! Rods on the staggered grid: stretch and shear in every segment, bending and twist in every coupling, and the
//! variation of curvature in every pair of couplings. Kinds of rods differ in the stiffnesses of these parts
//! ([`Stiffness`]).

use crate::kernel::{
    BendTwist, BlendedStretchShear, SegmentStiffness, Stencil, StretchShear, edge_stiffness, rotation_matrix,
    turn_of_curvature,
};
use crate::variation::Variation;
use std::ops::Range;
use wireloom_core::law::{RodLaw, SegmentLaw};
use wireloom_core::rod::{
    Beside, BranchHessian, BranchShape, CellPair, CouplingHessian, Mesh, RodEnergy, RodSegment, RodSpec,
};
use wireloom_core::section::{SectionFriction, SectionLaws};
use wireloom_core::{BuildError, Matrix, Rotation, Vector};

/// The stiffness of every part of a branch.
pub struct Stiffness {
    /// Of each segment.
    pub segments: Vec<SegmentStiffness>,
    /// C of each coupling about its principal axes, N m²: diag(EI1, EI2, GJ) where these are the axes of the frames.
    pub couplings: Vec<Vector>,
    /// Q of each coupling: frames `q Q` have its principal axes ([`wireloom_core::Section::principal_axes`]),
    /// the same in a pair of couplings; empty: the axes of the frames.
    pub axes: Vec<Rotation>,
    /// Coefficient of a station at an end of the branch, and of one within it, in the segments beside it
    /// ([`Stencil`]), where the scheme is of second order.
    pub blends: [f64; 2],
    /// Factor f of the variation of curvature ([`Variation`]); 0: the scheme is of second order everywhere.
    pub variation: f64,
}

impl Stiffness {
    /// Refuses sections whose bending and twist are coupled, of a kind of rod that does not know them.
    ///
    /// # Errors
    /// The first such section.
    pub(super) fn uncoupled(spec: &RodSpec, rod: &str) -> Result<(), BuildError> {
        let Some(section) = spec.sections.iter().find(|section| section.couples()) else { return Ok(()) };
        let message = format!("its section \"{}\" has a `coupling_stiffness`, which {rod} does not know", section.name);
        Err(BuildError::new(message, "rod = \"cosserat\" knows it").at("rod"))
    }
}

/// One branch on the staggered grid.
pub struct StaggeredRod {
    mesh: Mesh,
    /// Runs of segments that are not beside a station.
    plain: Vec<Range<usize>>,
    /// Coefficients of the neighbours of each segment beside a station, in the order of [`Mesh::beside`].
    stencils: Vec<[f64; 2]>,
    stiffness: Stiffness,
    /// κ°, 1/m.
    curvature: Vector,
}

impl StaggeredRod {
    /// From its specification, with these stiffnesses in place of those of the section.
    pub fn new(spec: RodSpec, stiffness: Stiffness) -> Self {
        let mut plain = Vec::new();
        let mut start = 0;
        for beside in spec.mesh.beside.iter().map(|b| b.segment).chain([spec.mesh.segments()]) {
            if start < beside {
                plain.push(start..beside);
            }
            start = beside + 1;
        }
        let mesh = spec.mesh;
        let stencils = mesh.beside.iter().map(|beside| stencil(&mesh, beside, &stiffness)).collect();
        Self { plain, stencils, stiffness, curvature: spec.curvature, mesh }
    }

    pub(super) fn plain(&self) -> impl Iterator<Item = usize> {
        self.plain.iter().flat_map(Clone::clone)
    }

    #[inline(always)]
    pub(super) fn segment(&self, shape: &BranchShape<'_>, j: usize) -> StretchShear {
        let q = &shape.frames[self.mesh.segment_frames[j]];
        StretchShear::new(&shape.edge(j), q, [shape.rest_lengths[j], shape.free_strain], &self.stiffness.segments[j])
    }

    /// The segment of [`Mesh::beside`] with this index.
    fn blended(&self, shape: &BranchShape<'_>, index: usize) -> BlendedStretchShear {
        let beside = &self.mesh.beside[index];
        let j = beside.segment;
        let q = &shape.frames[self.mesh.segment_frames[j]];
        let (frames, stencil) = (beside.neighbours(), &self.stencils[index]);
        let neighbours = [0, 1].map(|k| frames[k].map(|c| (&shape.frames[c], stencil[k])));
        let length = [shape.rest_lengths[j], shape.free_strain];
        BlendedStretchShear::new(&shape.edge(j), q, neighbours, length, &self.stiffness.segments[j])
    }

    /// Segments beside stations with their laws.
    pub(super) fn all_blended<'s>(
        &'s self,
        shape: &'s BranchShape<'_>,
    ) -> impl Iterator<Item = (&'s Beside, BlendedStretchShear)> + 's {
        self.mesh.beside.iter().enumerate().map(|(index, beside)| (beside, self.blended(shape, index)))
    }

    /// Pairs whose variation counts.
    fn pairs(&self) -> &[CellPair] {
        if self.stiffness.variation == 0.0 { &[] } else { &self.mesh.pairs }
    }

    /// Variation of a pair between these couplings.
    #[inline(always)]
    fn variation(&self, shape: &BranchShape<'_>, pair: &CellPair, couplings: [&BendTwist; 2]) -> Variation {
        let c = pair.frame;
        let lengths = [shape.coupling_lengths[c - 1], shape.coupling_lengths[c]];
        Variation::new(couplings, lengths, pair.shares, self.stiffness.variation, &self.stiffness.couplings[c])
    }

    /// Passes every coupling with its whole moment, that of the variation beside it included, to `act`; returns the
    /// (bend, twist) energy, J.
    #[inline(always)]
    fn each_coupling(&self, shape: &BranchShape<'_>, mut act: impl FnMut(usize, &BendTwist)) -> (f64, f64) {
        let lengths = shape.coupling_lengths;
        if lengths.is_empty() {
            return (0.0, 0.0);
        }
        let mut pairs = self.pairs().iter().peekable();
        let mut before = self.coupling(shape, 0);
        let (mut bend, mut twist) = before.energy(lengths[0]);
        // Moment of the coupling before so far.
        let mut moment_before = before.moment;
        for (c, &lambda) in lengths.iter().enumerate().skip(1) {
            let law = self.coupling(shape, c);
            let (own_bend, own_twist) = law.energy(lambda);
            bend += own_bend;
            twist += own_twist;
            let mut moment = law.moment;
            if let Some(pair) = pairs.next_if(|pair| pair.frame == c) {
                let variation = self.variation(shape, pair, [&before, &law]);
                let (of_bend, of_twist) = variation.energy();
                bend += of_bend;
                twist += of_twist;
                let [first, second] = variation.moments();
                moment_before += first;
                moment += second;
            }
            act(c - 1, &before.with_moment(moment_before));
            (before, moment_before) = (law, moment);
        }
        act(lengths.len() - 1, &before.with_moment(moment_before));
        (bend, twist)
    }

    /// κ° (1/m) and C of a coupling (N m²), for rods of which all couplings are alike.
    pub(super) fn bending_law(&self) -> [Vector; 2] {
        [self.curvature, self.stiffness.couplings.first().copied().unwrap_or_default()]
    }

    #[inline(always)]
    pub(super) fn coupling(&self, shape: &BranchShape<'_>, c: usize) -> BendTwist {
        let (a, b) = (&shape.frames[c], &shape.frames[c + 1]);
        let rest = match shape.extra_curvature.get(c) {
            None => self.curvature,
            Some(extra) => self.curvature + extra,
        };
        let (lambda, stiffness) = (shape.coupling_lengths[c], &self.stiffness.couplings[c]);
        match self.stiffness.axes.get(c) {
            None => BendTwist::new(a, b, lambda, stiffness, &rest),
            Some(axes) => {
                BendTwist::new(&(a * axes), &(b * axes), lambda, stiffness, &axes.inverse_transform_vector(&rest))
            }
        }
    }

    /// [`BendTwist::gradient`] of a coupling about the axes of its frames.
    #[inline(always)]
    fn gradient(&self, c: usize, law: &BendTwist) -> (Vector, Vector) {
        let (a, b) = law.gradient();
        match self.stiffness.axes.get(c) {
            None => (a, b),
            Some(axes) => (axes * a, axes * b),
        }
    }

    /// Turns the second derivatives of couplings and pairs from the principal axes to those of the frames.
    fn turn_hessian(&self, hessian: &mut BranchHessian) {
        let turn = |axes: &Rotation, block: &mut Matrix| {
            let axes = rotation_matrix(axes);
            *block = axes * *block * axes.transpose();
        };
        for (axes, CouplingHessian { aa, ab, bb }) in self.stiffness.axes.iter().zip(&mut hessian.couplings) {
            [aa, ab, bb].into_iter().for_each(|block| turn(axes, block));
        }
        if !self.stiffness.axes.is_empty() {
            for (pair, across) in self.mesh.pairs.iter().zip(&mut hessian.pairs) {
                turn(&self.stiffness.axes[pair.frame], across);
            }
        }
    }
}

/// Coefficients of the neighbours of a segment.
fn stencil(mesh: &Mesh, beside: &Beside, stiffness: &Stiffness) -> [f64; 2] {
    let of_second_order = |c: usize| stiffness.blends[usize::from(c > 0 && c + 1 < mesh.frames())];
    if stiffness.variation == 0.0 || !mesh.is_fine(beside.segment) {
        return beside.stations.map(|station| station.map_or(0.0, of_second_order));
    }
    let stencil = if beside.next.is_some() { Stencil::WIDE } else { Stencil::NARROW };
    beside.stations.map(|station| if station.is_some() { stencil.station } else { stencil.next })
}

/// A coupling whose second derivatives are being summed up.
struct OpenCoupling {
    law: BendTwist,
    /// Moment so far, N m.
    moment: Vector,
    /// Derivative of the moment in the curvature so far, N m².
    tangent: Matrix,
}

impl OpenCoupling {
    #[inline(always)]
    fn new(law: BendTwist, stiffness: &Vector) -> Self {
        Self { law, moment: law.moment, tangent: Matrix::from_diagonal(stiffness) }
    }

    /// Adds the second derivatives of the coupling.
    #[inline(always)]
    fn close(&self, hessian: &mut CouplingHessian) {
        let CouplingHessian { aa, ab, bb } = self.law.with_moment(self.moment).hessian_with(&self.tangent);
        hessian.aa += aa;
        hessian.ab += ab;
        hessian.bb += bb;
    }
}

impl StaggeredRod {
    /// Second derivatives of bending and twist with the variation. With `J_a` and `J_b` those of κ in the frames of a
    /// coupling, a pair has `J_aᵀ (∂²E/∂κ∂κ′) J′_b` across its couplings.
    fn bending_hessian(&self, shape: &BranchShape<'_>, hessian: &mut BranchHessian) {
        let (lengths, stiffness) = (shape.coupling_lengths, &self.stiffness.couplings);
        let all = &mut hessian.couplings;
        all.fill(CouplingHessian::default());
        let mut pairs = self.mesh.pairs.iter().zip(&mut hessian.pairs).peekable();
        let mut before = OpenCoupling::new(self.coupling(shape, 0), &stiffness[0]);
        for c in 1..lengths.len() {
            let mut own = OpenCoupling::new(self.coupling(shape, c), &stiffness[c]);
            if let Some((pair, across)) = pairs.next_if(|(pair, _)| pair.frame == c) {
                let variation = self.variation(shape, pair, [&before.law, &own.law]);
                let [first, second] = variation.moments();
                let [aa, ab, bb] = variation.hessian();
                before.moment += first;
                before.tangent += aa * before.law.by_length;
                own.moment += second;
                own.tangent += bb * own.law.by_length;
                let [outer, inner] = before.law.hessian_across(&own.law, &ab);
                all[c - 1].ab += outer[0];
                *across = outer[1];
                all[c].aa = inner[0] + inner[0].transpose();
                all[c].ab = inner[1];
            }
            before.close(&mut all[c - 1]);
            before = own;
        }
        let last = lengths.len() - 1;
        before.close(&mut all[last]);
    }
}

impl RodSegment for StaggeredRod {
    fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    fn couples_pairs(&self) -> bool {
        self.stiffness.variation > 0.0
    }

    fn energy(&self, shape: &BranchShape<'_>) -> RodEnergy {
        let mut energy = RodEnergy::default();
        let lengths = shape.rest_lengths;
        let plain = self.plain().map(|j| self.segment(shape, j).energy(lengths[j]));
        let blended = self.all_blended(shape).map(|(beside, law)| law.energy(lengths[beside.segment]));
        for (shear, stretch) in plain.chain(blended) {
            energy.shear += shear;
            energy.stretch += stretch;
        }
        (energy.bend, energy.twist) = self.each_coupling(shape, |_, _| {});
        energy
    }

    fn coupling_gradient(&self, shape: &BranchShape<'_>, frames: &mut [Vector]) -> f64 {
        frames.fill(Vector::zeros());
        let (bend, twist) = self.each_coupling(shape, |c, law| {
            let (a, b) = self.gradient(c, law);
            frames[c] += a;
            frames[c + 1] += b;
        });
        bend + twist
    }

    fn segment_gradient(&self, shape: &BranchShape<'_>, points: &mut [Vector], frames: &mut [Vector]) -> f64 {
        let mut energy = 0.0;
        points.fill(Vector::zeros());
        for run in &self.plain {
            for j in run.clone() {
                let l = shape.rest_lengths[j];
                let law = self.segment(shape, j);
                let (shear, stretch) = law.energy(l);
                energy += shear + stretch;
                let (force, moment) = law.gradient(l);
                points[j] -= force;
                points[j + 1] += force;
                frames[self.mesh.segment_frames[j]] += moment;
            }
        }
        for (beside, law) in self.all_blended(shape) {
            let j = beside.segment;
            let l = shape.rest_lengths[j];
            let (shear, stretch) = law.energy(l);
            energy += shear + stretch;
            let (force, moment, at_neighbours) = law.gradient(l);
            points[j] -= force;
            points[j + 1] += force;
            frames[self.mesh.segment_frames[j]] += moment;
            for (frame, moment) in beside.neighbours().iter().zip(at_neighbours) {
                if let Some(c) = frame {
                    frames[*c] += moment;
                }
            }
        }
        energy
    }

    fn hessian(&self, shape: &BranchShape<'_>, forces: Option<&[Vector]>, hessian: &mut BranchHessian) {
        for run in &self.plain {
            for j in run.clone() {
                let law = self.segment(shape, j);
                let n = forces.map_or(law.n, |f| f[j]);
                hessian.segments[j] = law.hessian(shape.rest_lengths[j], &n);
            }
        }
        for ((beside, law), room) in self.all_blended(shape).zip(&mut hessian.beside) {
            let j = beside.segment;
            let n = forces.map_or(law.n, |f| f[j]);
            (hessian.segments[j], *room) = law.hessian(shape.rest_lengths[j], &n);
        }
        if self.pairs().is_empty() {
            for (c, own) in hessian.couplings.iter_mut().enumerate() {
                *own = self.coupling(shape, c).hessian(&self.stiffness.couplings[c]);
            }
        } else {
            self.bending_hessian(shape, hessian);
        }
        self.turn_hessian(hessian);
    }

    fn edge_stiffness(&self, shape: &BranchShape<'_>, stiffness: &mut [Matrix]) {
        for j in self.plain() {
            let law = self.segment(shape, j);
            stiffness[j] = edge_stiffness(&law.r, shape.rest_lengths[j], &law.c);
        }
        for (beside, law) in self.all_blended(shape) {
            let j = beside.segment;
            stiffness[j] = law.edge_stiffness(shape.rest_lengths[j]);
        }
    }

    /// `C (Γ + δΓ)` with `δΓ = Rᵀ δe/ℓ + v × θ` away from stations.
    fn predicted_forces(&self, shape: &BranchShape<'_>, points: &[Vector], frames: &[Vector], forces: &mut [Vector]) {
        for j in self.plain() {
            let law = self.segment(shape, j);
            let de = points[j + 1] - points[j];
            let change = law.strain_change(shape.rest_lengths[j], &de, &frames[self.mesh.segment_frames[j]]);
            forces[j] = law.n + law.c.component_mul(&change);
        }
        for (beside, law) in self.all_blended(shape) {
            let j = beside.segment;
            let at_neighbours = beside.neighbours().map(|c| c.map_or_else(Vector::zeros, |c| frames[c]));
            let (de, theta) = (points[j + 1] - points[j], &frames[self.mesh.segment_frames[j]]);
            let change = law.strain_change(shape.rest_lengths[j], &de, theta, at_neighbours);
            forces[j] = law.n + law.c.component_mul(&change);
        }
    }

    fn forces(&self, shape: &BranchShape<'_>, forces: &mut [Vector]) {
        for j in self.plain() {
            let law = self.segment(shape, j);
            forces[j] = law.r * law.n;
        }
        for (beside, law) in self.all_blended(shape) {
            forces[beside.segment] = law.world_force();
        }
    }

    fn length_terms(&self, shape: &BranchShape<'_>, segments: &mut [[f64; 2]], couplings: &mut [[f64; 3]]) {
        for j in self.plain() {
            segments[j] = self.segment(shape, j).length_terms(shape.rest_lengths[j]);
        }
        for (beside, law) in self.all_blended(shape) {
            let j = beside.segment;
            segments[j] = law.length_terms(shape.rest_lengths[j]);
        }
        for (c, &lambda) in shape.coupling_lengths.iter().enumerate() {
            let [first, second] = self.coupling(shape, c).length_terms(lambda, &self.stiffness.couplings[c]);
            couplings[c] = [first, second, 0.0];
        }
        for pair in self.pairs() {
            let [before, after] = [pair.frame - 1, pair.frame];
            let laws = [before, after].map(|c| self.coupling(shape, c));
            let own = self.variation(shape, pair, [&laws[0], &laws[1]]).length_derivatives();
            for (k, c) in [before, after].into_iter().enumerate() {
                couplings[c][0] += own.first[k];
                couplings[c][1] += own.second[k];
            }
            couplings[before][2] += own.mixed;
        }
    }

    fn length_mixed(
        &self,
        shape: &BranchShape<'_>,
        segment_rates: &[f64],
        coupling_rates: &[f64],
        points: &mut [Vector],
        frames: &mut [Vector],
    ) {
        for j in self.plain().filter(|&j| segment_rates[j] != 0.0) {
            let (rate, l) = (segment_rates[j], shape.rest_lengths[j]);
            let (force, moment) = self.segment(shape, j).per_length(l).gradient(l);
            points[j] -= force * rate;
            points[j + 1] += force * rate;
            frames[self.mesh.segment_frames[j]] += moment * rate;
        }
        for (beside, law) in self.all_blended(shape).filter(|(beside, _)| segment_rates[beside.segment] != 0.0) {
            let j = beside.segment;
            let (rate, l) = (segment_rates[j], shape.rest_lengths[j]);
            let (force, moment, at_neighbours) = law.per_length(l).gradient(l);
            points[j] -= force * rate;
            points[j + 1] += force * rate;
            frames[self.mesh.segment_frames[j]] += moment * rate;
            for (frame, moment) in beside.neighbours().iter().zip(at_neighbours) {
                if let Some(c) = frame {
                    frames[*c] += moment * rate;
                }
            }
        }
        for (c, &lambda) in shape.coupling_lengths.iter().enumerate().filter(|(c, _)| coupling_rates[*c] != 0.0) {
            let law = self.coupling(shape, c).per_length(lambda, &self.stiffness.couplings[c]);
            let (a, b) = self.gradient(c, &law);
            frames[c] += a * coupling_rates[c];
            frames[c + 1] += b * coupling_rates[c];
        }
        for pair in self.pairs() {
            let places = [pair.frame - 1, pair.frame];
            let rates = places.map(|c| coupling_rates[c]);
            if rates == [0.0; 2] {
                continue;
            }
            let laws = places.map(|c| self.coupling(shape, c));
            let changes = self.variation(shape, pair, [&laws[0], &laws[1]]).moments_per_length(rates);
            for ((c, law), change) in places.into_iter().zip(laws).zip(changes) {
                let (a, b) = self.gradient(c, &law.with_moment(change));
                frames[c] += a;
                frames[c + 1] += b;
            }
        }
    }

    /// `R_b ∂E/∂θ_b` of the parts of the energy that belong to couplings, which by objectivity equals `−R_a ∂E/∂θ_a`;
    /// and what a segment beside a station exerts on its neighbours.
    fn moments(&self, shape: &BranchShape<'_>, moments: &mut [Vector]) {
        self.each_coupling(shape, |c, law| {
            moments[c] = rotation_matrix(&shape.frames[c + 1]) * self.gradient(c, law).1
        });
        for (beside, law) in self.all_blended(shape) {
            let (_, _, at_neighbours) = law.gradient(shape.rest_lengths[beside.segment]);
            let [first, second] = beside.neighbours();
            if let Some(c) = first {
                moments[c] -= shape.frames[c] * at_neighbours[0];
            }
            if let Some(c) = second {
                moments[c - 1] += shape.frames[c] * at_neighbours[1];
            }
        }
    }

    fn law(&self) -> Option<RodLaw> {
        let segment = |s: &SegmentStiffness| SegmentLaw { stiffness: s.c, overturned: s.overturned };
        Some(RodLaw {
            segments: self.stiffness.segments.iter().map(segment).collect(),
            couplings: self.stiffness.couplings.clone(),
            axes: self.stiffness.axes.clone(),
            blends: self.stiffness.blends,
            variation: self.stiffness.variation,
            curvature: self.curvature,
            friction: SectionFriction::default(),
            laws: SectionLaws::default(),
        })
    }

    fn rest_rotation(&self, coupling: usize) -> Rotation {
        turn_of_curvature(&self.curvature, self.mesh.coupling_lengths[coupling])
    }
}
