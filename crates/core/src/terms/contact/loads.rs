//! Forces and moments of obstacles on the harness.

use super::term::{Contact, ContactTerm};
use crate::Vector;
use crate::conditions::{Against, Partner, System};
use std::collections::BTreeMap;

/// Gap, in radii, up to which the nodes of a segment are reported where contact takes them to be: more than results
/// refine nodes by elsewhere, so that no gap becomes an overlap.
const NEARLY: f64 = 0.1;

/// Load of an obstacle on the harness.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObstacleLoad {
    /// Force on the harness, N.
    pub force: Vector,
    /// Moment on the harness about the obstacle's position, N m.
    pub moment: Vector,
    /// Sum of the sizes of the contact forces, N: forces in opposite directions, as on both sides of a tube, add up.
    pub sizes: f64,
    /// Number of contact points with a force.
    pub points: usize,
    /// Largest depth, m.
    pub depth: f64,
}

impl ContactTerm {
    /// Load of every obstacle on the harness at the last evaluated state; `friction` gives the friction force of a
    /// contact, N.
    pub fn obstacle_loads(&self, system: System<'_>, friction: impl Fn(&Contact) -> Vector) -> Vec<ObstacleLoad> {
        let mut all = vec![ObstacleLoad::default(); system.network.obstacles.len()];
        for contact in &self.found {
            let Some(o) = contact.partner.obstacle().map(|o| o as usize) else { continue };
            let force = contact.normal * contact.force + friction(contact);
            // Friction of an obstacle acts on the centre line; the normal force may be shifted along its line of
            // action.
            let lever = contact.position - system.conditions.contact.poses[o].position;
            all[o].force += force;
            all[o].moment += lever.cross(&force);
            all[o].sizes += force.norm();
            all[o].points += 1;
            all[o].depth = all[o].depth.max(-contact.gap);
        }
        all
    }

    /// Sum of the sizes of the contact forces on each branch, N, by its index and what it touches, at the last
    /// evaluated state. Forces in opposite directions, as on both sides of a tube, add up. `friction` as in
    /// [`Self::obstacle_loads`].
    pub fn forces_by_branch(&self, friction: impl Fn(&Contact) -> Vector) -> BTreeMap<(usize, Against), f64> {
        let mut all = BTreeMap::new();
        for contact in &self.found {
            let branch = self.point(contact.point).branch;
            let force = (contact.normal * contact.force + friction(contact)).norm();
            let mut add = |branch, touched| *all.entry((branch, touched)).or_insert(0.0) += force;
            match contact.partner {
                Partner::Obstacle { obstacle, .. } => add(branch, Against::Obstacle(obstacle as usize)),
                Partner::Cable { branch: other, .. } => {
                    let other = other as usize;
                    add(branch, Against::Branch(other));
                    if other != branch {
                        add(other, Against::Branch(branch));
                    }
                }
            }
        }
        all
    }

    /// Whether each point belongs to a segment that touches something at the last evaluated state, or nearly does
    /// (a tenth of a radius).
    pub fn touching_points(&self, system: System<'_>) -> Vec<bool> {
        let mut touching = vec![false; system.network.points];
        let nearly = self.approaching.iter().filter(|contact| contact.gap <= NEARLY * contact.radius);
        for contact in self.found.iter().chain(nearly) {
            let others = contact.other.iter().flat_map(|other| [other.first, other.first + 1]);
            let own = self.support(system, contact.point, contact.fraction).map(|(point, _)| point);
            own.into_iter().chain(others).for_each(|point| touching[point] = true);
        }
        // All points tied to one joint touch if one of them does.
        for tie in &system.network.ties {
            touching[tie.hub_point] |= touching[tie.point];
        }
        for tie in &system.network.ties {
            touching[tie.point] |= touching[tie.hub_point];
        }
        touching
    }
}
