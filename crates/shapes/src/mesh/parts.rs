//! The parts of a mesh, and what is nearest in each.
//!
//! A cable in a groove lies against both of its sides, and what it is told of one must not jump to the other. So the
//! surface is cut, once, into parts, each with a nearest place of its own that changes smoothly as a point moves before
//! it: a closed surface without grooves is one part, however many triangles it has; any other is cut along its grooves,
//! and where it has turned by a third of a half turn since the first triangle of the part.

use super::topology::{NONE, Topology};
use crate::tree::{Corners, Feature, Found, Tree, hit_of_triangle, nearest_of_triangle};
use std::collections::VecDeque;
use wireloom_core::Vector;

/// rad. Below this an edge of a groove is one: what is finely divided (1/180 of a turn and finer) stays together.
const GROOVE: f32 = -0.035;
/// rad. A closed surface is convex where no edge is below this, which is more than coordinates of single precision
/// bring about.
const CONVEX: f32 = -0.002;
/// Cosine of how far a part may turn.
const TURN: f64 = 0.5;
/// Parts of so many triangles have no tree.
const FEW: usize = 6;

/// Triangles of a part: a range of the list of all.
struct Part {
    first: usize,
    end: usize,
    tree: Option<Tree>,
}

/// The place of a surface that is nearest to a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    pub part: u32,
    pub triangle: u32,
    pub feature: Feature,
    pub place: Vector,
    pub distance: f64,
}

/// All parts, found by where they are.
pub(super) struct Parts {
    parts: Vec<Part>,
    /// Triangles, part by part.
    order: Vec<u32>,
    /// The part of every triangle; of one without area it means nothing.
    part_of: Vec<u32>,
    tree: Tree,
}

impl Parts {
    /// Cuts a surface.
    pub fn of(topology: &Topology, open: bool) -> Self {
        let mut part_of = cut(topology, open);
        // Triangles without area are no part of anything: their neighbours have their edges.
        let mut order: Vec<u32> =
            (0..topology.triangles.len() as u32).filter(|&t| topology.normals[t as usize] != Vector::zeros()).collect();
        order.sort_by_key(|&t| part_of[t as usize]);
        let mut parts = Vec::new();
        for same in order.chunk_by(|&a, &b| part_of[a as usize] == part_of[b as usize]) {
            let first = parts.last().map_or(0, |last: &Part| last.end);
            let boxes = same.iter().map(|&t| (t as usize, box_of(&topology.at(t as usize))));
            let tree = (same.len() > FEW).then(|| Tree::of(boxes));
            parts.push(Part { first, end: first + same.len(), tree });
        }
        for (k, part) in parts.iter().enumerate() {
            order[part.first..part.end].iter().for_each(|&t| part_of[t as usize] = k as u32);
        }
        let tree = Tree::of(parts.iter().enumerate().map(|(k, part)| {
            let own = order[part.first..part.end].iter().flat_map(|&t| topology.at(t as usize));
            let start = [Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY)];
            (k, own.fold(start, |[low, high], corner| [low.inf(&corner), high.sup(&corner)]))
        }));
        Self { parts, order, part_of, tree }
    }

    /// Number of parts.
    pub fn count(&self) -> usize {
        self.parts.len()
    }

    /// The part of a triangle.
    pub fn part_of(&self, triangle: usize) -> u32 {
        self.part_of[triangle]
    }

    /// A box about all.
    pub fn corners(&self) -> Corners {
        self.tree.corners()
    }

    /// The nearest place of a part.
    pub fn nearest_of(&self, topology: &Topology, part: u32, x: &Vector, reach: f64) -> Option<Nearest> {
        let own = &self.parts[part as usize];
        let look = |triangle: u32, _| {
            let (place, feature) = nearest_of_triangle(x, &topology.at(triangle as usize));
            let distance = (x - place).norm();
            Some(Found { cost: distance, what: Nearest { part, triangle, feature, place, distance } })
        };
        match &own.tree {
            Some(tree) => tree.nearest(x, reach, look).map(|found| found.what),
            None => {
                let all = self.order[own.first..own.end].iter().filter_map(|&t| look(t, reach));
                let nearest = all.reduce(|best, next| if next.cost < best.cost { next } else { best });
                nearest.filter(|found| found.cost < reach).map(|found| found.what)
            }
        }
    }

    /// The nearest place of all.
    pub fn nearest(&self, topology: &Topology, x: &Vector, reach: f64) -> Option<Nearest> {
        let look = |part, best| {
            let what = self.nearest_of(topology, part, x, best)?;
            Some(Found { cost: what.distance, what })
        };
        self.tree.nearest(x, reach, look).map(|found| found.what)
    }

    /// All parts of which something may be nearer than `reach`.
    pub fn within(&self, x: &Vector, reach: f64, see: impl FnMut(u32)) {
        self.tree.within(x, reach, see);
    }

    /// The first share of a straight way, before `before`, at which it meets a triangle.
    pub fn first_hit(&self, topology: &Topology, from: &Vector, way: &Vector, before: f64) -> Option<f64> {
        let look = |part: u32, best: f64| {
            let own = &self.parts[part as usize];
            let look = |triangle: u32, _| {
                let cost = hit_of_triangle(from, way, &topology.at(triangle as usize))?;
                Some(Found { cost, what: () })
            };
            let cost = match &own.tree {
                Some(tree) => tree.first_hit(from, way, best, look)?.cost,
                None => {
                    let all = self.order[own.first..own.end].iter().filter_map(|&t| look(t, best));
                    all.map(|found| found.cost).reduce(f64::min)?
                }
            };
            Some(Found { cost, what: () })
        };
        self.tree.first_hit(from, way, before, look).map(|found| found.cost)
    }
}

fn box_of(corners: &[Vector; 3]) -> Corners {
    let [a, b, c] = corners;
    [a.inf(b).inf(c), a.sup(b).sup(c)]
}

/// The part of every triangle.
fn cut(topology: &Topology, open: bool) -> Vec<u32> {
    let count = topology.triangles.len();
    let mut part_of = vec![NONE; count];
    let mut parts = 0;
    let mut queue = VecDeque::new();
    let mut component = Vec::new();
    let mut seen = vec![false; count];
    for first in 0..count {
        if seen[first] {
            continue;
        }
        component.clear();
        component.push(first);
        seen[first] = true;
        let mut next = 0;
        while next < component.len() {
            for &other in &topology.neighbours[component[next]] {
                if other != NONE && !std::mem::replace(&mut seen[other as usize], true) {
                    component.push(other as usize);
                }
            }
            next += 1;
        }
        let convex = !open && component.iter().all(|&t| topology.bends[t].iter().all(|bend| *bend > CONVEX));
        if convex {
            component.iter().for_each(|&t| part_of[t] = parts);
            parts += 1;
            continue;
        }
        component.sort_unstable();
        for &seed in &component {
            if part_of[seed] != NONE {
                continue;
            }
            let facing = topology.normals[seed];
            part_of[seed] = parts;
            queue.push_back(seed);
            while let Some(t) = queue.pop_front() {
                for e in 0..3 {
                    let other = topology.neighbours[t][e];
                    if other == NONE || part_of[other as usize] != NONE {
                        continue;
                    }
                    let bend = topology.bends[t][e];
                    let groove = if open { bend.abs() > -GROOVE } else { bend < GROOVE };
                    let normal = topology.normals[other as usize];
                    let turned = normal != Vector::zeros() && facing.dot(&normal) < TURN;
                    if !groove && !turned {
                        part_of[other as usize] = parts;
                        queue.push_back(other as usize);
                    }
                }
            }
            parts += 1;
        }
    }
    part_of
}
