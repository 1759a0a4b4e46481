//! Spring in bending and twist between two of the frames that a joint couples.

use crate::coupling_law::{Bent, CouplingLaw};
use crate::kernel::{BendTwist, rotation_matrix, turn_of_curvature};
use std::ops::Range;
use wireloom_core::joint::JointShape;
use wireloom_core::law::PairLaw;
use wireloom_core::section::SectionFriction;
use wireloom_core::{Matrix, Rotation, Vector};

/// A spring between two frames of a joint: the energy of [`BendTwist`] between `q_a α` and `q_b β`.
pub(super) struct Pair {
    /// Indices of the frames, a before b.
    pub(super) a: usize,
    pub(super) b: usize,
    /// Length that the energy's curvature is of, m.
    pub(super) lambda: f64,
    /// About the axes of the coupled frames, N m².
    pub(super) stiffness: Vector,
    /// Rest curvature from one frame to the other, 1/m.
    pub(super) curvature: Vector,
    /// Constant rotations with which the coupled frames are `q_a alpha` and `q_b beta`.
    pub(super) alpha: Rotation,
    pub(super) beta: Rotation,
    /// What slips beside the linear stiffness.
    pub(super) slips: Option<Slipping>,
}

/// The law of what slips, and the place of its state variables in the memory of the joint.
pub(super) struct Slipping {
    law: CouplingLaw,
    memory: Range<usize>,
}

impl Slipping {
    /// That of these elements, if there are any, with their state variables behind `before` others.
    pub(super) fn new(friction: &SectionFriction, before: usize) -> Option<Self> {
        let law = CouplingLaw { curve: None, friction: friction.clone(), creep: Default::default() };
        let memory = before..before + law.width();
        (!memory.is_empty()).then_some(Self { law, memory })
    }
}

impl Pair {
    /// Number of its state variables.
    pub(super) fn width(&self) -> usize {
        self.slips.as_ref().map_or(0, |own| own.memory.len())
    }

    /// The linear spring, and what slips beside it.
    fn at<'s>(&'s self, shape: &'s JointShape<'_>) -> (BendTwist, Option<Bent<'s>>) {
        let (qa, qb) = (shape.frames[self.a] * self.alpha, shape.frames[self.b] * self.beta);
        let coupling = BendTwist::new(&qa, &qb, self.lambda, &self.stiffness, &self.curvature);
        let slips = self.slips.as_ref().map(|own| own.law.at(coupling.strain, &shape.memory[own.memory.clone()], 0.0));
        (coupling, slips)
    }

    /// Energy, J, of both.
    fn sum(&self, coupling: &BendTwist, slips: Option<&Bent<'_>>) -> f64 {
        let (bend, twist) = coupling.energy(self.lambda);
        let of_slips = |slips: &Bent<'_>| {
            let (bend, twist) = slips.energy();
            self.lambda * (bend + twist)
        };
        bend + twist + slips.map_or(0.0, of_slips)
    }

    /// Energy, J.
    pub(super) fn energy(&self, shape: &JointShape<'_>) -> f64 {
        let (coupling, slips) = self.at(shape);
        self.sum(&coupling, slips.as_ref())
    }

    /// Adds ∂E/∂θ of both frames (N m, body axes); returns the energy, J.
    pub(super) fn add_gradient(&self, shape: &JointShape<'_>, gradient: &mut [Vector]) -> f64 {
        let (coupling, slips) = self.at(shape);
        let energy = self.sum(&coupling, slips.as_ref());
        let (a, b) = match slips {
            Some(slips) => coupling.with_moment(coupling.moment + slips.moment()).gradient(),
            None => coupling.gradient(),
        };
        gradient[self.a] += self.alpha * a;
        gradient[self.b] += self.beta * b;
        energy
    }

    /// Adds the second derivatives to the blocks on and below the diagonal.
    pub(super) fn add_hessian(&self, shape: &JointShape<'_>, hessian: &mut [Matrix]) {
        let k = shape.frames.len();
        let h = match self.at(shape) {
            (coupling, Some(slips)) => {
                let tangent = Matrix::from_diagonal(&self.stiffness) + slips.tangent();
                coupling.with_moment(coupling.moment + slips.moment()).hessian_with(&tangent)
            }
            (coupling, None) => coupling.hessian(&self.stiffness),
        };
        let (ra, rb) = (rotation_matrix(&self.alpha), rotation_matrix(&self.beta));
        hessian[self.a * k + self.a] += ra * h.aa * ra.transpose();
        hessian[self.b * k + self.b] += rb * h.bb * rb.transpose();
        hessian[self.b * k + self.a] += rb * h.ab.transpose() * ra.transpose();
    }

    /// Writes its state variables at the end of an increment; returns the energy dissipated in it, J.
    pub(super) fn commit(&self, shape: &JointShape<'_>, memory: &mut [f64]) -> f64 {
        match (&self.slips, self.at(shape)) {
            (Some(own), (_, Some(slips))) => self.lambda * slips.commit(&own.law, &mut memory[own.memory.clone()]),
            _ => 0.0,
        }
    }

    /// Turn from the first coupled frame to the second one that would remain without a moment.
    pub(super) fn set(&self, memory: &[f64]) -> Option<Rotation> {
        let own = self.slips.as_ref()?;
        let strain = own.law.strain_under(&self.stiffness, &Vector::zeros(), &memory[own.memory.clone()], 0.0);
        Some(turn_of_curvature(&(self.curvature + strain), self.lambda))
    }

    /// Its coefficients.
    pub(super) fn law(&self) -> PairLaw {
        PairLaw {
            a: self.a,
            b: self.b,
            alpha: self.alpha,
            beta: self.beta,
            length: self.lambda,
            stiffness: self.stiffness,
            curvature: self.curvature,
            friction: self.slips.as_ref().map(|own| own.law.friction.clone()).unwrap_or_default(),
        }
    }
}
