//! Contact points that are added where a cable lies deeper between two of them.

use super::distance_cache::CachedDistance;
use super::term::ContactTerm;
use crate::conditions::{ContactPoint, System};
use crate::{State, Vector};

/// Depth between contact points, in radii, from which on one is put there: the cable is a smooth curve, of which
/// straight segments cut corners.
const BETWEEN: f64 = 0.02;
/// Least distance of an added contact point from others, as a fraction of the distance between its neighbours.
const APART: f64 = 0.1;
/// Steps of the search for the deepest place between two contact points; each takes a third off the interval.
const SEARCH: usize = 16;

impl ContactTerm {
    /// Places, in order, where a cable lies deeper between two contact points than the tolerance allows. Only between
    /// points of which one has a force at `state`, or that are both within a spacing of a body.
    pub(crate) fn deeper_places(&mut self, system: System<'_>, state: &State) -> Vec<ContactPoint> {
        if self.is_idle() {
            return Vec::new();
        }
        self.search(system, state);
        self.search_pairs(system, state);
        let mut found: Vec<ContactPoint> = Vec::new();
        for pair in &self.cables.pairs {
            let point = self.points[pair.point as usize];
            if point.fraction < 1.0 {
                self.crossings(system, state, pair, self.next_fraction(&point), &mut found);
            }
        }
        for &index in &self.near {
            let point = self.points[index as usize];
            if point.fraction == 1.0 {
                continue;
            }
            let next = self.next_fraction(&point);
            for cached in &self.cached[index as usize] {
                found.extend(self.deepest_between(system, state, &point, next, cached));
            }
        }
        found.sort_by(|a, b| (a.branch, a.segment).cmp(&(b.branch, b.segment)).then(a.fraction.total_cmp(&b.fraction)));
        found.dedup_by(|a, b| a.branch == b.branch && a.segment == b.segment && (a.fraction - b.fraction).abs() < 1e-6);
        found
    }

    /// Fraction of the next contact point on the segment; those that every harness has are in order.
    pub(super) fn next_fraction(&self, point: &ContactPoint) -> f64 {
        let place = |s: &ContactPoint| (s.branch, s.segment);
        let (own, added) = self.points.split_at(self.own);
        let first = own.partition_point(|s| place(s) < place(point));
        let others = own[first..].iter().take_while(|s| place(s) == place(point));
        let others = others.chain(added.iter().filter(|s| place(s) == place(point)));
        others.map(|s| s.fraction).filter(|t| *t > point.fraction).fold(1.0, f64::min)
    }

    /// Deepest place between a contact point and the next one on its segment, if it is deeper than both and than the
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
        let way = b - a;
        let tolerated = radius - BETWEEN * radius;
        // φ falls no faster than one goes.
        if cached.is_beyond(&a, tolerated + way.norm()) {
            return None;
        }
        // φ and how it falls along the way.
        let nearest = |x: &Vector| {
            let mut least: Option<(f64, f64)> = None;
            shape.touches(x, 2.0 * radius + way.norm(), &mut |touch| {
                if least.is_none_or(|(distance, _)| touch.distance < distance) {
                    least = Some((touch.distance, touch.normal.dot(&way)));
                }
            });
            least
        };
        let (at_a, down) = nearest(&a)?;
        if down >= 0.0 {
            return None;
        }
        let (at_b, up) = nearest(&b)?;
        // Along a straight line φ of a convex body is convex: it lies above its tangents.
        if up <= 0.0 || 0.5 * (at_a + at_b - way.norm()) >= tolerated {
            return None;
        }
        // at_a + down t = at_b + up (t − 1)
        let meet = (at_b - up - at_a) / (down - up);
        if at_a + down * meet >= tolerated {
            return None;
        }
        let depth = |x: &Vector| shape.distance(x, 2.0 * radius + way.norm());
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..SEARCH {
            let (first, second) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if depth(&(a + way * first)) < depth(&(a + way * second)) {
                high = second;
            } else {
                low = first;
            }
        }
        let t = 0.5 * (low + high);
        let deepest = depth(&(a + way * t));
        let inside = t > APART && t < 1.0 - APART;
        (inside && deepest < tolerated && deepest < at_a.min(at_b))
            .then(|| at(point.fraction + (next - point.fraction) * t))
    }
}
