//! State of a harness and its tangent space. They are different types, connected by [`Network::retract`].

use crate::rod::BranchShape;
use crate::rotation::turned;
use crate::{Network, Pose, Rotation, Vector};
use serde::{Deserialize, Serialize};

/// Positions and frames of a whole harness; see [`Network`] for the indices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Positions, m.
    pub points: Vec<Vector>,
    /// Low-order parts of the positions, m: a position is `points + compensation`, unevaluated, so that strains
    /// are not limited by the round-off of coordinates.
    pub compensation: Vec<Vector>,
    /// Frames.
    pub frames: Vec<Rotation>,
    /// ℓ_j, m, at the index of the segment's first node: those of the meshes, unless a constraint slides. 0 for
    /// joints and last nodes.
    pub rest_lengths: Vec<f64>,
    /// λ_c, m, at the index of the coupling's first frame.
    pub coupling_lengths: Vec<f64>,
}

/// A direction of motion or a gradient: one vector for each point and each frame of a [`State`].
#[derive(Clone, Debug, PartialEq)]
pub struct Tangent {
    /// δx (m), or ∂E/∂x (N).
    pub points: Vec<Vector>,
    /// θ (rad, body frame), or ∂E/∂θ (N m).
    pub frames: Vec<Vector>,
    /// For each sliding constraint (see [`Network::slides`]) the change of its arc length (m), or ∂E/∂s (N).
    pub slides: Vec<f64>,
}

impl Tangent {
    /// All zero.
    pub fn zeros(network: &Network) -> Self {
        Self {
            points: vec![Vector::zeros(); network.points],
            frames: vec![Vector::zeros(); network.frames],
            slides: vec![0.0; network.slides.len()],
        }
    }

    /// Overwrites with another one of the same network, without allocating.
    pub fn copy_from(&mut self, other: &Tangent) {
        self.points.copy_from_slice(&other.points);
        self.frames.copy_from_slice(&other.frames);
        self.slides.copy_from_slice(&other.slides);
    }

    /// Overwrites with zeros.
    pub fn clear(&mut self) {
        self.points.fill(Vector::zeros());
        self.frames.fill(Vector::zeros());
        self.slides.fill(0.0);
    }

    /// Scalar product.
    pub fn dot(&self, other: &Tangent) -> f64 {
        let dot = |a: &[Vector], b: &[Vector]| -> f64 { a.iter().zip(b).map(|(a, b)| a.dot(b)).sum() };
        let slides: f64 = self.slides.iter().zip(&other.slides).map(|(a, b)| a * b).sum();
        dot(&self.points, &other.points) + dot(&self.frames, &other.frames) + slides
    }

    /// `self + alpha other`, in place.
    pub fn add_scaled(&mut self, alpha: f64, other: &Tangent) {
        for (a, b) in self.points.iter_mut().zip(&other.points).chain(self.frames.iter_mut().zip(&other.frames)) {
            *a += b * alpha;
        }
        for (a, b) in self.slides.iter_mut().zip(&other.slides) {
            *a += b * alpha;
        }
    }
}

impl State {
    /// State with all points at the origin and identity frames.
    pub fn origin(network: &Network) -> Self {
        let mut state = Self {
            points: vec![Vector::zeros(); network.points],
            compensation: vec![Vector::zeros(); network.points],
            frames: vec![Rotation::identity(); network.frames],
            rest_lengths: vec![0.0; network.points],
            coupling_lengths: vec![0.0; network.frames],
        };
        for branch in &network.branches {
            let mesh = branch.rod.mesh();
            state.rest_lengths[branch.points.start..][..mesh.segments()].copy_from_slice(&mesh.rest_lengths);
            let couplings = &mesh.coupling_lengths;
            state.coupling_lengths[branch.frames.start..][..couplings.len()].copy_from_slice(couplings);
        }
        state
    }

    /// The shape of one branch, without its memory: for its geometry. See [`crate::Problem::shape`].
    #[inline]
    pub fn branch(&self, network: &Network, branch: usize) -> BranchShape<'_> {
        let b = &network.branches[branch];
        BranchShape {
            points: &self.points[b.points.clone()],
            compensation: &self.compensation[b.points.clone()],
            frames: &self.frames[b.frames.clone()],
            rest_lengths: &self.rest_lengths[b.points.start..b.points.end - 1],
            coupling_lengths: &self.coupling_lengths[b.frames.start..b.frames.end - 1],
            free_strain: 0.0,
            extra_curvature: &[],
            memory: &[],
            duration: 0.0,
        }
    }

    /// Unstressed arc length of every node of a branch, m.
    pub fn arc_lengths(&self, network: &Network, branch: usize) -> Vec<f64> {
        let lengths = self.branch(network, branch).rest_lengths;
        let sums = lengths.iter().scan(0.0, |s, l| {
            *s += l;
            Some(*s)
        });
        std::iter::once(0.0).chain(sums).collect()
    }

    /// Pose of a site; the identity orientation for a site without a frame.
    pub fn pose(&self, site: &crate::network::Site) -> Pose {
        let carrier = Pose {
            position: self.points[site.point] + self.compensation[site.point],
            orientation: site.frame.map_or_else(Rotation::identity, |f| self.frames[f]),
        };
        carrier.compose(&site.local)
    }

    /// Overwrites with another state of the same network, without allocating.
    pub fn copy_from(&mut self, other: &State) {
        self.points.copy_from_slice(&other.points);
        self.compensation.copy_from_slice(&other.compensation);
        self.frames.copy_from_slice(&other.frames);
        self.copy_lengths_from(other);
    }

    /// Overwrites the lengths only.
    pub(crate) fn copy_lengths_from(&mut self, other: &State) {
        self.rest_lengths.copy_from_slice(&other.rest_lengths);
        self.coupling_lengths.copy_from_slice(&other.coupling_lengths);
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.points.iter().all(|p| p.iter().all(|x| x.is_finite()))
            && self.frames.iter().all(|q| q.coords.iter().all(|x| x.is_finite()))
    }
}

/// `x + δ` with its rounding error: the error-free sum of Knuth.
#[inline(always)]
fn add_exactly(x: f64, compensation: f64, delta: f64) -> (f64, f64) {
    let delta = delta + compensation;
    let sum = x + delta;
    let virtual_delta = sum - x;
    let error = (x - (sum - virtual_delta)) + (delta - virtual_delta);
    (sum, error)
}

impl Network {
    /// `to = from ⊕ α step`: points move by α δ, frames turn by α θ (see [`crate::rotation::turned`]), and tied
    /// points and frames follow their joints.
    pub fn retract(&self, from: &State, step: &Tangent, alpha: f64, to: &mut State) {
        for i in 0..self.points {
            let (x, c, d) = (&from.points[i], &from.compensation[i], &step.points[i]);
            for k in 0..3 {
                let (sum, error) = add_exactly(x[k], c[k], alpha * d[k]);
                to.points[i][k] = sum;
                to.compensation[i][k] = error;
            }
        }
        for c in 0..self.frames {
            to.frames[c] = turned(&from.frames[c], &(step.frames[c] * alpha));
        }
        to.copy_lengths_from(from);
        self.follow_ties(to);
    }

    /// Moves points by δ (m) without turning frames.
    pub fn shift_points(&self, state: &mut State, step: &Tangent) {
        for ((x, compensation), d) in state.points.iter_mut().zip(&mut state.compensation).zip(&step.points) {
            for k in 0..3 {
                (x[k], compensation[k]) = add_exactly(x[k], compensation[k], d[k]);
            }
        }
        self.follow_ties(state);
    }

    /// Moves tied points and frames with their joints.
    pub fn follow_ties(&self, state: &mut State) {
        for tie in &self.ties {
            let (hub, compensation) = (state.points[tie.hub_point], state.compensation[tie.hub_point]);
            state.points[tie.point] = hub;
            state.compensation[tie.point] = compensation;
            if let Some(frame) = tie.hub_frame {
                let q = state.frames[frame];
                let offset = q * tie.offset;
                for k in 0..3 {
                    let (sum, error) = add_exactly(hub[k], compensation[k], offset[k]);
                    state.points[tie.point][k] = sum;
                    state.compensation[tie.point][k] = error;
                }
                if let Some(own) = tie.frame {
                    state.frames[own] = q * tie.rest;
                }
            }
        }
    }

    /// Pulls a gradient back to the independent variables: the force on a tied point and the moment on a tied frame act
    /// on its joint, with o the offset `g_θ += o × Rᵀ g_x`; the tied entries become zero.
    pub fn pull_back(&self, state: &State, gradient: &mut Tangent) {
        for tie in &self.ties {
            let force = std::mem::take(&mut gradient.points[tie.point]);
            gradient.points[tie.hub_point] += force;
            if let Some(hub) = tie.hub_frame {
                let body_force = state.frames[hub].inverse_transform_vector(&force);
                gradient.frames[hub] += tie.offset.cross(&body_force);
                if let Some(own) = tie.frame {
                    let moment = std::mem::take(&mut gradient.frames[own]);
                    gradient.frames[hub] += tie.rest * moment;
                }
            }
        }
    }

    /// Extends a step of the independent variables to what is tied to the joints (to first order).
    pub fn push_forward(&self, state: &State, step: &mut Tangent) {
        for tie in &self.ties {
            step.points[tie.point] = step.points[tie.hub_point];
            if let Some(hub) = tie.hub_frame {
                let theta = step.frames[hub];
                step.points[tie.point] += state.frames[hub] * theta.cross(&tie.offset);
                if let Some(own) = tie.frame {
                    step.frames[own] = tie.rest.inverse_transform_vector(&theta);
                }
            }
        }
    }
}
