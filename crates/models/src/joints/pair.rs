//! Spring in bending and twist between two of the frames that a joint couples.

use crate::kernel::{BendTwist, rotation_matrix};
use wireloom_core::law::PairLaw;
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
}

impl Pair {
    fn coupling(&self, frames: &[Rotation]) -> BendTwist {
        let (qa, qb) = (frames[self.a] * self.alpha, frames[self.b] * self.beta);
        BendTwist::new(&qa, &qb, self.lambda, &self.stiffness, &self.curvature)
    }

    /// Energy, J.
    pub(super) fn energy(&self, frames: &[Rotation]) -> f64 {
        let (bend, twist) = self.coupling(frames).energy(self.lambda);
        bend + twist
    }

    /// Adds ∂E/∂θ of both frames (N m, body axes); returns the energy, J.
    pub(super) fn add_gradient(&self, frames: &[Rotation], gradient: &mut [Vector]) -> f64 {
        let coupling = self.coupling(frames);
        let (a, b) = coupling.gradient();
        gradient[self.a] += self.alpha * a;
        gradient[self.b] += self.beta * b;
        let (bend, twist) = coupling.energy(self.lambda);
        bend + twist
    }

    /// Adds the second derivatives to the blocks on and below the diagonal.
    pub(super) fn add_hessian(&self, frames: &[Rotation], hessian: &mut [Matrix]) {
        let k = frames.len();
        let h = self.coupling(frames).hessian(&self.stiffness);
        let (ra, rb) = (rotation_matrix(&self.alpha), rotation_matrix(&self.beta));
        hessian[self.a * k + self.a] += ra * h.aa * ra.transpose();
        hessian[self.b * k + self.b] += rb * h.bb * rb.transpose();
        hessian[self.b * k + self.a] += rb * h.ab.transpose() * ra.transpose();
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
        }
    }
}
