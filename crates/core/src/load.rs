//! Loads: forces and moments on places of a harness, and forces per length along it.
//!
//! What a load exerts depends on the frame of the cable alone. The built-in ones:
//!
//! | load | force or moment | potential |
//! | --- | --- | --- |
//! | [`Dead`], [`DeadLine`]: force, force per length | f, fixed in space | `−f·x` |
//! | [`Dead`]: moment | M, about an axis fixed in space | none |
//! | [`Follower`], [`FollowerLine`] | `R F`, `R M`: turns with the frame R | none |
//! | [`Flow`]: drag of a flow | `½ ρ C d |u| u`, u the velocity across the cable | none |
//!
//! What has no potential (Ziegler 1968, Principles of Structural Stability; Bolotin 1963, Nonconservative Problems of
//! the Theory of Elastic Stability) is in the balance of forces exactly, but in no energy: an equilibrium under it is
//! no minimum.
//!
//! For a load of your own implement [`PointLoad`] or [`LineLoad`], hold it against the suites
//! `wireloom_testkit::point_load_conformance` and `line_load_conformance`, and add it to the loads of a network.

use crate::rotation::{columns, skew};
use crate::{Matrix, Rotation, Vector};
use std::fmt::Debug;
use std::sync::Arc;

/// What a load exerts, and where: places are given as P, parts of branches as S.
#[derive(Clone, Debug)]
pub enum LoadAction<P, S> {
    /// Force and moment at a place.
    At {
        /// The place.
        place: P,
        /// What it exerts there.
        load: Arc<dyn PointLoad>,
    },
    /// Force per length along parts of branches.
    Along {
        /// The parts.
        spans: Vec<S>,
        /// What it exerts along them.
        load: Arc<dyn LineLoad>,
    },
}

impl<P, S> LoadAction<P, S> {
    /// The same with other places and parts.
    pub fn map<Q, T>(&self, place: impl FnOnce(&P) -> Q, span: impl FnMut(&S) -> T) -> LoadAction<Q, T> {
        match self {
            Self::At { place: at, load } => LoadAction::At { place: place(at), load: load.clone() },
            Self::Along { spans, load } => {
                LoadAction::Along { spans: spans.iter().map(span).collect(), load: load.clone() }
            }
        }
    }

    /// Why it has no potential; `None` if it has one.
    pub fn without_potential(&self) -> Option<&str> {
        match self {
            Self::At { load, .. } => load.without_potential(),
            Self::Along { load, .. } => load.without_potential(),
        }
    }
}

/// Axes in which a force and a moment are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// Those of the world.
    World,
    /// d1, d2, d3 of the frame at the place.
    Frame,
}

/// Force and moment at a place: one that is fixed in space, which has a potential, and one that has none.
///
/// Contract: twice differentiable in the frame, finite, the same bits for the same input.
pub trait PointLoad: Debug + Send + Sync {
    /// Force fixed in space, N, world axes: it has the potential `−f·x`.
    fn dead_force(&self) -> Vector {
        Vector::zeros()
    }
    /// Why it has no potential, such as "follows the cable"; `None` if the dead force is all of it.
    fn without_potential(&self) -> Option<&str>;
    /// Axes of [`Self::on`].
    fn axes(&self) -> Axes;
    /// Force (N) and moment (N m) beside the dead force, at a place with this frame.
    fn on(&self, frame: &Rotation) -> [Vector; 2];
    /// Derivatives of [`Self::on`] along `frame ∘ exp(θ)`, N and N m: columns θ.
    fn derivative(&self, frame: &Rotation) -> [Matrix; 2];
    /// Largest size of all its force (N) and moment (N m), over all frames.
    fn largest(&self) -> [f64; 2];
}

/// Force per unstressed length: one that is fixed in space, which has a potential, and one that has none.
///
/// Contract: as for [`PointLoad`]; the diameter is that of the cable, m.
pub trait LineLoad: Debug + Send + Sync {
    /// Force per length fixed in space, N/m, world axes: it has a potential.
    fn dead_force(&self) -> Vector {
        Vector::zeros()
    }
    /// Why it has no potential, such as "is the drag of a flow"; `None` if the dead force is all of it.
    fn without_potential(&self) -> Option<&str>;
    /// Force per length beside the dead force on a cable with this frame, N/m, world axes.
    fn on(&self, frame: &Rotation, diameter: f64) -> Vector;
    /// Derivative of [`Self::on`] along `frame ∘ exp(θ)`, N/m: columns θ.
    fn derivative(&self, frame: &Rotation, diameter: f64) -> Matrix;
    /// Largest size of all its force per length, over all frames, N/m.
    fn largest(&self, diameter: f64) -> f64;
    /// [`Self::on`] for many frames: one call for a part of a branch.
    fn on_all(&self, frames: &[Rotation], diameter: f64, forces: &mut [Vector]) {
        for (force, frame) in forces.iter_mut().zip(frames) {
            *force = self.on(frame, diameter);
        }
    }
    /// [`Self::derivative`] for many frames.
    fn derivative_all(&self, frames: &[Rotation], diameter: f64, derivatives: &mut [Matrix]) {
        for (derivative, frame) in derivatives.iter_mut().zip(frames) {
            *derivative = self.derivative(frame, diameter);
        }
    }
}

/// Force and moment fixed in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dead {
    /// N, world axes.
    pub force: Vector,
    /// N m, world axes.
    pub moment: Vector,
}

impl PointLoad for Dead {
    fn dead_force(&self) -> Vector {
        self.force
    }
    fn without_potential(&self) -> Option<&str> {
        (self.moment != Vector::zeros()).then_some("has a moment about an axis fixed in space")
    }
    fn axes(&self) -> Axes {
        Axes::World
    }
    fn on(&self, _: &Rotation) -> [Vector; 2] {
        [Vector::zeros(), self.moment]
    }
    fn derivative(&self, _: &Rotation) -> [Matrix; 2] {
        [Matrix::zeros(); 2]
    }
    fn largest(&self) -> [f64; 2] {
        [self.force.norm(), self.moment.norm()]
    }
}

/// Force and moment that turn with the frame at their place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follower {
    /// N, axes d1, d2, d3.
    pub force: Vector,
    /// N m, axes d1, d2, d3.
    pub moment: Vector,
}

impl PointLoad for Follower {
    fn without_potential(&self) -> Option<&str> {
        Some("follows the cable")
    }
    fn axes(&self) -> Axes {
        Axes::Frame
    }
    fn on(&self, _: &Rotation) -> [Vector; 2] {
        [self.force, self.moment]
    }
    fn derivative(&self, _: &Rotation) -> [Matrix; 2] {
        [Matrix::zeros(); 2]
    }
    fn largest(&self) -> [f64; 2] {
        [self.force.norm(), self.moment.norm()]
    }
}

/// Force per length fixed in space, N/m, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadLine(pub Vector);

impl LineLoad for DeadLine {
    fn dead_force(&self) -> Vector {
        self.0
    }
    fn without_potential(&self) -> Option<&str> {
        None
    }
    fn on(&self, _: &Rotation, _: f64) -> Vector {
        Vector::zeros()
    }
    fn derivative(&self, _: &Rotation, _: f64) -> Matrix {
        Matrix::zeros()
    }
    fn largest(&self, _: f64) -> f64 {
        self.0.norm()
    }
}

/// Force per length that turns with the frame of the cable, N/m, axes d1, d2, d3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowerLine(pub Vector);

impl LineLoad for FollowerLine {
    fn without_potential(&self) -> Option<&str> {
        Some("follows the cable")
    }
    fn on(&self, frame: &Rotation, _: f64) -> Vector {
        frame * self.0
    }
    fn derivative(&self, frame: &Rotation, _: f64) -> Matrix {
        turned(frame, &self.0)
    }
    fn largest(&self, _: f64) -> f64 {
        self.0.norm()
    }
}

/// Derivative of `R v` along `R ∘ exp(θ)`.
fn turned(frame: &Rotation, v: &Vector) -> Matrix {
    -(frame.to_rotation_matrix().matrix() * skew(v))
}

/// Flow of a fluid across a cable of circular section.
///
/// The drag per length is `f = k |u| u` with `u = v − (v·t) t`, v the velocity of the fluid, t the tangent of the cable
/// and `k = ½ ρ C d`, d the diameter: it depends on the velocity across the cable alone (independence principle:
/// Hoerner 1965, Fluid-Dynamic Drag, chapter III). Friction along the cable is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// v, m/s, world axes.
    pub velocity: Vector,
    /// `½ ρ C`, kg/m³.
    pub drag: f64,
}

/// With `δt = R (θ × e3)`, `δu = −(v·t) δt − t (v·δt)` and `δf = k (|u| I + u uᵀ/|u|) δu`.
impl LineLoad for Flow {
    fn without_potential(&self) -> Option<&str> {
        Some("is the drag of a flow")
    }
    fn on(&self, frame: &Rotation, diameter: f64) -> Vector {
        let across = across(&self.velocity, &columns(frame)[2]);
        across * (self.drag * diameter * across.norm())
    }
    fn derivative(&self, frame: &Rotation, diameter: f64) -> Matrix {
        let (v, t) = (&self.velocity, columns(frame)[2]);
        let u = across(v, &t);
        let speed = u.norm();
        if speed == 0.0 {
            return Matrix::zeros();
        }
        let of_u = Matrix::identity() * speed + u * u.transpose() / speed;
        let of_t = -(Matrix::identity() * v.dot(&t) + t * v.transpose());
        of_u * of_t * turned(frame, &Vector::z()) * (self.drag * diameter)
    }
    fn largest(&self, diameter: f64) -> f64 {
        self.drag * diameter * self.velocity.norm_squared()
    }
}

/// Part of a velocity across a tangent.
fn across(velocity: &Vector, tangent: &Vector) -> Vector {
    velocity - tangent * velocity.dot(tangent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flow_along_the_cable_exerts_nothing_and_one_across_it_the_whole_drag() {
        let along = Flow { velocity: Vector::z() * 5.0, drag: 2.0 };
        assert_eq!(along.on(&Rotation::identity(), 0.1), Vector::zeros());
        assert_eq!(along.derivative(&Rotation::identity(), 0.1), Matrix::zeros());
        let across = Flow { velocity: Vector::x() * 5.0, drag: 2.0 };
        assert_eq!(across.on(&Rotation::identity(), 0.1), Vector::x() * 5.0);
    }
}
