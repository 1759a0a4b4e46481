//! Rods on the staggered grid: stretch and shear in every segment, bending and twist in every coupling. Kinds of rods
//! differ in the stiffnesses of these parts ([`Stiffness`]).

use crate::kernel::{BendTwist, BlendedStretchShear, SegmentStiffness, StretchShear, edge_stiffness, rotation_matrix};
use nalgebra::{Quaternion, Unit};
use std::ops::Range;
use wireloom_core::law::{RodLaw, SegmentLaw};
use wireloom_core::rod::{Beside, BranchHessian, BranchShape, Mesh, RodEnergy, RodSegment, RodSpec};
use wireloom_core::section::SectionFriction;
use wireloom_core::{Matrix, Rotation, Vector};

/// The stiffness of every part of a branch.
pub struct Stiffness {
    /// Of each segment.
    pub segments: Vec<SegmentStiffness>,
    /// C of each coupling: diag(EI1, EI2, GJ), N m².
    pub couplings: Vec<Vector>,
    /// Fraction β of the tangent of a station at an end of the branch, and of one within it, in that of the segments
    /// beside it.
    pub blends: [f64; 2],
}

/// One branch on the staggered grid.
pub struct StaggeredRod {
    mesh: Mesh,
    /// Runs of segments that are not beside a station.
    plain: Vec<Range<usize>>,
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
        Self { plain, stiffness, curvature: spec.curvature, mesh: spec.mesh }
    }

    fn plain(&self) -> impl Iterator<Item = usize> {
        self.plain.iter().flat_map(Clone::clone)
    }

    #[inline(always)]
    fn segment(&self, shape: &BranchShape<'_>, j: usize) -> StretchShear {
        let q = &shape.frames[self.mesh.segment_frames[j]];
        StretchShear::new(&shape.edge(j), q, [shape.rest_lengths[j], shape.free_strain], &self.stiffness.segments[j])
    }

    fn blended(&self, shape: &BranchShape<'_>, beside: &Beside) -> BlendedStretchShear {
        let j = beside.segment;
        let q = &shape.frames[self.mesh.segment_frames[j]];
        let end = |c: usize| c == 0 || c + 1 == shape.frames.len();
        let [end_blend, inner_blend] = self.stiffness.blends;
        let blend = |c: usize| if end(c) { end_blend } else { inner_blend };
        let stations = beside.stations.map(|station| station.map(|c| (&shape.frames[c], blend(c))));
        let length = [shape.rest_lengths[j], shape.free_strain];
        BlendedStretchShear::new(&shape.edge(j), q, stations, length, &self.stiffness.segments[j])
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
        BendTwist::new(a, b, shape.coupling_lengths[c], &self.stiffness.couplings[c], &rest)
    }
}

impl RodSegment for StaggeredRod {
    fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    fn energy(&self, shape: &BranchShape<'_>) -> RodEnergy {
        let mut energy = RodEnergy::default();
        let lengths = shape.rest_lengths;
        let plain = self.plain().map(|j| self.segment(shape, j).energy(lengths[j]));
        let blended = self.mesh.beside.iter().map(|b| self.blended(shape, b).energy(lengths[b.segment]));
        for (shear, stretch) in plain.chain(blended) {
            energy.shear += shear;
            energy.stretch += stretch;
        }
        for (c, &lambda) in shape.coupling_lengths.iter().enumerate() {
            let (bend, twist) = self.coupling(shape, c).energy(lambda);
            energy.bend += bend;
            energy.twist += twist;
        }
        energy
    }

    fn gradient(&self, shape: &BranchShape<'_>, points: &mut [Vector], frames: &mut [Vector]) -> f64 {
        let mut energy = 0.0;
        points.fill(Vector::zeros());
        frames.fill(Vector::zeros());
        for run in &self.plain {
            for j in run.clone() {
                let l = shape.rest_lengths[j];
                let law = self.segment(shape, j);
                let (shear, stretch) = law.energy(l);
                energy += shear + stretch;
                let (force, moment) = law.gradient(l);
                points[j] -= force;
                points[j + 1] += force;
                frames[self.mesh.segment_frames[j]] = moment;
            }
        }
        for beside in &self.mesh.beside {
            let j = beside.segment;
            let l = shape.rest_lengths[j];
            let law = self.blended(shape, beside);
            let (shear, stretch) = law.energy(l);
            energy += shear + stretch;
            let (force, moment, at_stations) = law.gradient(l);
            points[j] -= force;
            points[j + 1] += force;
            frames[self.mesh.segment_frames[j]] += moment;
            for (station, moment) in beside.stations.iter().zip(at_stations) {
                if let Some(c) = station {
                    frames[*c] += moment;
                }
            }
        }
        for (c, &lambda) in shape.coupling_lengths.iter().enumerate() {
            let law = self.coupling(shape, c);
            let (bend, twist) = law.energy(lambda);
            energy += bend + twist;
            let (a, b) = law.gradient();
            frames[c] += a;
            frames[c + 1] += b;
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
        for (beside, room) in self.mesh.beside.iter().zip(&mut hessian.beside) {
            let j = beside.segment;
            let law = self.blended(shape, beside);
            let n = forces.map_or(law.n, |f| f[j]);
            (hessian.segments[j], *room) = law.hessian(shape.rest_lengths[j], &n);
        }
        for (c, &lambda) in shape.coupling_lengths.iter().enumerate() {
            hessian.couplings[c] = self.coupling(shape, c).hessian(lambda, &self.stiffness.couplings[c]);
        }
    }

    fn edge_stiffness(&self, shape: &BranchShape<'_>, stiffness: &mut [Matrix]) {
        for j in self.plain() {
            let law = self.segment(shape, j);
            stiffness[j] = edge_stiffness(&law.r, shape.rest_lengths[j], &law.c);
        }
        for beside in &self.mesh.beside {
            let j = beside.segment;
            stiffness[j] = self.blended(shape, beside).edge_stiffness(shape.rest_lengths[j]);
        }
    }

    /// `C (Γ + δΓ)` with `δΓ = Rᵀ δe/ℓ + v × θ` away from stations.
    fn predicted_forces(&self, shape: &BranchShape<'_>, points: &[Vector], frames: &[Vector], forces: &mut [Vector]) {
        for j in self.plain() {
            let law = self.segment(shape, j);
            let de = points[j + 1] - points[j];
            let theta = &frames[self.mesh.segment_frames[j]];
            let change = law.r.tr_mul(&de) / shape.rest_lengths[j] + law.v.cross(theta);
            forces[j] = law.n + law.c.component_mul(&change);
        }
        for beside in &self.mesh.beside {
            let j = beside.segment;
            let law = self.blended(shape, beside);
            let at_stations = beside.stations.map(|c| c.map_or_else(Vector::zeros, |c| frames[c]));
            let (de, theta) = (points[j + 1] - points[j], &frames[self.mesh.segment_frames[j]]);
            let change = law.strain_change(shape.rest_lengths[j], &de, theta, at_stations);
            forces[j] = law.n + law.c.component_mul(&change);
        }
    }

    fn forces(&self, shape: &BranchShape<'_>, forces: &mut [Vector]) {
        for j in self.plain() {
            let law = self.segment(shape, j);
            forces[j] = law.r * law.n;
        }
        for beside in &self.mesh.beside {
            forces[beside.segment] = self.blended(shape, beside).world_force();
        }
    }

    fn length_terms(&self, shape: &BranchShape<'_>, segments: &mut [[f64; 2]], couplings: &mut [[f64; 2]]) {
        for j in self.plain() {
            segments[j] = self.segment(shape, j).length_terms(shape.rest_lengths[j]);
        }
        for beside in &self.mesh.beside {
            let j = beside.segment;
            segments[j] = self.blended(shape, beside).length_terms(shape.rest_lengths[j]);
        }
        for (c, &lambda) in shape.coupling_lengths.iter().enumerate() {
            couplings[c] = self.coupling(shape, c).length_terms(lambda, &self.stiffness.couplings[c]);
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
        for beside in self.mesh.beside.iter().filter(|b| segment_rates[b.segment] != 0.0) {
            let j = beside.segment;
            let (rate, l) = (segment_rates[j], shape.rest_lengths[j]);
            let law = self.blended(shape, beside).per_length(l);
            let (force, moment, at_stations) = law.gradient(l);
            points[j] -= force * rate;
            points[j + 1] += force * rate;
            frames[self.mesh.segment_frames[j]] += moment * rate;
            for (station, moment) in beside.stations.iter().zip(at_stations) {
                if let Some(c) = station {
                    frames[*c] += moment * rate;
                }
            }
        }
        for (c, &lambda) in shape.coupling_lengths.iter().enumerate().filter(|(c, _)| coupling_rates[*c] != 0.0) {
            let (a, b) = self.coupling(shape, c).per_length(lambda, &self.stiffness.couplings[c]).gradient();
            frames[c] += a * coupling_rates[c];
            frames[c + 1] += b * coupling_rates[c];
        }
    }

    /// `R_b ∂E/∂θ_b`, which by objectivity equals `−R_a ∂E/∂θ_a`; beside a station the moment on it, to which the
    /// blended segment contributes.
    fn moments(&self, shape: &BranchShape<'_>, moments: &mut [Vector]) {
        for (c, moment) in moments.iter_mut().enumerate() {
            *moment = rotation_matrix(&shape.frames[c + 1]) * self.coupling(shape, c).gradient().1;
        }
        for beside in &self.mesh.beside {
            let (_, _, at_stations) = self.blended(shape, beside).gradient(shape.rest_lengths[beside.segment]);
            let [first, second] = beside.stations;
            if let Some(c) = first {
                moments[c] -= shape.frames[c] * at_stations[0];
            }
            if let Some(c) = second {
                moments[c - 1] += shape.frames[c] * at_stations[1];
            }
        }
    }

    fn law(&self) -> Option<RodLaw> {
        let segment = |s: &SegmentStiffness| SegmentLaw { stiffness: s.c, overturned: s.overturned };
        Some(RodLaw {
            segments: self.stiffness.segments.iter().map(segment).collect(),
            couplings: self.stiffness.couplings.clone(),
            blends: self.stiffness.blends,
            curvature: self.curvature,
            friction: SectionFriction::default(),
        })
    }

    /// The rotation whose imaginary part v has `(1 + |v|²/6) v = (λ/2) κ°`.
    fn rest_rotation(&self, coupling: usize) -> Rotation {
        let half = self.curvature * (0.5 * self.mesh.coupling_lengths[coupling]);
        let wanted = half.norm();
        if wanted == 0.0 {
            return Rotation::identity();
        }
        let mut v = wanted.sin();
        for _ in 0..20 {
            v -= (v * (1.0 + v * v / 6.0) - wanted) / (1.0 + 0.5 * v * v);
        }
        let w = (1.0 - v * v).max(0.0).sqrt();
        Unit::new_normalize(Quaternion::from_parts(w, half * (v / wanted)))
    }
}
