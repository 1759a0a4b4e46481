//! Overlaps of cables that constraints prescribe.
//!
//! Neither cable can move there, so no contact force can separate them: the held overlap is permitted, and decreases to
//! zero over [`RUN_OUT`] mean radii of cable on either side. [`ContactTerm::held_overlaps`] lists these places, so that
//! the run can report them.

use super::pairs::HeldOverlap;
use super::term::{ContactTerm, DEPTH, HeldDepth, RUN_OUT};
use crate::State;
use crate::conditions::{ContactPoint, System};
use crate::constraint::Action;
use crate::network::{APART, Place};

impl ContactTerm {
    /// Places where constraints that act hold cables nearer to each other than the sum of their radii.
    pub fn held_overlaps(&self) -> &[HeldOverlap] {
        &self.cables.held
    }

    /// Finds the overlaps that constraints prescribe.
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
                let diameters = [a, b].map(|(branch, node)| system.network.diameter_at(Place::Node { branch, node }));
                let both = 0.5 * (diameters[0] + diameters[1]);
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

    /// Branches and nodes that a constraint holds.
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

    /// Least permitted distance (m) of a contact point from a segment (indices of branch and segment) of another cable
    /// near a prescribed overlap; `None` if there is none nearby. `both` is the sum of the radii, m.
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
        let run_out = 0.5 * RUN_OUT * both;
        let near = |overlap: &HeldOverlap, [own, other]: [usize; 2]| {
            let ((a, m), (b, n)) = (overlap.places[own], overlap.places[other]);
            if (a, b) != (point.branch, segment.0) {
                return None;
            }
            let (j, k) = (segment.1, segment.1 + 1);
            let t = arc_from_node(system, state, m, point).max(between(system, state, b, [n, n.clamp(j, k)])) / run_out;
            (t < 1.0).then_some(overlap.distance + (both - overlap.distance) * t * t * (3.0 - 2.0 * t))
        };
        held.iter().flat_map(|overlap| [near(overlap, [0, 1]), near(overlap, [1, 0])]).flatten().reduce(f64::min)
    }
}

impl HeldDepth {
    /// Length of cable from the place to a contact point of the same branch, m.
    pub(super) fn arc_to(&self, system: System<'_>, state: &State, point: &ContactPoint) -> f64 {
        arc_from_node(system, state, self.place.1, point)
    }
}

/// Length of cable from a node to a contact point of the same branch, m.
fn arc_from_node(system: System<'_>, state: &State, node: usize, point: &ContactPoint) -> f64 {
    let within = point.fraction * rest_lengths(system, state, point.branch)[point.segment];
    let to_segment = between(system, state, point.branch, [node, point.segment]);
    if point.segment >= node { to_segment + within } else { to_segment - within }
}

/// Length of cable between two nodes of a branch, m.
fn between(system: System<'_>, state: &State, branch: usize, [a, b]: [usize; 2]) -> f64 {
    rest_lengths(system, state, branch)[a.min(b)..a.max(b)].iter().sum()
}

/// Rest lengths from the first segment of a branch on, m.
fn rest_lengths<'s>(system: System<'_>, state: &'s State, branch: usize) -> &'s [f64] {
    &state.rest_lengths[system.network.branches[branch].points.start..]
}
