//! Broad phase: obstacles near each contact point, searched again only after it has moved far enough.

use super::distance_cache::CachedDistance;
use super::follow::arc_of;
use super::term::{ContactTerm, SPACING};
use crate::conditions::{Against, System};
use crate::{State, Vector};

/// Reach of the search around a contact point, in radii.
const REACH: f64 = 12.0;
/// Margin of the cache, in radii: obstacles nearer than a radius plus this are cached.
const MARGIN: f64 = 1.0;

/// Penetration of a centre line into an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// Index of the branch.
    pub branch: usize,
    /// Arc length, m.
    pub s: f64,
    /// Position, m.
    pub position: Vector,
    /// Index of the obstacle.
    pub obstacle: usize,
    /// Depth, m.
    pub depth: f64,
}

impl ContactTerm {
    /// Whether contact point `i`, with position `x`, may touch an obstacle that is not in its cache.
    fn has_gone_far(&self, i: usize, x: &Vector) -> bool {
        let (at, reach) = &self.searched[i];
        !((x - at).norm_squared() <= reach * reach && *reach >= 0.0)
    }

    /// Searches around every contact point that has moved too far since its last search.
    pub(super) fn search(&mut self, system: System<'_>, state: &State) {
        let network = system.network;
        if network.obstacles.is_empty() || self.without_obstacles {
            return;
        }
        let mut changed = false;
        for i in 0..self.points.len() {
            let point = self.points[i];
            let x = arc_of(system, state, &point).at(point.fraction);
            if !self.has_gone_far(i, &x) {
                continue;
            }
            changed = true;
            let radius = network.radius(point.branch, point.segment);
            let reach = REACH * radius;
            let cached = &mut self.cached[i];
            cached.clear();
            let mut safe = f64::INFINITY;
            for (o, obstacle) in network.obstacles.iter().enumerate() {
                if point.follows.is_some_and(|followed| followed != Against::Obstacle(o)) {
                    continue;
                }
                let own = system.conditions.contact.poses[o].local(&x);
                let distance = obstacle.shape.distance(&own, reach).min(reach);
                if distance < (1.0 + MARGIN) * radius {
                    cached.push(CachedDistance::new(o as u32, own, distance));
                    // It stays in the cache as long as the point has moved less than `safe`.
                    continue;
                }
                safe = safe.min(distance - radius);
            }
            if !cached.is_empty() {
                safe = safe.min(SPACING * radius);
            }
            self.searched[i] = (x, safe);
        }
        if changed {
            let Self { near, points, held, cached, .. } = self;
            near.clear();
            near.extend((0..points.len() as u32).filter(|&i| {
                let point = &points[i as usize];
                let first = network.branches[point.branch].points.start + point.segment;
                // A point that a constraint holds cannot move.
                let free = |point: usize| !held[point];
                let moves = point.fraction < 1.0 && free(first) || point.fraction > 0.0 && free(first + 1);
                moves && !cached[i as usize].is_empty()
            }));
        }
    }

    /// Deepest penetration of a centre line into an obstacle at `state`, except where constraints hold it there; `None`
    /// if there is no penetration.
    pub fn deepest_penetration(&mut self, system: System<'_>, state: &State) -> Option<Penetration> {
        let network = system.network;
        self.update_held(system);
        let mut deepest: Option<Penetration> = None;
        for point in &self.points {
            let x = point.position(network, state);
            let radius = network.radius(point.branch, point.segment);
            for (o, obstacle) in network.obstacles.iter().enumerate() {
                let own = system.conditions.contact.poses[o].local(&x);
                let depth = -obstacle.shape.distance(&own, radius);
                let held_there = self.touch_radius(system, state, point, o as u32) < 0.5 * radius;
                if depth > deepest.as_ref().map_or(0.0, |deepest| deepest.depth) && !held_there {
                    let s = point.arc_length(network, state);
                    deepest = Some(Penetration { branch: point.branch, s, position: x, obstacle: o, depth });
                }
            }
        }
        deepest
    }
}
