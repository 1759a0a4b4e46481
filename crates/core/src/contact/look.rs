//! Which spots may touch which obstacles: looked at only where something came near.

use super::watch::Watched;
use super::{Contacts, SPACING, position};
use crate::problem::Problem;
use crate::{Pose, State, Vector};

/// How far around a spot is looked, in radii.
const REACH: f64 = 12.0;
/// A spot watches what is nearer than its radius and so many radii.
const MARGIN: f64 = 1.0;

/// A place of a cable whose centre line is inside a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inside {
    /// Index of the branch.
    pub branch: usize,
    /// Arc length, m.
    pub s: f64,
    /// Where it is, m.
    pub position: Vector,
    /// Index of the obstacle.
    pub obstacle: usize,
    /// How deep, m.
    pub depth: f64,
}

impl Contacts {
    /// Whether spot `i`, which is at `x`, may touch something that it does not watch.
    fn has_gone_far(&self, i: usize, x: &Vector) -> bool {
        let (at, room) = &self.looks[i];
        !((x - at).norm_squared() <= room * room && *room >= 0.0)
    }
}

impl Problem<'_> {
    /// Looks around wherever a spot has gone too far since it was looked at last.
    pub(super) fn look(&mut self, state: &State) {
        let network = self.network;
        let mut changed = false;
        for i in 0..self.contacts.spots.len() {
            let spot = self.contacts.spots[i];
            let x = position(network, state, &spot);
            if !self.contacts.has_gone_far(i, &x) {
                continue;
            }
            changed = true;
            let radius = 0.5 * network.branches[spot.branch].section.diameter;
            let reach = REACH * radius;
            let watched = &mut self.contacts.watched[i];
            watched.clear();
            let mut room = f64::INFINITY;
            for (o, obstacle) in network.obstacles.iter().enumerate() {
                let own = self.conditions.contact.poses[o].local(&x);
                let distance = obstacle.shape.distance(&own, reach).min(reach);
                if distance < (1.0 + MARGIN) * radius {
                    watched.push(Watched::new(o as u32, own, distance));
                    // What is watched is looked at as long as it is within reach of that.
                    continue;
                }
                room = room.min(distance - radius);
            }
            if !watched.is_empty() {
                room = room.min(SPACING * radius);
            }
            self.contacts.looks[i] = (x, room);
        }
        if changed {
            let contacts = &mut self.contacts;
            contacts.near.clear();
            contacts.near.extend((0..contacts.spots.len() as u32).filter(|&i| {
                let spot = &contacts.spots[i as usize];
                let first = network.branches[spot.branch].points.start + spot.segment;
                // What a fixing holds cannot give way.
                let free = |point: usize| !contacts.held[point];
                let moves = spot.share < 1.0 && free(first) || spot.share > 0.0 && free(first + 1);
                moves && !contacts.watched[i as usize].is_empty()
            }));
        }
    }

    /// The place where a centre line is deepest inside a body at `state`, but for what is held there; `None` where none is.
    pub fn deepest_inside(&mut self, state: &State) -> Option<Inside> {
        let network = self.network;
        self.note_held_near();
        let mut deepest: Option<Inside> = None;
        for spot in &self.contacts.spots {
            let x = position(network, state, spot);
            let radius = 0.5 * network.branches[spot.branch].section.diameter;
            for (o, obstacle) in network.obstacles.iter().enumerate() {
                let own = self.conditions.contact.poses[o].local(&x);
                let depth = -obstacle.shape.distance(&own, radius);
                let let_be = self.touch_radius(state, spot, o as u32) < 0.5 * radius;
                if depth > deepest.as_ref().map_or(0.0, |deepest| deepest.depth) && !let_be {
                    let lengths = &state.rest_lengths[network.branches[spot.branch].points.start..];
                    let s = lengths[..spot.segment].iter().sum::<f64>() + lengths[spot.segment] * spot.share;
                    deepest = Some(Inside { branch: spot.branch, s, position: x, obstacle: o, depth });
                }
            }
        }
        deepest
    }

    /// Where an obstacle stands from now on.
    pub fn set_obstacle(&mut self, obstacle: usize, pose: Pose) {
        if self.conditions.contact.poses[obstacle] != pose {
            self.conditions.contact.poses[obstacle] = pose;
            self.contacts.look_again();
        }
    }
}
