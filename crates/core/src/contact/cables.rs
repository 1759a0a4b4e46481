//! Cables that touch each other, or themselves.
//!
//! A spot is kept as far from the centre line of another cable as both radii together; its nearest place there is looked for anew with every
//! evaluation, so nothing but friction keeps the two from sliding along each other. Every cable has spots, so both of a pair are looked after.
//! Parts of the harness that are less than [`APART`] radii from each other along the cable do not count. Where cables overlap when a run
//! begins (arms that leave a joint side by side), they are let overlap so far, until they have come apart; where fixings hold them in each other
//! ([`super::held`]), as long as they do.

use super::cross::{self, meeting};
use super::held::HeldOverlap;
use super::{Against, COMING, Contact, DEPTH, Mark, SPACING, Spot, Touched, Turning, marks_of, position, pushed};
use crate::network::{BranchEnd, next_id};
use crate::problem::{Problem, Variable};
use crate::rotation::orthogonal;
use crate::{Matrix, Network, State, Vector};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashMap};

/// Distance along the harness, in sums of both radii, below which it does not touch itself: beyond it a cable that bends no more sharply than
/// its own radius allows cannot.
pub(super) const APART: f64 = 2.5;
/// Pairs are watched that are nearer than their radii and so many times the largest radius.
const MARGIN: f64 = 2.0;
/// Pairs are in the pattern of the matrix that are nearer than so many sums of both radii: more than those that may come to touch with a step.
const COUPLED: f64 = 2.0;
/// Depth between spots, in sums of both radii, from which on one is put where two cables cross.
const CROSSING: f64 = 4.0 * DEPTH;
/// None is put nearer to another one than this share of the distance between its neighbours.
const NEAR_SPOT: f64 = 0.02;
/// Distance between centre lines, in sums of both radii, below which the curvature of the distance is that at it: it has no bound.
const COINCIDENT: f64 = 1e-6;
/// Square of the sine of the angle below which pieces count as parallel.
const PARALLEL: f64 = 1e-3;

/// Cables that overlap from the beginning.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Overlap {
    /// Index of the spot.
    pub spot: u32,
    /// Index of the other branch.
    pub branch: u32,
    /// How near they may be, m.
    pub distance: f64,
}

/// A spot, and a row of segments that are near it.
pub(super) struct Pair {
    pub(super) spot: u32,
    branch: u32,
    /// First and last segment.
    segments: (u32, u32),
    /// How far apart they were when they were looked for, m.
    nearest: f64,
    /// Sum of both radii, m.
    both: f64,
}

/// Workspace of contact between cables.
#[derive(Default)]
pub(crate) struct Cables {
    /// Distances along the harness between joints, m, where they are short: by joint, the others and how far.
    between: Vec<Vec<(usize, f64)>>,
    largest_radius: f64,
    longest_segment: f64,
    /// Where the spots were when pairs were looked for; empty: not yet.
    searched: Vec<Vector>,
    /// How far any has gone since, m: nothing came nearer to anything than by twice that.
    moved: f64,
    pub(super) pairs: Vec<Pair>,
    /// Where fixings hold cables in each other.
    pub(super) held: Vec<HeldOverlap>,
    /// Pairs of segments, by branch and segment, that second derivatives may couple.
    pattern: BTreeSet<[(usize, usize); 2]>,
    /// Their variables.
    cliques: Vec<Vec<Variable>>,
    /// Changes with them: 0 where there are none, else different for every pattern of a process, whichever problem it is of.
    version: u64,
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

/// The place of the segment from `a` to `b` that is nearest to `x`: its share and itself.
fn nearest_on(x: &Vector, a: &Vector, b: &Vector) -> (f64, Vector) {
    let way = b - a;
    let share = ((x - a).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
    (share, a + way * share)
}

impl Problem<'_> {
    /// Where node `node` of a branch is, m.
    fn node(&self, state: &State, branch: usize, node: usize) -> Vector {
        let i = self.network.branches[branch].points.start + node;
        state.points[i] + state.carry[i]
    }

    /// Distance along the harness between a place of one branch and one of another, m; infinite where it is far.
    pub(super) fn along(&self, (a, s): (usize, f64), (b, t): (usize, f64)) -> f64 {
        if a == b {
            return (s - t).abs();
        }
        let ends = |branch: usize, s: f64| {
            let length = self.network.branches[branch].rod.mesh().length();
            let ends = [(self.network.branches[branch].start, s), (self.network.branches[branch].end, length - s)];
            ends.into_iter().filter_map(|(end, way)| match end {
                BranchEnd::Joint { joint, .. } => Some((joint, way)),
                BranchEnd::Free => None,
            })
        };
        let mut least = f64::INFINITY;
        for (from, way) in ends(a, s) {
            for (to, rest) in ends(b, t) {
                let between = self.contacts.cables.between[from].iter().find(|(joint, _)| *joint == to);
                least = between.map_or(least, |(_, gap)| least.min(way + gap + rest));
            }
        }
        least
    }

    /// Looks for pairs wherever something has moved far since they were looked for last.
    pub(super) fn search_pairs(&mut self, state: &State) {
        if !self.network.contact.cables {
            return;
        }
        let network = self.network;
        let margin = MARGIN * self.contacts.cables.largest_radius;
        let spots = || self.contacts.spots.iter().map(|spot| position(network, state, spot));
        let searched = &self.contacts.cables.searched;
        if searched.len() == self.contacts.spots.len() {
            let moved = spots().zip(searched).map(|(x, was)| (x - was).norm_squared()).fold(0.0, f64::max).sqrt();
            if moved <= 0.5 * margin {
                self.contacts.cables.moved = moved;
                return;
            }
        }
        let spots: Vec<Vector> = spots().collect();
        let first_search = searched.is_empty();
        let cables = &self.contacts.cables;
        // Midpoints of segments, by cell; what is near enough lies in a cell next door.
        let cell = 0.5 * cables.longest_segment * 1.5 + 2.0 * cables.largest_radius + margin;
        let key = |x: &Vector| x.map(|x| (x / cell).floor() as i64);
        let mut cells: HashMap<[i64; 3], Vec<(u32, u32)>> = HashMap::new();
        for (b, branch) in network.branches.iter().enumerate() {
            for j in 0..branch.rod.mesh().segments() {
                let middle = (self.node(state, b, j) + self.node(state, b, j + 1)) * 0.5;
                cells.entry(key(&middle).into()).or_default().push((b as u32, j as u32));
            }
        }
        let arcs: Vec<Vec<f64>> = (0..network.branches.len()).map(|b| state.arc_lengths(network, b)).collect();
        let mut pairs: Vec<Pair> = Vec::new();
        let mut found: Vec<(u32, u32, f64)> = Vec::new();
        for (index, (spot, x)) in self.contacts.spots.iter().zip(&spots).enumerate() {
            let radius = 0.5 * network.branches[spot.branch].section.diameter;
            let s = arcs[spot.branch][spot.segment];
            let s = s + (arcs[spot.branch][spot.segment + 1] - s) * spot.share;
            found.clear();
            let home = key(x);
            for i in -1..=1 {
                for j in -1..=1 {
                    for k in -1..=1 {
                        let Some(inside) = cells.get(&[home.x + i, home.y + j, home.z + k]) else { continue };
                        found.extend(inside.iter().filter_map(|&(of, segment)| {
                            let (b, j) = (of as usize, segment as usize);
                            let both = radius + 0.5 * network.branches[b].section.diameter;
                            let (_, place) = nearest_on(x, &self.node(state, b, j), &self.node(state, b, j + 1));
                            let middle = 0.5 * (arcs[b][j] + arcs[b][j + 1]);
                            let apart = APART * both + 0.5 * (arcs[b][j + 1] - arcs[b][j]);
                            let distance = (x - place).norm();
                            let counts = distance < both + margin && self.along((spot.branch, s), (b, middle)) > apart;
                            counts.then_some((of, segment, distance))
                        }));
                    }
                }
            }
            found.sort_unstable_by_key(|&(branch, segment, _)| (branch, segment));
            for &(branch, segment, distance) in &found {
                let spot = index as u32;
                match pairs.last_mut() {
                    Some(last) if (last.spot, last.branch) == (spot, branch) && segment <= last.segments.1 + 1 => {
                        last.segments.1 = segment;
                        last.nearest = distance.min(last.nearest);
                    }
                    _ => {
                        let both = radius + 0.5 * network.branches[branch as usize].section.diameter;
                        pairs.push(Pair { spot, branch, segments: (segment, segment), nearest: distance, both });
                    }
                }
            }
        }
        let cables = &mut self.contacts.cables;
        (cables.pairs, cables.searched, cables.moved) = (pairs, spots, 0.0);
        let pattern = self.coupled(state);
        let known = &self.contacts.cables.pattern;
        // As long as nothing new may be coupled the matrix keeps its pattern; where a search is the first, it is that of the state alone.
        if pattern != *known && (first_search || !pattern.is_subset(known)) {
            self.couple(pattern);
        }
    }

    /// Makes sure that what touches at `state`, or may come to, is in the pattern of the matrix, however far apart it is: a multiplier pushes
    /// on at any distance that it was large enough for.
    pub(super) fn couple_contacts<'c>(&mut self, state: &State, contacts: impl IntoIterator<Item = &'c Contact>) {
        let known = &self.contacts.cables.pattern;
        let pair = |contact: &Contact| match contact.against {
            Against::Cable { branch, segment } => {
                let spot = &self.contacts.spots[contact.spot as usize];
                Some([(spot.branch, spot.segment), (branch as usize, segment as usize)])
            }
            Against::Obstacle { .. } => None,
        };
        let mut missing = contacts.into_iter().filter_map(pair).filter(|pair| !known.contains(pair)).peekable();
        if missing.peek().is_some() {
            let mut pattern: BTreeSet<_> = missing.collect();
            pattern.extend(self.coupled(state));
            pattern.extend(known);
            self.couple(pattern);
        }
    }

    /// Pairs of segments of which one is near the other at `state`, or that friction holds to each other, wherever that is.
    fn coupled(&self, state: &State) -> BTreeSet<[(usize, usize); 2]> {
        let mut pattern = BTreeSet::new();
        for pair in &self.contacts.cables.pairs {
            let spot = &self.contacts.spots[pair.spot as usize];
            let x = position(self.network, state, spot);
            let branch = pair.branch as usize;
            let reach = COUPLED * pair.both;
            if pair.nearest - 2.0 * self.contacts.cables.moved > reach {
                continue;
            }
            for j in pair.segments.0 as usize..=pair.segments.1 as usize {
                let (_, place) = nearest_on(&x, &self.node(state, branch, j), &self.node(state, branch, j + 1));
                if (x - place).norm_squared() < reach * reach {
                    pattern.insert([(spot.branch, spot.segment), (branch, j)]);
                }
            }
        }
        for (mark, [branch, segment]) in self.bound_cables() {
            let spot = &self.contacts.spots[mark.spot as usize];
            pattern.insert([(spot.branch, spot.segment), (branch, segment)]);
        }
        pattern
    }

    /// Sets which pairs of segments the matrix couples.
    fn couple(&mut self, pattern: BTreeSet<[(usize, usize); 2]>) {
        let network = self.network;
        let points = |(b, j): (usize, usize)| {
            let first = network.branches[b].points.start + j;
            [first, first + 1].map(Variable::Point)
        };
        // Friction turns them, too.
        let rough = network.contact.friction > 0.0;
        let variables = |of: &(usize, usize)| {
            let frame = rough.then(|| Variable::Frame(network.branches[of.0].segment_frame(of.1)));
            points(*of).into_iter().chain(frame)
        };
        let cables = &mut self.contacts.cables;
        cables.cliques = pattern.iter().map(|pair| pair.iter().flat_map(variables).collect()).collect();
        cables.pattern = pattern;
        cables.version = 1 + next_id();
    }

    /// How far a pair's spot, which is at `x`, is from the nearest of its segments, m.
    fn distance(&self, state: &State, pair: &Pair, x: &Vector) -> f64 {
        let to = |j: u32| {
            let (b, j) = (pair.branch as usize, j as usize);
            (x - nearest_on(x, &self.node(state, b, j), &self.node(state, b, j + 1)).1).norm()
        };
        (pair.segments.0..=pair.segments.1).map(to).fold(f64::INFINITY, f64::min)
    }

    /// How near a spot may be to another cable, with which it has the radii `both` (m), as they overlapped from the beginning, m.
    fn overlap_distance(&self, spot: u32, branch: u32, both: f64) -> f64 {
        let overlaps = &self.conditions.contact.overlaps;
        let at = overlaps.partition_point(|o| (o.spot, o.branch) < (spot, branch));
        let own = overlaps.get(at).filter(|o| (o.spot, o.branch) == (spot, branch));
        own.map_or(both, |overlap| overlap.distance.min(both))
    }

    /// How near a spot may be to a segment (index of the branch and its own) of another cable, m.
    fn least_distance(&self, state: &State, spot: u32, (branch, segment): (u32, u32), both: f64) -> f64 {
        let least = self.overlap_distance(spot, branch, both);
        let held = self.distance_beside_held(state, spot, (branch as usize, segment as usize), both);
        held.map_or(least, |held| held.min(least))
    }

    /// Whether a spot and a segment were drawn or are held on top of each other: then they have no sides to change.
    fn may_coincide(&self, state: &State, spot: u32, of: (u32, u32), both: f64) -> bool {
        self.least_distance(state, spot, of, both) < COINCIDENT * both
    }

    /// Adds to `found` every spot that touches another cable at `state`, in order; returns the energy, J, but for what multipliers of marks
    /// that touch no more leave behind. Each segment counts for itself: so a spot in the crook of two of them touches both, and nothing jumps
    /// where it goes from one to the other.
    pub(super) fn find_pairs(&self, state: &State, found: &mut Vec<Contact>, coming: &mut Vec<Contact>) -> f64 {
        let mut energy = 0.0;
        let cables = &self.contacts.cables;
        // Multipliers push still at such a gap.
        let pull = |mark: &Mark| {
            let rho = self.contacts.penalties[self.contacts.spots[mark.spot as usize].branch] * mark.penalty;
            mark.multiplier / rho
        };
        let pull = self.conditions.contact.marks.iter().map(pull).fold(0.0, f64::max);
        for pair in &cables.pairs {
            if pair.nearest - 2.0 * cables.moved > (1.0 + COMING) * pair.both + pull {
                continue;
            }
            let spot = &self.contacts.spots[pair.spot as usize];
            let x = position(self.network, state, spot);
            let first = self.contacts.penalties[spot.branch];
            let marks = marks_of(&self.conditions.contact.marks, pair.spot);
            let least = self.overlap_distance(pair.spot, pair.branch, pair.both);
            for segment in pair.segments.0..=pair.segments.1 {
                let against = Against::Cable { branch: pair.branch, segment };
                let mark = marks.iter().find(|mark| mark.against == against);
                let rho = first * mark.map_or(1.0, |mark| mark.penalty);
                let lambda = mark.map_or(0.0, |mark| mark.multiplier);
                let (b, j) = (pair.branch as usize, segment as usize);
                let (from, to) = (self.node(state, b, j), self.node(state, b, j + 1));
                let (share, place) = nearest_on(&x, &from, &to);
                let distance = (x - place).norm();
                let held = self.distance_beside_held(state, pair.spot, (b, j), pair.both);
                let radius = held.map_or(least, |held| held.min(least));
                let gap = distance - radius;
                let (e, force) = pushed(gap, lambda, rho);
                energy += e + 0.5 * lambda * lambda / rho;
                if force == 0.0 && gap > COMING * radius {
                    continue;
                }
                // Centre lines on top of each other: any way apart is as good.
                let normal = if distance > 0.0 { (x - place) / distance } else { orthogonal(&(to - from).normalize()) };
                let mut across = Matrix::identity() - normal * normal.transpose();
                let turning = (share > 0.0 && share < 1.0).then(|| {
                    let length = (to - from).norm();
                    let direction = (to - from) / length;
                    across -= direction * direction.transpose();
                    Turning { direction, length, distance }
                });
                let contact = Contact {
                    spot: pair.spot,
                    against,
                    other: Some(Touched { first: self.network.branches[b].points.start + j, share, turning }),
                    position: x,
                    gap,
                    radius,
                    normal,
                    curvature: across / distance.max(COINCIDENT * radius),
                    force: lambda - rho * gap,
                    penalty: rho,
                };
                if force > 0.0 { found.push(contact) } else { coming.push(contact) }
            }
        }
        energy
    }

    /// The places between a spot and the next one on its segment that are nearer to another cable than is let pass, and nearer than both: where
    /// two straight pieces cross.
    pub(super) fn crossings(&self, state: &State, pair: &Pair, next: f64, found: &mut Vec<Spot>) {
        let spot = self.contacts.spots[pair.spot as usize];
        let at = |share: f64| position(self.network, state, &Spot { share, ..spot });
        let (p, d) = (at(spot.share), at(next) - at(spot.share));
        for segment in pair.segments.0..=pair.segments.1 {
            let radius = self.least_distance(state, pair.spot, (pair.branch, segment), pair.both);
            let (b, j) = (pair.branch as usize, segment as usize);
            let (q, e) = (self.node(state, b, j), self.node(state, b, j + 1) - self.node(state, b, j));
            // Where p + t d and q + s e are nearest to each other.
            let (dd, de, ee, r) = (d.norm_squared(), d.dot(&e), e.norm_squared(), q - p);
            let square = dd * ee - de * de;
            if square < PARALLEL * dd * ee {
                continue;
            }
            let t = (ee * d.dot(&r) - de * e.dot(&r)) / square;
            let s = (de * d.dot(&r) - dd * e.dot(&r)) / square;
            let inside = t > NEAR_SPOT && t < 1.0 - NEAR_SPOT && (0.0..=1.0).contains(&s);
            if inside && (p + d * t - q - e * s).norm() < radius * (1.0 - CROSSING) {
                found.push(Spot { share: spot.share + (next - spot.share) * t, ..spot });
            }
        }
    }

    /// Cables that overlap at `state` may do so from now on, as far as they do.
    pub fn note_overlaps(&mut self, state: &State) {
        self.conditions.contact.overlaps.clear();
        self.contacts.cables.search_again();
        self.search_pairs(state);
        let mut overlaps: Vec<Overlap> = Vec::new();
        for pair in &self.contacts.cables.pairs {
            let x = position(self.network, state, &self.contacts.spots[pair.spot as usize]);
            let distance = self.distance(state, pair, &x);
            if distance >= pair.both {
                continue;
            }
            match overlaps.last_mut() {
                Some(last) if (last.spot, last.branch) == (pair.spot, pair.branch) => {
                    last.distance = last.distance.min(distance);
                }
                _ => overlaps.push(Overlap { spot: pair.spot, branch: pair.branch, distance }),
            }
        }
        self.conditions.contact.overlaps = overlaps;
    }

    /// Cables that have come apart may not overlap again as far as they did; pairs are looked for anew, so that what is found next follows
    /// from this state alone.
    pub(super) fn commit_pairs(&mut self, state: &State) {
        self.contacts.cables.search_again();
        self.search_pairs(state);
        let mut overlaps = std::mem::take(&mut self.conditions.contact.overlaps);
        overlaps.retain_mut(|overlap| {
            let own = |pair: &&Pair| (pair.spot, pair.branch) == (overlap.spot, overlap.branch);
            let x = position(self.network, state, &self.contacts.spots[overlap.spot as usize]);
            let pairs = self.contacts.cables.pairs.iter().filter(own);
            let distance = pairs.map(|pair| self.distance(state, pair, &x)).fold(f64::INFINITY, f64::min);
            overlap.distance = overlap.distance.max(distance);
            distance.is_finite()
        });
        self.conditions.contact.overlaps = overlaps;
    }

    /// Which variables second derivatives of contact between cables may couple, those of two segments each time, and a number that changes with
    /// them.
    pub fn contact_pattern(&self) -> (u64, &[Vec<Variable>]) {
        (self.contacts.cables.version, &self.contacts.cables.cliques)
    }

    /// The largest share of the way from one state to another on which no centre line comes through another one, for certain.
    pub(super) fn free_share_of_cables(&mut self, from: &State, to: &State) -> f64 {
        if !self.network.contact.cables {
            return 1.0;
        }
        self.search_pairs(from);
        let moved = |i: usize| (to.points[i] - from.points[i]) + (to.carry[i] - from.carry[i]);
        let cables = &self.contacts.cables;
        let spots = self.contacts.spots.iter();
        let moves = spots.map(|spot| position(self.network, to, spot) - position(self.network, from, spot));
        let farthest = moves.map(|way| way.norm()).fold(0.0, f64::max);
        let mut free = 1.0_f64;
        for pair in &cables.pairs {
            let spot = &self.contacts.spots[pair.spot as usize];
            let radius = 0.5 * self.network.branches[spot.branch].section.diameter;
            let nearest = pair.nearest - 2.0 * cables.moved;
            if 2.0 * farthest < (SAFE * nearest).min(nearest - SPACING * radius) {
                continue;
            }
            free = free.min(self.share_of_piece(from, to, pair));
            let (a, b) = (position(self.network, from, spot), position(self.network, to, spot));
            let own = b - a;
            let distance = self.distance(from, pair, &a);
            let start = self.network.branches[pair.branch as usize].points.start;
            let points = start + pair.segments.0 as usize..=start + pair.segments.1 as usize + 1;
            let way = points.map(|i| (moved(i) - own).norm()).fold(0.0, f64::max);
            let segments = || (pair.segments.0..=pair.segments.1).map(|segment| (pair.branch, segment));
            let coincides = |of| self.may_coincide(from, pair.spot, of, pair.both);
            if way >= SAFE * distance && !segments().any(coincides) {
                free = free.min(SAFE * distance / way);
            }
        }
        // What is not watched is farther away than that; beyond it the way is gone in parts.
        let room = 0.5 * MARGIN * self.contacts.cables.largest_radius;
        if farthest > room {
            free = free.min(self.share_of_swept(from, to, farthest));
        }
        free
    }

    /// The share of the way from one state to another on which the piece between a spot and the next one does not come through what is near it.
    fn share_of_piece(&self, from: &State, to: &State, pair: &Pair) -> f64 {
        let spot = self.contacts.spots[pair.spot as usize];
        if spot.share == 1.0 {
            return 1.0;
        }
        let next = self.next_share(&spot);
        let piece =
            |state: &State| [spot.share, next].map(|share| position(self.network, state, &Spot { share, ..spot }));
        let (p, p_end) = (piece(from), piece(to));
        let b = pair.branch as usize;
        let segment = |state: &State, j: usize| [self.node(state, b, j), self.node(state, b, j + 1)];
        let rows = pair.segments.0 as usize..=pair.segments.1 as usize;
        let meets = rows.filter_map(|j| meeting([&p, &p_end], [&segment(from, j), &segment(to, j)]));
        meets.fold(1.0, |free, at| free.min(cross::SAFE * at))
    }

    /// The same for a way on which something goes far, `farthest` (m): by all segments that come near each other's way.
    fn share_of_swept(&self, from: &State, to: &State, farthest: f64) -> f64 {
        let network = self.network;
        let cables = &self.contacts.cables;
        let middle = |state: &State, b: usize, j: usize| (self.node(state, b, j) + self.node(state, b, j + 1)) * 0.5;
        let reach = 0.75 * cables.longest_segment + 2.0 * farthest;
        let cell = 2.0 * reach;
        let key = |x: &Vector| x.map(|x| (x / cell).floor() as i64);
        let mut cells: HashMap<[i64; 3], Vec<(usize, usize)>> = HashMap::new();
        for (b, branch) in network.branches.iter().enumerate() {
            for j in 0..branch.rod.mesh().segments() {
                cells.entry(key(&middle(from, b, j)).into()).or_default().push((b, j));
            }
        }
        let mut free = 1.0_f64;
        for (index, spot) in self.contacts.spots.iter().enumerate() {
            let (x, end) = (position(network, from, spot), position(network, to, spot));
            let home = key(&x);
            let lengths = &network.branches[spot.branch].rod.mesh().rest_lengths;
            let s = lengths[..spot.segment].iter().sum::<f64>() + lengths[spot.segment] * spot.share;
            for i in -1..=1 {
                for j in -1..=1 {
                    for k in -1..=1 {
                        for &(b, j) in cells.get(&[home.x + i, home.y + j, home.z + k]).into_iter().flatten() {
                            let (p, q) = (self.node(from, b, j), self.node(from, b, j + 1));
                            let distance = (x - nearest_on(&x, &p, &q).1).norm();
                            let own = end - x;
                            let way =
                                (self.node(to, b, j) - p - own).norm().max((self.node(to, b, j + 1) - q - own).norm());
                            if way < SAFE * distance {
                                continue;
                            }
                            let diameters = [spot.branch, b].map(|b| network.branches[b].section.diameter);
                            let both = 0.5 * (diameters[0] + diameters[1]);
                            let lengths = &network.branches[b].rod.mesh().rest_lengths;
                            let middle = lengths[..j].iter().sum::<f64>() + 0.5 * lengths[j];
                            if self.along((spot.branch, s), (b, middle)) > APART * both + 0.5 * lengths[j]
                                && !self.may_coincide(from, index as u32, (b as u32, j as u32), both)
                            {
                                free = free.min((SAFE * distance / way).max(LEAST));
                            }
                        }
                    }
                }
            }
        }
        free
    }
}

/// Share of the distance between two centre lines that may be gone at once.
const SAFE: f64 = 0.7;
/// Least share of a way that is let be gone, where cables are on top of each other: below it nothing would move any more.
const LEAST: f64 = 1e-3;
