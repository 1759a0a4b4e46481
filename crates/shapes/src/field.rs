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
/// φ is negative anywhere.
fn crossing_of_convex(at: impl Fn(f64) -> Place, way: &Vector) -> Option<f64> {
    let [start, end] = [at(0.0), at(1.0)];
    if start.distance < 0.0 {
        return (end.distance > 0.0).then(|| halve(0.0, 1.0, |t| at(t).distance < 0.0));
    }
    let inside = if end.distance < 0.0 { Some(1.0) } else { inside_convex(&at, [start, end], way) };
    inside.map(|inside| halve(0.0, inside, |t| at(t).distance >= 0.0))
}

/// A fraction of a straight path at which it is inside a convex body, with both ends outside. φ is above its tangents,
/// so where those of two places meet it is least between them.
fn inside_convex(at: &impl Fn(f64) -> Place, [start, end]: [Place; 2], way: &Vector) -> Option<f64> {
    let slope = |place: &Place| place.normal.dot(way);
    let (mut low, mut high) = ((0.0, start.distance, slope(&start)), (1.0, end.distance, slope(&end)));
    for _ in 0..HALVINGS {
        let ((a, first, falls), (b, last, rises)) = (low, high);
        if falls >= 0.0 || rises <= 0.0 {
            return None;
        }
        let meet = (last - first + falls * a - rises * b) / (falls - rises);
        if first + falls * (meet - a) >= 0.0 {
            return None;
        }
        let t = if a < meet && meet < b { meet } else { 0.5 * (a + b) };
        let place = at(t);
        if place.distance < 0.0 {
            return Some(t);
        }
        let slope = slope(&place);
        if slope < 0.0 { low = (t, place.distance, slope) } else { high = (t, place.distance, slope) }
    }
    None
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

    /// The tangents of φ tell of most paths at once that they pass by.
    #[test]
    fn paths_by_a_convex_body_enter_it_where_their_lowest_place_is_inside() {
        let mut seed = 7_u64;
        let mut number = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let (mut entered, mut evaluations) = (0, 0);
        for _ in 0..2000 {
            let [from, to] = [0, 1].map(|_| Vector::from_fn(|_, _| 0.5 * number()));
            let way = to - from;
            let at = |t: f64| ball(&(from + way * t));
            let lowest = (-from.dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
            let enters = at(0.0).distance >= 0.0 && at(lowest).distance < 0.0;
            let calls = std::cell::Cell::new(0);
            let counted = |t: f64| {
                calls.set(calls.get() + 1);
                at(t)
            };
            let found = crossing_of_convex(counted, &way).filter(|_| at(0.0).distance >= 0.0);
            assert_eq!(found.is_some(), enters, "from {from} to {to}");
            assert!(found.is_none_or(|t| at(t).distance.abs() < 1e-12), "{found:?}");
            if enters {
                entered += 1;
            } else if at(0.0).distance >= 0.0 {
                evaluations += calls.get();
            }
        }
        assert!(entered > 100 && evaluations < 4 * (2000 - entered), "{entered} entered, {evaluations} evaluations");
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
