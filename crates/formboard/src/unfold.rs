//! Unfolding a graph of straight edges in a plane, with true lengths and without crossings: the layout from which the
//! search starts.
//!
//! For each connected piece:
//! 1. A spanning tree of the shortest edges (Kruskal 1956); the other edges close loops and are returned.
//! 2. The trunk: the longest path of the tree. At its vertices the given directions are changed evenly such that it is
//!    straight.
//! 3. *Equal angles* (Meacham's algorithm of PLOTREE, described by Bachmaier, Brandes and Schlieper 2005, "Drawing
//!    phylogenetic trees"): from the middle of the trunk every subtree gets a wedge whose angle is in proportion to
//!    the number of its leaves, and its edge runs along the middle of the wedge. A wedge with its tip moved along its
//!    middle lies inside the old one, so no edges cross, for any lengths.
//! 4. *Daylight* (after Felsenstein's DRAWTREE, 2004, "Inferring phylogenies", ch. 34): at one vertex after another
//!    the subtrees, each seen from there within an arc, are turned as rigid bodies. DRAWTREE makes the gaps between
//!    the arcs equal; here they approach the gaps of the given directions, as far as there is room. The arcs stay
//!    apart, so no edges come to cross.

use crate::line::Point;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// An edge of the graph.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Edge {
    /// The vertices it joins; two different ones.
    pub ends: [usize; 2],
    /// Above zero.
    pub length: f64,
    /// Direction in which the edge leaves each of its ends, rad, counted counter-clockwise from a direction that is
    /// the same for all edges of that vertex. The order of directions about a vertex is kept, the angles where there
    /// is room.
    pub leaves_at: [f64; 2],
}

/// A graph in the plane.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Unfolded {
    /// Positions of the vertices. The trunk of every piece runs along x about the origin.
    pub points: Vec<Point>,
    /// Edges that close loops, by index: the layout ignores them, and the distance of their ends is not their length.
    pub closing: Vec<usize>,
    /// The vertices of each piece, and those of its trunk in order.
    pub pieces: Vec<Piece>,
}

/// A connected part of the graph.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Piece {
    pub vertices: Vec<usize>,
    pub trunk: Vec<usize>,
}

/// What is done after the subtrees have their wedges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turning {
    /// Nothing: any two places of the tree are then at least `sin(π/n)` times the way between them apart, n the number
    /// of leaves.
    Wedges,
    /// Subtrees are turned towards the given directions, and the trunk becomes straight.
    Daylight,
}

/// Smallest gap between neighbouring subtrees if there is room, rad.
const LEAST_GAP: f64 = 0.05;
/// Smallest sum of all gaps between subtrees for which they are turned, rad. With less they stay where they are.
const LEAST_DAYLIGHT: f64 = 0.02;
/// Largest number of rounds of turning; later rounds turn little.
const ROUNDS: usize = 30;
/// Largest number of visits: each round visits all vertices from every vertex. The wedges stay as they are if one round
/// needs more.
const VISITS: usize = 20_000_000;
/// Largest turn in a round, rad, after which no further round follows.
const SMALL_TURN: f64 = 1e-3;

/// Unfolds a graph. Pieces lie upon one another.
///
/// # Panics
/// If an end is not below `vertices`.
pub(crate) fn unfold(vertices: usize, edges: &[Edge], turning: Turning) -> Unfolded {
    let forest = Forest::new(vertices, edges);
    let mut points = vec![Point::zeros(); vertices];
    let mut pieces = Vec::new();
    for vertices in forest.pieces() {
        let trunk = forest.trunk(vertices[0]);
        forest.lay(&vertices, &trunk, turning, &mut points);
        pieces.push(Piece { vertices, trunk });
    }
    Unfolded { points, closing: forest.closing, pieces }
}

/// The spanning trees of a graph.
struct Forest<'e> {
    edges: &'e [Edge],
    /// Edges of the tree at each vertex.
    arms: Vec<Vec<usize>>,
    closing: Vec<usize>,
}

impl<'e> Forest<'e> {
    fn new(vertices: usize, edges: &'e [Edge]) -> Self {
        let mut order: Vec<usize> = (0..edges.len()).collect();
        order.sort_by(|&a, &b| edges[a].length.total_cmp(&edges[b].length));
        let mut set: Vec<usize> = (0..vertices).collect();
        let mut arms = vec![Vec::new(); vertices];
        let mut closing = Vec::new();
        for e in order {
            let [a, b] = edges[e].ends.map(|end| representative(&mut set, end));
            if a == b {
                closing.push(e);
                continue;
            }
            set[a] = b;
            edges[e].ends.iter().for_each(|&end| arms[end].push(e));
        }
        closing.sort_unstable();
        arms.iter_mut().for_each(|arms| arms.sort_unstable());
        Self { edges, arms, closing }
    }

    fn other(&self, edge: usize, vertex: usize) -> usize {
        let [a, b] = self.edges[edge].ends;
        if a == vertex { b } else { a }
    }

    fn wanted(&self, edge: usize, vertex: usize) -> f64 {
        self.edges[edge].leaves_at[usize::from(self.edges[edge].ends[0] != vertex)]
    }

    /// Vertices of each connected piece.
    fn pieces(&self) -> Vec<Vec<usize>> {
        let mut seen = vec![false; self.arms.len()];
        let mut pieces = Vec::new();
        for start in 0..self.arms.len() {
            if !seen[start] {
                let piece: Vec<usize> = self.walk(start, None).into_iter().map(|visit| visit.vertex).collect();
                piece.iter().for_each(|&v| seen[v] = true);
                pieces.push(piece);
            }
        }
        pieces
    }

    /// All vertices connected to `start` after the edge `without` is removed, each after the one it is reached from.
    fn walk(&self, start: usize, without: Option<usize>) -> Vec<Visit> {
        let mut visits = vec![Visit { vertex: start, from: 0, by: without, distance: 0.0 }];
        let mut next = 0;
        while next < visits.len() {
            let Visit { vertex, by, distance, .. } = visits[next];
            for &edge in self.arms[vertex].iter().filter(|edge| Some(**edge) != by) {
                let distance = distance + self.edges[edge].length;
                visits.push(Visit { vertex: self.other(edge, vertex), from: next, by: Some(edge), distance });
            }
            next += 1;
        }
        visits
    }

    /// The vertices of the longest path of a tree: the farthest from anywhere, and the farthest from that.
    fn trunk(&self, start: usize) -> Vec<usize> {
        let farthest = |visits: &[Visit]| {
            (0..visits.len()).max_by(|&a, &b| visits[a].distance.total_cmp(&visits[b].distance)).unwrap_or(0)
        };
        let out = self.walk(start, None);
        let back = self.walk(out[farthest(&out)].vertex, None);
        let mut at = farthest(&back);
        let mut trunk = vec![back[at].vertex];
        while at != 0 {
            at = back[at].from;
            trunk.push(back[at].vertex);
        }
        trunk
    }

    /// The arms of a vertex in the order of their given directions; if two belong to the trunk, the first is one of
    /// them and the other is opposite. `at`: index of the vertex in the trunk.
    fn compass(&self, vertex: usize, trunk: &[usize], at: Option<usize>) -> Compass {
        let mut arms: Vec<(usize, f64)> =
            self.arms[vertex].iter().map(|&edge| (edge, self.wanted(edge, vertex).rem_euclid(TAU))).collect();
        arms.sort_by(|a, b| a.1.total_cmp(&b.1));
        let on_trunk = |edge: usize| {
            let other = self.other(edge, vertex);
            at.is_some_and(|at| at > 0 && trunk[at - 1] == other || trunk.get(at + 1) == Some(&other))
        };
        let of_trunk: Vec<usize> = (0..arms.len()).filter(|&i| on_trunk(arms[i].0)).collect();
        let mut opposite = None;
        if let [first, second] = of_trunk[..] {
            opposite = Some(second - first);
            // On either side the directions are spread evenly to half a turn.
            let zero = arms[first].1;
            arms.rotate_left(first);
            let bend = arms[second - first].1 - zero;
            for (_, angle) in &mut arms {
                let turn = (*angle - zero).rem_euclid(TAU);
                *angle = match turn {
                    turn if turn < bend => PI * turn / bend,
                    turn if turn > bend => PI + PI * (turn - bend) / (TAU - bend),
                    _ => PI,
                };
            }
        }
        Compass { arms, opposite }
    }

    fn lay(&self, piece: &[usize], trunk: &[usize], turning: Turning, points: &mut [Point]) {
        let middle = trunk[trunk.len() / 2];
        let on_trunk: HashMap<usize, usize> = trunk.iter().enumerate().map(|(at, &v)| (v, at)).collect();
        let compasses: Vec<Compass> =
            piece.iter().map(|&v| self.compass(v, trunk, on_trunk.get(&v).copied())).collect();
        let mut compass_of = vec![0; self.arms.len()];
        for (i, &v) in piece.iter().enumerate() {
            compass_of[v] = i;
        }
        let compass = |vertex: usize| &compasses[compass_of[vertex]];
        self.lay_in_wedges(middle, compass, points);
        let rounds = if turning == Turning::Daylight { ROUNDS.min(VISITS / (piece.len() * piece.len())) } else { 0 };
        for _ in 0..rounds {
            let mut largest = 0.0_f64;
            for visit in self.walk(middle, None) {
                largest = largest.max(self.distribute_daylight(visit.vertex, visit.by, compass(visit.vertex), points));
            }
            if largest < SMALL_TURN {
                break;
            }
        }
        let along = points[trunk[trunk.len() - 1]] - points[trunk[0]];
        let (origin, turn) = (points[trunk[0]] + along * 0.5, nalgebra::Rotation2::new(-along.y.atan2(along.x)));
        for &v in piece {
            points[v] = turn * (points[v] - origin);
        }
    }

    /// Equal angles: every leaf gets the same part of a full turn about `root`.
    fn lay_in_wedges<'c>(&self, root: usize, compass: impl Fn(usize) -> &'c Compass, points: &mut [Point]) {
        let visits = self.walk(root, None);
        let mut leaves = vec![0usize; self.arms.len()];
        for visit in visits.iter().rev() {
            leaves[visit.vertex] = leaves[visit.vertex].max(1);
            if visit.vertex != root {
                leaves[visits[visit.from].vertex] += leaves[visit.vertex];
            }
        }
        let mut wedges = vec![(0.0, TAU); self.arms.len()];
        points[root] = Point::zeros();
        for visit in &visits {
            let (mut from, width) = wedges[visit.vertex];
            let arms = &compass(visit.vertex).arms;
            // Counter-clockwise from the edge that leads here.
            let first = arms.iter().position(|(edge, _)| Some(*edge) == visit.by).map_or(0, |i| i + 1);
            for i in 0..arms.len() {
                let edge = arms[(first + i) % arms.len()].0;
                if Some(edge) == visit.by {
                    continue;
                }
                let child = self.other(edge, visit.vertex);
                let share = width * leaves[child] as f64 / leaves[visit.vertex] as f64;
                points[child] = points[visit.vertex] + self.edges[edge].length * direction(from + 0.5 * share);
                wedges[child] = (from, share);
                from += share;
            }
        }
    }

    /// Turns the subtrees about a vertex such that the gaps between their arcs become those of the given directions.
    /// The subtree towards `fixed` stays. Returns the largest turn, rad.
    ///
    /// With `r_i` and `l_i` the angles that the subtree of arm i spans to the right and left of its edge, and `ω_i`
    /// the given directions, the wanted gaps are `w_i = ω_{i+1} − ω_i − l_i − r_{i+1}`. Between arms that
    /// enclose the angle A (a full turn; half a turn on each side of the trunk if there is room on both) the gaps
    /// have the sum `D = A − Σ (l_i + r_{i+1})`. If some are less than the least gap m they become
    /// `m + (w_i − m)⁺ (D − k m) / Σ (w_j − m)⁺`.
    fn distribute_daylight(&self, vertex: usize, fixed: Option<usize>, compass: &Compass, points: &mut [Point]) -> f64 {
        let arms = &compass.arms;
        let k = arms.len();
        if k < 2 {
            return 0.0;
        }
        let subtrees: Vec<Vec<Visit>> =
            arms.iter().map(|&(edge, _)| self.walk(self.other(edge, vertex), Some(edge))).collect();
        let centre = points[vertex];
        let reach: Vec<(f64, f64)> = subtrees.iter().map(|subtree| seen_arc(subtree, centre, points)).collect();
        // The gap after arm i: the angle taken by the arcs on both its sides, and the wanted angle.
        let taken = |i: usize| reach[i].1 + reach[(i + 1) % k].0;
        let wanted = |i: usize| if i + 1 < k { arms[i + 1].1 - arms[i].1 } else { arms[0].1 + TAU - arms[i].1 };
        let share = |gaps: std::ops::Range<usize>, angle: f64| -> Option<Vec<f64>> {
            let daylight = angle - gaps.clone().map(taken).sum::<f64>();
            let least = LEAST_GAP.min(0.5 * daylight / gaps.len() as f64);
            let beyond: Vec<f64> = gaps.clone().map(|i| (wanted(i) - taken(i) - least).max(0.0)).collect();
            let (sum, spare) = (beyond.iter().sum::<f64>(), daylight - least * gaps.len() as f64);
            let part = |w: f64| if sum > 0.0 { w / sum } else { 1.0 / gaps.len() as f64 };
            (daylight > LEAST_DAYLIGHT).then(|| beyond.iter().map(|&w| least + spare * part(w)).collect())
        };
        let halves = compass.opposite.and_then(|j| Some([share(0..j, PI)?, share(j..k, PI)?].concat()));
        let Some(gaps) = halves.or_else(|| share(0..k, TAU)) else { return 0.0 };
        let first = arms.iter().position(|(edge, _)| Some(*edge) == fixed).unwrap_or(0);
        let bearing = |arm: usize| {
            let d = points[self.other(arms[arm].0, vertex)] - centre;
            d.y.atan2(d.x)
        };
        let mut aim = bearing(first);
        let mut turns = vec![0.0; k];
        for step in 1..k {
            let (before, arm) = ((first + step - 1) % k, (first + step) % k);
            aim += reach[before].1 + gaps[before] + reach[arm].0;
            turns[arm] = aim - bearing(arm);
        }
        let mut largest = 0.0_f64;
        for (subtree, turn) in subtrees.iter().zip(&turns) {
            let turn = (turn + PI).rem_euclid(TAU) - PI;
            largest = largest.max(turn.abs());
            let rotation = nalgebra::Rotation2::new(turn);
            for visit in subtree {
                points[visit.vertex] = centre + rotation * (points[visit.vertex] - centre);
            }
        }
        largest
    }
}

/// The arms of a vertex.
struct Compass {
    /// Edge, and wanted direction, rad; ascending, within one turn.
    arms: Vec<(usize, f64)>,
    /// The arm opposite the first.
    opposite: Option<usize>,
}

/// A vertex on a walk through a tree.
#[derive(Clone, Copy)]
struct Visit {
    vertex: usize,
    /// Index in the walk of the vertex that it is reached from.
    from: usize,
    /// The edge that it is reached by; for the first vertex the removed edge.
    by: Option<usize>,
    /// Distance from the start of the walk.
    distance: f64,
}

/// Angles that a subtree spans to the right and left of its first vertex, rad, seen from `eye`. Angles are followed
/// along the edges, so a subtree around the eye may span more than half a turn.
fn seen_arc(subtree: &[Visit], eye: Point, points: &[Point]) -> (f64, f64) {
    let mut angles = vec![0.0; subtree.len()];
    let (mut right, mut left) = (0.0_f64, 0.0_f64);
    for (i, visit) in subtree.iter().enumerate().skip(1) {
        let (a, b) = (points[subtree[visit.from].vertex] - eye, points[visit.vertex] - eye);
        angles[i] = angles[visit.from] + a.perp(&b).atan2(a.dot(&b));
        right = right.max(-angles[i]);
        left = left.max(angles[i]);
    }
    (right, left)
}

fn direction(angle: f64) -> Point {
    Point::new(angle.cos(), angle.sin())
}

/// The representative of a set in a forest of parents, with path halving (Tarjan and van Leeuwen 1984).
fn representative(parents: &mut [usize], mut at: usize) -> usize {
    while parents[at] != at {
        parents[at] = parents[parents[at]];
        at = parents[at];
    }
    at
}

#[cfg(test)]
mod tests;
