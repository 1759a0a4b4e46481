//! Dead forces and moments: weight of fixed meshes, masses of joints, and loads. `E = −Σ f·x`.
//!
//! A dead moment M (about an axis fixed in space) has no potential (Ziegler 1968, Principles of Structural
//! Stability). It adds `−Rᵀ M` to the gradient; the derivative of that along `q ∘ exp(θ)`, pulled back to θ as all
//! second derivatives are, is `−½ [Rᵀ M]ₓ`: antisymmetric, so that [`crate::Problem::hessian`] does not contain
//! it.

use super::gravity;
use crate::conditions::System;
use crate::{Network, State, Tangent, Vector};

/// Term of the dead loads.
pub struct LoadTerm {
    /// Dead force at every point, N; without the weight of branches whose mesh may move along the cable.
    forces: Vec<Vector>,
    /// Dead moments by independent frame, N m, world axes.
    moments: Vec<(usize, Vector)>,
    /// Active fraction of the dead moments.
    moment_fraction: f64,
}

impl LoadTerm {
    /// Term without loads; see [`Self::update`].
    pub fn new(network: &Network) -> Self {
        Self {
            forces: vec![Vector::zeros(); network.points],
            moments: Vec::with_capacity(network.loads.len()),
            moment_fraction: 1.0,
        }
    }

    /// Recomputes the lumped weights and loads, after a change of the conditions.
    pub fn update(&mut self, system: System<'_>) {
        let Self { forces, moments, moment_fraction } = self;
        forces.fill(Vector::zeros());
        gravity::fixed_weights(system, |point, force| forces[point] += force);
        moments.clear();
        for joint in &system.network.joints {
            forces[joint.point] += system.conditions.gravity * joint.mass;
        }
        for (load, factor) in system.network.loads.iter().zip(&system.conditions.load_factors) {
            forces[load.point] += load.force * *factor;
            let moment = load.moment * (*factor * *moment_fraction);
            if let Some(frame) = load.site.frame
                && moment != Vector::zeros()
            {
                moments.push((frame, moment));
            }
        }
    }

    /// Dead force at every point of the state, N: weight and loads, also at points tied to a joint. Without the weight
    /// of branches whose mesh may move along the cable.
    pub fn forces(&self) -> &[Vector] {
        &self.forces
    }

    /// Active dead moments: index of the independent frame, and the moment, N m, world axes.
    pub fn moments(&self) -> &[(usize, Vector)] {
        &self.moments
    }

    /// Sets the active fraction of the dead moments, 0 to 1; effective from the next [`Self::update`].
    pub fn set_moment_fraction(&mut self, fraction: f64) {
        self.moment_fraction = fraction;
    }

    /// Potential energy of the loads, `−Σ f·x` without weight, J.
    pub fn energy(&self, system: System<'_>, state: &State) -> f64 {
        let mut energy = 0.0;
        for (load, factor) in system.network.loads.iter().zip(&system.conditions.load_factors) {
            energy -= factor * load.force.dot(&state.points[load.point]);
        }
        energy
    }

    /// Potential energy of all dead forces, `−Σ f·x` including weight, J.
    pub fn energy_with_weight(&self, state: &State) -> f64 {
        self.forces.iter().zip(&state.points).map(|(f, x)| -f.dot(x)).sum()
    }

    /// Adds the first derivatives `−f` of the dead forces to the gradient, their energy to `energy` (J), and the sum
    /// of its absolute values to `magnitude` (J).
    pub fn force_gradient(&self, state: &State, gradient: &mut Tangent, energy: &mut f64, magnitude: &mut f64) {
        for ((g, x), f) in gradient.points.iter_mut().zip(&state.points).zip(&self.forces) {
            *g -= f;
            let work = f.dot(x);
            *energy -= work;
            *magnitude += work.abs();
        }
    }

    /// Adds the generalised forces `−Rᵀ M` of the dead moments to the gradient.
    pub fn moment_gradient(&self, state: &State, gradient: &mut Tangent) {
        for (frame, moment) in &self.moments {
            gradient.frames[*frame] -= state.frames[*frame].inverse_transform_vector(moment);
        }
    }

    /// Work of the dead moments over a step, `α Σ M·R θ`, J, to first order.
    pub fn moment_work(&self, state: &State, step: &Tangent, alpha: f64) -> f64 {
        self.moments.iter().map(|(c, m)| alpha * m.dot(&(state.frames[*c] * step.frames[*c]))).sum()
    }
}
