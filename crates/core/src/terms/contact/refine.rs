//! Refinement: contact points added where the penetration between two of them is deeper.

use super::distance_cache::CachedDistance;
use super::follow::{Along, FOLLOWED, RECESS, arc_of, nearest_part};
use super::term::ContactTerm;
use crate::conditions::{Against, ContactPoint, System};
use crate::{State, Vector};

/// Depth between contact points, in radii, above which one is added; it must be deeper than both neighbours by as much.
const TOLERATED: f64 = 1e-3;
/// Least distance of an added contact point that stays from others, as a fraction of the distance between its
/// neighbours.
const APART: f64 = 0.1;

impl ContactTerm {
    /// Places, in order, where the penetration between two contact points exceeds the tolerance at `state`; searched
    /// after contact points with a cached obstacle or a near cable.
    pub fn deeper_places(&mut self, system: System<'_>, state: &State) -> Vec<ContactPoint> {
        if self.is_idle() {
            return Vec::new();
        }
        self.energy(system, state);
        let mut found: Vec<ContactPoint> = Vec::new();
        for pair in &self.cables.pairs {
            let point = self.points[pair.point as usize];
            if point.fraction < 1.0 && point.follows.is_none() {
                self.crossings_of(system, state, pair, self.next[pair.point as usize], &mut found);
            }
        }
        for &index in &self.near {
            let point = self.points[index as usize];
            if point.fraction == 1.0 || point.follows.is_some() {
                continue;
            }
            let next = self.next[index as usize];
            for cached in &self.cached[index as usize] {
                let deepest = self.deepest_between(system, state, &point, next, cached);
                let missing = deepest.filter(|(place, distance)| !self.has_follower(place, *distance));
                found.extend(missing.map(|(place, _)| place));
            }
        }
        found.sort_by(|a, b| (a.branch, a.segment).cmp(&(b.branch, b.segment)).then(a.fraction.total_cmp(&b.fraction)));
        found.dedup_by(|a, b| {
            a.branch == b.branch
                && a.segment == b.segment
                && a.follows == b.follows
                && (a.fraction - b.fraction).abs() < 1e-6
        });
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
        let is_beside =
            |s: &&ContactPoint| (s.branch, s.segment) == (point.branch, point.segment) && s.follows.is_none();
        let added = self.points[self.own..].iter().filter(is_beside);
        let others = self.permanent_on_segment(point).chain(added.map(|s| s.fraction));
        others.filter(|t| *t > point.fraction).fold(1.0, f64::min)
    }

    /// Deepest place between a contact point and the next one on its segment, and its distance (m), if it is deeper
    /// than both by the tolerance. On an edge it follows.
    fn deepest_between(
        &self,
        system: System<'_>,
        state: &State,
        point: &ContactPoint,
        next: f64,
        cached: &CachedDistance,
    ) -> Option<(ContactPoint, f64)> {
        let o = cached.obstacle as usize;
        let (obstacle, pose) = (&system.network.obstacles[o], &system.conditions.contact.poses[o]);
        let radius = self.touch_radius(system, state, point, cached.obstacle);
        let line = arc_of(system, state, point).seen_from(pose);
        let length = line.edge().norm() * (next - point.fraction);
        let nearest = |x: &Vector| nearest_part(&*obstacle.shape, 2.0 * radius + length, x);
        let chord = Along { nearest: &nearest, arc: line.chord() };
        let arc = Along { arc: line, ..chord };
        // φ decreases by no more than the distance.
        let least = radius * (1.0 - TOLERATED);
        if cached.is_beyond(&chord.arc.at(point.fraction), least + length) {
            return None;
        }
        let ends = [point.fraction, next];
        let is_smooth = obstacle.friction == 0.0;
        let is_edge = |t: &f64| arc.at(*t).is_some_and(|profile| profile.is_edge(line.edge().norm(), radius));
        let edge = arc.lowest(ends, least).filter(|t| is_smooth && is_edge(t));
        let t = edge.or_else(|| chord.lowest(ends, least))?;
        // The arc counts where it is farther from the body.
        let distance = |t: f64| Some(chord.at(t)?.distance.max(arc.at(t)?.distance));
        let [first, last] = [distance(point.fraction)?, distance(next)?];
        let (follows, tolerated, apart) = match edge {
            Some(_) => (Some(Against::Obstacle(o)), FOLLOWED, 0.0),
            None => (None, TOLERATED, APART * (next - point.fraction)),
        };
        let tolerated = tolerated * radius + RECESS * line.beside(t).norm();
        let (inside, own) = (t > point.fraction + apart && t < next - apart, distance(t)?);
        let is_deep = own < radius.min(first).min(last) - tolerated;
        (inside && is_deep).then_some((ContactPoint { fraction: t, follows, ..*point }, own))
    }
}
