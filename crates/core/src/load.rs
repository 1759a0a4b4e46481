//! Loads: forces and moments on places of a harness, and forces per length along it.
//!
//! | load | force or moment | potential |
//! | --- | --- | --- |
//! | dead force, force per length | f, fixed in space | `−f·x` |
//! | dead moment | M, about an axis fixed in space | none |
//! | follower force, moment, force per length | `R F`, `R M`: turns with the frame R | none |
//! | drag of a flow | `½ ρ C d |u| u`, u the velocity across the cable | none |
//!
//! What has no potential (Ziegler 1968, Principles of Structural Stability; Bolotin 1963, Nonconservative Problems of
//! the Theory of Elastic Stability) is in the balance of forces exactly, but in no energy: an equilibrium under it is
//! no minimum.

use crate::rotation::{columns, skew};
use crate::{Matrix, Rotation, Vector};

/// What a load exerts, and where: places are given as P, parts of branches as S.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadAction<P, S> {
    /// Force and moment at a place.
    At {
        /// The place.
        place: P,
        /// Force, N.
        force: Vector,
        /// Moment, N m.
        moment: Vector,
        /// Whether both turn with the frame at the place: their axes are then d1, d2, d3, otherwise those of the
        /// world.
        follows: bool,
    },
    /// Force per length along parts of branches.
    Along {
        /// The parts.
        spans: Vec<S>,
        /// The force per length.
        force: LineForce,
    },
}

impl<P, S> LoadAction<P, S> {
    /// The same with other places and parts.
    pub fn map<Q, T>(&self, place: impl FnOnce(&P) -> Q, span: impl FnMut(&S) -> T) -> LoadAction<Q, T> {
        match self {
            Self::At { place: at, force, moment, follows } => {
                LoadAction::At { place: place(at), force: *force, moment: *moment, follows: *follows }
            }
            Self::Along { spans, force } => {
                LoadAction::Along { spans: spans.iter().map(span).collect(), force: *force }
            }
        }
    }
}

/// Force per unstressed length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LineForce {
    /// Fixed in space, N/m, world axes.
    Dead(Vector),
    /// Turns with the frame of the cable, N/m, axes d1, d2, d3.
    Follower(Vector),
    /// Drag of a flow.
    Flow(Flow),
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

impl LineForce {
    /// Why it has no potential; `None` if it has one.
    pub(crate) fn without_potential(&self) -> Option<&'static str> {
        match self {
            Self::Dead(_) => None,
            Self::Follower(_) => Some("follows the cable"),
            Self::Flow(_) => Some("is the drag of a flow"),
        }
    }

    /// Force per length on a cable with this frame and diameter (m), N/m, world axes.
    pub fn on(&self, frame: &Rotation, diameter: f64) -> Vector {
        match self {
            Self::Dead(force) => *force,
            Self::Follower(force) => frame * force,
            Self::Flow(Flow { velocity, drag }) => {
                let across = across(velocity, &columns(frame)[2]);
                across * (*drag * diameter * across.norm())
            }
        }
    }

    /// Derivative of [`Self::on`] along `frame ∘ exp(θ)`, N/m: columns θ. For a flow, with `δt = R (θ × e3)`,
    /// `δu = −(v·t) δt − t (v·δt)` and `δf = k (|u| I + u uᵀ/|u|) δu`.
    pub fn derivative(&self, frame: &Rotation, diameter: f64) -> Matrix {
        let turned = |v: &Vector| -(frame.to_rotation_matrix().matrix() * skew(v));
        match self {
            Self::Dead(_) => Matrix::zeros(),
            Self::Follower(force) => turned(force),
            Self::Flow(Flow { velocity: v, drag }) => {
                let t = columns(frame)[2];
                let u = across(v, &t);
                let speed = u.norm();
                if speed == 0.0 {
                    return Matrix::zeros();
                }
                let of_u = Matrix::identity() * speed + u * u.transpose() / speed;
                let of_t = -(Matrix::identity() * v.dot(&t) + t * v.transpose());
                of_u * of_t * turned(&Vector::z()) * (*drag * diameter)
            }
        }
    }

    /// Largest size that it can have on a cable of this diameter (m), N/m.
    pub fn largest(&self, diameter: f64) -> f64 {
        match self {
            Self::Dead(force) | Self::Follower(force) => force.norm(),
            Self::Flow(Flow { velocity, drag }) => drag * diameter * velocity.norm_squared(),
        }
    }
}

/// Part of a velocity across a tangent.
fn across(velocity: &Vector, tangent: &Vector) -> Vector {
    velocity - tangent * velocity.dot(tangent)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Central differences of step 1e-5 err by their square, relative to forces of order 10.
    #[test]
    fn derivatives_are_those_of_the_forces() {
        let flow = Flow { velocity: Vector::new(3.0, -2.0, 4.0), drag: 0.7 };
        let forces = [LineForce::Follower(Vector::new(1.0, 2.0, -3.0)), LineForce::Flow(flow)];
        let frame = Rotation::from_scaled_axis(Vector::new(0.4, -1.1, 0.7));
        for force in forces {
            let derivative = force.derivative(&frame, 0.9);
            for k in 0..3 {
                let theta = Vector::ith(k, 1e-5);
                let at = |theta: Vector| force.on(&(frame * Rotation::from_scaled_axis(theta)), 0.9);
                let found = (at(theta) - at(-theta)) / 2e-5;
                assert!((derivative.column(k) - found).norm() < 1e-7, "{force:?}, {k}: {found}");
            }
        }
    }

    #[test]
    fn a_flow_along_the_cable_exerts_nothing_and_one_across_it_the_whole_drag() {
        let along = LineForce::Flow(Flow { velocity: Vector::z() * 5.0, drag: 2.0 });
        assert_eq!(along.on(&Rotation::identity(), 0.1), Vector::zeros());
        assert_eq!(along.derivative(&Rotation::identity(), 0.1), Matrix::zeros());
        let across = LineForce::Flow(Flow { velocity: Vector::x() * 5.0, drag: 2.0 });
        assert_eq!(across.on(&Rotation::identity(), 0.1), Vector::x() * 5.0);
    }
}
