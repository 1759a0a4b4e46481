//! Checks of [`Shape`], one for each clause of its contract.

use super::numeric::{random_direction, uniform};
use fastrand::Rng;
use wireloom_core::Vector;
use wireloom_core::obstacle::{Shape, Surface, Touch};

/// Makes the shape under test.
pub type Factory<'f> = dyn Fn() -> Box<dyn Shape> + 'f;

const CASES: usize = 400;
/// Cases without a kink near by that there must be, or a check says nothing.
const SMOOTH: usize = 100;
const ROUND_OFF: f64 = 1e-10;
const DIFFERENCES: f64 = 1e-6;

/// Size at which an unbounded shape is drawn, m.
const DRAWN: f64 = 0.5;

/// A shape, its surface and its size, and points about it.
struct Subject {
    shape: Box<dyn Shape>,
    surface: Surface,
    size: f64,
}

impl Subject {
    fn of(factory: &Factory<'_>) -> Self {
        let shape = factory();
        let surface = shape.surface(DRAWN);
        assert!(!surface.triangles.is_empty(), "it has a surface");
        let size = surface.corners.iter().map(|corner| corner.amax()).fold(0.0, f64::max);
        assert!(size.is_finite() && size > 0.0, "size {size}");
        Self { shape, surface, size }
    }

    /// Reach of queries, m.
    fn reach(&self) -> f64 {
        0.3 * self.size
    }

    fn corners(&self, triangle: usize) -> [Vector; 3] {
        self.surface.triangles[triangle].map(|k| self.surface.corners[k as usize])
    }

    /// A point within reach of the surface.
    fn point(&self, rng: &mut Rng) -> Vector {
        let [a, b, c] = self.corners(rng.usize(..self.surface.triangles.len()));
        let (mut s, mut t) = (rng.f64(), rng.f64());
        if s + t > 1.0 {
            (s, t) = (1.0 - s, 1.0 - t);
        }
        a + (b - a) * s + (c - a) * t + *random_direction(rng) * (self.reach() * uniform(rng))
    }

    fn touches(&self, x: &Vector) -> Vec<Touch> {
        let mut touches = Vec::new();
        self.shape.touches(x, self.reach(), &mut |touch| touches.push(touch));
        touches
    }

    fn touch_of(&self, x: &Vector, part: u32) -> Option<Touch> {
        self.touches(x).into_iter().find(|touch| touch.part == part)
    }
}

/// `|∂φ/∂x| = 1`, and so `(∂²φ/∂x²) n = 0`; second derivatives are symmetric.
pub fn normals_are_unit_vectors_along_which_nothing_bends(factory: &Factory<'_>) {
    let (subject, mut rng) = (Subject::of(factory), Rng::with_seed(71));
    let mut seen = 0;
    for _ in 0..CASES {
        let x = subject.point(&mut rng);
        for Touch { normal, curvature, .. } in subject.touches(&x) {
            seen += 1;
            assert!((normal.norm() - 1.0).abs() < ROUND_OFF, "|n| = {} at {x:?}", normal.norm());
            let scale = ROUND_OFF * (1.0 + curvature.norm());
            assert!((curvature - curvature.transpose()).norm() < scale, "{curvature} at {x:?}");
            assert!((curvature * normal).norm() < scale, "{} along the normal at {x:?}", curvature * normal);
        }
    }
    assert!(seen >= SMOOTH, "{seen} touches only");
}

/// `n = ∂φ/∂x` by differences, of each part by itself.
pub fn normals_are_the_derivative_of_the_distance(factory: &Factory<'_>) {
    let (subject, mut rng) = (Subject::of(factory), Rng::with_seed(72));
    let h = 1e-6 * subject.size;
    let mut smooth = 0;
    for _ in 0..CASES {
        let (x, along) = (subject.point(&mut rng), random_direction(&mut rng));
        for touch in subject.touches(&x) {
            let beside = [-h, h].map(|h| subject.touch_of(&(x + *along * h), touch.part));
            let [Some(before), Some(after)] = beside else { continue };
            if (after.normal - before.normal).norm() > 1e-3 {
                continue;
            }
            smooth += 1;
            let (expected, found) = ((after.distance - before.distance) / (2.0 * h), touch.normal.dot(&along));
            assert!((expected - found).abs() < DIFFERENCES, "∂φ {found}, by differences {expected}, at {x:?}");
        }
    }
    assert!(smooth >= SMOOTH, "{smooth} smooth cases only");
}

/// `∂²φ/∂x²` by differences of normals.
pub fn curvature_is_the_derivative_of_the_normal(factory: &Factory<'_>) {
    let (subject, mut rng) = (Subject::of(factory), Rng::with_seed(73));
    let h = 1e-6 * subject.size;
    let mut smooth = 0;
    for _ in 0..CASES {
        let (x, along) = (subject.point(&mut rng), random_direction(&mut rng));
        for touch in subject.touches(&x) {
            let beside = [-h, h].map(|h| subject.touch_of(&(x + *along * h), touch.part));
            let [Some(before), Some(after)] = beside else { continue };
            let scale = touch.curvature.norm() + 1.0 / subject.size;
            let turned = (after.curvature - before.curvature).norm() > 1e-3 * scale;
            if turned || (after.normal - before.normal).norm() > 1e-3 {
                continue;
            }
            smooth += 1;
            let (expected, found) = ((after.normal - before.normal) / (2.0 * h), touch.curvature * *along);
            let off = (expected - found).norm();
            assert!(off < 10.0 * DIFFERENCES * scale, "∂n {found:?}, by differences {expected:?}, at {x:?}");
        }
    }
    assert!(smooth >= SMOOTH, "{smooth} smooth cases only");
}

/// φ is the least of the distances of all parts, and beyond reach there is none.
pub fn the_distance_is_that_of_the_nearest_touch(factory: &Factory<'_>) {
    let (subject, mut rng) = (Subject::of(factory), Rng::with_seed(74));
    for _ in 0..CASES {
        let x = subject.point(&mut rng);
        let distance = subject.shape.distance(&x, subject.reach());
        let least = subject.touches(&x).iter().map(|touch| touch.distance).reduce(f64::min);
        match least {
            Some(least) => {
                assert!((distance - least).abs() < ROUND_OFF * subject.size, "φ = {distance}, touch {least} at {x:?}");
            }
            None => assert!(distance >= subject.reach(), "φ = {distance} and no touch at {x:?}"),
        }
    }
}

/// Parts by number, each once, and nearer than reach.
pub fn parts_come_in_order_and_within_reach(factory: &Factory<'_>) {
    let (subject, mut rng) = (Subject::of(factory), Rng::with_seed(75));
    for _ in 0..CASES {
        let x = subject.point(&mut rng);
        let touches = subject.touches(&x);
        assert!(touches.iter().all(|touch| touch.distance < subject.reach()), "{touches:?}");
        assert!(touches.windows(2).all(|pair| pair[0].part < pair[1].part), "{touches:?} at {x:?}");
    }
}

/// `|φ(x) − φ(y)| ≤ |x − y|`.
pub fn the_distance_grows_no_faster_than_the_way(factory: &Factory<'_>) {
    let (subject, mut rng) = (Subject::of(factory), Rng::with_seed(76));
    for _ in 0..CASES {
        let (x, y) = (subject.point(&mut rng), subject.point(&mut rng));
        let [at_x, at_y] = [x, y].map(|x| subject.shape.distance(&x, f64::INFINITY));
        assert!((at_x - at_y).abs() <= (x - y).norm() + ROUND_OFF * subject.size, "{at_x} at {x:?}, {at_y} at {y:?}");
    }
}

/// Corners of the triangles lie on it; in front of a triangle φ is greater than behind.
pub fn the_surface_is_where_the_distance_is_zero_and_faces_outward(factory: &Factory<'_>) {
    let subject = Subject::of(factory);
    for corner in &subject.surface.corners {
        let distance = subject.shape.distance(corner, f64::INFINITY);
        assert!(distance.abs() < ROUND_OFF * subject.size, "φ = {distance} at the corner {corner:?}");
    }
    let every = subject.surface.triangles.len().div_ceil(CASES);
    for triangle in (0..subject.surface.triangles.len()).step_by(every) {
        let [a, b, c] = subject.corners(triangle);
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { continue };
        let (middle, off) = ((a + b + c) / 3.0, 0.01 * subject.size);
        let [behind, before] = [-off, off].map(|h| subject.shape.distance(&(middle + normal * h), f64::INFINITY));
        // A sheet is solid on both sides.
        assert!(before > behind || (before - behind).abs() < ROUND_OFF, "{before} before, {behind} behind {middle:?}");
    }
}

/// From outside to inside or back there is a way through; where there is none, there is no change of sign.
pub fn ways_cross_where_the_sign_changes(factory: &Factory<'_>) {
    let (subject, mut rng) = (Subject::of(factory), Rng::with_seed(78));
    let mut crossings = 0;
    for _ in 0..CASES {
        let (from, to) = (subject.point(&mut rng), subject.point(&mut rng));
        let at = |t: f64| subject.shape.distance(&(from + (to - from) * t), f64::INFINITY);
        match subject.shape.crossing(&from, &to) {
            Some(share) => {
                crossings += 1;
                assert!((0.0..=1.0).contains(&share), "share {share}");
                assert!(at(share).abs() < 1e-9 * subject.size, "φ = {} where it crosses", at(share));
                let all_before = (0..20).all(|k| at(share * f64::from(k) / 20.0) * at(0.0) >= 0.0);
                assert!(all_before, "it crosses before {share} between {from:?} and {to:?}");
            }
            None => assert!(at(0.0) * at(1.0) >= 0.0, "from {} to {} without crossing", at(0.0), at(1.0)),
        }
    }
    assert!(crossings > CASES / 20, "{crossings} crossings only");
}

/// No number, no touch.
pub fn a_point_that_is_nowhere_touches_nothing(factory: &Factory<'_>) {
    let subject = Subject::of(factory);
    for x in [Vector::repeat(f64::NAN), Vector::new(0.0, f64::NAN, 0.0), Vector::new(f64::INFINITY, 0.0, 0.0)] {
        let touches = subject.touches(&x);
        assert!(x.x.is_infinite() || touches.is_empty(), "{touches:?} at {x:?}");
    }
}

/// Asked again, and made again, it says the same.
pub fn same_input_gives_same_bits(factory: &Factory<'_>) {
    let (subject, again) = (Subject::of(factory), Subject::of(factory));
    let mut rng = Rng::with_seed(79);
    for _ in 0..CASES / 4 {
        let x = subject.point(&mut rng);
        assert_eq!(subject.touches(&x), again.touches(&x));
        assert_eq!(subject.shape.distance(&x, 1.0).to_bits(), again.shape.distance(&x, 1.0).to_bits());
    }
}
