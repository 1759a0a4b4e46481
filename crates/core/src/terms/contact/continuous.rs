//! Continuous collision detection: no centre line passes through a surface or another centre line during a step.

use super::term::ContactTerm;
use crate::conditions::{ContactPoint, System};
use crate::obstacle::Shape;
use crate::{Pose, State, Vector};

/// Fraction of the motion up to a collision that one step may cover.
pub(super) const SAFE: f64 = 0.9;
/// Bisections in the search for the time of collision of two segments.
const HALVINGS: usize = 50;
/// Round-off of the intersection of two lines, as a fraction of the segments.
const BESIDE: f64 = 1e-9;

/// Length of a piece of cable that moves as its middle does, as a fraction of the cable's radius, or of the distance of
/// contact points where that is more: thinner bodies may pass between these unseen.
const THIN: [f64; 2] = [0.05, 1.0 / 64.0];

/// Straight segment, given by its ends.
pub(super) type Piece = [Vector; 2];

/// First fraction of the motion at which two straight segments, whose ends move linearly, pass through each other;
/// `None` if they do not. They meet where the volume of the tetrahedron of their four ends, a cubic polynomial of the
/// fraction, is zero (Provot 1997).
pub(super) fn meeting([p, p_end]: [&Piece; 2], [q, q_end]: [&Piece; 2]) -> Option<f64> {
    let edge = |piece: &Piece| piece[1] - piece[0];
    let (e, f, g) = (edge(p), edge(q), q[0] - p[0]);
    let (de, df, dg) = (edge(p_end) - e, edge(q_end) - f, q_end[0] - p_end[0] - g);
    let volume = |t: f64| (e + de * t).dot(&(f + df * t).cross(&(g + dg * t)));
    // Derivative of the volume, c₁ + 2 c₂ t + 3 c₃ t²: between its zeros the volume is monotonic.
    let triple = |a: &Vector, b: &Vector, c: &Vector| a.dot(&b.cross(c));
    let c1 = triple(&de, &f, &g) + triple(&e, &df, &g) + triple(&e, &f, &dg);
    let c2 = triple(&de, &df, &g) + triple(&de, &f, &dg) + triple(&e, &df, &dg);
    let c3 = triple(&de, &df, &dg);
    let mut places = [0.0, 1.0, 1.0, 1.0];
    let square = c2 * c2 - 3.0 * c3 * c1;
    if square > 0.0 {
        // Zeros without cancellation: one from the sum of c₂ and the root with equal signs, the other one from the
        // product of the zeros; c₃ may be zero.
        let w = -(c2 + square.sqrt().copysign(c2));
        let mut zeros = [w / (3.0 * c3), c1 / w].map(|t| if t > 0.0 && t < 1.0 { t } else { 1.0 });
        zeros.sort_by(f64::total_cmp);
        places[1..3].copy_from_slice(&zeros);
    }
    places.windows(2).find_map(|ends| {
        let (mut low, mut high) = (ends[0], ends[1]);
        let rises = volume(high) > volume(low);
        let above = |t: f64| if rises { volume(t) > 0.0 } else { volume(t) < 0.0 };
        // Segments in one plane at the start cannot pass through each other.
        if volume(low) == 0.0 || above(low) || !above(high) {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if above(middle) { high = middle } else { low = middle }
        }
        let (e, f, g) = (e + de * low, f + df * low, g + dg * low);
        let (ee, ef, ff) = (e.norm_squared(), e.dot(&f), f.norm_squared());
        let square = ee * ff - ef * ef;
        let s = (ff * e.dot(&g) - ef * f.dot(&g)) / square;
        let t = (ef * e.dot(&g) - ee * f.dot(&g)) / square;
        let within = |x: f64| (-BESIDE..=1.0 + BESIDE).contains(&x);
        (within(s) && within(t)).then_some(low)
    })
}

impl ContactTerm {
    /// Largest fraction of the motion from one state to another on which no centre line enters an obstacle or passes
    /// through a cable; 1 if none does. The obstacles may have moved from `poses`; `None`: they are at rest. A cable
    /// that is inside already is free to leave.
    pub fn collision_free_fraction(
        &mut self,
        system: System<'_>,
        from: &State,
        to: &State,
        poses: Option<&[Pose]>,
    ) -> f64 {
        let mut free = 1.0_f64;
        if self.is_idle() {
            return free;
        }
        if poses.is_some() {
            // Nothing has been evaluated yet under these conditions.
            self.update_held(system);
        }
        free = free.min(self.collision_free_fraction_of_cables(system, from, to));
        let network = system.network;
        if network.obstacles.is_empty() || self.without_obstacles {
            return free;
        }
        for (i, point) in self.points.iter().enumerate().filter(|(_, point)| point.follows.is_none()) {
            let (a, b) = (point.position(network, from), point.position(network, to));
            let (at, reach) = &self.searched[i];
            let first = network.branches[point.branch].points.start + point.segment;
            // The piece of cable up to the next contact point.
            let next = ContactPoint { fraction: self.next[i], ..*point };
            let held = |point: usize, weight: f64| weight == 0.0 || self.held[point];
            let is_held = |own: &ContactPoint| held(first, 1.0 - own.fraction) && held(first + 1, own.fraction);
            if is_held(point) && is_held(&next) {
                continue;
            }
            let cached = &self.cached[i];
            let (c, d) = (next.position(network, from), next.position(network, to));
            let (piece, motion) = ((c - a).norm(), (b - a).norm().max((d - c).norm()));
            // At the last search no obstacle outside the cache was nearer than `reach`.
            let out_of_reach = poses.is_none() && (a - at).norm() + piece + motion <= *reach;
            if out_of_reach && cached.is_empty() {
                continue;
            }
            for (o, obstacle) in network.obstacles.iter().enumerate() {
                let cached = cached.iter().find(|cached| cached.obstacle as usize == o);
                if out_of_reach && cached.is_none() {
                    continue;
                }
                let now = &system.conditions.contact.poses[o];
                let was = poses.map_or(now, |poses| &poses[o]);
                let (start, end) = (was.local(&a), now.local(&b));
                let ends = [was.local(&c), now.local(&d)];
                let path = (end - start).norm();
                let longest = path.max((ends[1] - ends[0]).norm());
                let beyond = |reach: f64| cached.is_some_and(|cached| cached.is_beyond(&start, reach));
                if longest == 0.0 || beyond(piece + longest) || self.is_held_inside(system, from, point, o) {
                    continue;
                }
                let shape = &*obstacle.shape;
                if path > 0.0 && !beyond(path) {
                    let distance = shape.distance(&start, path);
                    let entered = (distance > 0.0 && distance < path).then(|| shape.crossing(&start, &end)).flatten();
                    free = entered.map_or(free, |fraction| free.min(SAFE * fraction));
                }
                if !self.is_held_inside(system, from, &next, o) {
                    let radius = network.radius(point.branch, point.segment);
                    let short = (THIN[0] * radius).max(THIN[1] * piece);
                    let entered = entering(shape, [&[start, ends[0]], &[end, ends[1]]], short);
                    free = entered.map_or(free, |fraction| free.min(SAFE * fraction));
                }
            }
        }
        free
    }

    /// Whether constraints hold the cable in an obstacle near a contact point: it must be able to reach their targets.
    fn is_held_inside(&self, system: System<'_>, state: &State, point: &ContactPoint, obstacle: usize) -> bool {
        let radius = system.network.radius(point.branch, point.segment);
        self.touch_radius(system, state, point, obstacle as u32) < 0.5 * radius
    }
}

/// First fraction of the motion at which a straight piece of cable, whose ends move linearly in the axes of an
/// obstacle, enters it between its ends; `short` is the length up to which it moves as its middle does.
fn entering(shape: &dyn Shape, [p, p_end]: [&Piece; 2], short: f64) -> Option<f64> {
    let middle = |piece: &Piece| 0.5 * (piece[0] + piece[1]);
    let (from, to) = (middle(p), middle(p_end));
    let half = 0.5 * (p[1] - p[0]).norm();
    let path = (p_end[0] - p[0]).norm().max((p_end[1] - p[1]).norm());
    let distance = shape.distance(&from, half + path);
    if distance >= half + path {
        return None;
    }
    // A cable that is inside already is free to leave.
    let own = (distance > 0.0).then(|| shape.crossing(&from, &to)).flatten();
    // Also where it is not finite.
    let is_long = 2.0 * half > short;
    if !is_long {
        return own;
    }
    let halves = [[&[p[0], from], &[p_end[0], to]], [&[from, p[1]], &[to, p_end[1]]]];
    halves.into_iter().map(|half| entering(shape, half, short)).chain([own]).flatten().min_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(a: [f64; 3], b: [f64; 3]) -> Piece {
        [a.into(), b.into()]
    }

    #[test]
    fn pieces_meet_where_one_falls_through_the_other() {
        let still = piece([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
        let (above, below) = (piece([0.2, -1.0, 0.3], [0.2, 1.0, 0.3]), piece([0.2, -1.0, -0.7], [0.2, 1.0, -0.7]));
        let at = meeting([&still, &still], [&above, &below]).expect("they meet");
        assert!((at - 0.3).abs() < 1e-12, "{at}");
        // The same to round-off if the other segment moves.
        let moved = meeting([&above, &below], [&still, &still]).expect("they meet");
        assert!((at - moved).abs() < 1e-12, "{moved}");
        // Beside its end, or only up to it.
        let (beside, down) = (piece([1.2, -1.0, 0.3], [1.2, 1.0, 0.3]), piece([1.2, -1.0, -0.7], [1.2, 1.0, -0.7]));
        assert_eq!(meeting([&still, &still], [&beside, &down]), None);
        assert_eq!(meeting([&still, &still], [&above, &piece([0.2, -1.0, 0.1], [0.2, 1.0, 0.1])]), None);
    }

    /// Rotating segments may meet more than once: comparison with small steps of the motion, except for collisions near
    /// an end.
    #[test]
    fn pieces_that_turn_meet_first_where_small_steps_say() {
        // Numbers between -1 and 1 without a pattern.
        let mut seed = 1.0_f64;
        let mut number = || {
            seed += 1.0;
            2.0 * ((seed * 12.9898).sin() * 43758.5453).rem_euclid(1.0) - 1.0
        };
        let mut vector = || Vector::new(number(), number(), number());
        let mut met = 0;
        for _ in 0..3000 {
            let [p, p_end, q, q_end] = [0; 4].map(|_| [vector(), vector()]);
            let at = |from: &Piece, to: &Piece, t: f64| [0, 1].map(|k| from[k] + (to[k] - from[k]) * t);
            // Signed volume, and distance of the crossing from the ends.
            let seen = |t: f64| {
                let (p, q) = (at(&p, &p_end, t), at(&q, &q_end, t));
                let (e, f, g) = (p[1] - p[0], q[1] - q[0], q[0] - p[0]);
                let n = e.cross(&f);
                let (s, u) = (g.cross(&f).dot(&n) / n.norm_squared(), g.cross(&e).dot(&n) / n.norm_squared());
                (g.dot(&n), s.min(1.0 - s).min(u).min(1.0 - u))
            };
            let place = |k: usize| k as f64 / 400.0;
            let crosses = |k: &usize| {
                let ((before, a), (after, b)) = (seen(place(*k)), seen(place(k + 1)));
                before * after < 0.0 && a.min(b) > 0.02
            };
            let expected = (0..400).find(crosses).map(place);
            let found = meeting([&p, &p_end], [&q, &q_end]);
            met += usize::from(found.is_some());
            if let Some(expected) = expected {
                assert!(found.is_some_and(|found| found < expected + 1.0 / 400.0), "{found:?}, {expected} expected");
            }
            if let Some(found) = found {
                let (volume, within) = seen(found);
                assert!(volume.abs() < 1e-6 && within > -1e-6, "{volume} {within}");
            }
        }
        assert!(met > 100, "{met}");
    }
}
