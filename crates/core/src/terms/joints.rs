//! Energy of the joints: `E = Σ E_j(q_1, …, q_k)` in the frames that it couples; see [`crate::JointModel`].

use crate::rotation::turned;
use crate::terms::slope::{Contradiction, Slope, along};
use crate::{Matrix, Network, Rotation, State, Tangent, Vector};

/// Term of the joints; keeps its workspace.
pub struct JointTerm {
    /// Frames of one joint, and the gradients in them.
    frames: Vec<Rotation>,
    gradients: Vec<Vector>,
}

impl JointTerm {
    /// Term of the joints of a network.
    pub fn new(network: &Network) -> Self {
        let arms = network.joints.iter().map(|j| j.coupled_frames.len()).max().unwrap_or(0);
        Self { frames: Vec::with_capacity(arms), gradients: vec![Vector::zeros(); arms] }
    }

    /// Energy of the joints, J.
    pub fn energy(&mut self, network: &Network, state: &State) -> f64 {
        let mut energy = 0.0;
        for joint in &network.joints {
            self.frames.clear();
            self.frames.extend(joint.coupled_frames.iter().map(|&c| state.frames[c]));
            energy += joint.model.energy(&self.frames);
        }
        energy
    }

    /// Adds the first derivatives ∂E/∂θ_a (N m) in the frames of the joints, and the energies (J) to `energy`.
    pub fn gradient(&mut self, network: &Network, state: &State, gradient: &mut Tangent, energy: &mut f64) {
        for joint in &network.joints {
            if joint.coupled_frames.is_empty() {
                continue;
            }
            self.frames.clear();
            self.frames.extend(joint.coupled_frames.iter().map(|&c| state.frames[c]));
            let arms = &mut self.gradients[..joint.coupled_frames.len()];
            arms.fill(Vector::zeros());
            *energy += joint.model.add_gradient(&self.frames, arms);
            for (&c, g) in joint.coupled_frames.iter().zip(arms) {
                gradient.frames[c] += *g;
            }
        }
    }

    /// Writes the second derivatives ∂²E/∂θ_a∂θ_b of each joint: the k × k table of
    /// [`crate::JointModel::add_hessian`].
    pub fn hessian(&mut self, network: &Network, state: &State, hessian: &mut [Vec<Matrix>]) {
        for (joint, table) in network.joints.iter().zip(hessian) {
            table.fill(Matrix::zeros());
            self.frames.clear();
            self.frames.extend(joint.coupled_frames.iter().map(|&c| state.frames[c]));
            joint.model.add_hessian(&self.frames, table);
        }
    }

    /// First joint (by index) whose first derivatives at `state` are not those of its energy.
    pub fn contradiction(&mut self, network: &Network, state: &State) -> Option<(usize, Contradiction)> {
        network.joints.iter().enumerate().find_map(|(j, joint)| {
            self.frames.clear();
            self.frames.extend(joint.coupled_frames.iter().map(|&c| state.frames[c]));
            let arms = &mut self.gradients[..joint.coupled_frames.len()];
            arms.fill(Vector::zeros());
            joint.model.add_gradient(&self.frames, arms);
            let mut slope = Slope::default();
            arms.iter().enumerate().for_each(|(a, g)| slope.add(g, &along(a)));
            let mut moved = self.frames.clone();
            let found = slope.contradiction(|t| {
                for (a, (q, from)) in moved.iter_mut().zip(&self.frames).enumerate() {
                    *q = turned(from, &(along(a) * t));
                }
                joint.model.energy(&moved)
            });
            found.map(|found| (j, found))
        })
    }
}
