//! Signed distances in closed form, and shapes made of them.

use wireloom_core::obstacle::{Shape, Surface, Touch};
use wireloom_core::{Matrix, Vector};

/// A signed distance with its derivatives at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// φ, m.
    pub distance: f64,
    /// n = ∂φ/∂x, a unit vector.
    pub normal: Vector,
    /// ∂²φ/∂x², 1/m.
    pub curvature: Matrix,
}

impl Place {
    /// Straight: of a plane, or where the nearest place is not unique.
    pub fn flat(distance: f64, normal: Vector) -> Self {
        Self { distance, normal, curvature: Matrix::zeros() }
    }

    /// Distance from a point, seen from `r` beside it: φ = |r|, ∂²φ/∂x² = (I − n nᵀ)/|r|. At the point itself, where
    /// there is no direction, along z.
    pub fn round(r: &Vector) -> Self {
        let distance = r.norm();
        if distance < SINGULAR {
            return Self::flat(distance, Vector::z());
        }
        let normal = r / distance;
        Self { distance, normal, curvature: (Matrix::identity() - normal * normal.transpose()) / distance }
    }

    /// The surface at `distance` m from that one.
    pub fn grown(self, distance: f64) -> Self {
        Self { distance: self.distance - distance, ..self }
    }

    /// A wall: what lies between `inner` and `outer` m from where this distance is counted from.
    pub fn wall(self, inner: f64, outer: f64) -> Self {
        if inner > 0.0 && self.distance < 0.5 * (inner + outer) {
            return Self { distance: inner - self.distance, normal: -self.normal, curvature: -self.curvature };
        }
        self.grown(outer)
    }
}

/// Closer than this to the middle of a body, m, there is no direction out of it.
pub(crate) const SINGULAR: f64 = 1e-12;

/// A shape by its signed distance.
pub(crate) trait Field: Send + Sync {
    /// φ and its derivatives.
    fn at(&self, x: &Vector) -> Place;
    /// Whether the body is convex: φ is a convex function then.
    fn convex(&self) -> bool;
    /// A length, m, that is small beside the body.
    fn fineness(&self) -> f64;
    /// See [`Shape::surface`].
    fn outline(&self, size: f64) -> Surface;
}

/// A body whose surface is one part.
pub(crate) struct Primitive<F>(pub F);

impl<F: Field> Shape for Primitive<F> {
    fn distance(&self, x: &Vector, _: f64) -> f64 {
        self.0.at(x).distance
    }

    fn touches(&self, x: &Vector, reach: f64, see: &mut dyn FnMut(Touch)) {
        let Place { distance, normal, curvature } = self.0.at(x);
        if distance < reach {
            see(Touch { distance, normal, curvature, part: 0 });
        }
    }

    fn crossing(&self, from: &Vector, to: &Vector) -> Option<f64> {
        let way = to - from;
        let at = |t: f64| self.0.at(&(from + way * t));
        if self.0.convex() { crossing_of_convex(at, &way) } else { crossing_by_marching(at, &way, self.0.fineness()) }
    }

    fn surface(&self, size: f64) -> Surface {
        self.0.outline(size)
    }
}

/// Halvings after which an interval of fractions is as short as round-off.
const HALVINGS: usize = 52;

/// First crossing of a straight path and a convex body. Along the path φ is convex: from outside, the path enters if
/// the minimum of φ is negative.
fn crossing_of_convex(at: impl Fn(f64) -> Place, way: &Vector) -> Option<f64> {
    let (begin, end) = (at(0.0).distance, at(1.0).distance);
    if begin < 0.0 {
        return (end > 0.0).then(|| halve(0.0, 1.0, |t| at(t).distance < 0.0));
    }
    let lowest = halve(0.0, 1.0, |t| at(t).normal.dot(way) < 0.0);
    (at(lowest).distance < 0.0).then(|| halve(0.0, lowest, |t| at(t).distance >= 0.0))
}

/// First crossing by sphere tracing: steps of the distance, or of `fineness` if that is more. A chord of the body that
/// is shorter than `fineness` may be missed.
fn crossing_by_marching(at: impl Fn(f64) -> Place, way: &Vector, fineness: f64) -> Option<f64> {
    let length = way.norm();
    if length == 0.0 {
        return None;
    }
    if !length.is_finite() {
        // Its direction is not defined: it ends where it begins.
        return Some(0.0);
    }
    let outside = at(0.0).distance >= 0.0;
    let mut before = 0.0;
    while before < 1.0 {
        let next = before + at(before).distance.abs().max(fineness) / length;
        // On a very long path this may be less than round-off.
        let next = next.max(before.next_up()).min(1.0);
        if (at(next).distance >= 0.0) != outside {
            return Some(halve(before, next, |t| (at(t).distance >= 0.0) == outside));
        }
        before = next;
    }
    None
}

/// Bisection: the point between `low`, at which `still` holds, and `high` from which it does not hold.
fn halve(mut low: f64, mut high: f64, still: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if still(middle) { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball, treated as if it were not convex.
    fn ball(x: &Vector) -> Place {
        Place::round(x).grown(0.1)
    }

    /// A step along the way is then less than a fraction of it can resolve.
    #[test]
    fn a_way_that_is_far_too_long_comes_to_an_end() {
        let crossing = |from: Vector, to: Vector| {
            let way = to - from;
            crossing_by_marching(|t| ball(&(from + way * t)), &way, 1e-3)
        };
        let (near, far) = (Vector::new(-1.0, 0.0, 0.0), |x: f64| Vector::new(x, 0.0, 0.0));
        for length in [1e16, 1e30, 1e150] {
            assert_eq!(crossing(near, far(-length)), None);
            let fraction = crossing(near, far(length));
            assert!(fraction.is_none_or(|fraction| fraction * length < 1.0), "{fraction:?}");
        }
        assert_eq!(crossing(near, far(1e308)), Some(0.0), "the square of its length is no number");
        let fraction = crossing(near, far(1.0)).expect("through the ball");
        assert!((fraction - 0.45).abs() < 1e-12, "{fraction}");
    }
}
