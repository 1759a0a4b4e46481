//! Clearances of cables from obstacles and from each other, and the depths to which cables lie in each other.
//!
//! Distances are from surface to surface: distances of centre lines, which are arcs between nodes, less the radii.
//! Parts of the same harness closer than [`APART`] sums of radii along the cables are neighbours and do not count.

use super::lines::{Line, Pair, Place, between, nearest_pair, nearest_within};
use std::borrow::Cow;
use std::ops::Range;
use std::sync::OnceLock;
use wireloom_core::equilibrium::{BranchResult, Clearance, ClearanceFrom, StepResult};
use wireloom_core::network::{APART, BranchEnd};
use wireloom_core::obstacle::Obstacle;
use wireloom_core::requirement::SOFT;
use wireloom_core::sections::SectionResult;
use wireloom_core::{Moment, Network, Pose, Vector};

/// Clearances in one equilibrium, with the obstacles at these poses, in the order of the harness: of every branch from
/// every obstacle, and from every branch after it; without `all` only from the obstacles with a required clearance.
pub(super) fn clearances(cables: &Cables<'_>, poses: &[Pose], now: &Moment, all: bool) -> Vec<Clearance> {
    let network = cables.network;
    let included = |k: usize| all || network.obstacles[k].min_clearance.is_some();
    if all {
        cables.fine();
    }
    let of_branch = |b: usize| {
        let branch = &network.branches[b];
        let mut found = Vec::new();
        for (k, obstacle) in network.obstacles.iter().enumerate().filter(|(k, _)| included(*k)) {
            let place = cables.clearance_from_obstacle(CablePart::whole(b), obstacle, &poses[k]);
            found.push(Clearance {
                branch: branch.name.clone(),
                from: ClearanceFrom::Obstacle(obstacle.name.clone()),
                distance: place.distance,
                s: place.s,
                position: place.at,
                required: obstacle.min_clearance,
                moment: now.clone(),
            });
        }
        for (c, other) in network.branches.iter().enumerate().skip(b + 1).filter(|_| all) {
            if let Some(place) = cables.clearance_from_branch(CablePart::whole(b), CablePart::whole(c)) {
                found.push(Clearance {
                    branch: branch.name.clone(),
                    from: ClearanceFrom::Branch { name: other.name.clone(), s: place.s[1] },
                    distance: place.distance,
                    s: place.s[0],
                    position: place.at,
                    required: None,
                    moment: now.clone(),
                });
            }
        }
        found
    };
    network.map(network.branches.len(), of_branch).into_iter().flatten().collect()
}

/// Updates the least clearance of each pair so far. The pairs of successive increments are mostly the same, in the same
/// order.
pub fn keep_least(so_far: &mut Vec<Clearance>, now: Vec<Clearance>) {
    for (k, clearance) in now.into_iter().enumerate() {
        let same = |other: &Clearance| other.branch == clearance.branch && same_thing(&other.from, &clearance.from);
        let known = if so_far.get(k).is_some_and(same) { Some(k) } else { so_far.iter().position(same) };
        match known {
            Some(k) if clearance.distance < so_far[k].distance => so_far[k] = clearance,
            Some(_) => {}
            None => so_far.push(clearance),
        }
    }
}

fn same_thing(a: &ClearanceFrom, b: &ClearanceFrom) -> bool {
    match (a, b) {
        (ClearanceFrom::Obstacle(a), ClearanceFrom::Obstacle(b)) => a == b,
        (ClearanceFrom::Branch { name: a, .. }, ClearanceFrom::Branch { name: b, .. }) => a == b,
        _ => false,
    }
}

/// A branch between two arc lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CablePart {
    /// Index of the branch.
    pub branch: usize,
    /// Arc length where the part begins, m.
    pub from: f64,
    /// Arc length where it ends, m; infinite: the end of the branch.
    pub to: f64,
}

impl CablePart {
    /// A whole branch.
    pub fn whole(branch: usize) -> Self {
        Self { branch, from: 0.0, to: f64::INFINITY }
    }
}

/// Two cables, or two parts of one, that lie in each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CableOverlap {
    /// Indices of the branches, the lower one first; equal for two parts of one.
    pub branches: [usize; 2],
    /// Arc lengths of the deepest place, m.
    pub s: [f64; 2],
    /// Depth there, m: the sum of the radii less the distance of the centre lines.
    pub depth: f64,
    /// Depth to which soft cables may lie in each other, m: [`SOFT`] diameters of the thinner one.
    pub allowed: f64,
    /// Place on the centre line of the first one, m.
    pub position: Vector,
}

/// A way along the harness between two branches, from an end of the one to an end of the other.
struct Way {
    /// Whether it begins at the start of the one, and ends at the start of the other.
    starts: [bool; 2],
    /// Its length between these ends, m.
    length: f64,
    /// Arc lengths from these ends, m, up to which the cables still lie in each other as they leave their joints.
    together: [f64; 2],
}

/// The cables of a harness in one equilibrium.
pub(crate) struct Cables<'n> {
    network: &'n Network,
    lines: Vec<Line>,
    /// Of each branch, the parts with sections of their own: arc lengths of both ends, and radius, m. Empty where the
    /// section does not change.
    sections: Vec<Vec<([f64; 2], f64)>>,
    fine: OnceLock<FineLines>,
    overlaps: OnceLock<Vec<CableOverlap>>,
}

/// What distances of cables from each other are measured with.
struct FineLines {
    /// The lines, finer.
    lines: Vec<Line>,
    /// For each joint the joints near it along the harness, with their distances, m.
    near: Vec<Vec<(usize, f64)>>,
}

impl<'n> Cables<'n> {
    /// The cables of a network, with the results of all its branches.
    pub fn new(network: &'n Network, branches: &[BranchResult]) -> Self {
        let lines = network.map(branches.len(), |b| Line::of(&branches[b]));
        let part = |part: &SectionResult| ([part.from, part.to], 0.5 * part.diameter);
        let sections = branches.iter().map(|branch| branch.sections.iter().map(part).collect()).collect();
        Self { network, lines, sections, fine: OnceLock::new(), overlaps: OnceLock::new() }
    }

    /// To be called before threads share work that needs these lines: one that waits for them could be the one that
    /// makes them.
    fn fine(&self) -> &FineLines {
        self.fine.get_or_init(|| {
            let thickest = self.lines.iter().map(|line| line.radius).fold(0.0, f64::max);
            let zone = 2.0 * APART * thickest;
            let thinnest =
                |b: usize| self.sections[b].iter().map(|(_, radius)| *radius).fold(self.lines[b].radius, f64::min);
            let lines = self.network.map(self.lines.len(), |b| self.lines[b].divided(zone, thinnest(b)));
            FineLines { lines, near: self.network.near_joints(zone) }
        })
    }

    /// All pairs of branches, and all branches, that lie in each other or in themselves, at their deepest place, in the
    /// order of the branches. Cables that leave a joint (or two joints less than [`APART`] sums of radii from each
    /// other) side by side do not count up to the place where they have separated.
    pub fn overlaps(&self) -> &[CableOverlap] {
        self.overlaps.get_or_init(|| {
            let mut pairs = near_pairs(&self.fine().lines);
            pairs.sort_unstable();
            let overlap = |k: usize| self.overlap(pairs[k][0], pairs[k][1]);
            self.network.map(pairs.len(), overlap).into_iter().flatten().collect()
        })
    }

    /// Clearance of a part of a branch from an obstacle at `pose`, and where it is least.
    pub fn clearance_from_obstacle(&self, part: CablePart, obstacle: &Obstacle, pose: &Pose) -> Place {
        let clearance = |piece: &Cow<'_, Line>| {
            let place = piece.nearest_to(pose, |x, reach| obstacle.shape.distance(x, reach));
            Place { distance: place.distance - piece.radius, ..place }
        };
        let all = self.pieces(&self.lines, part);
        let rest = all[1..].iter().map(clearance);
        rest.fold(clearance(&all[0]), |least, own| if own.distance < least.distance { own } else { least })
    }

    /// Part of a branch in pieces of one radius; not empty.
    fn pieces<'l>(&self, lines: &'l [Line], part: CablePart) -> Vec<Cow<'l, Line>> {
        let line = &lines[part.branch];
        let piece = |(range, radius): &([f64; 2], f64)| {
            let (from, to) = (range[0].max(part.from), range[1].min(part.to));
            (from < to).then(|| Cow::Owned(line.part(from, to).of_radius(*radius)))
        };
        let mut pieces: Vec<_> = self.sections[part.branch].iter().filter_map(piece).collect();
        if pieces.is_empty() {
            pieces.push(part_of(lines, part));
        }
        pieces
    }

    /// Radius of a branch at an arc length, m.
    pub fn radius_at(&self, branch: usize, s: f64) -> f64 {
        let part = self.sections[branch].iter().find(|([_, to], _)| s <= *to);
        part.map_or(self.lines[branch].radius, |(_, radius)| *radius)
    }

    /// Upper bound of the distance of the arc from the chord on the segment of a branch at an arc length, m.
    pub fn beside(&self, branch: usize, s: f64) -> f64 {
        self.lines[branch].beside(s)
    }

    /// Clearance between parts of two branches, or of one, and where it is least; `None` where they are neighbours
    /// only.
    pub fn clearance_from_branch(&self, one: CablePart, other: CablePart) -> Option<Pair> {
        let ways = self.ways(one.branch, other.branch);
        let [first, second] = [one, other].map(|part| self.pieces(&self.fine().lines, part));
        let mut least: Option<Pair> = None;
        for (a, b) in first.iter().flat_map(|a| second.iter().map(move |b| (a, b))) {
            let mut best = Pair::nearer_than(f64::INFINITY);
            let apart = |i: &Range<usize>, j: &Range<usize>| {
                let along = (one.branch == other.branch).then(|| a.along(i, b, j));
                is_apart([a, b], [i, j], &ways, along)
            };
            nearest_pair(a.piece(), b.piece(), &apart, &mut best);
            let found = best.is_found().then(|| Pair { distance: best.distance - a.radius - b.radius, ..best });
            least = [least, found].into_iter().flatten().min_by(|a, b| a.distance.total_cmp(&b.distance));
        }
        least
    }

    /// Deepest place at which two branches lie in each other, or one in itself.
    fn overlap(&self, b: usize, c: usize) -> Option<CableOverlap> {
        let [first, second] = [b, c].map(|branch| self.pieces(&self.fine().lines, CablePart::whole(branch)));
        let mut ways = self.ways(b, c);
        // Each pair of pieces once.
        let pairs = || {
            let all =
                first.iter().enumerate().flat_map(|(k, one)| second.iter().enumerate().map(move |o| ((k, one), o)));
            all.filter(|((k, _), (l, _))| b != c || k <= l).map(|((k, one), (l, other))| (one, other, b == c && k == l))
        };
        let search = |ways: &[Way]| {
            let deepest = pairs().filter_map(|(one, other, same)| deepest(one, other, [b == c, same], ways));
            deepest.max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)))
        };
        let mut best = search(&ways);
        if best.is_some() && !ways.is_empty() {
            // A branch whose ends leave one joint side by side: each half lies in the other one.
            let of_end = |branch: usize, start: bool| {
                let pieces = if branch == b { &first } else { &second };
                let line = &self.fine().lines[branch];
                let radius = pieces[if start { 0 } else { pieces.len() - 1 }].radius;
                let whole = Line::clone(line).of_radius(radius);
                let [before, after] = if b == c { whole.halves() } else { [whole.clone(), whole] };
                if start { before } else { after }
            };
            for way in ways.iter_mut().filter(|way| b != c || way.starts[0]) {
                let [one, other] = [of_end(b, way.starts[0]), of_end(c, way.starts[1])];
                way.together = [together(&one, way.starts[0], &other), together(&other, way.starts[1], &one)];
            }
            best = search(&ways);
        }
        best.map(|(depth, allowed, pair)| CableOverlap {
            branches: [b, c],
            s: pair.s,
            depth,
            allowed,
            position: pair.at,
        })
    }

    /// The ways between two branches, or between the ends of one, through common joints and joints near each other.
    fn ways(&self, b: usize, c: usize) -> Vec<Way> {
        let ends = |branch: usize| {
            let branch = &self.network.branches[branch];
            [(branch.start, true), (branch.end, false)].into_iter().filter_map(|(end, starts)| match end {
                BranchEnd::Joint { joint, .. } => Some((joint, starts)),
                BranchEnd::Free => None,
            })
        };
        let mut ways = Vec::new();
        for (joint, own) in ends(b) {
            for (other, others) in ends(c).filter(|(_, others)| b != c || *others != own) {
                let near = self.fine().near[joint].iter().find(|(near, _)| *near == other);
                ways.extend(near.map(|(_, length)| Way { starts: [own, others], length: *length, together: [0.0; 2] }));
            }
        }
        ways
    }
}

/// Depth of the deepest place at which two lines lie in each other, that to which they may, and the place; `alike`:
/// whether they are of one branch, and the same.
fn deepest(one: &Line, other: &Line, [of_one, same]: [bool; 2], ways: &[Way]) -> Option<(f64, f64, Pair)> {
    let radii = one.radius + other.radius;
    let turning = same.then(|| one.turning());
    let mut best = Pair::nearer_than(radii);
    let apart = |i: &Range<usize>, j: &Range<usize>| {
        let along = of_one.then(|| one.along(i, other, j));
        let straight = turning.as_ref().is_some_and(|own| own.keeps_apart(i, j, APART * radii, radii));
        !straight && is_apart([one, other], [i, j], ways, along)
    };
    match same {
        true => nearest_within(one.piece(), &apart, &mut best),
        false => nearest_pair(one.piece(), other.piece(), &apart, &mut best),
    }
    let allowed = SOFT * 2.0 * one.radius.min(other.radius);
    best.is_found().then_some((radii - best.distance, allowed, best))
}

/// Pairs of lines whose boxes overlap, by sweep and prune along x; each line with itself, too.
fn near_pairs(lines: &[Line]) -> Vec<[usize; 2]> {
    let finite = |b: &usize| lines[*b].around().iter().all(|corner| corner.iter().all(|x| x.is_finite()));
    let low = |b: usize| lines[b].around()[0].x - lines[b].radius;
    let mut order: Vec<usize> = (0..lines.len()).filter(finite).collect();
    order.sort_by(|a, b| low(*a).total_cmp(&low(*b)).then(a.cmp(b)));
    let mut pairs = Vec::new();
    for (k, &b) in order.iter().enumerate() {
        let line = &lines[b];
        let high = line.around()[1].x + line.radius;
        pairs.push([b, b]);
        for &c in order[k + 1..].iter().take_while(|c| low(**c) <= high) {
            let other = &lines[c];
            if between(line.around(), other.around()) < line.radius + other.radius {
                pairs.push([b.min(c), b.max(c)]);
            }
        }
    }
    pairs
}

/// A whole line, or the part of it.
fn part_of(lines: &[Line], part: CablePart) -> Cow<'_, Line> {
    let line = &lines[part.branch];
    if line.is_within(part.from, part.to) {
        return Cow::Borrowed(line);
    }
    Cow::Owned(line.part(part.from, part.to))
}

/// Whether two segments of lines are not neighbours: far enough from each other along every way, and not both where
/// their cables have not separated yet; of several, whether two may be none. `along`: arc length between them, for
/// segments of the same branch.
fn is_apart(lines: [&Line; 2], segments: [&Range<usize>; 2], ways: &[Way], along: Option<f64>) -> bool {
    let neighbours = APART * (lines[0].radius + lines[1].radius);
    let far = |way: &Way| {
        let [p, q] = [0, 1].map(|k| lines[k].to_end(segments[k], way.starts[k]));
        p + way.length + q >= neighbours && (p >= way.together[0] || q >= way.together[1])
    };
    along.is_none_or(|along| along >= neighbours) && ways.iter().all(far)
}

/// Arc length from an end of a line, m, up to which its cable lies in that of another line without a gap.
fn together(line: &Line, start: bool, other: &Line) -> f64 {
    let n = line.segments();
    let from_end = |k: usize| if start { k } else { n - 1 - k };
    let meets = |k: &usize| {
        let segment = line.segment(from_end(*k));
        let mut best = Pair::nearer_than(line.radius + other.radius);
        nearest_pair(segment.piece(), other.piece(), &|_, _| true, &mut best);
        best.is_found()
    };
    let separate = (0..n).find(|k| !meets(k));
    separate.map_or(f64::INFINITY, |k| line.to_end(&(from_end(k)..from_end(k) + 1), start))
}

/// Distance between the surfaces of a branch between two arc lengths (m) and of an obstacle at the end of an increment,
/// m; negative where they overlap.
pub fn clearance_from_obstacle(
    network: &Network,
    end: &StepResult,
    (branch, from, to): (usize, f64, f64),
    obstacle: usize,
) -> f64 {
    let cables = Cables::new(network, &end.branches);
    let part = CablePart { branch, from, to };
    cables.clearance_from_obstacle(part, &network.obstacles[obstacle], &end.obstacles[obstacle].pose).distance
}

/// The same of two branches, each between two arc lengths; NaN where they are only neighbours at a joint.
pub fn clearance_of_branches(network: &Network, end: &StepResult, parts: [(usize, f64, f64); 2]) -> f64 {
    let [one, other] = parts.map(|(branch, from, to)| CablePart { branch, from, to });
    Cables::new(network, &end.branches).clearance_from_branch(one, other).map_or(f64::NAN, |pair| pair.distance)
}

/// Clearance of a held point of a cable with this radius (m) from an obstacle at `pose`, m.
pub(crate) fn of_held_point(obstacle: &Obstacle, pose: &Pose, position: &Vector, radius: f64) -> f64 {
    obstacle.shape.distance(&pose.local(position), f64::INFINITY) - radius
}
