//! Clearances of cables from obstacles and from each other.
//!
//! Distances are from surface to surface: distances of centre lines, straight between nodes, less the radii. Points of
//! the same harness closer than [`APART`] sums of radii along the cables are neighbours and do not count.

use wireloom_core::equilibrium::{BranchResult, Clearance, ClearanceFrom, StepResult};
use wireloom_core::network::BranchEnd;
use wireloom_core::{Moment, Network, Pose, Vector};

/// Distance along the harness through a joint, in sums of both radii, below which cables are neighbours; the same as
/// for contact.
const APART: f64 = 2.5;
/// Number of segments up to which a piece is searched segment by segment.
const FEW: usize = 4;
/// Steps of the ternary search for the nearest place of a segment: 1e-5 of its length remains.
const THIRDS: usize = 28;
/// Squared sine of the angle below which two segments count as parallel: there the nearest places are ill-conditioned.
const PARALLEL: f64 = 1e-12;

/// Clearances at the end of an increment, in the order of the harness: of every branch from every obstacle, and from
/// every branch after it; without `all` only from the obstacles with a required clearance.
pub fn clearances(network: &Network, end: &StepResult, now: &Moment, all: bool) -> Vec<Clearance> {
    let included = |k: usize| all || network.obstacles[k].min_clearance.is_some();
    let between_branches = all && end.branches.len() > 1;
    if !between_branches && !(0..network.obstacles.len()).any(included) {
        return Vec::new();
    }
    let lines: Vec<Line<'_>> = end.branches.iter().map(Line::of).collect();
    let mut found = Vec::new();
    for (b, line) in lines.iter().enumerate() {
        for (k, obstacle) in network.obstacles.iter().enumerate().filter(|(k, _)| included(*k)) {
            let place = line.nearest_to(&end.obstacles[k].pose, |x, reach| obstacle.shape.distance(x, reach));
            found.push(Clearance {
                branch: line.branch.name.clone(),
                from: ClearanceFrom::Obstacle(obstacle.name.clone()),
                distance: place.distance - line.radius(),
                s: place.s,
                position: place.at,
                required: obstacle.min_clearance,
                moment: now.clone(),
            });
        }
        for (c, other) in lines.iter().enumerate().skip(b + 1).filter(|_| all) {
            let joined = joined(network, b, c);
            let radii = line.radius() + other.radius();
            let apart = |i: usize, j: usize| {
                let paths =
                    joined.iter().map(|(own_end, others_end)| line.to_end(i, *own_end) + other.to_end(j, *others_end));
                paths.fold(f64::INFINITY, f64::min) >= APART * radii
            };
            let mut best = Pair { distance: f64::INFINITY, s: [0.0; 2], at: Vector::zeros() };
            nearest_pair((line, 1, 0..line.segments()), (other, 1, 0..other.segments()), &apart, &mut best);
            if best.distance.is_finite() {
                found.push(Clearance {
                    branch: line.branch.name.clone(),
                    from: ClearanceFrom::Branch { name: other.branch.name.clone(), s: best.s[1] },
                    distance: best.distance - radii,
                    s: best.s[0],
                    position: best.at,
                    required: None,
                    moment: now.clone(),
                });
            }
        }
    }
    found
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

/// Common joints of two branches: for each, whether it is at the start of the one and of the other.
fn joined(network: &Network, b: usize, c: usize) -> Vec<(bool, bool)> {
    let ends = |branch: usize| {
        let branch = &network.branches[branch];
        [(branch.start, true), (branch.end, false)].into_iter().filter_map(|(end, starts)| match end {
            BranchEnd::Joint { joint, .. } => Some((joint, starts)),
            BranchEnd::Free => None,
        })
    };
    let mut shared = Vec::new();
    for (joint, own) in ends(b) {
        shared.extend(ends(c).filter(|(other, _)| *other == joint).map(|(_, others)| (own, others)));
    }
    shared
}

/// Centre line with the bounding boxes of its pieces: piece 1 is the whole line, 2k and 2k + 1 are the halves of piece
/// k.
struct Line<'r> {
    branch: &'r BranchResult,
    boxes: Vec<[Vector; 2]>,
}

/// A place on a line.
struct Place {
    distance: f64,
    s: f64,
    at: Vector,
}

/// Nearest places of two lines.
struct Pair {
    distance: f64,
    s: [f64; 2],
    /// Place on the first line.
    at: Vector,
}

impl<'r> Line<'r> {
    fn of(branch: &'r BranchResult) -> Self {
        let mut line = Self { branch, boxes: Vec::new() };
        line.enclose(1, 0..line.segments());
        line
    }

    fn segments(&self) -> usize {
        self.branch.position.len() - 1
    }

    fn radius(&self) -> f64 {
        0.5 * self.branch.diameter
    }

    /// Distance of a segment (its nearer node) from an end, m.
    fn to_end(&self, segment: usize, start: bool) -> f64 {
        let s = &self.branch.s;
        if start { s[segment] - s[0] } else { s[s.len() - 1] - s[segment + 1] }
    }

    fn enclose(&mut self, piece: usize, segments: std::ops::Range<usize>) -> [Vector; 2] {
        let nodes = &self.branch.position[segments.start..=segments.end];
        let around = if segments.len() <= FEW {
            let low = nodes.iter().fold(nodes[0], |low, x| low.inf(x));
            [low, nodes.iter().fold(nodes[0], |high, x| high.sup(x))]
        } else {
            let middle = segments.start + segments.len() / 2;
            let first = self.enclose(2 * piece, segments.start..middle);
            let second = self.enclose(2 * piece + 1, middle..segments.end);
            [first[0].inf(&second[0]), first[1].sup(&second[1])]
        };
        if self.boxes.len() <= piece {
            self.boxes.resize(piece + 1, [Vector::zeros(); 2]);
        }
        self.boxes[piece] = around;
        around
    }

    /// Place nearest to a body at `pose`. The distance changes along a segment by at most its length, so most segments
    /// are skipped; on the others it is assumed to have a single minimum.
    fn nearest_to(&self, pose: &Pose, distance: impl Fn(&Vector, f64) -> f64) -> Place {
        let into = pose.inverse();
        let local = |x: &Vector| into.position + into.orientation * x;
        let (x, s) = (&self.branch.position, &self.branch.s);
        let mut best = Place { distance: f64::INFINITY, s: s[0], at: x[0] };
        let mut before = f64::INFINITY;
        for i in 0..x.len() {
            let length = if i > 0 { (x[i] - x[i - 1]).norm() } else { 0.0 };
            let reach = best.distance + length;
            let here = distance(&local(&x[i]), reach);
            if here < best.distance {
                best = Place { distance: here, s: s[i], at: x[i] };
            }
            if i > 0 && before.min(reach) + here.min(reach) - length < 2.0 * best.distance {
                let at = |fraction: f64| x[i - 1] + (x[i] - x[i - 1]) * fraction;
                let (mut low, mut high) = (0.0, 1.0);
                for _ in 0..THIRDS {
                    let third = (high - low) / 3.0;
                    let [a, b] = [low + third, high - third];
                    let [of_a, of_b] = [a, b].map(|fraction| distance(&local(&at(fraction)), reach));
                    if of_a <= of_b { high = b } else { low = a }
                }
                let fraction = 0.5 * (low + high);
                let least = distance(&local(&at(fraction)), reach);
                if least < best.distance {
                    best = Place { distance: least, s: s[i - 1] + (s[i] - s[i - 1]) * fraction, at: at(fraction) };
                }
            }
            before = here;
        }
        best
    }
}

/// A piece of a line: line, number and segments of the piece.
type Piece<'l, 'r> = (&'l Line<'r>, usize, std::ops::Range<usize>);

/// Searches two pieces for places nearer to each other than the best so far, the nearer halves first; `apart` selects
/// the pairs of segments that count.
fn nearest_pair<'l, 'r>(a: Piece<'l, 'r>, b: Piece<'l, 'r>, apart: &impl Fn(usize, usize) -> bool, best: &mut Pair) {
    if between(&a.0.boxes[a.1], &b.0.boxes[b.1]) >= best.distance {
        return;
    }
    if a.2.len() <= FEW && b.2.len() <= FEW {
        for i in a.2.clone() {
            for j in b.2.clone().filter(|j| apart(i, *j)) {
                let ends = |line: &Line<'_>, k: usize| [line.branch.position[k], line.branch.position[k + 1]];
                let (distance, fractions, at) = nearest_of_segments(ends(a.0, i), ends(b.0, j));
                if distance < best.distance {
                    let s = |line: &Line<'_>, k: usize, fraction: f64| {
                        line.branch.s[k] + (line.branch.s[k + 1] - line.branch.s[k]) * fraction
                    };
                    *best = Pair { distance, s: [s(a.0, i, fractions[0]), s(b.0, j, fractions[1])], at };
                }
            }
        }
        return;
    }
    let halves = |(line, piece, segments): &Piece<'l, 'r>| {
        let middle = segments.start + segments.len() / 2;
        [(*line, 2 * piece, segments.start..middle), (*line, 2 * piece + 1, middle..segments.end)]
    };
    let parts = |x: [usize; 2]| between(&a.0.boxes[x[0]], &b.0.boxes[x[1]]);
    if b.2.len() <= FEW || (a.2.len() > FEW && a.2.len() >= b.2.len()) {
        let [first, second] = halves(&a);
        let swap = parts([second.1, b.1]) < parts([first.1, b.1]);
        for half in if swap { [second, first] } else { [first, second] } {
            nearest_pair(half, b.clone(), apart, best);
        }
    } else {
        let [first, second] = halves(&b);
        let swap = parts([a.1, second.1]) < parts([a.1, first.1]);
        for half in if swap { [second, first] } else { [first, second] } {
            nearest_pair(a.clone(), half, apart, best);
        }
    }
}

/// Distance of two boxes.
fn between(a: &[Vector; 2], b: &[Vector; 2]) -> f64 {
    (a[0] - b[1]).sup(&(b[0] - a[1])).sup(&Vector::zeros()).norm()
}

/// Distance of two segments, the fractions at which they are nearest, and the place on the first: the minimum of
/// |a + t u − b − r v| over 0 ≤ t, r ≤ 1.
fn nearest_of_segments([a, a_end]: [Vector; 2], [b, b_end]: [Vector; 2]) -> (f64, [f64; 2], Vector) {
    let (u, v, w) = (a_end - a, b_end - b, a - b);
    let (uu, uv, vv) = (u.dot(&u), u.dot(&v), v.dot(&v));
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let on_first = |r: f64| if uu > 0.0 { ((r * uv - uw) / uu).clamp(0.0, 1.0) } else { 0.0 };
    let on_second = |t: f64| if vv > 0.0 { ((t * uv + vw) / vv).clamp(0.0, 1.0) } else { 0.0 };
    let crossed = uu * vv - uv * uv;
    let t = if crossed > PARALLEL * uu * vv { ((uv * vw - vv * uw) / crossed).clamp(0.0, 1.0) } else { 0.0 };
    let r = on_second(t);
    let t = on_first(r);
    let at = a + u * t;
    ((at - b - v * r).norm(), [t, r], at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom_core::Rotation;

    fn branch(name: &str, position: Vec<Vector>) -> BranchResult {
        let n = position.len();
        let s = std::iter::once(0.0).chain(position.windows(2).scan(0.0, |s, pair| {
            *s += (pair[1] - pair[0]).norm();
            Some(*s)
        }));
        BranchResult {
            name: name.into(),
            diameter: 0.02,
            bend_radius_limit: None,
            axial_stiffness: 1.0,
            s: s.collect(),
            frame: vec![Rotation::identity(); n],
            force: vec![Vector::zeros(); n],
            moment: vec![Vector::zeros(); n],
            bend_radius: vec![f64::INFINITY; n],
            twist_turns: 0.0,
            position,
        }
    }

    fn wave(n: usize, at: impl Fn(f64) -> Vector) -> Vec<Vector> {
        (0..=n).map(|k| at(k as f64 / n as f64)).collect()
    }

    /// Least distance of all pairs of segments, one by one.
    fn by_all_pairs(a: &BranchResult, b: &BranchResult) -> f64 {
        let mut least = f64::INFINITY;
        for p in a.position.windows(2) {
            for q in b.position.windows(2) {
                // Alternating projections converge to the least distance of two convex sets.
                let mut y = q[0];
                for _ in 0..2000 {
                    let on = |x: &Vector, [a, b]: [Vector; 2]| {
                        let edge = b - a;
                        a + edge * ((x - a).dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0)
                    };
                    let x = on(&y, [p[0], p[1]]);
                    y = on(&x, [q[0], q[1]]);
                    least = least.min((x - y).norm());
                }
            }
        }
        least
    }

    #[test]
    fn halving_finds_what_all_pairs_have() {
        for k in 0..6 {
            let phase = f64::from(k);
            let first =
                branch("a", wave(37, |t| Vector::new(t, 0.1 * (9.0 * t).sin(), 0.05 * (5.0 * t + phase).cos())));
            let second =
                branch("b", wave(23, |t| Vector::new(0.4 + 0.1 * (7.0 * t).sin(), t - 0.5, 0.12 + 0.1 * t * phase)));
            let lines = [Line::of(&first), Line::of(&second)];
            let mut best = Pair { distance: f64::INFINITY, s: [0.0; 2], at: Vector::zeros() };
            nearest_pair((&lines[0], 1, 0..37), (&lines[1], 1, 0..23), &|_, _| true, &mut best);
            let expected = by_all_pairs(&first, &second);
            assert!((best.distance - expected).abs() < 1e-6, "{} not {expected}", best.distance);
        }
    }

    /// A sphere beside the middle of a long segment, in a turned frame: nodes alone would miss it.
    #[test]
    fn the_place_nearest_to_a_body_may_be_between_nodes() {
        let line = branch("a", wave(5, |t| Vector::new(2.0 * t - 0.9, 0.0, 0.0)));
        let pose =
            Pose { position: Vector::new(0.3, 0.0, 0.5), orientation: Rotation::from_euler_angles(0.3, -0.7, 1.1) };
        let center = Vector::new(0.01, 0.02, -0.03);
        let place = Line::of(&line).nearest_to(&pose, |x, _| (x - center).norm() - 0.1);
        let at = pose.position + pose.orientation * center;
        assert!((place.distance - (at.y.hypot(at.z) - 0.1)).abs() < 1e-9, "{}", place.distance);
        assert!(
            (place.at.x - at.x).abs() < 1e-4 && (place.s - (at.x + 0.9)).abs() < 1e-4,
            "{} at {}",
            place.at,
            place.s
        );
    }
}
