//! Spanning trees of the harness from its roots, with distances.

use super::harness::{Constraint, Harness, Place, Role};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Shortest paths from a root of each piece to all its vertices.
pub(super) struct Tree {
    /// Branch and vertex by which each vertex is reached; `None` for roots.
    pub parent: Vec<Option<(usize, usize)>>,
    /// Length of cable to the root, m.
    pub distance: Vec<f64>,
    /// Vertices, each after its parent.
    pub order: Vec<usize>,
    /// The root of each piece.
    pub roots: Vec<usize>,
    /// The root of the piece that each vertex belongs to.
    root: Vec<usize>,
}

impl Tree {
    /// The trees of a harness. The root of a piece is the connector on its heaviest branch (the first of equal ones),
    /// where most of the wires end; the root of a piece without connectors is its first vertex.
    pub fn new(harness: &Harness) -> Self {
        let n = harness.vertices.len();
        let mut branches_at: Vec<Vec<usize>> = vec![Vec::new(); n];
        for (index, branch) in harness.branches.iter().enumerate() {
            branch.ends.iter().for_each(|&end| branches_at[end].push(index));
        }
        let weight = |constraint: &Constraint| match constraint.at {
            Place::End(vertex) if constraint.role == Role::Connector => {
                let branch = &harness.branches[branches_at[vertex][0]];
                Some((vertex, branch.linear_density))
            }
            _ => None,
        };
        let mut plugs: Vec<(usize, f64)> = harness.constraints.iter().filter_map(weight).collect();
        plugs.sort_by(|a, b| b.1.total_cmp(&a.1));
        let starts = plugs.into_iter().map(|(vertex, _)| vertex).chain(0..n);

        let mut tree = Self {
            parent: vec![None; n],
            distance: vec![f64::INFINITY; n],
            order: Vec::new(),
            roots: Vec::new(),
            root: vec![0; n],
        };
        let mut done = vec![false; n];
        for root in starts {
            if tree.distance[root].is_finite() || branches_at[root].is_empty() {
                continue;
            }
            tree.roots.push(root);
            tree.distance[root] = 0.0;
            // Dijkstra's algorithm. A vertex may be open more than once; the first time counts. Lengths are positive,
            // so their bits have the same order.
            let mut open = BinaryHeap::from([Reverse((0, root))]);
            while let Some(Reverse((reached, vertex))) = open.pop() {
                if reached != tree.distance[vertex].to_bits() || std::mem::replace(&mut done[vertex], true) {
                    continue;
                }
                tree.order.push(vertex);
                tree.root[vertex] = root;
                for &index in &branches_at[vertex] {
                    let branch = &harness.branches[index];
                    let other = branch.ends[usize::from(branch.ends[0] == vertex)];
                    let distance = tree.distance[vertex] + branch.length;
                    if distance < tree.distance[other] {
                        open.push(Reverse((distance.to_bits(), other)));
                        tree.distance[other] = distance;
                        tree.parent[other] = Some((index, vertex));
                    }
                }
            }
        }
        tree
    }

    /// Length of cable from the root to a place, m.
    pub fn distance_to(&self, harness: &Harness, at: Place) -> f64 {
        match at {
            Place::End(vertex) | Place::Joint(vertex) => self.distance[vertex],
            Place::Along { branch, s } => {
                let branch = &harness.branches[branch];
                let [a, b] = branch.ends.map(|end| self.distance[end]);
                (a + s).min(b + branch.length - s)
            }
        }
    }

    /// The outer vertex of a place: itself, or the outer end of its branch.
    pub fn outer_vertex(&self, harness: &Harness, at: Place) -> usize {
        match at {
            Place::End(vertex) | Place::Joint(vertex) => vertex,
            Place::Along { branch, .. } => {
                let [a, b] = harness.branches[branch].ends;
                if self.parent[b] == Some((branch, a)) { b } else { a }
            }
        }
    }

    /// The root of the piece that a place belongs to.
    pub fn root_of(&self, harness: &Harness, at: Place) -> usize {
        self.root[self.outer_vertex(harness, at)]
    }
}
