//! Continuous check: no centre line goes through a surface on its way.

use super::position;
use crate::problem::Problem;
use crate::{Pose, State};

/// Share of the way to a surface that may be gone.
const SAFE: f64 = 0.9;

impl Problem<'_> {
    /// The largest share of the way from one state to another that no centre line goes into a body on; 1 where none does. The body may have
    /// moved there from `poses`; left out, it stands. What is inside already is free to come out.
    pub fn free_share(&mut self, from: &State, to: &State, poses: Option<&[Pose]>) -> f64 {
        let mut free = 1.0_f64;
        if self.contacts.is_idle() {
            return free;
        }
        free = free.min(self.free_share_of_cables(from, to));
        let network = self.network;
        for (i, spot) in self.contacts.spots.iter().enumerate() {
            let (a, b) = (position(network, from, spot), position(network, to, spot));
            let (at, room) = &self.contacts.looks[i];
            let first = network.branches[spot.branch].points.start + spot.segment;
            let held = |point: usize, weight: f64| weight == 0.0 || self.contacts.held[point];
            if held(first, 1.0 - spot.share) && held(first + 1, spot.share) {
                continue;
            }
            let watched = &self.contacts.watched[i];
            // Where it was looked at last nothing was nearer than that, but for what it watches.
            let out_of_reach = poses.is_none() && (a - at).norm() + (b - a).norm() <= *room;
            if out_of_reach && watched.is_empty() {
                continue;
            }
            for (o, obstacle) in network.obstacles.iter().enumerate() {
                let watched = watched.iter().find(|watched| watched.obstacle as usize == o);
                if out_of_reach && watched.is_none() {
                    continue;
                }
                let now = &self.conditions.contact.poses[o];
                let was = poses.map_or(now, |poses| &poses[o]);
                let (start, end) = (was.local(&a), now.local(&b));
                let way = (end - start).norm();
                if way == 0.0 || watched.is_some_and(|watched| watched.is_beyond(&start, way)) {
                    continue;
                }
                // A cable that is held inside a body must get there.
                let radius = 0.5 * network.branches[spot.branch].section.diameter;
                if self.touch_radius(from, spot, o as u32) < 0.5 * radius {
                    continue;
                }
                let distance = obstacle.shape.distance(&start, way);
                if !(distance > 0.0 && distance < way) {
                    continue;
                }
                if let Some(share) = obstacle.shape.crossing(&start, &end) {
                    free = free.min(SAFE * share);
                }
            }
        }
        free
    }
}
