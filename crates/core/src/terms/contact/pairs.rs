//! Pairs of cables that are near each other.

use crate::network::BranchEnd;
use crate::variable::Variable;
use crate::{Network, Vector};
use std::collections::BTreeSet;

/// Distance along the harness, in sums of both radii, below which it does not touch itself: beyond it a cable that
/// bends no more sharply than its own radius allows cannot.
pub(super) const APART: f64 = 2.5;
/// A contact point, and a row of segments near it.
pub(super) struct Pair {
    pub(super) point: u32,
    pub(super) branch: u32,
    /// First and last segment.
    pub(super) segments: (u32, u32),
    /// How far apart they were when they were looked for, m.
    pub(super) nearest: f64,
    /// Sum of both radii, m.
    pub(super) both: f64,
}

/// Workspace of contact between cables.
#[derive(Default)]
pub(crate) struct Cables {
    /// Distances along the harness between joints, m, where they are short: by joint, the others and how far.
    pub(super) between: Vec<Vec<(usize, f64)>>,
    pub(super) largest_radius: f64,
    pub(super) longest_segment: f64,
    /// Where the points were when pairs were looked for; empty: not yet.
    pub(super) searched: Vec<Vector>,
    /// How far any has gone since, m: nothing came nearer to anything than by twice that.
    pub(super) moved: f64,
    pub(super) pairs: Vec<Pair>,
    /// Where constraints hold cables in each other.
    pub(super) held: Vec<HeldOverlap>,
    /// Pairs of segments, by branch and segment, that second derivatives may couple.
    pub(super) pattern: BTreeSet<[(usize, usize); 2]>,
    /// Their variables.
    pub(super) cliques: Vec<Vec<Variable>>,
    /// Changes with them: 0 where there are none, else different for every pattern of a process, whichever problem it
    /// is of.
    pub(super) version: u64,
}

impl Cables {
    pub(super) fn new(network: &Network) -> Self {
        let radii = network.branches.iter().map(|b| 0.5 * b.section.diameter);
        let largest_radius = radii.fold(0.0, f64::max);
        let lengths = network.branches.iter().flat_map(|b| &b.rod.mesh().rest_lengths);
        let longest_segment = lengths.copied().fold(0.0, f64::max);
        let reach = 2.0 * APART * largest_radius;
        let mut ways: Vec<Vec<(usize, f64)>> = vec![Vec::new(); network.joints.len()];
        for branch in &network.branches {
            if let (BranchEnd::Joint { joint: a, .. }, BranchEnd::Joint { joint: b, .. }) = (branch.start, branch.end) {
                let length = branch.rod.mesh().length();
                ways[a].push((b, length));
                ways[b].push((a, length));
            }
        }
        let between = (0..ways.len()).map(|joint| near_joints(&ways, joint, reach)).collect();
        Self { between, largest_radius, longest_segment, ..Self::default() }
    }

    /// Radius of the thickest branch, m.
    pub(super) fn largest_radius(&self) -> f64 {
        self.largest_radius
    }

    /// Pairs must be looked for anew.
    pub(super) fn search_again(&mut self) {
        self.searched.clear();
    }
}

/// Joints that are within reach of one along the harness, itself included.
fn near_joints(ways: &[Vec<(usize, f64)>], joint: usize, reach: f64) -> Vec<(usize, f64)> {
    let mut near = vec![(joint, 0.0)];
    let mut next = 0;
    while let Some(&(at, gone)) = near.get(next) {
        next += 1;
        for &(other, length) in &ways[at] {
            let way = gone + length;
            match near.iter_mut().find(|(known, _)| *known == other) {
                Some(known) if known.1 <= way => {}
                Some(known) => known.1 = way,
                None if way < reach => near.push((other, way)),
                None => {}
            }
        }
    }
    near
}

/// The place of the segment from `a` to `b` that is nearest to `x`: its fraction and itself.
pub(super) fn nearest_on(x: &Vector, a: &Vector, b: &Vector) -> (f64, Vector) {
    let way = b - a;
    let fraction = ((x - a).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
    (fraction, a + way * fraction)
}

/// Two places of cables that constraints hold nearer to each other than they are thick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOverlap {
    /// Indices of the constraints.
    pub constraints: [usize; 2],
    /// What they hold: index of the branch, and node.
    pub places: [(usize, usize); 2],
    /// How far apart the centre lines are held, m.
    pub distance: f64,
    /// Sum of both radii, m.
    pub both: f64,
}
