//! Near pairs of contact points and segments.

use crate::network::APART;
use crate::variable::Variable;
use crate::{Network, Vector};
use rustc_hash::FxHashSet;
use std::collections::BTreeSet;

/// A contact point and consecutive segments near it.
pub(super) struct Pair {
    pub(super) point: u32,
    /// Branch of the contact point.
    pub(super) own: u32,
    /// Branch of the segments.
    pub(super) branch: u32,
    /// First and last segment.
    pub(super) segments: (u32, u32),
    /// Their distance at the last search, m.
    pub(super) nearest: f64,
    /// Sum of both radii, m.
    pub(super) both: f64,
}

/// Workspace of contact between cables.
#[derive(Default)]
pub(crate) struct Cables {
    /// Short distances along the harness between joints: for each joint the other joints and their distances, m.
    pub(super) between: Vec<Vec<(usize, f64)>>,
    pub(super) largest_radius: f64,
    pub(super) longest_segment: f64,
    /// Positions of all points at the last search; empty: no search yet.
    pub(super) searched: Vec<Vector>,
    /// Positions of all points at the last evaluated state, m.
    pub(super) nodes: Vec<Vector>,
    /// Largest displacement of a node of each branch since the last search, m: no distance between two branches has
    /// decreased by more than the sum of theirs.
    pub(super) moved: Vec<f64>,
    /// Workspace: the same of one motion, m.
    pub(super) motions: Vec<f64>,
    pub(super) pairs: Vec<Pair>,
    /// Overlaps that constraints prescribe.
    pub(super) held: Vec<HeldOverlap>,
    /// Pairs of segments (branch, segment) that second derivatives may couple.
    pub(super) pattern: BTreeSet<[(usize, usize); 2]>,
    /// The same, for look-ups.
    pub(super) coupled: FxHashSet<[(usize, usize); 2]>,
    /// Their variables.
    pub(super) cliques: Vec<Vec<Variable>>,
    /// Version of the pattern: 0 if it is empty, otherwise unique in the process.
    pub(super) version: u64,
}

impl Cables {
    pub(super) fn new(network: &Network) -> Self {
        let radii = network.branches.iter().map(|b| 0.5 * b.sections.diameter());
        let largest_radius = radii.fold(0.0, f64::max);
        let lengths = network.branches.iter().flat_map(|b| &b.rod.mesh().rest_lengths);
        let longest_segment = lengths.copied().fold(0.0, f64::max);
        let between = network.near_joints(2.0 * APART * largest_radius);
        let moved = vec![0.0; network.branches.len()];
        Self { between, largest_radius, longest_segment, motions: moved.clone(), moved, ..Self::default() }
    }

    /// Lower bound of the distance of a pair, m.
    pub(super) fn nearest(&self, pair: &Pair) -> f64 {
        pair.nearest - self.moved[pair.own as usize] - self.moved[pair.branch as usize]
    }

    /// Radius of the thickest branch, m.
    pub(super) fn largest_radius(&self) -> f64 {
        self.largest_radius
    }

    /// Discards the pairs, so that the next evaluation searches again.
    pub(super) fn search_again(&mut self) {
        self.searched.clear();
    }
}

/// Nearest point to `x` on the segment from `a` to `b`: its fraction, and its position.
pub(super) fn nearest_on(x: &Vector, a: &Vector, b: &Vector) -> (f64, Vector) {
    let edge = b - a;
    let fraction = ((x - a).dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
    (fraction, a + edge * fraction)
}

/// Overlap that constraints prescribe: two places of cables held nearer to each other than the sum of their radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOverlap {
    /// Indices of the constraints.
    pub constraints: [usize; 2],
    /// Held places: index of the branch, and node.
    pub places: [(usize, usize); 2],
    /// Prescribed distance of the centre lines, m.
    pub distance: f64,
    /// Sum of both radii, m.
    pub both: f64,
}
