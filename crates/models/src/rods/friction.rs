//! Rods whose sections slip or yield within: an elastic rod on the staggered grid and, in every coupling, the elements
//! of [`crate::friction`].

use crate::friction::Friction;
use crate::rods::staggered::StaggeredRod;
use wireloom_core::law::RodLaw;
use wireloom_core::rod::{BranchHessian, BranchShape, Mesh, RodEnergy, RodSegment, RodSpec};
use wireloom_core::section::SectionFriction;
use wireloom_core::{Matrix, Rotation, Vector};

/// One branch of a section with friction, or with a part that yields.
pub struct FrictionRod {
    elastic: StaggeredRod,
    friction: SectionFriction,
}

/// A rod of the stiffness that lasts ([`wireloom_core::Section::lasting_diagonal`]), and beside it what slips or yields
/// in its section.
pub fn with_friction(spec: &RodSpec, elastic: StaggeredRod) -> Box<dyn RodSegment> {
    match spec.section.remembers() {
        false => Box::new(elastic),
        true => Box::new(FrictionRod { elastic, friction: spec.section.slipping() }),
    }
}

impl FrictionRod {
    /// Friction of a coupling that is bent so, with its memory.
    fn friction<'s>(&'s self, shape: &BranchShape<'s>, c: usize, strain: Vector) -> Friction<'s> {
        let width = Friction::width(&self.friction);
        Friction::new(&self.friction, strain, &shape.memory[c * width..(c + 1) * width])
    }
}

impl RodSegment for FrictionRod {
    fn mesh(&self) -> &Mesh {
        self.elastic.mesh()
    }

    fn energy(&self, shape: &BranchShape<'_>) -> RodEnergy {
        let mut energy = self.elastic.energy(shape);
        for (c, &lambda) in shape.coupling_lengths.iter().enumerate() {
            let (bend, twist) = self.friction(shape, c, self.elastic.coupling(shape, c).strain).energy();
            energy.bend += lambda * bend;
            energy.twist += lambda * twist;
        }
        energy
    }

    fn gradient(&self, shape: &BranchShape<'_>, points: &mut [Vector], frames: &mut [Vector]) -> f64 {
        let mut energy = self.elastic.gradient(shape, points, frames);
        for (c, &lambda) in shape.coupling_lengths.iter().enumerate() {
            let coupling = self.elastic.coupling(shape, c);
            let friction = self.friction(shape, c, coupling.strain);
            let (bend, twist) = friction.energy();
            energy += lambda * (bend + twist);
            let (a, b) = coupling.with_moment(friction.moment()).gradient();
            frames[c] += a;
            frames[c + 1] += b;
        }
        energy
    }

    fn hessian(&self, shape: &BranchShape<'_>, forces: Option<&[Vector]>, hessian: &mut BranchHessian) {
        self.elastic.hessian(shape, forces, hessian);
        for (c, &lambda) in shape.coupling_lengths.iter().enumerate() {
            let coupling = self.elastic.coupling(shape, c);
            let friction = self.friction(shape, c, coupling.strain);
            let own = coupling.with_moment(friction.moment()).hessian_with(lambda, &friction.tangent());
            let all = &mut hessian.couplings[c];
            all.aa += own.aa;
            all.ab += own.ab;
            all.bb += own.bb;
        }
    }

    fn edge_stiffness(&self, shape: &BranchShape<'_>, stiffness: &mut [Matrix]) {
        self.elastic.edge_stiffness(shape, stiffness);
    }

    fn predicted_forces(&self, shape: &BranchShape<'_>, points: &[Vector], frames: &[Vector], forces: &mut [Vector]) {
        self.elastic.predicted_forces(shape, points, frames, forces);
    }

    fn forces(&self, shape: &BranchShape<'_>, forces: &mut [Vector]) {
        self.elastic.forces(shape, forces);
    }

    fn moments(&self, shape: &BranchShape<'_>, moments: &mut [Vector]) {
        self.elastic.moments(shape, moments);
        for (c, moment) in moments.iter_mut().enumerate() {
            let coupling = self.elastic.coupling(shape, c);
            let friction = self.friction(shape, c, coupling.strain);
            *moment += shape.frames[c + 1] * coupling.with_moment(friction.moment()).gradient().1;
        }
    }

    /// The part of friction: with `κ` as 1/λ and p fixed, `∂(λ h)/∂λ = h − κ·m` and `κᵀ ∂²h κ/λ`.
    fn length_terms(&self, shape: &BranchShape<'_>, segments: &mut [[f64; 2]], couplings: &mut [[f64; 3]]) {
        self.elastic.length_terms(shape, segments, couplings);
        for (c, &lambda) in shape.coupling_lengths.iter().enumerate() {
            let coupling = self.elastic.coupling(shape, c);
            let friction = self.friction(shape, c, coupling.strain);
            let (kappa, (bend, twist)) = (coupling.curvature(), friction.energy());
            couplings[c][0] += bend + twist - kappa.dot(&friction.moment());
            couplings[c][1] += kappa.dot(&(friction.tangent() * kappa)) / lambda;
        }
    }

    /// The part of friction: with `∂m/∂λ = −∂²h κ/λ` in place of the moment.
    fn length_mixed(
        &self,
        shape: &BranchShape<'_>,
        segment_rates: &[f64],
        coupling_rates: &[f64],
        points: &mut [Vector],
        frames: &mut [Vector],
    ) {
        self.elastic.length_mixed(shape, segment_rates, coupling_rates, points, frames);
        for (c, &lambda) in shape.coupling_lengths.iter().enumerate().filter(|(c, _)| coupling_rates[*c] != 0.0) {
            let coupling = self.elastic.coupling(shape, c);
            let friction = self.friction(shape, c, coupling.strain);
            let change = friction.tangent() * coupling.curvature() / -lambda;
            let (a, b) = coupling.with_moment(change).gradient();
            frames[c] += a * coupling_rates[c];
            frames[c + 1] += b * coupling_rates[c];
        }
    }

    fn rest_rotation(&self, coupling: usize) -> Rotation {
        self.elastic.rest_rotation(coupling)
    }

    fn law(&self) -> Option<RodLaw> {
        self.elastic.law().map(|law| RodLaw { friction: self.friction.clone(), ..law })
    }

    fn memory(&self) -> Vec<f64> {
        vec![0.0; self.mesh().coupling_lengths.len() * Friction::width(&self.friction)]
    }

    fn commit(&self, shape: &BranchShape<'_>, memory: &mut [f64]) -> f64 {
        let width = Friction::width(&self.friction);
        let mut dissipated = 0.0;
        for (c, own) in memory.chunks_exact_mut(width).enumerate() {
            let friction = self.friction(shape, c, self.elastic.coupling(shape, c).strain);
            dissipated += shape.coupling_lengths[c] * friction.commit(own);
        }
        dissipated
    }

    fn curvature_under(&self, moment: &Vector, memory: &[f64]) -> Option<Vector> {
        let [rest, stiffness] = self.elastic.bending_law();
        Some(rest + Friction::strain_under(&self.friction, &stiffness, moment, memory))
    }
}
