//! The Cosserat rod: stretch, shear, bending and twist, on a staggered grid.

use crate::kernel::{BendTwist, StretchShear, rotation_matrix};
use nalgebra::{Quaternion, Unit};
use wireloom_core::registry::RodKind;
use wireloom_core::rod::{BranchShape, CouplingHessian, Mesh, RodEnergy, RodSegment, RodSpec, SegmentHessian};
use wireloom_core::{Rotation, Vector};

/// The kind `cosserat`.
pub fn kind() -> RodKind {
    RodKind {
        name: "cosserat".into(),
        doc: "geometrically exact rod: stretch, shear, bending and twist; second order in the segment length".into(),
        parameters: vec![],
        build: Box::new(|spec, _| Ok(Box::new(CosseratRod::new(spec.clone())))),
    }
}

/// One branch as a Cosserat rod.
pub struct CosseratRod {
    mesh: Mesh,
    /// diag(GA1, GA2, EA), N.
    stretch: Vector,
    /// diag(EI1, EI2, GJ), N m².
    bend: Vector,
    /// κ°, 1/m.
    curvature: Vector,
}

impl CosseratRod {
    /// From its specification.
    pub fn new(spec: RodSpec) -> Self {
        Self {
            stretch: spec.section.stretch_diagonal(),
            bend: spec.section.bend_diagonal(),
            curvature: spec.curvature,
            mesh: spec.mesh,
        }
    }

    #[inline(always)]
    fn segment(&self, shape: &BranchShape<'_>, j: usize) -> StretchShear {
        let q = &shape.frames[self.mesh.segment_frames[j]];
        StretchShear::new(&shape.edge(j), q, self.mesh.rest_lengths[j], &self.stretch)
    }

    #[inline(always)]
    fn coupling(&self, shape: &BranchShape<'_>, c: usize) -> BendTwist {
        let (a, b) = (&shape.frames[c], &shape.frames[c + 1]);
        BendTwist::new(a, b, self.mesh.coupling_lengths[c], &self.bend, &self.curvature)
    }
}

impl RodSegment for CosseratRod {
    fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    fn energy(&self, shape: &BranchShape<'_>) -> RodEnergy {
        let mut energy = RodEnergy::default();
        for (j, &l) in self.mesh.rest_lengths.iter().enumerate() {
            let (shear, stretch) = self.segment(shape, j).energy(l);
            energy.shear += shear;
            energy.stretch += stretch;
        }
        for (c, &lambda) in self.mesh.coupling_lengths.iter().enumerate() {
            let (bend, twist) = self.coupling(shape, c).energy(lambda);
            energy.bend += bend;
            energy.twist += twist;
        }
        energy
    }

    fn gradient(&self, shape: &BranchShape<'_>, points: &mut [Vector], frames: &mut [Vector]) -> f64 {
        let mut energy = 0.0;
        points[0] = Vector::zeros();
        for &c in &self.mesh.station_frames {
            frames[c] = Vector::zeros();
        }
        for (j, &l) in self.mesh.rest_lengths.iter().enumerate() {
            let law = self.segment(shape, j);
            let (shear, stretch) = law.energy(l);
            energy += shear + stretch;
            let (force, moment) = law.gradient(l);
            points[j] -= force;
            points[j + 1] = force;
            frames[self.mesh.segment_frames[j]] = moment;
        }
        for (c, &lambda) in self.mesh.coupling_lengths.iter().enumerate() {
            let law = self.coupling(shape, c);
            let (bend, twist) = law.energy(lambda);
            energy += bend + twist;
            let (a, b) = law.gradient();
            frames[c] += a;
            frames[c + 1] += b;
        }
        energy
    }

    fn hessian(
        &self,
        shape: &BranchShape<'_>,
        forces: Option<&[Vector]>,
        segments: &mut [SegmentHessian],
        couplings: &mut [CouplingHessian],
    ) {
        for (j, &l) in self.mesh.rest_lengths.iter().enumerate() {
            let law = self.segment(shape, j);
            let n = forces.map_or(law.n, |f| f[j]);
            segments[j] = law.hessian(l, &self.stretch, &n);
        }
        for (c, &lambda) in self.mesh.coupling_lengths.iter().enumerate() {
            couplings[c] = self.coupling(shape, c).hessian(lambda, &self.bend);
        }
    }

    /// `C (Γ + δΓ)` with `δΓ = Rᵀ δe/ℓ + v × θ`.
    fn predicted_forces(&self, shape: &BranchShape<'_>, points: &[Vector], frames: &[Vector], forces: &mut [Vector]) {
        for (j, &l) in self.mesh.rest_lengths.iter().enumerate() {
            let law = self.segment(shape, j);
            let de = points[j + 1] - points[j];
            let theta = &frames[self.mesh.segment_frames[j]];
            let change = law.r.tr_mul(&de) / l + law.v.cross(theta);
            forces[j] = law.n + self.stretch.component_mul(&change);
        }
    }

    fn forces(&self, shape: &BranchShape<'_>, forces: &mut [Vector]) {
        for (j, force) in forces.iter_mut().enumerate() {
            let law = self.segment(shape, j);
            *force = law.r * law.n;
        }
    }

    /// `R_b ∂E/∂θ_b`, which by objectivity equals `−R_a ∂E/∂θ_a`.
    fn moments(&self, shape: &BranchShape<'_>, moments: &mut [Vector]) {
        for (c, moment) in moments.iter_mut().enumerate() {
            *moment = rotation_matrix(&shape.frames[c + 1]) * self.coupling(shape, c).gradient().1;
        }
    }

    /// The rotation whose imaginary part is `(λ/2) κ°`.
    fn rest_rotation(&self, coupling: usize) -> Rotation {
        let v = self.curvature * (0.5 * self.mesh.coupling_lengths[coupling]);
        let w = (1.0 - v.norm_squared()).max(0.0).sqrt();
        Unit::new_normalize(Quaternion::from_parts(w, v))
    }
}
