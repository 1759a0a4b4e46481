//! How near two branches may be on the board, and how near they are.

use crate::line::{Line, Point};

/// Rules of clearance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rules {
    /// Distance between surfaces, m.
    pub gap: f64,
    /// Arms of a fork cannot be apart at the fork itself. Two places with the demanded distance D may be nearer if the
    /// way between them along the harness is at most this number times D.
    pub zone: f64,
    /// Least angle between two arms of a vertex, rad; a vertex with many arms halves what they have evenly.
    pub angle: f64,
}

impl Rules {
    /// Least angle between two arms of a vertex that has so many.
    pub fn angle_of(&self, arms: usize) -> f64 {
        self.angle.min(std::f64::consts::PI / arms.max(1) as f64)
    }
}

/// Two branches: each from the end that is nearer to the other one, along the harness.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    /// Lines that begin at the ends that are near each other.
    pub lines: [Line; 2],
    /// The way between these ends, m.
    pub way: f64,
    /// Least distance of centre lines, m: the sum of the radii and the gap.
    pub distance: f64,
}

/// Distance below which centre lines touch, m.
const TOUCH: f64 = 1e-9;

/// Part of a demanded distance or angle that round-off may take.
pub(crate) const ROUND_OFF: f64 = 1e-9;

/// By how much a pair of branches breaks the rules: zero if it keeps them, the missing part of the distance where they
/// are too near, and one more where they cross.
pub(crate) fn breach(pair: &Pair, zone: f64) -> f64 {
    let [a, b] = &pair.lines;
    let (na, nb) = (a.chords(), b.chords());
    let distance = pair.distance + a.sagitta() + b.sagitta();
    let mut worst = 0.0_f64;
    let mut cross = false;
    for i in 0..na {
        let first = Chord::new(a, i, na);
        for j in 0..nb {
            let second = Chord::new(b, j, nb);
            let before = pair.way + first.s + second.s;
            let beyond = zone * pair.distance - before;
            let (free, constrained) = least(&first, &second, beyond);
            // Chords that begin in a common vertex meet there.
            cross |= free < TOUCH && before > 0.0;
            if constrained < distance * (1.0 - ROUND_OFF) {
                worst = worst.max(1.0 - constrained / distance);
            }
        }
    }
    worst + f64::from(u8::from(cross))
}

/// A straight piece.
struct Chord {
    from: Point,
    along: Point,
    length: f64,
    /// Arc length at which it begins.
    s: f64,
}

impl Chord {
    fn new(line: &Line, index: usize, of: usize) -> Self {
        let at = |k: usize| line.length * k as f64 / of as f64;
        let (from, to) = if of == 1 { (line.start, line.end()) } else { (line.at(at(index)), line.at(at(index + 1))) };
        let length = (to - from).norm();
        let along = if length > 0.0 { (to - from) / length } else { Point::zeros() };
        Self { from, along, length, s: at(index) }
    }
}

/// Least distance of two chords: of all their points, and of those at arc lengths u and v with `u + v ≥ beyond`.
///
/// The squared distance is convex in (u, v). Where its least place over both chords does not have `u + v ≥ beyond`, the
/// least of those that do lies on the line `u + v = beyond`.
fn least(a: &Chord, b: &Chord, beyond: f64) -> (f64, f64) {
    let (u, v) = nearest(a, b);
    let distance = |u: f64, v: f64| (a.from + u * a.along - b.from - v * b.along).norm();
    let free = distance(u, v);
    if u + v >= beyond {
        return (free, free);
    }
    let (low, high) = ((beyond - b.length).max(0.0), a.length.min(beyond));
    if low > high {
        return (free, f64::INFINITY);
    }
    // w(u) = w₀ + u (dₐ + d_b) with v = beyond − u.
    let (w, d) = (a.from - b.from - beyond * b.along, a.along + b.along);
    let square = d.norm_squared();
    let u = if square > 0.0 { (-w.dot(&d) / square).clamp(low, high) } else { low };
    (free, distance(u, beyond - u))
}

/// Arc lengths of the nearest points of two chords (Ericson 2005, "Real-time collision detection", 5.1.9).
fn nearest(a: &Chord, b: &Chord) -> (f64, f64) {
    let r = a.from - b.from;
    let (c, f) = (a.along.dot(&r), b.along.dot(&r));
    let k = a.along.dot(&b.along);
    let denominator = 1.0 - k * k;
    let mut u = if denominator > 1e-12 { ((k * f - c) / denominator).clamp(0.0, a.length) } else { 0.0 };
    let v = k * u + f;
    if v < 0.0 {
        u = (-c).clamp(0.0, a.length);
        return (u, 0.0);
    }
    if v > b.length {
        u = (k * b.length - c).clamp(0.0, a.length);
        return (u, b.length);
    }
    (u, v)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(x: f64, y: f64, direction: f64, length: f64) -> Line {
        Line { start: Point::new(x, y), direction, curvature: 0.0, length }
    }

    /// Breach by sampling: the missing part of the distance among places that are further apart along the harness.
    fn sampled(pair: &Pair, zone: f64) -> f64 {
        let n = 400;
        let mut worst = 0.0_f64;
        for i in 0..=n {
            for j in 0..=n {
                let [s, t] = [(i, 0), (j, 1)].map(|(k, of)| pair.lines[of].length * f64::from(k) / f64::from(n));
                let apart = (pair.lines[0].at(s) - pair.lines[1].at(t)).norm();
                if pair.way + s + t >= zone * pair.distance {
                    worst = worst.max(1.0 - apart / pair.distance);
                }
            }
        }
        worst
    }

    #[test]
    fn arms_of_a_fork_may_be_near_at_the_fork_alone() {
        let pair = |angle: f64| Pair {
            lines: [line(0.0, 0.0, 0.0, 1.0), line(0.0, 0.0, angle, 1.0)],
            way: 0.0,
            distance: 0.02,
        };
        // At the end of the zone of 8 D both arms are 4 D long: 2 · 4 D sin(α/2) = D for α = 14.36°.
        let limit = 2.0 * (1.0_f64 / 8.0).asin();
        assert_eq!(breach(&pair(limit * 1.001), 8.0), 0.0);
        assert!(breach(&pair(limit * 0.99), 8.0) > 0.005);
        assert!((breach(&pair(0.1), 8.0) - (1.0 - 8.0 * 0.05_f64.sin())).abs() < 1e-9);
    }

    #[test]
    fn breaches_are_those_of_samples() {
        let mut random = fastrand::Rng::with_seed(3);
        let (mut broken, mut kept) = (0, 0);
        for _ in 0..300 {
            let mut arm = || Line {
                start: Point::new(random.f64(), random.f64()) * 0.3,
                direction: random.f64() * 7.0,
                curvature: if random.bool() { 0.0 } else { 4.0 * random.f64() - 2.0 },
                length: 0.1 + random.f64(),
            };
            let lines = [arm(), arm()];
            let pair = Pair { lines, way: random.f64() * 0.5, distance: 0.1 };
            let (found, expected) = (breach(&pair, 8.0), sampled(&pair, 8.0));
            // Samples lie 3 mm apart; chords are taken to stand off their arcs by up to 2 mm each, to be safe.
            let within = found.fract();
            assert!(
                found >= 1.0 || within > expected - 0.03 && within < expected + 0.12,
                "{found} {expected} {pair:?}"
            );
            if expected > 0.0 { broken += 1 } else { kept += 1 }
        }
        assert!(broken > 30 && kept > 50, "{broken} {kept}");
    }

    #[test]
    fn lines_that_cross_are_told_whatever_the_way_between_them() {
        let cross = |angle: f64| Pair {
            lines: [line(0.0, 0.0, 0.0, 0.05), line(0.02, -0.02, angle, 0.05)],
            way: 0.03,
            distance: 0.02,
        };
        assert!(breach(&cross(1.57), 8.0) >= 1.0);
        assert!(breach(&cross(-1.57), 8.0) < 1.0);
    }
}
