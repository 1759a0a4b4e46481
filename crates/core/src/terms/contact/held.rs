//! Cables that constraints hold nearer to each other than they are thick.
//!
//! Neither can give way there, however hard they push: so they are let overlap as far as they are held, and less and
//! less over [`RUN_OUT`] mean radii of cable on either side. It is no equilibrium that anybody wants: who asks is told
//! ([`Problem::held_overlaps`]).

use super::pairs::{APART, HeldOverlap};
use super::term::{ContactTerm, DEPTH, RUN_OUT};
use crate::State;
use crate::conditions::System;
use crate::constraint::Action;
use crate::network::Place;

impl ContactTerm {
    /// Where constraints that act hold cables nearer to each other than they are thick.
    pub fn held_overlaps(&self) -> &[HeldOverlap] {
        &self.cables.held
    }

    /// Finds where constraints hold cables in each other.
    pub(super) fn update_held_overlaps(&mut self, system: System<'_>) {
        let mut overlaps = std::mem::take(&mut self.cables.held);
        overlaps.clear();
        if system.network.contact.cables {
            let holds = |f: &usize| match system.network.constraints[*f].model.action() {
                Action::Prescribed(hold) => system.conditions.active[*f] && hold.position && hold.rails.is_empty(),
                _ => false,
            };
            let holding: Vec<usize> = (0..system.network.constraints.len()).filter(holds).collect();
            let thickest = 2.0 * self.cables.largest_radius();
            for (k, &f) in holding.iter().enumerate() {
                for &g in &holding[..k] {
                    let targets = &system.conditions.targets;
                    let distance = (targets[f].position - targets[g].position).norm();
                    if distance < thickest {
                        self.add_held_overlaps(system, [g, f], distance, &mut overlaps);
                    }
                }
            }
        }
        self.cables.held = overlaps;
    }

    fn add_held_overlaps(
        &self,
        system: System<'_>,
        constraints: [usize; 2],
        distance: f64,
        overlaps: &mut Vec<HeldOverlap>,
    ) {
        let [first, second] = constraints.map(|f| self.held_places(system, f));
        for &a in &first {
            for &b in &second {
                let radius = |branch: usize| 0.5 * system.network.branches[branch].section.diameter;
                let both = radius(a.0) + radius(b.0);
                let rest = |(branch, node): (usize, usize)| -> f64 {
                    system.network.branches[branch].rod.mesh().rest_lengths[..node].iter().sum()
                };
                let apart = self.along(system, (a.0, rest(a)), (b.0, rest(b))) > APART * both;
                if apart && distance < both * (1.0 - DEPTH) {
                    overlaps.push(HeldOverlap { constraints, places: [a, b], distance, both });
                }
            }
        }
    }

    /// The nodes that a constraint holds, with their branches.
    fn held_places(&self, system: System<'_>, constraint: usize) -> Vec<(usize, usize)> {
        match system.network.constraints[constraint].place {
            Place::Node { branch, node } => vec![(branch, node)],
            Place::Joint(j) => {
                let joint = &system.network.joints[j];
                let end = |branch: usize| system.network.branches[branch].rod.mesh().segments();
                let arms = joint.arms.iter().zip(&joint.branches);
                arms.map(|(arm, &branch)| (branch, if arm.starts_here { 0 } else { end(branch) })).collect()
            }
        }
    }

    /// How near a point may be to a segment (index of the branch and its own) of another cable, with which it has the
    /// radii `both` (m), as both are held in each other nearby, m.
    pub(super) fn distance_beside_held(
        &self,
        system: System<'_>,
        state: &State,
        point: u32,
        segment: (usize, usize),
        both: f64,
    ) -> Option<f64> {
        let held = &self.cables.held;
        let point = &self.points[point as usize];
        let lengths = |branch: usize| &state.rest_lengths[system.network.branches[branch].points.start..];
        // Cable between two nodes of a branch.
        let between = |branch: usize, a: usize, b: usize| lengths(branch)[a.min(b)..a.max(b)].iter().sum::<f64>();
        let run_out = 0.5 * RUN_OUT * both;
        let near = |overlap: &HeldOverlap, [own, other]: [usize; 2]| {
            let ((a, m), (b, n)) = (overlap.places[own], overlap.places[other]);
            if (a, b) != (point.branch, segment.0) {
                return None;
            }
            let within = point.fraction * lengths(a)[point.segment];
            let way = if point.segment >= m {
                between(a, m, point.segment) + within
            } else {
                between(a, point.segment, m) - within
            };
            let (j, k) = (segment.1, segment.1 + 1);
            let t = way.max(between(b, n, n.clamp(j, k))) / run_out;
            (t < 1.0).then_some(overlap.distance + (both - overlap.distance) * t * t * (3.0 - 2.0 * t))
        };
        held.iter().flat_map(|overlap| [near(overlap, [0, 1]), near(overlap, [1, 0])]).flatten().reduce(f64::min)
    }
}
