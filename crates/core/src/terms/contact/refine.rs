//! Refinement: contact points added where the penetration between two of them is deeper.

use super::distance_cache::CachedDistance;
use super::term::ContactTerm;
use crate::conditions::{ContactPoint, System};
use crate::{State, Vector};

/// Depth between contact points, in radii, above which one is added. Smaller depths are within the error of straight
/// segments, which cut the corners of the smooth curve.
const BETWEEN: f64 = 0.02;
/// Least distance of an added contact point from others, as a fraction of the distance between its neighbours.
const APART: f64 = 0.1;
/// Steps of the ternary search for the deepest place between two contact points; each reduces the interval by a third.
const SEARCH: usize = 16;

impl ContactTerm {
    /// Places, in order, where the penetration between two contact points exceeds the tolerance at `state`; searched
    /// after contact points with a cached obstacle or a near cable.
    pub fn deeper_places(&mut self, system: System<'_>, state: &State) -> Vec<ContactPoint> {
        if self.is_idle() {
            return Vec::new();
        }
        self.search(system, state);
        self.search_pairs(system, state);
        let mut found: Vec<ContactPoint> = Vec::new();
        for pair in &self.cables.pairs {
            let point = self.points[pair.point as usize];
            if point.fraction < 1.0 {
                self.crossings(system, state, pair, self.next[pair.point as usize], &mut found);
            }
        }
        for &index in &self.near {
            let point = self.points[index as usize];
            if point.fraction == 1.0 {
                continue;
            }
            let next = self.next[index as usize];
            for cached in &self.cached[index as usize] {
                found.extend(self.deepest_between(system, state, &point, next, cached));
            }
        }
        found.sort_by(|a, b| (a.branch, a.segment).cmp(&(b.branch, b.segment)).then(a.fraction.total_cmp(&b.fraction)));
        found.dedup_by(|a, b| a.branch == b.branch && a.segment == b.segment && (a.fraction - b.fraction).abs() < 1e-6);
        found
    }

    /// Finds the fraction of the next contact point on the segment, for each of them.
    pub(super) fn find_next(&mut self) {
        self.next = self.points.iter().map(|point| self.next_fraction(point)).collect();
    }

    /// Fraction of the next contact point on the segment; the permanent ones are in order.
    fn next_fraction(&self, point: &ContactPoint) -> f64 {
        let place = |s: &ContactPoint| (s.branch, s.segment);
        let (own, added) = self.points.split_at(self.own);
        let first = own.partition_point(|s| place(s) < place(point));
        let others = own[first..].iter().take_while(|s| place(s) == place(point));
        let others = others.chain(added.iter().filter(|s| place(s) == place(point)));
        others.map(|s| s.fraction).filter(|t| *t > point.fraction).fold(1.0, f64::min)
    }

    /// Deepest place between a contact point and the next one on its segment, if its depth exceeds that of both and the
    /// tolerance.
    fn deepest_between(
        &self,
        system: System<'_>,
        state: &State,
        point: &ContactPoint,
        next: f64,
        cached: &CachedDistance,
    ) -> Option<ContactPoint> {
        let o = cached.obstacle as usize;
        let (shape, pose) = (&system.network.obstacles[o].shape, &system.conditions.contact.poses[o]);
        let radius = self.touch_radius(system, state, point, cached.obstacle);
        let at = |fraction: f64| ContactPoint { fraction, ..*point };
        let own = |fraction: f64| pose.local(&at(fraction).position(system.network, state));
        let (a, b) = (own(point.fraction), own(next));
        let edge = b - a;
        let tolerated = radius - BETWEEN * radius;
        // φ decreases by no more than the distance.
        if cached.is_beyond(&a, tolerated + edge.norm()) {
            return None;
        }
        // φ and its derivative along the piece.
        let nearest = |x: &Vector| {
            let mut least: Option<(f64, f64)> = None;
            shape.touches(x, 2.0 * radius + edge.norm(), &mut |touch| {
                if least.is_none_or(|(distance, _)| touch.distance < distance) {
                    least = Some((touch.distance, touch.normal.dot(&edge)));
                }
            });
            least
        };
        let (at_a, down) = nearest(&a)?;
        if down >= 0.0 {
            return None;
        }
        let (at_b, up) = nearest(&b)?;
        // Along a straight line φ of a convex obstacle is convex, so it is above its tangents.
        if up <= 0.0 || 0.5 * (at_a + at_b - edge.norm()) >= tolerated {
            return None;
        }
        // at_a + down t = at_b + up (t − 1)
        let meet = (at_b - up - at_a) / (down - up);
        if at_a + down * meet >= tolerated {
            return None;
        }
        let depth = |x: &Vector| shape.distance(x, 2.0 * radius + edge.norm());
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..SEARCH {
            let (first, second) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if depth(&(a + edge * first)) < depth(&(a + edge * second)) {
                high = second;
            } else {
                low = first;
            }
        }
        let t = 0.5 * (low + high);
        let deepest = depth(&(a + edge * t));
        let inside = t > APART && t < 1.0 - APART;
        (inside && deepest < tolerated && deepest < at_a.min(at_b))
            .then(|| at(point.fraction + (next - point.fraction) * t))
    }
}
