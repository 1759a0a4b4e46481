//! Cables that touch each other, or themselves.
//!
//! A point is kept as far from the centre line of another cable as both radii together; its nearest place there is
//! looked for anew with every evaluation, so nothing but friction keeps the two from sliding along each other. Every
//! cable has points, so both of a pair are looked after. Parts of the harness that are less than [`APART`] radii from
//! each other along the cable do not count. Where cables overlap when a run begins (arms that leave a joint side by
//! side), they are let overlap so far, until they have come apart; where constraints hold them in each other
//! ([`super::held`]), as long as they do.

use super::continuous::{self, meeting};
use super::evaluate::inequality;
use super::pairs::{APART, Pair, nearest_on};
use super::term::{APPROACHING, Contact, ContactTerm, DEPTH, SPACING, Touched, Turning};
use crate::conditions::{ContactPoint, ContactRecord, Overlap, Partner, System};
use crate::network::{BranchEnd, next_id};
use crate::rotation::orthogonal;
use crate::variable::Variable;
use crate::{Matrix, State, Vector};
use std::collections::{BTreeSet, HashMap};

/// Pairs are kept that are nearer than their radii and so many times the largest radius.
const MARGIN: f64 = 2.0;
/// Pairs are in the pattern of the matrix that are nearer than so many sums of both radii: more than those that may
/// come to touch with a step.
const COUPLED: f64 = 2.0;
/// Depth between points, in sums of both radii, from which on one is put where two cables cross.
const CROSSING: f64 = 4.0 * DEPTH;
/// None is put nearer to another one than this fraction of the distance between its neighbours.
const NEAR_POINT: f64 = 0.02;
/// Distance between centre lines, in sums of both radii, below which the curvature of the distance is that at it: it
/// has no bound.
const COINCIDENT: f64 = 1e-6;
/// Square of the sine of the angle below which pieces count as parallel.
const PARALLEL: f64 = 1e-3;

impl ContactTerm {
    /// Distance along the harness between a place of one branch and one of another, m; infinite where it is far.
    pub(super) fn along(&self, system: System<'_>, (a, s): (usize, f64), (b, t): (usize, f64)) -> f64 {
        if a == b {
            return (s - t).abs();
        }
        let ends = |branch: usize, s: f64| {
            let length = system.network.branches[branch].rod.mesh().length();
            let ends = [(system.network.branches[branch].start, s), (system.network.branches[branch].end, length - s)];
            ends.into_iter().filter_map(|(end, way)| match end {
                BranchEnd::Joint { joint, .. } => Some((joint, way)),
                BranchEnd::Free => None,
            })
        };
        let mut least = f64::INFINITY;
        for (from, way) in ends(a, s) {
            for (to, rest) in ends(b, t) {
                let between = self.cables.between[from].iter().find(|(joint, _)| *joint == to);
                least = between.map_or(least, |(_, gap)| least.min(way + gap + rest));
            }
        }
        least
    }

    /// Looks for pairs wherever something has moved far since they were looked for last.
    pub(super) fn search_pairs(&mut self, system: System<'_>, state: &State) {
        if !system.network.contact.cables {
            return;
        }
        let network = system.network;
        let margin = MARGIN * self.cables.largest_radius;
        let points = || self.points.iter().map(|point| point.position(network, state));
        let searched = &self.cables.searched;
        if searched.len() == self.points.len() {
            let moved = points().zip(searched).map(|(x, was)| (x - was).norm_squared()).fold(0.0, f64::max).sqrt();
            if moved <= 0.5 * margin {
                self.cables.moved = moved;
                return;
            }
        }
        let points: Vec<Vector> = points().collect();
        let first_search = searched.is_empty();
        let cables = &self.cables;
        // Midpoints of segments, by cell; what is near enough lies in a cell next door.
        let cell = 0.5 * cables.longest_segment * 1.5 + 2.0 * cables.largest_radius + margin;
        let key = |x: &Vector| x.map(|x| (x / cell).floor() as i64);
        let mut cells: HashMap<[i64; 3], Vec<(u32, u32)>> = HashMap::new();
        for (b, branch) in network.branches.iter().enumerate() {
            for j in 0..branch.rod.mesh().segments() {
                let middle =
                    (Self::node(system.network, state, b, j) + Self::node(system.network, state, b, j + 1)) * 0.5;
                cells.entry(key(&middle).into()).or_default().push((b as u32, j as u32));
            }
        }
        let arcs: Vec<Vec<f64>> = (0..network.branches.len()).map(|b| state.arc_lengths(network, b)).collect();
        let mut pairs: Vec<Pair> = Vec::new();
        let mut found: Vec<(u32, u32, f64)> = Vec::new();
        for (index, (point, x)) in self.points.iter().zip(&points).enumerate() {
            let radius = 0.5 * network.branches[point.branch].section.diameter;
            let s = arcs[point.branch][point.segment];
            let s = s + (arcs[point.branch][point.segment + 1] - s) * point.fraction;
            found.clear();
            let home = key(x);
            for i in -1..=1 {
                for j in -1..=1 {
                    for k in -1..=1 {
                        let Some(inside) = cells.get(&[home.x + i, home.y + j, home.z + k]) else { continue };
                        found.extend(inside.iter().filter_map(|&(of, segment)| {
                            let (b, j) = (of as usize, segment as usize);
                            let both = radius + 0.5 * network.branches[b].section.diameter;
                            let (_, place) = nearest_on(
                                x,
                                &Self::node(system.network, state, b, j),
                                &Self::node(system.network, state, b, j + 1),
                            );
                            let middle = 0.5 * (arcs[b][j] + arcs[b][j + 1]);
                            let apart = APART * both + 0.5 * (arcs[b][j + 1] - arcs[b][j]);
                            let distance = (x - place).norm();
                            let counts =
                                distance < both + margin && self.along(system, (point.branch, s), (b, middle)) > apart;
                            counts.then_some((of, segment, distance))
                        }));
                    }
                }
            }
            found.sort_unstable_by_key(|&(branch, segment, _)| (branch, segment));
            for &(branch, segment, distance) in &found {
                let point = index as u32;
                match pairs.last_mut() {
                    Some(last) if (last.point, last.branch) == (point, branch) && segment <= last.segments.1 + 1 => {
                        last.segments.1 = segment;
                        last.nearest = distance.min(last.nearest);
                    }
                    _ => {
                        let both = radius + 0.5 * network.branches[branch as usize].section.diameter;
                        pairs.push(Pair { point, branch, segments: (segment, segment), nearest: distance, both });
                    }
                }
            }
        }
        let cables = &mut self.cables;
        (cables.pairs, cables.searched, cables.moved) = (pairs, points, 0.0);
        let pattern = self.coupled(system, state);
        let known = &self.cables.pattern;
        // As long as nothing new may be coupled the matrix keeps its pattern; where a search is the first, it is that
        // of the state alone.
        if pattern != *known && (first_search || !pattern.is_subset(known)) {
            self.couple(system, pattern);
        }
    }

    /// Makes sure that what touches at `state`, or may come to, is in the pattern of the matrix, however far apart it
    /// is: a multiplier pushes on at any distance that it was large enough for.
    pub(super) fn couple_contacts<'c>(
        &mut self,
        system: System<'_>,
        state: &State,
        contacts: impl IntoIterator<Item = &'c Contact>,
    ) {
        let known = &self.cables.pattern;
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
            pattern.extend(known);
            self.couple(system, pattern);
        }
    }

    /// Pairs of segments of which one is near the other at `state`, or that friction holds to each other, wherever that
    /// is.
    fn coupled(&self, system: System<'_>, state: &State) -> BTreeSet<[(usize, usize); 2]> {
        let mut pattern = BTreeSet::new();
        for pair in &self.cables.pairs {
            let point = &self.points[pair.point as usize];
            let x = point.position(system.network, state);
            let branch = pair.branch as usize;
            let reach = COUPLED * pair.both;
            if pair.nearest - 2.0 * self.cables.moved > reach {
                continue;
            }
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

    /// Sets which pairs of segments the matrix couples.
    fn couple(&mut self, system: System<'_>, pattern: BTreeSet<[(usize, usize); 2]>) {
        let network = system.network;
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
        let cables = &mut self.cables;
        cables.cliques = pattern.iter().map(|pair| pair.iter().flat_map(variables).collect()).collect();
        cables.pattern = pattern;
        cables.version = 1 + next_id();
    }

    /// How far a pair's point, which is at `x`, is from the nearest of its segments, m.
    fn distance(&self, system: System<'_>, state: &State, pair: &Pair, x: &Vector) -> f64 {
        let to = |j: u32| {
            let (b, j) = (pair.branch as usize, j as usize);
            (x - nearest_on(x, &Self::node(system.network, state, b, j), &Self::node(system.network, state, b, j + 1))
                .1)
                .norm()
        };
        (pair.segments.0..=pair.segments.1).map(to).fold(f64::INFINITY, f64::min)
    }

    /// How near a point may be to another cable, with which it has the radii `both` (m), as they overlapped from the
    /// beginning, m.
    fn overlap_distance(&self, system: System<'_>, point: u32, branch: u32, both: f64) -> f64 {
        let overlaps = &system.conditions.contact.overlaps;
        let at = overlaps.partition_point(|o| (o.point, o.branch) < (point, branch));
        let own = overlaps.get(at).filter(|o| (o.point, o.branch) == (point, branch));
        own.map_or(both, |overlap| overlap.distance.min(both))
    }

    /// How near a point may be to a segment (index of the branch and its own) of another cable, m.
    fn least_distance(
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

    /// Whether a point and a segment were drawn or are held on top of each other: then they have no sides to change.
    fn may_coincide(&self, system: System<'_>, state: &State, point: u32, of: (u32, u32), both: f64) -> bool {
        self.least_distance(system, state, point, of, both) < COINCIDENT * both
    }

    /// Adds to `found` every point that touches another cable at `state`, in order; returns the energy, J, but for what
    /// multipliers of records that touch no more leave behind. Each segment counts for itself: so a point in the crook
    /// of two of them touches both, and nothing jumps where it goes from one to the other.
    pub(super) fn find_pairs(
        &self,
        system: System<'_>,
        state: &State,
        found: &mut Vec<Contact>,
        approaching: &mut Vec<Contact>,
    ) -> f64 {
        let mut energy = 0.0;
        let cables = &self.cables;
        // Multipliers push still at such a gap.
        let pull = |record: &ContactRecord| record.multiplier / self.penalty(record);
        let pull = system.conditions.contact.records.iter().map(pull).fold(0.0, f64::max);
        for pair in &cables.pairs {
            if pair.nearest - 2.0 * cables.moved > (1.0 + APPROACHING) * pair.both + pull {
                continue;
            }
            let point = &self.points[pair.point as usize];
            let x = point.position(system.network, state);
            let first = self.penalties[point.branch];
            let records = system.conditions.contact.records_of(pair.point);
            let least = self.overlap_distance(system, pair.point, pair.branch, pair.both);
            for segment in pair.segments.0..=pair.segments.1 {
                let partner = Partner::Cable { branch: pair.branch, segment };
                let record = records.iter().find(|record| record.partner == partner);
                let rho = first * record.map_or(1.0, |record| record.penalty);
                let lambda = record.map_or(0.0, |record| record.multiplier);
                let (b, j) = (pair.branch as usize, segment as usize);
                let (from, to) = (Self::node(system.network, state, b, j), Self::node(system.network, state, b, j + 1));
                let (fraction, place) = nearest_on(&x, &from, &to);
                let distance = (x - place).norm();
                let held = self.distance_beside_held(system, state, pair.point, (b, j), pair.both);
                let radius = held.map_or(least, |held| held.min(least));
                let gap = distance - radius;
                let (e, force) = inequality(gap, lambda, rho);
                energy += e + 0.5 * lambda * lambda / rho;
                if force == 0.0 && gap > APPROACHING * radius {
                    continue;
                }
                // Centre lines on top of each other: any way apart is as good.
                let normal = if distance > 0.0 { (x - place) / distance } else { orthogonal(&(to - from).normalize()) };
                let mut across = Matrix::identity() - normal * normal.transpose();
                let turning = (fraction > 0.0 && fraction < 1.0).then(|| {
                    let length = (to - from).norm();
                    let direction = (to - from) / length;
                    across -= direction * direction.transpose();
                    Turning { direction, length, distance }
                });
                let contact = Contact {
                    point: pair.point,
                    partner,
                    other: Some(Touched { first: system.network.branches[b].points.start + j, fraction, turning }),
                    position: x,
                    gap,
                    radius,
                    normal,
                    curvature: across / distance.max(COINCIDENT * radius),
                    force: lambda - rho * gap,
                    penalty: rho,
                };
                if force > 0.0 { found.push(contact) } else { approaching.push(contact) }
            }
        }
        energy
    }

    /// The places between a point and the next one on its segment that are nearer to another cable than is let pass,
    /// and nearer than both: where two straight pieces cross.
    pub(super) fn crossings(
        &self,
        system: System<'_>,
        state: &State,
        pair: &Pair,
        next: f64,
        found: &mut Vec<ContactPoint>,
    ) {
        let point = self.points[pair.point as usize];
        let at = |fraction: f64| (ContactPoint { fraction, ..point }).position(system.network, state);
        let (p, d) = (at(point.fraction), at(next) - at(point.fraction));
        for segment in pair.segments.0..=pair.segments.1 {
            let radius = self.least_distance(system, state, pair.point, (pair.branch, segment), pair.both);
            let (b, j) = (pair.branch as usize, segment as usize);
            let (q, e) = (
                Self::node(system.network, state, b, j),
                Self::node(system.network, state, b, j + 1) - Self::node(system.network, state, b, j),
            );
            // Where p + t d and q + s e are nearest to each other.
            let (dd, de, ee, r) = (d.norm_squared(), d.dot(&e), e.norm_squared(), q - p);
            let square = dd * ee - de * de;
            if square < PARALLEL * dd * ee {
                continue;
            }
            let t = (ee * d.dot(&r) - de * e.dot(&r)) / square;
            let s = (de * d.dot(&r) - dd * e.dot(&r)) / square;
            let inside = t > NEAR_POINT && t < 1.0 - NEAR_POINT && (0.0..=1.0).contains(&s);
            if inside && (p + d * t - q - e * s).norm() < radius * (1.0 - CROSSING) {
                found.push(ContactPoint { fraction: point.fraction + (next - point.fraction) * t, ..point });
            }
        }
    }

    /// Overlaps of cables at `state`.
    pub(crate) fn overlaps(&mut self, system: System<'_>, state: &State) -> Vec<Overlap> {
        self.cables.search_again();
        self.search_pairs(system, state);
        let mut overlaps: Vec<Overlap> = Vec::new();
        for pair in &self.cables.pairs {
            let x = self.points[pair.point as usize].position(system.network, state);
            let distance = self.distance(system, state, pair, &x);
            if distance >= pair.both {
                continue;
            }
            match overlaps.last_mut() {
                Some(last) if (last.point, last.branch) == (pair.point, pair.branch) => {
                    last.distance = last.distance.min(distance);
                }
                _ => overlaps.push(Overlap { point: pair.point, branch: pair.branch, distance }),
            }
        }
        overlaps
    }

    /// Overlaps that are left at `state`: cables that have come apart may not overlap again as far as they did. Pairs
    /// are searched anew, so that what is found next follows from this state alone.
    pub(crate) fn remaining_overlaps(&mut self, system: System<'_>, state: &State) -> Vec<Overlap> {
        self.cables.search_again();
        self.search_pairs(system, state);
        let mut overlaps = system.conditions.contact.overlaps.clone();
        overlaps.retain_mut(|overlap| {
            let own = |pair: &&Pair| (pair.point, pair.branch) == (overlap.point, overlap.branch);
            let x = self.points[overlap.point as usize].position(system.network, state);
            let pairs = self.cables.pairs.iter().filter(own);
            let distance = pairs.map(|pair| self.distance(system, state, pair, &x)).fold(f64::INFINITY, f64::min);
            overlap.distance = overlap.distance.max(distance);
            distance.is_finite()
        });
        overlaps
    }

    /// Pattern of the matrix: variables that second derivatives of contact between cables may couple, those of two
    /// segments each time, and a number that changes with them.
    pub fn pattern(&self) -> (u64, &[Vec<Variable>]) {
        (self.cables.version, &self.cables.cliques)
    }

    /// The largest fraction of the way from one state to another on which no centre line comes through another one, for
    /// certain.
    pub(super) fn collision_free_fraction_of_cables(&mut self, system: System<'_>, from: &State, to: &State) -> f64 {
        if !system.network.contact.cables {
            return 1.0;
        }
        self.search_pairs(system, from);
        let moved = |i: usize| (to.points[i] - from.points[i]) + (to.compensation[i] - from.compensation[i]);
        let cables = &self.cables;
        let points = self.points.iter();
        let moves = points.map(|point| point.position(system.network, to) - point.position(system.network, from));
        let farthest = moves.map(|way| way.norm()).fold(0.0, f64::max);
        let mut free = 1.0_f64;
        for pair in &cables.pairs {
            let point = &self.points[pair.point as usize];
            let radius = 0.5 * system.network.branches[point.branch].section.diameter;
            let nearest = pair.nearest - 2.0 * cables.moved;
            if 2.0 * farthest < (SAFE * nearest).min(nearest - SPACING * radius) {
                continue;
            }
            free = free.min(self.fraction_of_piece(system, from, to, pair));
            let (a, b) = (point.position(system.network, from), point.position(system.network, to));
            let own = b - a;
            let distance = self.distance(system, from, pair, &a);
            let start = system.network.branches[pair.branch as usize].points.start;
            let points = start + pair.segments.0 as usize..=start + pair.segments.1 as usize + 1;
            let way = points.map(|i| (moved(i) - own).norm()).fold(0.0, f64::max);
            let segments = || (pair.segments.0..=pair.segments.1).map(|segment| (pair.branch, segment));
            let coincides = |of| self.may_coincide(system, from, pair.point, of, pair.both);
            if way >= SAFE * distance && !segments().any(coincides) {
                free = free.min(SAFE * distance / way);
            }
        }
        // What is not cached is farther away than that; beyond it the way is gone in parts.
        let room = 0.5 * MARGIN * self.cables.largest_radius;
        if farthest > room {
            free = free.min(self.fraction_of_swept(system, from, to, farthest));
        }
        free
    }

    /// The fraction of the way from one state to another on which the piece between a point and the next one does not
    /// come through what is near it.
    fn fraction_of_piece(&self, system: System<'_>, from: &State, to: &State, pair: &Pair) -> f64 {
        let point = self.points[pair.point as usize];
        if point.fraction == 1.0 {
            return 1.0;
        }
        let next = self.next_fraction(&point);
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

    /// The same for a way on which something goes far, `farthest` (m): by all segments that come near each other's way.
    fn fraction_of_swept(&self, system: System<'_>, from: &State, to: &State, farthest: f64) -> f64 {
        let network = system.network;
        let cables = &self.cables;
        let middle = |state: &State, b: usize, j: usize| {
            (Self::node(system.network, state, b, j) + Self::node(system.network, state, b, j + 1)) * 0.5
        };
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
        for (index, point) in self.points.iter().enumerate() {
            let (x, end) = (point.position(network, from), point.position(network, to));
            let home = key(&x);
            let lengths = &network.branches[point.branch].rod.mesh().rest_lengths;
            let s = lengths[..point.segment].iter().sum::<f64>() + lengths[point.segment] * point.fraction;
            for i in -1..=1 {
                for j in -1..=1 {
                    for k in -1..=1 {
                        for &(b, j) in cells.get(&[home.x + i, home.y + j, home.z + k]).into_iter().flatten() {
                            let (p, q) =
                                (Self::node(system.network, from, b, j), Self::node(system.network, from, b, j + 1));
                            let distance = (x - nearest_on(&x, &p, &q).1).norm();
                            let own = end - x;
                            let way = (Self::node(system.network, to, b, j) - p - own)
                                .norm()
                                .max((Self::node(system.network, to, b, j + 1) - q - own).norm());
                            if way < SAFE * distance {
                                continue;
                            }
                            let diameters = [point.branch, b].map(|b| network.branches[b].section.diameter);
                            let both = 0.5 * (diameters[0] + diameters[1]);
                            let lengths = &network.branches[b].rod.mesh().rest_lengths;
                            let middle = lengths[..j].iter().sum::<f64>() + 0.5 * lengths[j];
                            if self.along(system, (point.branch, s), (b, middle)) > APART * both + 0.5 * lengths[j]
                                && !self.may_coincide(system, from, index as u32, (b as u32, j as u32), both)
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
/// Least fraction of a way that is let be gone, where cables are on top of each other: below it nothing would move any
/// more.
const LEAST: f64 = 1e-3;
