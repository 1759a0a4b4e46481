//! Refinement: contact points added where the penetration between two of them is deeper.
//!
//! Straight segments cut the corners of the smooth curve: where a cable lies on a round body, its chords are deeper in
//! it than the cable by the height of an arc. So much is no penetration.

use super::distance_cache::CachedDistance;
use super::term::ContactTerm;
use crate::conditions::{ContactPoint, System};
use crate::{State, Vector};

/// Depth between contact points beyond that of a chord, in radii, above which one is added; it must be deeper than both
/// neighbours by as much.
const TOLERATED: f64 = 1e-3;
/// Depth between contact points, in radii, above which one is added in any case.
pub const BETWEEN: f64 = 0.025;
/// Depth of a chord in units of the height of the arc over it.
const CORNER: f64 = 1.5;
/// Least distance of an added contact point from others, as a fraction of the distance between its neighbours.
const APART: f64 = 0.1;
/// Steps of the bisection for the nearest place between two contact points.
const SEARCH: usize = 30;

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

    /// Fractions of the permanent contact points on the segment of a contact point, in order.
    fn permanent_on_segment(&self, point: &ContactPoint) -> impl Iterator<Item = f64> {
        let place = (point.branch, point.segment);
        let own = &self.points[..self.own];
        let first = own.partition_point(|s| (s.branch, s.segment) < place);
        own[first..].iter().take_while(move |s| (s.branch, s.segment) == place).map(|s| s.fraction)
    }

    /// Fraction of the next contact point on the segment.
    fn next_fraction(&self, point: &ContactPoint) -> f64 {
        let added = self.points[self.own..].iter().filter(|s| (s.branch, s.segment) == (point.branch, point.segment));
        let others = self.permanent_on_segment(point).chain(added.map(|s| s.fraction));
        others.filter(|t| *t > point.fraction).fold(1.0, f64::min)
    }

    /// Deepest place between a contact point and the next one on its segment, if its depth exceeds that of a chord and
    /// that of both by the tolerance.
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
        let least = radius - TOLERATED * radius;
        // φ decreases by no more than the distance.
        if cached.is_beyond(&a, least + edge.norm()) {
            return None;
        }
        // φ and its normal.
        let nearest = |x: &Vector| {
            let mut least: Option<(f64, Vector)> = None;
            shape.touches(x, 2.0 * radius + edge.norm(), &mut |touch| {
                if least.is_none_or(|(distance, _)| touch.distance < distance) {
                    least = Some((touch.distance, touch.normal));
                }
            });
            least
        };
        let (at_a, down) = nearest(&a).map(|(distance, normal)| (distance, normal.dot(&edge)))?;
        if down >= 0.0 {
            return None;
        }
        let (at_b, up) = nearest(&b).map(|(distance, normal)| (distance, normal.dot(&edge)))?;
        // Along a straight line φ of a convex obstacle is convex, so it is above its tangents.
        if up <= 0.0 || 0.5 * (at_a + at_b - edge.norm()) >= least {
            return None;
        }
        // at_a + down t = at_b + up (t − 1)
        let meet = (at_b - up - at_a) / (down - up);
        if at_a + down * meet >= least {
            return None;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..SEARCH {
            let middle = 0.5 * (low + high);
            let (_, normal) = nearest(&(a + edge * middle))?;
            if normal.dot(&edge) < 0.0 { low = middle } else { high = middle }
        }
        let t = 0.5 * (low + high);
        let (distance, normal) = nearest(&(a + edge * t))?;
        let place = at(point.fraction + (next - point.fraction) * t);
        // Height of an arc over the chord from one permanent contact point to the next, at the distances a and b from
        // them: κ a b/2.
        let length = edge.norm() / (next - point.fraction);
        let (before, after) = self.permanent_on_segment(&place).fold((0.0, 1.0), |(before, after), t| match t {
            t if t <= place.fraction => (t, after),
            t => (before, f64::min(after, t)),
        });
        let [before, after] = [place.fraction - before, after - place.fraction].map(|part| part * length);
        let curvature = -Self::curvature(system, state, &place).dot(&(pose.orientation * normal));
        let chord = CORNER * (0.5 * curvature * before * after).max(0.0);
        let tolerated = (chord + TOLERATED * radius).min(BETWEEN * radius);
        let inside = t > APART && t < 1.0 - APART;
        let deep = distance < (radius - tolerated).min(at_a.min(at_b) - TOLERATED * radius);
        (inside && deep).then_some(place)
    }

    /// Curvature vector of a branch at a contact point, 1/m.
    fn curvature(system: System<'_>, state: &State, point: &ContactPoint) -> Vector {
        let points = &system.network.branches[point.branch].points;
        let node = |i: usize| state.points[i] + state.compensation[i];
        // At a node between two segments with directions d₁, d₂: 2 (d₂ − d₁)/(ℓ₁ + ℓ₂).
        let curvature = |i: usize| {
            let inside = i > points.start && i + 1 < points.end;
            inside.then(|| {
                let (before, after) = (node(i) - node(i - 1), node(i + 1) - node(i));
                (after.normalize() - before.normalize()) * (2.0 / (before.norm() + after.norm()))
            })
        };
        let i = points.start + point.segment;
        match (curvature(i), curvature(i + 1)) {
            (Some(a), Some(b)) => a + (b - a) * point.fraction,
            (a, b) => a.or(b).unwrap_or_default(),
        }
    }
}
