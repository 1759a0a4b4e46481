//! Energy of the joints: `E = Σ E_j(q_1, …, q_k)` in the frames that it couples; see [`crate::JointModel`].

use crate::conditions::{JointState, System};
use crate::constitutive::Derivatives;
use crate::joint::JointShape;
use crate::network::Joint;
use crate::rotation::turned;
use crate::terms::slope::{Contradiction, Line, Slope};
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

    /// What the energy of a joint depends on, and room for the gradients in its frames.
    fn at<'s>(&'s mut self, joint: &Joint, own: &'s JointState, state: &State) -> (JointShape<'s>, &'s mut [Vector]) {
        self.frames.clear();
        self.frames.extend(joint.coupled_frames.iter().map(|&c| state.frames[c]));
        let gradients = &mut self.gradients[..joint.coupled_frames.len()];
        gradients.fill(Vector::zeros());
        (JointShape { frames: &self.frames, memory: &own.memory }, gradients)
    }

    /// Energy of the joints, J.
    pub fn energy(&mut self, system: System<'_>, state: &State) -> f64 {
        let mut energy = 0.0;
        for (joint, own) in system.joints() {
            energy += joint.model.energy(&self.at(joint, own, state).0);
        }
        energy
    }

    /// Adds the first derivatives ∂E/∂θ_a (N m) in the frames of the joints, and the energies (J) to `energy`.
    pub fn gradient(&mut self, system: System<'_>, state: &State, gradient: &mut Tangent, energy: &mut f64) {
        for (joint, own) in system.joints() {
            if joint.coupled_frames.is_empty() {
                continue;
            }
            let (shape, arms) = self.at(joint, own, state);
            *energy += joint.model.add_gradient(&shape, arms);
            for (&c, g) in joint.coupled_frames.iter().zip(arms) {
                gradient.frames[c] += *g;
            }
        }
    }

    /// Writes the second derivatives ∂²E/∂θ_a∂θ_b of each joint: the k × k table of
    /// [`crate::JointModel::add_hessian`].
    pub fn hessian(&mut self, system: System<'_>, state: &State, hessian: &mut [Vec<Matrix>]) {
        for ((joint, own), table) in system.joints().zip(hessian) {
            table.fill(Matrix::zeros());
            joint.model.add_hessian(&self.at(joint, own, state).0, table);
        }
    }

    /// State of every joint that remembers, by index, updated to `state`, the equilibrium that ends an increment.
    pub fn memories(&mut self, system: System<'_>, state: &State) -> Vec<(usize, JointState)> {
        let mut memories = Vec::new();
        // A rigid hub has no energy, and nothing to remember.
        let remembers =
            |(joint, own): &(&Joint, &JointState)| !own.memory.is_empty() && !joint.coupled_frames.is_empty();
        for (j, (joint, own)) in system.joints().enumerate().filter(|(_, of)| remembers(of)) {
            let (mut memory, mut dissipated) = (own.memory.clone(), vec![0.0; own.dissipated.len()]);
            joint.model.commit(&self.at(joint, own, state).0, &mut memory, &mut dissipated);
            let totals = dissipated.iter().zip(&own.dissipated).map(|(last, before)| [*last, before[1] + last]);
            memories.push((j, JointState { memory, dissipated: totals.collect() }));
        }
        memories
    }

    /// First joint (by index) whose first derivatives at `state` are not those of its energy, or second ones those of
    /// its moments if it remembers nothing.
    pub fn contradiction(&mut self, system: System<'_>, state: &State) -> Option<(usize, Derivatives, Contradiction)> {
        system.joints().enumerate().find_map(|(j, (joint, own))| {
            if joint.coupled_frames.is_empty() {
                return None;
            }
            let (shape, arms) = self.at(joint, own, state);
            joint.model.add_gradient(&shape, arms);
            let line = Line::at(shape.frames.iter().flat_map(|q| q.coords.iter()));
            let mut slope = Slope::default();
            arms.iter().enumerate().for_each(|(a, g)| slope.add(g, &line.along(a)));
            let mut moved = shape.frames.to_vec();
            let mut at = |t: f64, value: &mut dyn FnMut(&JointShape<'_>) -> f64| {
                for (a, (q, from)) in moved.iter_mut().zip(shape.frames).enumerate() {
                    *q = turned(from, &(line.along(a) * t));
                }
                value(&JointShape { frames: &moved, ..shape })
            };
            let first = slope.contradiction(|t| at(t, &mut |shape| joint.model.energy(shape)));
            if let Some(found) = first {
                return Some((j, Derivatives::First, found));
            }
            if !shape.memory.is_empty() {
                return None;
            }
            let k = arms.len();
            let mut table = vec![Matrix::zeros(); k * k];
            joint.model.add_hessian(&shape, &mut table);
            let mut slope = Slope::default();
            for a in 0..k {
                for b in 0..=a {
                    let twice = if a == b { 1.0 } else { 2.0 };
                    slope.add(&(table[a * k + b] * line.along(b) * twice), &line.along(a));
                }
            }
            let second = slope.contradiction(|t| {
                at(t, &mut |shape| {
                    arms.fill(Vector::zeros());
                    joint.model.add_gradient(shape, arms);
                    arms.iter().enumerate().map(|(a, g)| g.dot(&line.along(a))).sum()
                })
            });
            second.map(|found| (j, Derivatives::Second, found))
        })
    }
}
