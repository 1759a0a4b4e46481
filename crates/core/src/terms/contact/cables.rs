//! Contact between cables, including self-contact.
//!
//! The distance of a contact point from the centre line of another cable must be at least the sum of both radii. The
//! nearest point there is recomputed in every evaluation. Every cable has contact points, so each contact is evaluated
//! from both cables; [`super::crossing`] says how where they cross. Parts of the harness that are less than [`APART`]
//! sums of both radii apart along the cable are not considered. Cables that overlap at the start of a run (arms that
//! leave a joint side by side) may overlap as far until they have separated; cables that constraints hold in overlap
//! ([`super::held`]) may do so as long as they are held.

use super::continuous::{self, meeting};
use super::crossing::{COINCIDENT, CablePlace};
use super::evaluate::inequality;
use super::follow::WINDOW;
use super::pairs::{Cables, Pair, nearest_on};
use super::term::{APPROACHING, Contact, ContactTerm, Touched};
use crate::conditions::{Against, ContactPoint, ContactRecord, Overlap, Partner, System};
use crate::network::{APART, Branch, BranchEnd, next_id};
use crate::variable::Variable;
use crate::{Network, State, Vector};
use rustc_hash::FxHashMap;
use std::collections::BTreeSet;

/// Margin of the search, in largest radii: pairs nearer than their radii plus this are kept.
const MARGIN: f64 = 2.0;
/// Distance, in sums of both radii, below which pairs are in the pattern of the matrix: larger than that of pairs that
/// may touch after a step.
const COUPLED: f64 = 2.0;

impl ContactTerm {
    /// Distance along the harness between a place of one branch and one of another, m; infinite beyond the reach of the
    /// search.
    pub(super) fn along(&self, system: System<'_>, (a, s): (usize, f64), (b, t): (usize, f64)) -> f64 {
        if a == b {
            return (s - t).abs();
        }
        let ends = |branch: usize, s: f64| {
            let length = system.network.branches[branch].rod.mesh().length();
            let ends = [(system.network.branches[branch].start, s), (system.network.branches[branch].end, length - s)];
            ends.into_iter().filter_map(|(end, distance)| match end {
                BranchEnd::Joint { joint, .. } => Some((joint, distance)),
                BranchEnd::Free => None,
            })
        };
        let mut least = f64::INFINITY;
        for (from, first) in ends(a, s) {
            for (to, last) in ends(b, t) {
                let between = self.cables.between[from].iter().find(|(joint, _)| *joint == to);
                least = between.map_or(least, |(_, gap)| least.min(first + gap + last));
            }
        }
        least
    }

    /// Searches for near pairs if a node has moved too far since the last search.
    pub(super) fn search_pairs(&mut self, system: System<'_>, state: &State) {
        if !system.network.contact.cables {
            return;
        }
        let network = system.network;
        let cables = &mut self.cables;
        let margin = MARGIN * cables.largest_radius;
        cables.nodes.clear();
        cables.nodes.extend(state.points.iter().zip(&state.compensation).map(|(x, low)| x + low));
        let Cables { nodes, searched, moved, .. } = cables;
        if searched.len() == nodes.len() {
            largest_moves(network, |i| nodes[i] - searched[i], moved);
            if moved.iter().all(|moved| *moved <= 0.5 * margin) {
                return;
            }
        }
        let first_search = searched.is_empty();
        searched.clone_from(nodes);
        let cables = &self.cables;
        // Spatial hash of the midpoints of segments: near ones are in the same or a neighbouring cell.
        let cell = 0.5 * cables.longest_segment * 1.5 + 2.0 * cables.largest_radius + margin;
        let key = |x: &Vector| x.map(|x| (x / cell).floor() as i64);
        let segments = segments(network, &cables.nodes);
        let mut cells: FxHashMap<[i64; 3], Vec<&Segment>> = FxHashMap::default();
        for segment in &segments {
            cells.entry(key(&segment.middle).into()).or_default().push(segment);
        }
        let arcs: Vec<Vec<f64>> = (0..network.branches.len()).map(|b| state.arc_lengths(network, b)).collect();
        let mut pairs: Vec<Pair> = Vec::new();
        let mut found: Vec<(u32, u32, f64)> = Vec::new();
        // Segments around a cell: those of the last contact point are mostly those of the next one, too.
        let (mut around, mut inside) = (None, Vec::new());
        for (index, point) in self.points.iter().enumerate() {
            let x = point.position(network, state);
            let radius = network.radius(point.branch, point.segment);
            let s = arcs[point.branch][point.segment];
            let s = s + (arcs[point.branch][point.segment + 1] - s) * point.fraction;
            let center = key(&x);
            if around.replace(center) != Some(center) {
                inside.clear();
                for (i, j, k) in neighbours() {
                    inside.extend(cells.get(&[center.x + i, center.y + j, center.z + k]).into_iter().flatten());
                }
            }
            found.clear();
            found.extend(inside.iter().filter_map(|&&Segment { branch: b, index: j, middle, half }| {
                if point.follows.is_some_and(|followed| followed != Against::Branch(b)) {
                    return None;
                }
                let both = radius + network.radius(b, j);
                let reach = both + margin;
                if (x - middle).norm_squared() > SURELY * (reach + half) * (reach + half) {
                    return None;
                }
                let start = network.branches[b].points.start + j;
                let (_, place) = nearest_on(&x, &cables.nodes[start], &cables.nodes[start + 1]);
                let middle = 0.5 * (arcs[b][j] + arcs[b][j + 1]);
                let apart = APART * both + 0.5 * (arcs[b][j + 1] - arcs[b][j]);
                let distance = (x - place).norm();
                let counts = distance < reach && self.along(system, (point.branch, s), (b, middle)) > apart;
                counts.then_some((b as u32, j as u32, distance))
            }));
            found.sort_unstable_by_key(|&(branch, segment, _)| (branch, segment));
            for &(branch, segment, distance) in &found {
                let point = index as u32;
                let both = radius + network.radius(branch as usize, segment as usize);
                match pairs.last_mut() {
                    Some(last)
                        if (last.point, last.branch, last.both) == (point, branch, both)
                            && segment <= last.segments.1 + 1 =>
                    {
                        last.segments.1 = segment;
                        last.nearest = distance.min(last.nearest);
                    }
                    _ => {
                        let own = self.points[index].branch as u32;
                        pairs.push(Pair { point, own, branch, segments: (segment, segment), nearest: distance, both });
                    }
                }
            }
        }
        self.cables.pairs = pairs;
        self.cables.moved.fill(0.0);
        let pattern = self.coupled(system, state);
        let known = &self.cables.pattern;
        // The matrix keeps its pattern unless there is a new pair; after the first search the pattern depends on the
        // state alone.
        if pattern != *known && (first_search || !pattern.is_subset(known)) {
            self.couple(system, pattern);
        }
    }

    /// Adds pairs that touch at `state`, or may do so after a step, to the pattern of the matrix at any distance: a
    /// large multiplier acts across a gap.
    pub(super) fn couple_contacts<'c>(
        &mut self,
        system: System<'_>,
        state: &State,
        contacts: impl IntoIterator<Item = &'c Contact>,
    ) {
        let known = &self.cables.coupled;
        let pair = |contact: &Contact| match contact.partner {
            Partner::Cable { branch, segment } => {
                let point = &self.points[contact.point as usize];
                Some([(point.branch, point.segment), (branch as usize, segment as usize)])
            }
            Partner::Obstacle { .. } => None,
        };
        let mut missing = contacts.into_iter().filter_map(pair).filter(|pair| !known.contains(pair)).peekable();
        if missing.peek().is_some() {
            let mut pattern: BTreeSet<_> = missing.collect();
            pattern.extend(self.coupled(system, state));
            pattern.extend(&self.cables.pattern);
            self.couple(system, pattern);
        }
    }

    /// Pairs of segments that are near each other at `state`, or between which friction acts at any distance.
    fn coupled(&self, system: System<'_>, state: &State) -> BTreeSet<[(usize, usize); 2]> {
        let mut pattern = BTreeSet::new();
        for pair in &self.cables.pairs {
            let point = &self.points[pair.point as usize];
            let branch = pair.branch as usize;
            let reach = COUPLED * pair.both;
            if self.cables.nearest(pair) > reach {
                continue;
            }
            let x = point.position(system.network, state);
            for j in pair.segments.0 as usize..=pair.segments.1 as usize {
                let (_, place) = nearest_on(
                    &x,
                    &Self::node(system.network, state, branch, j),
                    &Self::node(system.network, state, branch, j + 1),
                );
                if (x - place).norm_squared() < reach * reach {
                    pattern.insert([(point.branch, point.segment), (branch, j)]);
                }
            }
        }
        for (record, [branch, segment]) in system.conditions.contact.bound_cables() {
            let point = &self.points[record.point as usize];
            pattern.insert([(point.branch, point.segment), (branch, segment)]);
        }
        pattern
    }

    /// Sets the pairs of segments that the matrix couples.
    fn couple(&mut self, system: System<'_>, pattern: BTreeSet<[(usize, usize); 2]>) {
        let network = system.network;
        let points = |(b, j): (usize, usize)| {
            let first = network.branches[b].points.start + j;
            [first, first + 1].map(Variable::Point)
        };
        // Friction also acts on the frames.
        let has_friction = network.contact.friction > 0.0;
        let variables = |of: &(usize, usize)| {
            let frame = has_friction.then(|| Variable::Frame(network.branches[of.0].segment_frame(of.1)));
            points(*of).into_iter().chain(frame)
        };
        let cables = &mut self.cables;
        cables.cliques = pattern.iter().map(|pair| pair.iter().flat_map(variables).collect()).collect();
        cables.coupled = pattern.iter().copied().collect();
        cables.pattern = pattern;
        cables.version = 1 + next_id();
    }

    /// Distance of a pair's contact point, with position `x`, from the nearest of its segments, m.
    fn distance(&self, system: System<'_>, state: &State, pair: &Pair, x: &Vector) -> f64 {
        let to = |j: u32| {
            let (b, j) = (pair.branch as usize, j as usize);
            (x - nearest_on(x, &Self::node(system.network, state, b, j), &Self::node(system.network, state, b, j + 1))
                .1)
                .norm()
        };
        (pair.segments.0..=pair.segments.1).map(to).fold(f64::INFINITY, f64::min)
    }

    /// Least permitted distance of a contact point from another cable with regard to initial overlaps, m; `both` is the
    /// sum of the radii, m.
    fn overlap_distance(&self, system: System<'_>, point: u32, branch: u32, both: f64) -> f64 {
        let overlaps = &system.conditions.contact.overlaps;
        let at = overlaps.partition_point(|o| (o.point, o.branch) < (point, branch));
        let own = overlaps.get(at).filter(|o| (o.point, o.branch) == (point, branch));
        own.map_or(both, |overlap| (overlap.distance + (both - overlap.both)).min(both))
    }

    /// Least permitted distance of a contact point from a segment (indices of branch and segment) of another cable, m.
    pub(super) fn least_distance(
        &self,
        system: System<'_>,
        state: &State,
        point: u32,
        (branch, segment): (u32, u32),
        both: f64,
    ) -> f64 {
        let least = self.overlap_distance(system, point, branch, both);
        let held = self.distance_beside_held(system, state, point, (branch as usize, segment as usize), both);
        held.map_or(least, |held| held.min(least))
    }

    /// Whether a contact point and a segment may coincide, because they were drawn or are held so: then passing through
    /// each other cannot be detected.
    fn may_coincide(&self, system: System<'_>, state: &State, point: u32, of: (u32, u32), both: f64) -> bool {
        self.least_distance(system, state, point, of, both) < COINCIDENT * both
    }

    /// Adds all contacts between cables at `state` to `found` (with a force) and `approaching`, in order; returns their
    /// energy, J, without the part −λ²/(2ρ) of the records. Each segment is a partner of its own: a contact point
    /// at the concave side of a corner touches both segments, and the energy is continuous where the nearest segment
    /// changes.
    pub(super) fn find_pairs(
        &self,
        system: System<'_>,
        state: &State,
        found: &mut Vec<Contact>,
        approaching: &mut Vec<Contact>,
    ) -> f64 {
        let mut energy = 0.0;
        let cables = &self.cables;
        // Largest gap at which a multiplier still acts.
        let pull = |record: &ContactRecord| record.multiplier / self.penalty(record);
        let pull = system.conditions.contact.records.iter().map(pull).fold(0.0, f64::max);
        // Records of this and the following pairs, which are in the order of their contact points.
        let mut records = &system.conditions.contact.records[..];
        for pair in &cables.pairs {
            let reach = (1.0 + APPROACHING) * pair.both;
            let point = &self.points[pair.point as usize];
            // One that follows may be as much nearer.
            let way = if point.follows.is_some() { WINDOW * pair.both } else { 0.0 };
            if cables.nearest(pair) > reach + pull + way {
                continue;
            }
            let x = point.position(system.network, state);
            let first = self.penalties[point.branch];
            while let [record, later @ ..] = records
                && record.point < pair.point
            {
                records = later;
            }
            let start = system.network.branches[pair.branch as usize].points.start;
            for segment in pair.segments.0..=pair.segments.1 {
                let partner = Partner::Cable { branch: pair.branch, segment };
                let own = records.iter().take_while(|record| record.point == pair.point);
                let record = own.into_iter().find(|record| record.partner == partner);
                let (b, j) = (pair.branch as usize, segment as usize);
                let (from, to) = (cables.nodes[start + j], cables.nodes[start + j + 1]);
                let (_, place) = nearest_on(&x, &from, &to);
                if record.is_none() && (x - place).norm_squared() > SURELY * (reach + way) * (reach + way) {
                    continue;
                }
                let rho = first * record.map_or(1.0, |record| record.penalty);
                let lambda = record.map_or(0.0, |record| record.multiplier);
                let radius = self.least_distance(system, state, pair.point, (pair.branch, segment), pair.both);
                let place = self.cable_place(system, state, (pair.point, &x), ((b, j), [from, to]), pair.both);
                let CablePlace { fraction, position, other, normal, curvature, slides, .. } = place;
                let gap = place.distance + place.held - radius;
                let (e, force) = inequality(gap, lambda, rho);
                energy += e + 0.5 * lambda * lambda / rho;
                if force == 0.0 && gap > APPROACHING * radius {
                    continue;
                }
                let contact = Contact {
                    point: pair.point,
                    fraction,
                    partner,
                    other: Some(Touched { first: start + j, fraction: other }),
                    on_edge: place.on_crossing,
                    slides,
                    position,
                    gap,
                    radius,
                    normal,
                    curvature,
                    force: lambda - rho * gap,
                    penalty: rho,
                };
                if force > 0.0 { found.push(contact) } else { approaching.push(contact) }
            }
        }
        energy
    }

    /// Overlaps of cables at `state`, as permitted ones.
    pub fn overlaps(&mut self, system: System<'_>, state: &State) -> Vec<Overlap> {
        self.cables.search_again();
        self.search_pairs(system, state);
        let mut overlaps: Vec<Overlap> = Vec::new();
        for pair in self.cables.pairs.iter().filter(|pair| self.points[pair.point as usize].follows.is_none()) {
            let x = self.points[pair.point as usize].position(system.network, state);
            let distance = self.distance(system, state, pair, &x);
            if distance >= pair.both {
                continue;
            }
            match overlaps.last_mut() {
                Some(last) if (last.point, last.branch) == (pair.point, pair.branch) => {
                    last.distance = last.distance.min(distance + (last.both - pair.both));
                }
                _ => overlaps.push(Overlap { point: pair.point, branch: pair.branch, distance, both: pair.both }),
            }
        }
        overlaps
    }

    /// Permitted overlaps that remain at `state`: cables that have separated may not overlap again as far as before.
    /// Repeats the search of pairs, so that later results depend on this state alone.
    pub fn remaining_overlaps(&mut self, system: System<'_>, state: &State) -> Vec<Overlap> {
        self.cables.search_again();
        self.search_pairs(system, state);
        let mut overlaps = system.conditions.contact.overlaps.clone();
        overlaps.retain_mut(|overlap| {
            let own = |pair: &&Pair| (pair.point, pair.branch) == (overlap.point, overlap.branch);
            let x = self.points[overlap.point as usize].position(system.network, state);
            let pairs = self.cables.pairs.iter().filter(own);
            let distance = |pair: &Pair| self.distance(system, state, pair, &x) + (overlap.both - pair.both);
            let distance = pairs.map(distance).fold(f64::INFINITY, f64::min);
            overlap.distance = overlap.distance.max(distance);
            distance.is_finite()
        });
        overlaps
    }

    /// Pattern of the matrix: its version, and the sets of variables, each of two segments, that second derivatives of
    /// contact between cables may couple.
    pub fn pattern(&self) -> (u64, &[Vec<Variable>]) {
        (self.cables.version, &self.cables.cliques)
    }

    /// Lower bound of the fraction of the motion from one state to another on which no centre line passes through
    /// another one.
    pub(super) fn collision_free_fraction_of_cables(&mut self, system: System<'_>, from: &State, to: &State) -> f64 {
        if !system.network.contact.cables {
            return 1.0;
        }
        self.search_pairs(system, from);
        let moved = |i: usize| (to.points[i] - from.points[i]) + (to.compensation[i] - from.compensation[i]);
        let network = system.network;
        let mut motions = std::mem::take(&mut self.cables.motions);
        largest_moves(network, moved, &mut motions);
        let farthest = motions.iter().copied().fold(0.0, f64::max);
        let mut free = 1.0_f64;
        for pair in &self.cables.pairs {
            let nearest = self.cables.nearest(pair);
            let both = motions[pair.own as usize] + motions[pair.branch as usize];
            if both < (SAFE * nearest).min(nearest - self.spacings[pair.own as usize]) {
                continue;
            }
            let point = &self.points[pair.point as usize];
            if point.follows.is_some() {
                continue;
            }
            let (a, b) = (point.position(network, from), point.position(network, to));
            let own = b - a;
            let distance = self.distance(system, from, pair, &a);
            let start = network.branches[pair.branch as usize].points.start;
            let points = start + pair.segments.0 as usize..=start + pair.segments.1 as usize + 1;
            // The piece up to the next contact point can meet the pair only if it comes that far.
            let first = network.branches[point.branch].points.start + point.segment;
            let ends = [moved(first), moved(first + 1)];
            let apart = |i: usize| ends.iter().map(|end| (moved(i) - end).norm()).fold(0.0, f64::max);
            let next = self.next[pair.point as usize];
            let piece = (next - point.fraction) * (from.points[first + 1] - from.points[first]).norm();
            if points.clone().map(apart).fold(0.0, f64::max) >= NEARLY * (distance - piece) {
                free = free.min(self.fraction_of_piece(system, from, to, pair));
            }
            let motion = points.map(|i| (moved(i) - own).norm()).fold(0.0, f64::max);
            let segments = || (pair.segments.0..=pair.segments.1).map(|segment| (pair.branch, segment));
            let coincides = |of| self.may_coincide(system, from, pair.point, of, pair.both);
            if motion >= SAFE * distance && !segments().any(coincides) {
                free = free.min(SAFE * distance / motion);
            }
        }
        // Pairs that are not cached are farther apart than this; larger motions are checked separately.
        let covered = 0.5 * MARGIN * self.cables.largest_radius;
        if farthest > covered {
            free = free.min(self.fraction_of_swept(system, from, to, &motions));
        }
        self.cables.motions = motions;
        free
    }

    /// Fraction of the motion from one state to another on which the piece between a contact point and the next one
    /// does not pass through the segments of a pair.
    fn fraction_of_piece(&self, system: System<'_>, from: &State, to: &State, pair: &Pair) -> f64 {
        let point = self.points[pair.point as usize];
        if point.fraction == 1.0 {
            return 1.0;
        }
        let next = self.next[pair.point as usize];
        let piece = |state: &State| {
            [point.fraction, next].map(|fraction| (ContactPoint { fraction, ..point }).position(system.network, state))
        };
        let (p, p_end) = (piece(from), piece(to));
        let b = pair.branch as usize;
        let segment = |state: &State, j: usize| {
            [Self::node(system.network, state, b, j), Self::node(system.network, state, b, j + 1)]
        };
        let rows = pair.segments.0 as usize..=pair.segments.1 as usize;
        let meets = rows.filter_map(|j| meeting([&p, &p_end], [&segment(from, j), &segment(to, j)]));
        meets.fold(1.0, |free, at| free.min(continuous::SAFE * at))
    }

    /// The same for large motions, at most `motions` (m) by branch: checks all segments that are not farther apart than
    /// they move.
    fn fraction_of_swept(&self, system: System<'_>, from: &State, to: &State, motions: &[f64]) -> f64 {
        let network = system.network;
        let nodes = &self.cables.nodes;
        let segments = segments(network, nodes);
        let count = |b: usize| network.branches[b].rod.mesh().segments();
        let starts = (0..network.branches.len()).scan(0, |start, b| Some(std::mem::replace(start, *start + count(b))));
        let starts: Vec<usize> = starts.collect();
        let boxes: Vec<[Vector; 2]> = network.branches.iter().map(|b| bounds(&nodes[b.points.clone()])).collect();
        // Farthest that a contact point and a branch may be apart to meet.
        let reach = |own: f64, b: usize| (own + motions[b]) / SAFE;
        let near = |(own, motion): (&[Vector; 2], &f64)| -> Vec<usize> {
            let is_near = |&b: &usize| gap_squared(own, &boxes[b]) <= SURELY * reach(*motion, b).powi(2);
            (0..boxes.len()).filter(is_near).collect()
        };
        let near: Vec<Vec<usize>> = boxes.iter().zip(motions).map(near).collect();
        let mut free = 1.0_f64;
        for (index, point) in self.points.iter().enumerate() {
            let (x, end) = (point.position(network, from), point.position(network, to));
            let own = end - x;
            let own_motion = own.norm();
            for &b in &near[point.branch] {
                let reach = reach(own_motion, b);
                if gap_squared(&[x, x], &boxes[b]) > SURELY * reach * reach {
                    continue;
                }
                for &Segment { index: j, middle, half, .. } in &segments[starts[b]..starts[b] + count(b)] {
                    if (x - middle).norm_squared() > SURELY * (reach + half) * (reach + half) {
                        continue;
                    }
                    let first = network.branches[b].points.start + j;
                    let (p, q) = (nodes[first], nodes[first + 1]);
                    let distance = (x - nearest_on(&x, &p, &q).1).norm();
                    let motion = (Self::node(network, to, b, j) - p - own)
                        .norm()
                        .max((Self::node(network, to, b, j + 1) - q - own).norm());
                    if motion < SAFE * distance {
                        continue;
                    }
                    let both = network.radius(point.branch, point.segment) + network.radius(b, j);
                    let lengths = &network.branches[point.branch].rod.mesh().rest_lengths;
                    let s = lengths[..point.segment].iter().sum::<f64>() + lengths[point.segment] * point.fraction;
                    let lengths = &network.branches[b].rod.mesh().rest_lengths;
                    let middle = lengths[..j].iter().sum::<f64>() + 0.5 * lengths[j];
                    if self.along(system, (point.branch, s), (b, middle)) > APART * both + 0.5 * lengths[j]
                        && !self.may_coincide(system, from, index as u32, (b as u32, j as u32), both)
                    {
                        free = free.min((SAFE * distance / motion).max(LEAST));
                    }
                }
            }
        }
        free
    }
}

/// A segment of a branch, for searches.
struct Segment {
    branch: usize,
    index: usize,
    middle: Vector,
    /// Half of its length, m.
    half: f64,
}

/// All segments, branch by branch, for these positions of the points.
fn segments(network: &Network, nodes: &[Vector]) -> Vec<Segment> {
    let of_branch = |(branch, b): (usize, &Branch)| {
        let segment = move |(index, [p, q]): (usize, &[Vector; 2])| Segment {
            branch,
            index,
            middle: (p + q) * 0.5,
            half: 0.5 * (q - p).norm(),
        };
        nodes[b.points.clone()].array_windows().enumerate().map(segment).collect::<Vec<_>>()
    };
    network.branches.iter().enumerate().flat_map(of_branch).collect()
}

/// Offsets of a cell's neighbours in a grid, and of itself.
fn neighbours() -> impl Iterator<Item = (i64, i64, i64)> {
    (0..27).map(|n| (n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1))
}

/// Least and largest coordinates.
fn bounds(points: &[Vector]) -> [Vector; 2] {
    let least = Vector::repeat(f64::INFINITY);
    points.iter().fold([least, -least], |[low, high], x| [low.inf(x), high.sup(x)])
}

/// Squared distance of two boxes, m².
fn gap_squared(a: &[Vector; 2], b: &[Vector; 2]) -> f64 {
    (a[0] - b[1]).sup(&(b[0] - a[1])).map(|gap| gap.max(0.0)).norm_squared()
}

/// Largest displacement of the nodes of each branch, m, from that of each point. No contact point of the branch moves
/// farther, as it lies on a straight line between two of them.
fn largest_moves(network: &Network, displacement: impl Fn(usize) -> Vector, largest: &mut [f64]) {
    for (branch, largest) in network.branches.iter().zip(largest) {
        *largest = branch.points.clone().map(|i| displacement(i).norm_squared()).fold(0.0, f64::max).sqrt();
    }
}

/// Above 1 by more than the round-off of squared distances.
const SURELY: f64 = 1.0 + 1e-9;
/// Below 1 by more than the round-off of distances.
const NEARLY: f64 = 1.0 - 1e-9;
/// Fraction of the distance between two centre lines that one step may cover.
const SAFE: f64 = 0.7;
/// Least fraction of a motion that is permitted where cables nearly coincide: a smaller one would stall the solver.
const LEAST: f64 = 1e-3;
