//! Dead forces and moments: weight that stays at its nodes, masses of joints, and loads.
//!
//! A dead moment M about an axis fixed in space has no potential. It adds `−Rᵀ M` to the gradient; the derivative
//! of that along `q ∘ exp(θ)`, pulled back to θ as all second derivatives are, is `−½ [Rᵀ M]ₓ`:
//! antisymmetric, so that [`crate::Problem::hessian`] does not contain it.

use super::gravity;
use crate::conditions::System;
use crate::{Network, State, Tangent, Vector};

/// Term of the dead loads.
pub struct LoadTerm {
    /// Dead force at every point, N; without the weight of branches whose mesh may move along them.
    forces: Vec<Vector>,
    /// Dead moment (world) by independent frame, N m.
    moments: Vec<(usize, Vector)>,
    /// Fraction of the dead moments that acts.
    moment_fraction: f64,
}

impl LoadTerm {
    /// No loads yet; see [`Self::update`].
    pub fn new(network: &Network) -> Self {
        Self {
            forces: vec![Vector::zeros(); network.points],
            moments: Vec::with_capacity(network.loads.len()),
            moment_fraction: 1.0,
        }
    }

    /// Lumps weights and loads anew, after a change of the conditions.
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

    /// Dead force at every point of the state, N: weight and loads; of points that ride on a joint, too. Without the
    /// weight of branches whose mesh may move along them.
    pub fn forces(&self) -> &[Vector] {
        &self.forces
    }

    /// Dead moments that act: the independent frame that takes each of them, and the moment, N m, world axes.
    pub fn moments(&self) -> &[(usize, Vector)] {
        &self.moments
    }

    /// Sets the fraction of the dead moments that acts from the next [`Self::update`] on, 0 to 1.
    pub fn set_moment_fraction(&mut self, fraction: f64) {
        self.moment_fraction = fraction;
    }

    /// Potential energy of the loads, J, without weight.
    pub fn energy(&self, system: System<'_>, state: &State) -> f64 {
        let mut energy = 0.0;
        for (load, factor) in system.network.loads.iter().zip(&system.conditions.load_factors) {
            energy -= factor * load.force.dot(&state.points[load.point]);
        }
        energy
    }

    /// Potential energy of all dead forces, weight included, J.
    pub fn energy_with_weight(&self, state: &State) -> f64 {
        self.forces.iter().zip(&state.points).map(|(f, x)| -f.dot(x)).sum()
    }

    /// Adds the first derivatives of the dead forces, and their work to `energy` (J) and, without its sign, to
    /// `magnitude`.
    pub fn force_gradient(&self, state: &State, gradient: &mut Tangent, energy: &mut f64, magnitude: &mut f64) {
        for ((g, x), f) in gradient.points.iter_mut().zip(&state.points).zip(&self.forces) {
            *g -= f;
            let work = f.dot(x);
            *energy -= work;
            *magnitude += work.abs();
        }
    }

    /// Adds the generalised forces of the dead moments to the gradient.
    pub fn moment_gradient(&self, state: &State, gradient: &mut Tangent) {
        for (frame, moment) in &self.moments {
            gradient.frames[*frame] -= state.frames[*frame].inverse_transform_vector(moment);
        }
    }

    /// Work of the dead moments over a step, J, to first order.
    pub fn moment_work(&self, state: &State, step: &Tangent, alpha: f64) -> f64 {
        self.moments.iter().map(|(c, m)| alpha * m.dot(&(state.frames[*c] * step.frames[*c]))).sum()
    }
}
