//! A tree of branches on the board, rooted at one end of its trunk.

use crate::clearance::{Pair, ROUND_OFF, Rules, breach};
use crate::line::{Line, Point, unit, wrapped};
use crate::unfold::Piece;
use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;

/// What the layout needs to know of a branch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strand {
    pub ends: [usize; 2],
    pub length: f64,
    pub radius: f64,
    /// Least bend radius, m.
    pub bend: f64,
}

/// An edge of the tree, from its inner to its outer vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limb {
    /// Index of the branch.
    pub branch: usize,
    /// Whether the branch runs from the outer to the inner vertex.
    pub inward: bool,
    pub line: Line,
    pub radius: f64,
    pub bend: f64,
    /// The limb that it continues.
    pub parent: Option<usize>,
    /// The limbs from this one up to here (exclusive) are it and all that it carries.
    pub last: usize,
    /// The way from the root to its outer vertex, m.
    pub way: f64,
    /// Whether it belongs to the trunk.
    pub trunk: bool,
    /// Angle that it should make with its parent, rad; the parent's end direction counts as zero.
    pub wanted: f64,
    /// Number of arms at its inner vertex.
    pub arms: usize,
    extent: [Point; 2],
}

/// A tree.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    /// Each limb after its parent, and all that it carries right after it.
    pub limbs: Vec<Limb>,
}

impl Tree {
    /// The tree of a piece, with straight limbs between points.
    pub fn new(piece: &Piece, strands: &[Strand], points: &[Point]) -> Self {
        let mut at: HashMap<usize, Vec<usize>> = piece.vertices.iter().map(|&v| (v, Vec::new())).collect();
        for (k, strand) in strands.iter().enumerate() {
            for end in strand.ends {
                if let Some(list) = at.get_mut(&end) {
                    list.push(k);
                }
            }
        }
        let steps: HashSet<[usize; 2]> = piece.trunk.array_windows().copied().collect();
        let on_trunk = |[a, b]: [usize; 2]| steps.contains(&[a, b]) || steps.contains(&[b, a]);
        let root = piece.trunk[0];
        let mut limbs: Vec<Limb> = Vec::new();
        // Depth first: a limb is numbered when it is taken, and its outer limbs are put on top.
        let mut open: Vec<(usize, usize, Option<usize>)> = at[&root].iter().rev().map(|&k| (k, root, None)).collect();
        while let Some((k, inner, parent)) = open.pop() {
            let strand = strands[k];
            let inward = strand.ends[0] != inner;
            let outer = strand.ends[usize::from(!inward)];
            let along = points[outer] - points[inner];
            let direction = along.y.atan2(along.x);
            let line = Line { start: points[inner], direction, curvature: 0.0, length: strand.length };
            let before = parent.map_or(0.0, |p: usize| limbs[p].way);
            let wanted = parent.map_or(0.0, |p| wrapped(direction - limbs[p].line.direction));
            let index = limbs.len();
            limbs.push(Limb {
                branch: k,
                inward,
                line,
                radius: strand.radius,
                bend: strand.bend,
                parent,
                last: 0,
                way: before + strand.length,
                trunk: on_trunk(strand.ends),
                wanted,
                arms: at[&inner].len(),
                extent: line.extent(),
            });
            open.extend(at[&outer].iter().rev().filter(|&&next| next != k).map(|&next| (next, outer, Some(index))));
        }
        for k in (0..limbs.len()).rev() {
            limbs[k].last = limbs[k].last.max(k + 1);
            if let Some(parent) = limbs[k].parent {
                limbs[parent].last = limbs[parent].last.max(limbs[k].last);
            }
        }
        let mut tree = Self { limbs };
        tree.place(0, tree.limbs.len());
        tree
    }

    /// Positions of some limbs, from their directions and curvatures.
    pub fn place(&mut self, from: usize, to: usize) {
        for k in from..to {
            if let Some(parent) = self.limbs[k].parent {
                self.limbs[k].line.start = self.limbs[parent].line.end();
            }
            self.limbs[k].extent = self.limbs[k].line.extent();
        }
    }

    /// The box around all limbs.
    pub fn extent(&self) -> [Point; 2] {
        let mut extent = [Point::repeat(f64::INFINITY), Point::repeat(f64::NEG_INFINITY)];
        for limb in &self.limbs {
            let own = Point::repeat(limb.radius);
            extent = [extent[0].inf(&(limb.extent[0] - own)), extent[1].sup(&(limb.extent[1] + own))];
        }
        extent
    }

    fn carries(&self, a: usize, b: usize) -> bool {
        (a..self.limbs[a].last).contains(&b)
    }

    /// Whether one limb carries or meets the other one at a vertex.
    fn meet(&self, a: usize, b: usize) -> bool {
        let parent = |k: usize| self.limbs[k].parent;
        parent(a) == Some(b) || parent(b) == Some(a) || parent(a) == parent(b)
    }

    /// The way from the root to the vertex where the ways to two limbs part, of which neither carries the other.
    fn fork(&self, a: usize, b: usize) -> f64 {
        let mut at = self.limbs[a].parent;
        while let Some(k) = at {
            if self.carries(k, b) {
                return self.limbs[k].way;
            }
            at = self.limbs[k].parent;
        }
        0.0
    }

    /// Two limbs, from the ends that are nearer to each other along the harness.
    pub fn pair(&self, a: usize, b: usize, rules: &Rules) -> Pair {
        let (la, lb) = (&self.limbs[a], &self.limbs[b]);
        let inner = |limb: &Limb| limb.way - limb.line.length;
        let distance = la.radius + lb.radius + rules.gap;
        let (lines, way) = if self.carries(a, b) {
            ([la.line.reversed(), lb.line], inner(lb) - la.way)
        } else if self.carries(b, a) {
            ([la.line, lb.line.reversed()], inner(la) - lb.way)
        } else {
            ([la.line, lb.line], inner(la) + inner(lb) - 2.0 * self.fork(a, b))
        };
        // Limbs that meet: no way at all, whatever the sums of lengths round to.
        Pair { lines, way: if self.meet(a, b) { 0.0 } else { way.max(f64::MIN_POSITIVE) }, distance }
    }

    /// By how much two limbs break the rules.
    pub fn breach(&self, a: usize, b: usize, rules: &Rules) -> f64 {
        let (la, lb) = (&self.limbs[a], &self.limbs[b]);
        let distance = la.radius + lb.radius + rules.gap;
        let apart = (la.extent[0] - lb.extent[1]).sup(&(lb.extent[0] - la.extent[1]));
        let near = apart.x < distance && apart.y < distance;
        let mut found = if near { breach(&self.pair(a, b, rules), rules.zone) } else { 0.0 };
        if self.meet(a, b) {
            let (one, other) = (self.leaves(a, b), self.leaves(b, a));
            let arms = if la.parent == Some(b) { la.arms } else { lb.arms };
            let least = rules.angle_of(arms);
            let angle = wrapped(one - other).abs();
            if angle < least * (1.0 - ROUND_OFF) {
                found += 1.0 - angle / least;
            }
        }
        found
    }

    /// Direction in which limb `a` leaves the vertex where it meets `b`.
    fn leaves(&self, a: usize, b: usize) -> f64 {
        let line = &self.limbs[a].line;
        if self.limbs[b].parent == Some(a) { line.reversed().direction } else { line.direction }
    }

    /// Turns a limb about its inner vertex: with all that it carries, or alone, and what it carries is shifted.
    pub fn turn(&mut self, limb: usize, angle: f64, alone: bool) {
        let last = self.limbs[limb].last;
        for k in limb..if alone { limb + 1 } else { last } {
            let direction = &mut self.limbs[k].line.direction;
            *direction = wrapped(*direction + angle);
        }
        self.place(limb, last);
    }

    /// Reflects what a limb carries about the limb's own direction.
    pub fn reflect(&mut self, limb: usize) {
        let (last, axis) = (self.limbs[limb].last, self.limbs[limb].line.direction);
        for k in limb..last {
            let line = &mut self.limbs[k].line;
            line.direction = wrapped(2.0 * axis - line.direction);
            line.curvature = -line.curvature;
        }
        self.place(limb, last);
    }

    /// Bends a limb by an angle from end to end; what it carries turns with its end.
    pub fn bend(&mut self, limb: usize, angle: f64) {
        let line = &mut self.limbs[limb].line;
        let change = angle - line.curvature * line.length;
        line.curvature = angle / line.length;
        let last = self.limbs[limb].last;
        for k in limb + 1..last {
            let direction = &mut self.limbs[k].line.direction;
            *direction = wrapped(*direction + change);
        }
        self.place(limb, last);
    }

    /// Moves the whole tree.
    pub fn shift(&mut self, by: Point) {
        for limb in &mut self.limbs {
            limb.line.start += by;
            limb.extent = [limb.extent[0] + by, limb.extent[1] + by];
        }
    }

    /// Rounds all directions to multiples of an angle.
    pub fn round_directions(&mut self, step: f64) {
        for limb in &mut self.limbs {
            limb.line.direction = wrapped((limb.line.direction / step).round() * step);
        }
        self.place(0, self.limbs.len());
    }

    /// Lays the trunk along x; what it carries turns with it.
    pub fn straighten(&mut self) {
        let mut turned = vec![0.0; self.limbs.len()];
        for k in 0..self.limbs.len() {
            let before = self.limbs[k].parent.map_or(0.0, |parent| turned[parent]);
            let limb = &mut self.limbs[k];
            turned[k] = if limb.trunk { -limb.line.direction } else { before };
            limb.line.direction = wrapped(limb.line.direction + turned[k]);
        }
        self.place(0, self.limbs.len());
    }

    /// Every pair of limbs that breaks the rules, by a sweep along x.
    pub fn breaches(&self, rules: &Rules) -> Vec<([usize; 2], f64)> {
        let mut order: Vec<usize> = (0..self.limbs.len()).collect();
        order.sort_by(|&a, &b| self.limbs[a].extent[0].x.total_cmp(&self.limbs[b].extent[0].x));
        let thickest = self.limbs.iter().map(|limb| limb.radius).fold(0.0, f64::max);
        let mut found = Vec::new();
        for (k, &a) in order.iter().enumerate() {
            let right = self.limbs[a].extent[1].x + self.limbs[a].radius + thickest + rules.gap;
            for &b in order[k + 1..].iter().take_while(|&&b| self.limbs[b].extent[0].x <= right) {
                let breach = self.breach(a, b, rules);
                if breach > 0.0 {
                    found.push(([a.min(b), a.max(b)], breach));
                }
            }
        }
        found.sort_by_key(|(pair, _)| *pair);
        found
    }

    /// Square of the deviation of a limb from the angle that it should make, as a fraction of half a turn.
    pub fn deviation(&self, limb: usize) -> f64 {
        let own = &self.limbs[limb];
        let base = own.parent.map_or(0.0, |p| {
            let parent = &self.limbs[p].line;
            parent.direction_at(parent.length)
        });
        (2.0 * wrapped(own.line.direction - base - own.wanted) / TAU).powi(2)
    }

    /// The line of a limb in the sense of its branch.
    pub fn line(&self, limb: usize) -> Line {
        let own = &self.limbs[limb];
        if own.inward { own.line.reversed() } else { own.line }
    }

    /// Where the tree begins: the direction of the trunk there.
    pub fn heading(&self) -> Point {
        unit(self.limbs[0].line.direction)
    }
}
