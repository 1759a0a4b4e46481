//! Cables that fixings hold nearer to each other than they are thick.
//!
//! Neither can give way there, however hard they push: so they are let overlap as far as they are held, and less and less over [`RUN_OUT`] mean
//! radii of cable on either side. It is no equilibrium that anybody wants: who asks is told ([`Problem::held_overlaps`]).

use super::cables::APART;
use super::{DEPTH, RUN_OUT};
use crate::State;
use crate::constraint::Action;
use crate::network::Place;
use crate::problem::Problem;

/// Two places of cables that fixings hold nearer to each other than they are thick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOverlap {
    /// Indices of the fixings.
    pub fixings: [usize; 2],
    /// What they hold: index of the branch, and node.
    pub places: [(usize, usize); 2],
    /// How far apart the centre lines are held, m.
    pub distance: f64,
    /// Sum of both radii, m.
    pub both: f64,
}

impl Problem<'_> {
    /// Where fixings that act hold cables nearer to each other than they are thick.
    pub fn held_overlaps(&self) -> &[HeldOverlap] {
        &self.contacts.cables.held
    }

    /// Finds where fixings hold cables in each other.
    pub(super) fn note_held_overlaps(&mut self) {
        let mut overlaps = std::mem::take(&mut self.contacts.cables.held);
        overlaps.clear();
        if self.network.contact.cables {
            let holds = |f: &usize| match self.network.fixings[*f].constraint.action() {
                Action::Prescribed(hold) => self.conditions.active[*f] && hold.position && hold.rails.is_empty(),
                _ => false,
            };
            let holding: Vec<usize> = (0..self.network.fixings.len()).filter(holds).collect();
            let thickest = 2.0 * self.contacts.cables.largest_radius();
            for (k, &f) in holding.iter().enumerate() {
                for &g in &holding[..k] {
                    let targets = &self.conditions.targets;
                    let distance = (targets[f].position - targets[g].position).norm();
                    if distance < thickest {
                        self.add_held_overlaps([g, f], distance, &mut overlaps);
                    }
                }
            }
        }
        self.contacts.cables.held = overlaps;
    }

    fn add_held_overlaps(&self, fixings: [usize; 2], distance: f64, overlaps: &mut Vec<HeldOverlap>) {
        let [first, second] = fixings.map(|f| self.held_places(f));
        for &a in &first {
            for &b in &second {
                let radius = |branch: usize| 0.5 * self.network.branches[branch].section.diameter;
                let both = radius(a.0) + radius(b.0);
                let rest = |(branch, node): (usize, usize)| -> f64 {
                    self.network.branches[branch].rod.mesh().rest_lengths[..node].iter().sum()
                };
                let apart = self.along((a.0, rest(a)), (b.0, rest(b))) > APART * both;
                if apart && distance < both * (1.0 - DEPTH) {
                    overlaps.push(HeldOverlap { fixings, places: [a, b], distance, both });
                }
            }
        }
    }

    /// The nodes that a fixing holds, with their branches.
    fn held_places(&self, fixing: usize) -> Vec<(usize, usize)> {
        match self.network.fixings[fixing].place {
            Place::Node { branch, node } => vec![(branch, node)],
            Place::Joint(j) => {
                let joint = &self.network.joints[j];
                let end = |branch: usize| self.network.branches[branch].rod.mesh().segments();
                let arms = joint.arms.iter().zip(&joint.branches);
                arms.map(|(arm, &branch)| (branch, if arm.starts_here { 0 } else { end(branch) })).collect()
            }
        }
    }

    /// How near a spot may be to a segment (index of the branch and its own) of another cable, with which it has the radii `both` (m), as both are
    /// held in each other nearby, m.
    pub(super) fn distance_beside_held(
        &self,
        state: &State,
        spot: u32,
        segment: (usize, usize),
        both: f64,
    ) -> Option<f64> {
        let held = &self.contacts.cables.held;
        let spot = &self.contacts.spots[spot as usize];
        let lengths = |branch: usize| &state.rest_lengths[self.network.branches[branch].points.start..];
        // Cable between two nodes of a branch.
        let between = |branch: usize, a: usize, b: usize| lengths(branch)[a.min(b)..a.max(b)].iter().sum::<f64>();
        let run_out = 0.5 * RUN_OUT * both;
        let near = |overlap: &HeldOverlap, [own, other]: [usize; 2]| {
            let ((a, m), (b, n)) = (overlap.places[own], overlap.places[other]);
            if (a, b) != (spot.branch, segment.0) {
                return None;
            }
            let within = spot.share * lengths(a)[spot.segment];
            let way = if spot.segment >= m {
                between(a, m, spot.segment) + within
            } else {
                between(a, spot.segment, m) - within
            };
            let (j, k) = (segment.1, segment.1 + 1);
            let t = way.max(between(b, n, n.clamp(j, k))) / run_out;
            (t < 1.0).then_some(overlap.distance + (both - overlap.distance) * t * t * (3.0 - 2.0 * t))
        };
        held.iter().flat_map(|overlap| [near(overlap, [0, 1]), near(overlap, [1, 0])]).flatten().reduce(f64::min)
    }
}
