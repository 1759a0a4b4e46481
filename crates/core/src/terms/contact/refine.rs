//! Refinement: contact points where an obstacle presses between two others.
//!
//! Between two contact points an obstacle is nearest to the centre line where the derivative of its distance φ along
//! the segment is zero. A contact point is added there, and follows that place from one solve to the next: at the
//! equilibrium the forces and their derivatives are then those of a contact that may be anywhere on the segment,
//! because φ does not change with the fraction to first order. Straight segments cut the corners of the smooth curve:
//! added points may be nearer by what an arc of the same curvature lies outside its chord
//! ([`ContactPoint::allowance`]). Their force is zero where they become necessary, so equilibria depend continuously on
//! what moves.

use super::distance_cache::CachedDistance;
use super::term::ContactTerm;
use crate::conditions::{ContactPoint, System};
use crate::{State, Vector};

/// Allowance of an added contact point in units of the height of an arc over its chord: above 1, so that a cable which
/// lies on a round obstacle touches it at the permanent contact points alone.
const CORNER: f64 = 1.5;
/// Least allowance, in radii, and least depth below both neighbours at which a contact point is added.
const LEAST: f64 = 1e-5;
/// Motion along the segment and change of the allowance, in radii, up to which an added contact point stays as it is. φ
/// is stationary there, so its error is of second order in the motion.
const STAYS: (f64, f64) = (1e-4, 1e-9);
/// Steps of the bisection for the nearest place between two contact points.
const SEARCH: usize = 40;

/// Place between two contact points where an obstacle is nearest.
struct Nearest {
    fraction: f64,
    /// φ, m.
    distance: f64,
    /// The least φ at both ends, m.
    beside: f64,
    /// Depth at which contact begins there: see [`ContactPoint::allowance`], m.
    allowance: f64,
}

impl ContactTerm {
    /// Places, in order, where the penetration between two contact points exceeds the allowance at `state`; searched
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
                let radius =
                    self.touch_radius(system, state, &ContactPoint { allowance: 0.0, ..point }, cached.obstacle);
                let new = self
                    .nearest_between(system, state, &point, next, cached)
                    .filter(|new| new.distance < radius - new.allowance && new.distance < new.beside - LEAST * radius);
                let at = |new: Nearest| ContactPoint { fraction: new.fraction, allowance: new.allowance, ..point };
                found.extend(new.map(at));
            }
        }
        found.sort_by(|a, b| (a.branch, a.segment).cmp(&(b.branch, b.segment)).then(a.fraction.total_cmp(&b.fraction)));
        found.dedup_by(|a, b| a.branch == b.branch && a.segment == b.segment && (a.fraction - b.fraction).abs() < 1e-6);
        found
    }

    /// The added contact points, those that press on an obstacle at `state` where it is nearest between their
    /// neighbours; `None` if they are there.
    pub fn followed(&mut self, system: System<'_>, state: &State) -> Option<Vec<ContactPoint>> {
        if self.points.len() == self.own {
            return None;
        }
        self.energy(system, state);
        let mut extra = self.points[self.own..].to_vec();
        let mut moved = false;
        for (k, point) in extra.iter_mut().enumerate() {
            let index = self.own + k;
            let pressed = self.found.iter().filter(|contact| contact.point as usize == index);
            let pressed = pressed.max_by(|a, b| a.force.total_cmp(&b.force)).and_then(|most| most.partner.obstacle());
            let Some(obstacle) = pressed else { continue };
            let cached = self.cached[index].iter().find(|cached| cached.obstacle == obstacle);
            let cached = cached.expect("an obstacle that presses is cached");
            let last = ContactPoint { fraction: self.last_fraction(point), ..*point };
            let next = self.next[index];
            let Some(nearest) = self.nearest_between(system, state, &last, next, cached) else { continue };
            let i = system.network.branches[point.branch].points.start + point.segment;
            let radius = 0.5 * system.network.branches[point.branch].section.diameter;
            let motion = (nearest.fraction - point.fraction).abs() * (state.points[i + 1] - state.points[i]).norm();
            let change = (nearest.allowance - point.allowance).abs();
            if motion > STAYS.0 * radius || change > STAYS.1 * radius {
                (point.fraction, point.allowance) = (nearest.fraction, nearest.allowance);
                moved = true;
            }
        }
        moved.then_some(extra)
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

    /// Fraction of the contact point before an added one on its segment.
    fn last_fraction(&self, point: &ContactPoint) -> f64 {
        let same = |s: &&ContactPoint| (s.branch, s.segment) == (point.branch, point.segment);
        let fractions = self.points.iter().filter(same).map(|s| s.fraction);
        fractions.filter(|t| *t < point.fraction).fold(0.0, f64::max)
    }

    /// Place between a contact point and the fraction `next` on its segment where an obstacle is nearest, if it is
    /// nearer there than at both ends, and not certainly beyond contact.
    fn nearest_between(
        &self,
        system: System<'_>,
        state: &State,
        point: &ContactPoint,
        next: f64,
        cached: &CachedDistance,
    ) -> Option<Nearest> {
        let o = cached.obstacle as usize;
        let (shape, pose) = (&system.network.obstacles[o].shape, &system.conditions.contact.poses[o]);
        let radius = 0.5 * system.network.branches[point.branch].section.diameter;
        let at = |fraction: f64| ContactPoint { fraction, ..*point };
        let own = |fraction: f64| pose.local(&at(fraction).position(system.network, state));
        let (a, b) = (own(point.fraction), own(next));
        let edge = b - a;
        // φ decreases by no more than the distance.
        if cached.is_beyond(&a, radius + edge.norm()) {
            return None;
        }
        // φ and its normal along the piece.
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
        if up <= 0.0 || 0.5 * (at_a + at_b - edge.norm()) >= radius {
            return None;
        }
        // at_a + down t = at_b + up (t − 1)
        let meet = (at_b - up - at_a) / (down - up);
        if at_a + down * meet >= radius {
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
        let at = at(point.fraction + (next - point.fraction) * t);
        // Height of an arc over its chord of length ℓ, at the fraction t: κ ℓ² t (1 − t)/2.
        let curvature = -Self::curvature(system, state, &at).dot(&(pose.orientation * normal));
        let height = 0.5 * curvature * edge.norm_squared() * t * (1.0 - t);
        let allowance = CORNER * height.max(0.0) + LEAST * radius;
        Some(Nearest { fraction: at.fraction, distance, beside: at_a.min(at_b), allowance })
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
