//! Parallel transport of directions along a step.
//!
//! A step turns a frame along `q ∘ cay(αθ)`, a rotation about one body-fixed axis by `φ = 2 atan(|h|)` with
//! `h = ½ α θ`. Parallel transport in the bi-invariant metric of rotations turns the body components of any other
//! direction `u` back by half of φ, while the frame itself turns by φ (Edelman, Arias and Smith 1998, 2.2.3):
//!
//! ```text
//! u′ = exp(−½ φ [θ̂]ₓ) u = c u + c²/(1 + c) h (h·u) − c h × u,   c = cos(φ/2) = 1/√(1 + |h|²)
//! ```
//!
//! It preserves lengths, angles, and θ itself. Positions and arc lengths are flat: directions there do not change.

use wireloom_core::{Tangent, Vector};

/// Transports a direction or a gradient along `α step`.
pub(crate) fn transport(direction: &mut Tangent, step: &Tangent, alpha: f64) {
    for (u, theta) in direction.frames.iter_mut().zip(&step.frames) {
        let h = theta * (0.5 * alpha);
        let c = half_cosine(&h);
        *u = *u * c + h * (h.dot(u) * c * c / (1.0 + c)) - h.cross(u) * c;
    }
}

/// Derivative of the energy along the step at α, with the `gradient` of the state there: a frame turns by `c² θ` per
/// unit of α.
pub(crate) fn slope(gradient: &Tangent, step: &Tangent, alpha: f64) -> f64 {
    let points: f64 = gradient.points.iter().zip(&step.points).map(|(g, d)| g.dot(d)).sum();
    let frames: f64 = gradient
        .frames
        .iter()
        .zip(&step.frames)
        .map(|(g, theta)| g.dot(theta) * half_cosine(&(theta * (0.5 * alpha))).powi(2))
        .sum();
    let slides: f64 = gradient.slides.iter().zip(&step.slides).map(|(g, d)| g * d).sum();
    points + frames + slides
}

/// `c = cos(φ/2)`.
fn half_cosine(h: &Vector) -> f64 {
    1.0 / (1.0 + h.norm_squared()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom_core::rotation::turned;
    use wireloom_core::{Rotation, Vector};

    fn one(u: Vector) -> Tangent {
        Tangent { points: vec![Vector::new(1.0, 2.0, 3.0)], frames: vec![u], slides: vec![0.5] }
    }

    /// In world components parallel transport turns by half the turn of the frame, about the same axis.
    #[test]
    fn half_the_turn_in_space() {
        let (theta, u, alpha) = (Vector::new(0.7, -0.4, 1.1), Vector::new(0.3, 0.9, -0.2), 0.8);
        let q = Rotation::from_euler_angles(0.3, -1.0, 2.0);
        let to = turned(&q, &(theta * alpha));
        let mut moved = one(u);
        transport(&mut moved, &one(theta), alpha);
        let turn = to * q.inverse();
        let half = Rotation::identity().slerp(&turn, 0.5);
        let want = to.inverse_transform_vector(&(half * (q * u)));
        assert!((moved.frames[0] - want).norm() < 1e-15, "{} instead of {want}", moved.frames[0]);
        assert_eq!((moved.points, moved.slides), (one(u).points, one(u).slides));
    }

    #[test]
    fn transport_keeps_the_step_itself_and_lengths() {
        let (theta, u) = (Vector::new(1.7, -0.4, 0.3), Vector::new(0.3, 0.9, -0.2));
        let mut moved = one(theta);
        transport(&mut moved, &one(theta), 1.3);
        assert!((moved.frames[0] - theta).norm() < 1e-15);
        moved = one(u);
        transport(&mut moved, &one(theta), 1.3);
        assert!((moved.frames[0].norm() - u.norm()).abs() < 1e-15);
    }

    /// For the height of a point on the body.
    #[test]
    fn the_slope_is_the_derivative_along_the_turn() {
        let (theta, arm) = (Vector::new(0.9, -1.4, 0.6), Vector::new(0.2, 0.5, -0.3));
        let q = Rotation::from_euler_angles(0.3, -1.0, 2.0);
        let height = |alpha: f64| (turned(&q, &(theta * alpha)) * arm).z;
        let (alpha, h) = (0.7, 1e-5);
        let now = turned(&q, &(theta * alpha));
        // ∂/∂θ of e_z · R exp(θ) a = a × Rᵀ e_z
        let gradient = Tangent {
            points: vec![Vector::zeros()],
            frames: vec![arm.cross(&now.inverse_transform_vector(&Vector::z()))],
            slides: vec![0.0],
        };
        let want = (height(alpha + h) - height(alpha - h)) / (2.0 * h);
        let got = slope(&gradient, &one(theta), alpha);
        assert!((got - want).abs() < 1e-9, "{got} instead of {want}");
    }
}
