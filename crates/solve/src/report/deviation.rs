//! Distance of the computed centre lines from the drawn ones, and why a branch does not lie where it is drawn.
//!
//! A drawing is met only where constraints make the cable meet it: between two of them its shape follows from stiffness
//! and weight alone. Points of a cable of length L between two places at the distance c lie within the ellipsoid
//! `|x − a| + |x − b| ≤ L`, whose half width is `√(L² − c²)/2`. So a branch that leaves its drawn line by more than its
//! diameter, although the constraints next to the place lie on that line, has too few of them.

use wireloom_core::equilibrium::{BranchResult, Deviation, DeviationCause};
use wireloom_core::network::{BranchEnd, Place};
use wireloom_core::{Network, Problem, Vector};

/// Part of the deviation of a branch from which on the deviation of a constraint beside it explains it.
const EXPLAINS: f64 = 0.5;

/// Place where a constraint holds the harness.
struct Held {
    /// Index of the constraint.
    constraint: usize,
    /// Position of the cable there, m.
    position: Vector,
    /// Distance from the drawn line, m; 0 where none is drawn.
    off: f64,
}

/// The held places of a harness.
struct HeldPlaces<'a> {
    network: &'a Network,
    branches: &'a [BranchResult],
    /// Those of each branch with their arc lengths, in order.
    along: Vec<Vec<(f64, Held)>>,
    /// Those at joints.
    at_joints: Vec<Option<Held>>,
}

/// Deviation of each branch at an equilibrium with these results; `None` where no line is drawn.
pub fn deviations(problem: &Problem<'_>, branches: &[BranchResult]) -> Vec<Option<Deviation>> {
    let network = problem.network;
    if network.branches.iter().all(|branch| branch.drawn.len() < 2) {
        return vec![None; branches.len()];
    }
    let places = HeldPlaces::of(problem, branches);
    let deviation = |b: usize| {
        let (branch, drawn) = (&branches[b], &network.branches[b].drawn);
        let (median, max, s) = (drawn.len() >= 2).then(|| distances(branch, drawn))??;
        let cause = (max > branch.diameter).then(|| places.cause(b, s, max));
        Some(Deviation { median, max, s, cause })
    };
    network.map(branches.len(), deviation)
}

/// Median along the branch and largest of the distances of its nodes from a line, m, and the arc length of the largest;
/// `None` where positions are not numbers.
fn distances(branch: &BranchResult, drawn: &[Vector]) -> Option<(f64, f64, f64)> {
    let n = branch.s.len();
    let own: Vec<f64> = branch.position.iter().map(|x| distance_from(drawn, x)).collect();
    if !own.iter().all(|distance| distance.is_finite()) {
        return None;
    }
    // Each node stands for half of the segments beside it.
    let length = |i: usize| 0.5 * (branch.s[(i + 1).min(n - 1)] - branch.s[i.saturating_sub(1)]);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| own[*a].total_cmp(&own[*b]));
    let half = 0.5 * (0..n).map(length).sum::<f64>();
    let mut below = 0.0;
    let median = order.iter().find(|i| {
        below += length(**i);
        below >= half
    });
    let largest = *order.last()?;
    Some((own[*median.unwrap_or(&largest)], own[largest], branch.s[largest]))
}

impl<'a> HeldPlaces<'a> {
    fn of(problem: &Problem<'a>, branches: &'a [BranchResult]) -> Self {
        let network = problem.network;
        let mut places = Self {
            network,
            branches,
            along: network.branches.iter().map(|_| Vec::new()).collect(),
            at_joints: network.joints.iter().map(|_| None).collect(),
        };
        let active = &problem.conditions().active;
        for (f, constraint) in network.constraints.iter().enumerate().filter(|(f, _)| active[*f]) {
            let ends = constraint.span.iter().flat_map(|span| {
                let first = network.branches[span.branch].points.start;
                [span.points.start - first, span.points.end - 1 - first]
                    .map(|node| Place::Node { branch: span.branch, node })
            });
            for place in constraint.places.iter().copied().chain(ends) {
                places.add(f, place);
            }
        }
        places.along.iter_mut().for_each(|along| along.sort_by(|a, b| a.0.total_cmp(&b.0)));
        places
    }

    fn add(&mut self, constraint: usize, place: Place) {
        match place {
            Place::Node { branch, node } => {
                let position = self.branches[branch].position[node];
                let off = off(&self.network.branches[branch].drawn, &position);
                self.along[branch].push((self.branches[branch].s[node], Held { constraint, position, off }));
            }
            Place::Joint(joint) => {
                let of = &self.network.joints[joint];
                let end = |arm: usize| {
                    let positions = &self.branches[of.branches[arm]].position;
                    positions[if of.arms[arm].starts_here { 0 } else { positions.len() - 1 }]
                };
                // An arm that is not drawn says nothing.
                let offs = of.branches.iter().enumerate().filter(|(_, b)| self.network.branches[**b].drawn.len() >= 2);
                let off = offs.map(|(arm, &b)| off(&self.network.branches[b].drawn, &end(arm)));
                let off = off.reduce(f64::min).unwrap_or(0.0);
                self.at_joints[joint] = Some(Held { constraint, position: end(0), off });
            }
        }
    }

    /// Why branch `b` is `max` away from its drawn line at the arc length `s`.
    fn cause(&self, b: usize, s: f64, max: f64) -> DeviationCause {
        let along = &self.along[b];
        let length = self.branches[b].s[self.branches[b].s.len() - 1];
        let before = along.iter().rev().find(|(at, _)| *at <= s).map(|(at, held)| (s - at, held));
        let before = before.or_else(|| self.beyond(self.network.branches[b].start, b).map(|(d, held)| (s + d, held)));
        let after = along.iter().find(|(at, _)| *at >= s).map(|(at, held)| (at - s, held));
        let after =
            after.or_else(|| self.beyond(self.network.branches[b].end, b).map(|(d, held)| (length - s + d, held)));
        let name = |held: &Held| self.network.constraints[held.constraint].name.clone();
        let sides = [&before, &after].into_iter().flatten().map(|(_, held)| *held);
        if let Some(held) = sides.max_by(|a, b| a.off.total_cmp(&b.off)).filter(|held| held.off >= EXPLAINS * max) {
            return DeviationCause::HeldElsewhere { constraint: name(held) };
        }
        match (before, after) {
            (Some((to_a, a)), Some((to_b, b))) => {
                let (free_length, chord) = (to_a + to_b, (b.position - a.position).norm());
                let room = 0.5 * (free_length * free_length - chord * chord).max(0.0).sqrt();
                DeviationCause::FewConstraints { between: [name(a), name(b)], free_length, room }
            }
            (Some((free_length, held)), None) | (None, Some((free_length, held))) => {
                DeviationCause::FreeEnd { from: Some(name(held)), free_length }
            }
            (None, None) => DeviationCause::FreeEnd { from: None, free_length: length },
        }
    }

    /// The held place nearest along the harness to an end of branch `without`, without that branch, with the length of
    /// cable to it, m; `None` where nothing is held there.
    fn beyond(&self, end: BranchEnd, without: usize) -> Option<(f64, &Held)> {
        let BranchEnd::Joint { joint, .. } = end else { return None };
        let mut nearest: Option<(f64, &Held)> = None;
        let mut take = |distance: f64, held| {
            if nearest.is_none_or(|(least, _)| distance < least) {
                nearest = Some((distance, held));
            }
        };
        let mut distances = vec![f64::INFINITY; self.network.joints.len()];
        distances[joint] = 0.0;
        let mut next = vec![joint];
        while let Some(joint) = next.pop() {
            let travelled = distances[joint];
            if let Some(held) = &self.at_joints[joint] {
                take(travelled, held);
                continue;
            }
            let of = &self.network.joints[joint];
            for (arm, &b) in of.arms.iter().zip(&of.branches).filter(|(_, b)| **b != without) {
                let s = &self.branches[b].s;
                let (along, length) = (&self.along[b], s[s.len() - 1]);
                let first = if arm.starts_here { along.first() } else { along.last() };
                if let Some((at, held)) = first {
                    take(travelled + if arm.starts_here { *at } else { length - at }, held);
                    continue;
                }
                let own = &self.network.branches[b];
                let other = if arm.starts_here { own.end } else { own.start };
                if let BranchEnd::Joint { joint: other, .. } = other
                    && travelled + length < distances[other]
                {
                    distances[other] = travelled + length;
                    next.push(other);
                }
            }
        }
        nearest
    }
}

/// Distance of a held point from the drawn line, m; 0 where none is drawn.
fn off(drawn: &[Vector], x: &Vector) -> f64 {
    if drawn.len() < 2 { 0.0 } else { distance_from(drawn, x) }
}

/// Distance of a point from a polygon, m.
pub(super) fn distance_from(path: &[Vector], x: &Vector) -> f64 {
    let to_edge = |pair: &[Vector]| {
        let edge = pair[1] - pair[0];
        let t = (x - pair[0]).dot(&edge) / edge.norm_squared();
        (x - pair[0] - edge * if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) }).norm()
    };
    path.windows(2).map(to_edge).fold(f64::INFINITY, f64::min)
}
