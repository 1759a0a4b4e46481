//! Rods of sections that are not linear: a linear rod on the staggered grid and, in every coupling, the laws of
//! [`crate::coupling_law`], in every segment that of `rods::axial`.

use crate::coupling_law::{Bent, CouplingLaw};
use crate::kernel::BendTwist;
use crate::rods::axial::{self, Stretched};
use crate::rods::staggered::StaggeredRod;
use wireloom_core::law::RodLaw;
use wireloom_core::rod::{BranchHessian, BranchShape, Mesh, RodEnergy, RodSegment, RodSpec};
use wireloom_core::section::AxialLaw;
use wireloom_core::{Matrix, Rotation, Vector};

/// One branch of a section that is not linear.
pub struct NonlinearRod {
    linear: StaggeredRod,
    /// `None`: bending and torsion are linear.
    couplings: Option<CouplingLaw>,
    axial: Option<AxialLaw>,
}

/// A rod of the stiffness that is linear and lasts ([`wireloom_core::Section::lasting_diagonal`],
/// [`wireloom_core::Section::linear_stretch_diagonal`]), and beside it the other laws of its section.
pub fn with_laws(spec: &RodSpec, linear: StaggeredRod) -> Box<dyn RodSegment> {
    let couplings = (!spec.section.bends_linearly()).then(|| CouplingLaw::of(&spec.section));
    let axial = spec.section.laws.axial.clone();
    if couplings.is_none() && axial.is_none() {
        return Box::new(linear);
    }
    Box::new(NonlinearRod { linear, couplings, axial })
}

impl NonlinearRod {
    /// The couplings with their laws and those of the linear rod, if they are not linear.
    fn couplings<'s>(
        &'s self,
        shape: &'s BranchShape<'_>,
    ) -> impl Iterator<Item = (usize, f64, BendTwist, Bent<'s>)> + 's {
        self.couplings.iter().flat_map(move |law| {
            let width = law.width();
            shape.coupling_lengths.iter().enumerate().map(move |(c, &lambda)| {
                let coupling = self.linear.coupling(shape, c);
                let bent = law.at(coupling.strain, &shape.memory[c * width..(c + 1) * width], shape.duration);
                (c, lambda, coupling, bent)
            })
        })
    }

    /// The segments with their lengths and axial laws, if they have such a law.
    fn stretched<'s>(&'s self, shape: &'s BranchShape<'_>) -> impl Iterator<Item = (f64, Stretched<'s>)> + 's {
        let all = self.axial.iter().flat_map(move |law| axial::all(&self.linear, law, shape));
        all.map(|own| (shape.rest_lengths[own.segment], own))
    }

    fn segment_frame(&self, segment: usize) -> usize {
        self.linear.mesh().segment_frames[segment]
    }
}

impl RodSegment for NonlinearRod {
    fn mesh(&self) -> &Mesh {
        self.linear.mesh()
    }

    fn couples_pairs(&self) -> bool {
        self.linear.couples_pairs()
    }

    fn energy(&self, shape: &BranchShape<'_>) -> RodEnergy {
        let mut energy = self.linear.energy(shape);
        for (l, own) in self.stretched(shape) {
            energy.stretch += own.energy(l);
        }
        for (_, lambda, _, bent) in self.couplings(shape) {
            let (bend, twist) = bent.energy();
            energy.bend += lambda * bend;
            energy.twist += lambda * twist;
        }
        energy
    }

    fn coupling_gradient(&self, shape: &BranchShape<'_>, frames: &mut [Vector]) -> f64 {
        let mut energy = self.linear.coupling_gradient(shape, frames);
        for (c, lambda, coupling, bent) in self.couplings(shape) {
            let (bend, twist) = bent.energy();
            energy += lambda * (bend + twist);
            let (a, b) = coupling.with_moment(bent.moment()).gradient();
            frames[c] += a;
            frames[c + 1] += b;
        }
        energy
    }

    fn segment_gradient(&self, shape: &BranchShape<'_>, points: &mut [Vector], frames: &mut [Vector]) -> f64 {
        let mut energy = self.linear.segment_gradient(shape, points, frames);
        for (l, own) in self.stretched(shape) {
            energy += own.energy(l);
            own.add_gradient([l, 1.0], self.segment_frame(own.segment), points, frames);
        }
        energy
    }

    /// Where forces are given, the linear rod has them in its geometric part, those of the axial law among them.
    fn hessian(&self, shape: &BranchShape<'_>, forces: Option<&[Vector]>, hessian: &mut BranchHessian) {
        self.linear.hessian(shape, forces, hessian);
        for (l, own) in self.stretched(shape) {
            own.add_hessian(l, forces.is_none(), hessian);
        }
        for (c, _, coupling, bent) in self.couplings(shape) {
            let own = coupling.with_moment(bent.moment()).hessian_with(&bent.tangent());
            let all = &mut hessian.couplings[c];
            all.aa += own.aa;
            all.ab += own.ab;
            all.bb += own.bb;
        }
    }

    fn edge_stiffness(&self, shape: &BranchShape<'_>, stiffness: &mut [Matrix]) {
        self.linear.edge_stiffness(shape, stiffness);
        for (l, own) in self.stretched(shape) {
            stiffness[own.segment] += own.edge_stiffness(l);
        }
    }

    fn predicted_forces(&self, shape: &BranchShape<'_>, points: &[Vector], frames: &[Vector], forces: &mut [Vector]) {
        self.linear.predicted_forces(shape, points, frames, forces);
        for (l, own) in self.stretched(shape) {
            let j = own.segment;
            let theta = &frames[self.segment_frame(j)];
            forces[j] += own.predicted_force(l, &(points[j + 1] - points[j]), theta, frames);
        }
    }

    fn forces(&self, shape: &BranchShape<'_>, forces: &mut [Vector]) {
        self.linear.forces(shape, forces);
        for (_, own) in self.stretched(shape) {
            forces[own.segment] += own.world_force();
        }
    }

    fn moments(&self, shape: &BranchShape<'_>, moments: &mut [Vector]) {
        self.linear.moments(shape, moments);
        for (l, own) in self.stretched(shape) {
            let Some(([first, second], at)) = own.at_neighbours(l) else { continue };
            if let Some(c) = first {
                moments[c] -= shape.frames[c] * at[0];
            }
            if let Some(c) = second {
                moments[c - 1] += shape.frames[c] * at[1];
            }
        }
        for (c, _, coupling, bent) in self.couplings(shape) {
            moments[c] += shape.frames[c + 1] * coupling.with_moment(bent.moment()).gradient().1;
        }
    }

    /// The part of couplings: with `κ` as 1/λ and the memory fixed, `∂(λ h)/∂λ = h − κ·m` and `κᵀ ∂²h κ/λ`.
    fn length_terms(&self, shape: &BranchShape<'_>, segments: &mut [[f64; 2]], couplings: &mut [[f64; 3]]) {
        self.linear.length_terms(shape, segments, couplings);
        for (l, own) in self.stretched(shape) {
            let [first, second] = own.length_terms(l);
            segments[own.segment][0] += first;
            segments[own.segment][1] += second;
        }
        for (c, lambda, coupling, bent) in self.couplings(shape) {
            let (kappa, (bend, twist)) = (coupling.curvature(), bent.energy());
            couplings[c][0] += bend + twist - kappa.dot(&bent.moment());
            couplings[c][1] += kappa.dot(&(bent.tangent() * kappa)) / lambda;
        }
    }

    /// The part of couplings: with `∂m/∂λ = −∂²h κ/λ` in place of the moment.
    fn length_mixed(
        &self,
        shape: &BranchShape<'_>,
        segment_rates: &[f64],
        coupling_rates: &[f64],
        points: &mut [Vector],
        frames: &mut [Vector],
    ) {
        self.linear.length_mixed(shape, segment_rates, coupling_rates, points, frames);
        for (l, own) in self.stretched(shape).filter(|(_, own)| segment_rates[own.segment] != 0.0) {
            let (rate, frame) = (segment_rates[own.segment], self.segment_frame(own.segment));
            own.per_length(l).add_gradient([l, rate], frame, points, frames);
        }
        for (c, lambda, coupling, bent) in self.couplings(shape).filter(|(c, ..)| coupling_rates[*c] != 0.0) {
            let change = bent.tangent() * coupling.curvature() / -lambda;
            let (a, b) = coupling.with_moment(change).gradient();
            frames[c] += a * coupling_rates[c];
            frames[c + 1] += b * coupling_rates[c];
        }
    }

    fn rest_rotation(&self, coupling: usize) -> Rotation {
        self.linear.rest_rotation(coupling)
    }

    fn law(&self) -> Option<RodLaw> {
        let mut law = self.linear.law()?;
        if let Some(CouplingLaw { curve, friction, creep }) = &self.couplings {
            law.friction = friction.clone();
            law.laws.bending = curve.clone();
            law.laws.creep = creep.clone();
        }
        law.laws.axial = self.axial.clone();
        Some(law)
    }

    fn memory(&self) -> Vec<f64> {
        let width = self.couplings.as_ref().map_or(0, CouplingLaw::width);
        vec![0.0; self.mesh().coupling_lengths.len() * width]
    }

    fn commit(&self, shape: &BranchShape<'_>, memory: &mut [f64]) -> f64 {
        let Some(law) = self.couplings.as_ref().filter(|law| law.width() > 0) else { return 0.0 };
        let rooms = memory.chunks_exact_mut(law.width());
        let dissipated = |((_, lambda, _, bent), own): ((usize, f64, BendTwist, Bent<'_>), &mut [f64])| {
            lambda * bent.commit(law, own)
        };
        self.couplings(shape).zip(rooms).map(dissipated).sum()
    }

    fn curvature_under(&self, moment: &Vector, memory: &[f64], duration: f64) -> Option<Vector> {
        let [rest, stiffness] = self.linear.bending_law();
        self.couplings.as_ref().map(|law| rest + law.strain_under(&stiffness, moment, memory, duration))
    }
}
