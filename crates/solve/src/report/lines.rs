//! Centre lines of branches, with the bounding boxes of their pieces, and places where they are nearest to bodies and
//! to each other.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::Range;
use wireloom_core::arc::{self, Arc};
use wireloom_core::equilibrium::BranchResult;
use wireloom_core::{Pose, Vector};

/// Number of segments up to which a piece is searched segment by segment.
const FEW: usize = 4;
/// Largest number of pieces of a segment.
const MOST_PIECES: f64 = 64.0;
/// Largest distance of a divided line from the arcs between nodes, in radii: a tenth of the depth at which cables that
/// press on each other count as in touch (`requirements::IN_TOUCH`).
const BESIDE: f64 = 2.5e-3;
/// Steps of the ternary search for the nearest place of a segment: 1e-5 of its length remains.
const THIRDS: usize = 28;
/// Squared sine of the angle below which two segments count as parallel: there the nearest places are ill-conditioned.
const PARALLEL: f64 = 1e-12;

/// Centre line of a branch or of a part of it, straight between nodes, with the bounding boxes of its pieces: piece 1
/// is the whole line, 2k and 2k + 1 are the halves of piece k.
#[derive(Clone)]
pub(super) struct Line {
    /// Unstressed arc length of each node, m.
    s: Vec<f64>,
    /// Position of each node, m.
    x: Vec<Vector>,
    /// Arc lengths of the ends of the branch, m.
    ends: [f64; 2],
    /// Radius of the cable, m; the greatest one where its section changes.
    pub radius: f64,
    boxes: Vec<[Vector; 2]>,
}

/// A place on a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// Distance of the centre line from the other thing, m.
    pub distance: f64,
    /// Arc length, m.
    pub s: f64,
    /// Position, m.
    pub at: Vector,
}

/// Nearest places of two lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pair {
    /// Distance of the centre lines, m.
    pub distance: f64,
    /// Arc lengths, m.
    pub s: [f64; 2],
    /// Place on the first line, m.
    pub at: Vector,
}

impl Pair {
    /// No place yet: only those nearer than `distance` (m) count.
    pub fn nearer_than(distance: f64) -> Self {
        Self { distance, s: [f64::NAN; 2], at: Vector::zeros() }
    }

    /// Whether a place was found.
    pub fn is_found(&self) -> bool {
        !self.s[0].is_nan()
    }
}

impl Line {
    /// The whole branch.
    pub fn of(branch: &BranchResult) -> Self {
        let s = branch.s.clone();
        let ends = [s[0], s[s.len() - 1]];
        Self::new(s, branch.position.clone(), ends, 0.5 * branch.diameter)
    }

    fn new(s: Vec<f64>, x: Vec<Vector>, ends: [f64; 2], radius: f64) -> Self {
        let mut line = Self { s, x, ends, radius, boxes: Vec::new() };
        line.enclose(1, 0..line.segments());
        line
    }

    /// The same line on the arcs between its nodes, with its segments divided: within `zone` (m) of the ends of the
    /// branch in pieces of at most a quarter of the radius, elsewhere of a diameter, and so that they are no more than
    /// [`BESIDE`] radii (m) beside the arcs. What counts of two segments then does not depend on the mesh.
    pub fn divided(&self, zone: f64, radius: f64) -> Self {
        let (mut s, mut x) = (vec![self.s[0]], vec![self.x[0]]);
        let lengths: Vec<f64> = self.s.windows(2).map(|ends| ends[1] - ends[0]).collect();
        let bends = arc::bends(&self.x, &lengths);
        for i in 0..self.segments() {
            let arc = Arc::new(self.x[i], self.x[i + 1], lengths[i], [bends[i], bends[i + 1]]);
            let beside = 0.125 * lengths[i] * lengths[i] * bends[i].norm().max(bends[i + 1].norm());
            let to_arc = (beside / (BESIDE * radius)).sqrt();
            let near = self.s[i] - self.ends[0] < zone || self.ends[1] - self.s[i + 1] < zone;
            let length = if near { 0.25 } else { 2.0 } * radius;
            let pieces = (lengths[i] / length).max(to_arc).ceil().clamp(1.0, MOST_PIECES) as usize;
            for k in 1..=pieces {
                let t = k as f64 / pieces as f64;
                s.push(if k == pieces { self.s[i + 1] } else { self.s[i] + lengths[i] * t });
                x.push(if k == pieces { self.x[i + 1] } else { arc.at(t) });
            }
        }
        Self::new(s, x, self.ends, self.radius)
    }

    /// Upper bound of the distance of the arc from the chord on the segment at an arc length, m.
    pub fn beside(&self, s: f64) -> f64 {
        let i = self.s.partition_point(|node| *node <= s).clamp(1, self.s.len() - 1) - 1;
        let lengths: Vec<f64> = self.s.windows(2).map(|ends| ends[1] - ends[0]).collect();
        let bends = arc::bends(&self.x, &lengths);
        0.125 * lengths[i] * lengths[i] * bends[i].norm().max(bends[i + 1].norm())
    }

    /// The part between two arc lengths (m), as far as it is on the branch, `from` before `to`.
    pub fn part(&self, from: f64, to: f64) -> Self {
        let [from, to] = [from, to].map(|s| s.clamp(self.ends[0], self.ends[1]));
        let inside = (0..self.s.len()).filter(|&i| from < self.s[i] && self.s[i] < to);
        let middle: Vec<(f64, Vector)> = inside.map(|i| (self.s[i], self.x[i])).collect();
        let all = std::iter::once((from, self.position(from))).chain(middle).chain([(to, self.position(to))]);
        let (s, x) = all.unzip();
        Self::new(s, x, self.ends, self.radius)
    }

    /// The line of a cable with this radius, m.
    pub fn of_radius(self, radius: f64) -> Self {
        Self { radius, ..self }
    }

    /// Whether a part between these arc lengths is the whole line.
    pub fn is_within(&self, from: f64, to: f64) -> bool {
        from <= self.ends[0] && to >= self.ends[1]
    }

    /// Position at an arc length, m.
    fn position(&self, s: f64) -> Vector {
        let i = self.s.partition_point(|node| *node <= s).clamp(1, self.s.len() - 1);
        let fraction = (s - self.s[i - 1]) / (self.s[i] - self.s[i - 1]);
        self.x[i - 1] + (self.x[i] - self.x[i - 1]) * fraction
    }

    /// Number of segments.
    pub fn segments(&self) -> usize {
        self.x.len() - 1
    }

    /// Box around the whole line.
    pub fn around(&self) -> &[Vector; 2] {
        &self.boxes[1]
    }

    /// Distance of a segment (its nearer node) from an end of the branch, m; of several the largest.
    pub fn to_end(&self, segments: &Range<usize>, start: bool) -> f64 {
        if start { self.s[segments.end - 1] - self.ends[0] } else { self.ends[1] - self.s[segments.start + 1] }
    }

    /// Arc length between a segment of this line and one of another line of the same branch, m; not above 0 for the
    /// same and for neighbours. Of several the largest.
    pub fn along(&self, i: &Range<usize>, other: &Self, j: &Range<usize>) -> f64 {
        (other.s[j.end - 1] - self.s[i.start + 1]).max(self.s[i.end - 1] - other.s[j.start + 1])
    }

    /// How the line turns.
    pub fn turning(&self) -> Turning {
        let (mut before, mut sum) = (Vector::zeros(), 0.0);
        let mut turning = Turning { up_to: Vec::with_capacity(self.segments()), stretch: f64::INFINITY };
        for (i, ([a, b], [from, to])) in self.x.array_windows().zip(self.s.array_windows()).enumerate() {
            let edge = b - a;
            let length = edge.norm();
            let tangent = edge / length;
            turning.stretch = turning.stretch.min(length / (to - from));
            if i > 0 {
                // The angle of two unit vectors at a distance c: 2 asin(c/2) ≤ c + (π − 2) c³/8.
                let c = (tangent - before).norm();
                sum += c + (PI - 2.0) * 0.125 * c * c * c;
            }
            turning.up_to.push(sum);
            before = tangent;
        }
        turning
    }

    /// The halves of the line.
    pub fn halves(&self) -> [Self; 2] {
        let middle = self.s[self.s.len() / 2];
        [self.part(self.ends[0], middle), self.part(middle, self.ends[1])]
    }

    /// The whole line as a piece.
    pub fn piece(&self) -> Piece<'_> {
        (self, 1, 0..self.segments())
    }

    /// One segment as a line.
    pub fn segment(&self, k: usize) -> Self {
        Self::new(self.s[k..k + 2].to_vec(), self.x[k..k + 2].to_vec(), self.ends, self.radius)
    }

    fn enclose(&mut self, piece: usize, segments: Range<usize>) -> [Vector; 2] {
        let nodes = &self.x[segments.start..=segments.end];
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
    /// are skipped; on the others it is assumed to have a single minimum. As in contact (`core::terms::contact`) a
    /// segment is its chord or the arc between its nodes, whichever is farther from the body.
    pub fn nearest_to(&self, pose: &Pose, distance: impl Fn(&Vector, f64) -> f64) -> Place {
        let into = pose.inverse();
        let local = |x: &Vector| into.position + into.orientation * x;
        let (x, s) = (&self.x, &self.s);
        let mut best = Place { distance: f64::INFINITY, s: s[0], at: x[0] };
        let mut before = f64::INFINITY;
        let lengths: Vec<f64> = s.windows(2).map(|ends| ends[1] - ends[0]).collect();
        let bends = arc::bends(x, &lengths);
        for i in 0..x.len() {
            let length = if i > 0 { (x[i] - x[i - 1]).norm() } else { 0.0 };
            let reach = best.distance + length;
            let here = distance(&local(&x[i]), reach);
            if here < best.distance {
                best = Place { distance: here, s: s[i], at: x[i] };
            }
            if i > 0 && before.min(reach) + here.min(reach) - length < 2.0 * best.distance {
                let arc = Arc::new(x[i - 1], x[i], lengths[i - 1], [bends[i - 1], bends[i]]);
                let of = |x: Vector| (distance(&local(&x), reach), x);
                let farther = |fraction: f64| {
                    let [chord, arc] = [of(arc.chord().at(fraction)), of(arc.at(fraction))];
                    if arc.0 > chord.0 { arc } else { chord }
                };
                let (mut low, mut high) = (0.0, 1.0);
                for _ in 0..THIRDS {
                    let third = (high - low) / 3.0;
                    let [a, b] = [low + third, high - third];
                    if farther(a).0 <= farther(b).0 { high = b } else { low = a }
                }
                let fraction = 0.5 * (low + high);
                let (least, at) = farther(fraction);
                if least < best.distance {
                    best = Place { distance: least, s: s[i - 1] + lengths[i - 1] * fraction, at };
                }
            }
            before = here;
        }
        best
    }
}

/// A piece of a line: line, number and segments of the piece.
pub(super) type Piece<'l> = (&'l Line, usize, Range<usize>);

/// Upper bounds of how much a line turns, to tell that it is too straight to meet itself.
pub(super) struct Turning {
    /// Sum of the angles between neighbouring segments up to each segment, rad.
    up_to: Vec<f64>,
    /// Least length of a segment over its unstressed length.
    stretch: f64,
}

impl Turning {
    /// Whether two places of these segments, the first before the second, with at least this arc length (m) between
    /// them are at least this far (m) from each other. Where a line turns by θ < π, the direction half-way makes an
    /// angle of at most θ/2 with every segment: a part of length L reaches at least `L cos(θ/2)` along it.
    pub fn keeps_apart(&self, first: &Range<usize>, second: &Range<usize>, along: f64, distance: f64) -> bool {
        let half = 0.5 * (self.up_to[second.end - 1] - self.up_to[first.start]);
        half < FRAC_PI_2 && self.stretch * along * half.cos() >= distance
    }
}

/// Searches two pieces for places nearer to each other than the best so far, the nearer halves first; `apart` tells of
/// two segments whether they count, and of several whether some may.
pub(super) fn nearest_pair(
    a: Piece<'_>,
    b: Piece<'_>,
    apart: &impl Fn(&Range<usize>, &Range<usize>) -> bool,
    best: &mut Pair,
) {
    if between(&a.0.boxes[a.1], &b.0.boxes[b.1]) >= best.distance || !apart(&a.2, &b.2) {
        return;
    }
    if a.2.len() <= FEW && b.2.len() <= FEW {
        let ends = |line: &Line, k: usize| [line.x[k], line.x[k + 1]];
        let s = |line: &Line, k: usize, fraction: f64| line.s[k] + (line.s[k + 1] - line.s[k]) * fraction;
        for i in a.2.clone() {
            let first = ends(a.0, i);
            for j in b.2.clone() {
                let second = ends(b.0, j);
                if are_far(&first, &second, best.distance) || !apart(&(i..i + 1), &(j..j + 1)) {
                    continue;
                }
                let (distance, fractions, at) = nearest_of_segments(first, second);
                if distance < best.distance {
                    *best = Pair { distance, s: [s(a.0, i, fractions[0]), s(b.0, j, fractions[1])], at };
                }
            }
        }
        return;
    }
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

/// Searches a piece for two of its own places that are nearer to each other than the best so far; `apart` as for
/// [`nearest_pair`], the first segments before the second ones.
pub(super) fn nearest_within(a: Piece<'_>, apart: &impl Fn(&Range<usize>, &Range<usize>) -> bool, best: &mut Pair) {
    if a.2.len() <= 1 || !apart(&a.2, &a.2) {
        return;
    }
    if a.2.len() <= FEW {
        nearest_pair(a.clone(), a, &|i, j| i.start < j.end - 1 && apart(i, j), best);
        return;
    }
    let [first, second] = halves(&a);
    nearest_within(first.clone(), apart, best);
    nearest_within(second.clone(), apart, best);
    nearest_pair(first, second, apart, best);
}

/// Whether two segments are at least this far (m) from each other along one of the axes.
fn are_far([a, b]: &[Vector; 2], [c, d]: &[Vector; 2], distance: f64) -> bool {
    (0..3).any(|k| (a[k].min(b[k]) - c[k].max(d[k])).max(c[k].min(d[k]) - a[k].max(b[k])) >= distance)
}

/// The halves of a piece.
fn halves<'l>((line, piece, segments): &Piece<'l>) -> [Piece<'l>; 2] {
    let middle = segments.start + segments.len() / 2;
    [(*line, 2 * piece, segments.start..middle), (*line, 2 * piece + 1, middle..segments.end)]
}

/// Distance of two boxes, m.
pub(super) fn between(a: &[Vector; 2], b: &[Vector; 2]) -> f64 {
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
            sections: Vec::new(),
            strain: None,
            s: s.collect(),
            frame: vec![Rotation::identity(); n],
            force: vec![Vector::zeros(); n],
            moment: vec![Vector::zeros(); n],
            bend_radius: vec![f64::INFINITY; n],
            sides: Vec::new(),
            twist_turns: 0.0,
            error: None,
            deviation: None,
            friction: None,
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
            let mut best = Pair::nearer_than(f64::INFINITY);
            nearest_pair(lines[0].piece(), lines[1].piece(), &|_, _| true, &mut best);
            let expected = by_all_pairs(&first, &second);
            assert!((best.distance - expected).abs() < 1e-6, "{} not {expected}", best.distance);
        }
    }

    /// Where the turning says that a line keeps apart from itself, all pairs of its segments do; a tight coil does not.
    #[test]
    fn a_line_that_turns_little_keeps_apart_from_itself() {
        let (mut kept, mut met) = (0, 0);
        for k in 0..12 {
            let turn = 0.8 * f64::from(k);
            let random = |t: f64| Vector::new(0.004 * (11.0 * t).sin(), 0.003 * (7.0 * t + turn).cos(), 0.05 * t);
            let radius = 1.0 / turn.max(1.0);
            let arc = |t: f64| Vector::new(radius * (turn * t).sin(), radius * (turn * t).cos(), 0.0);
            let line = Line::of(&branch("a", wave(24, |t| arc(t) + random(t))));
            let (turning, least) = (line.turning(), 0.15);
            for (i, j) in (0..24).flat_map(|i| (i + 1..24).map(move |j| (i, j))) {
                let along = line.along(&(i..i + 1), &line, &(j..j + 1));
                let ends = |k: usize| [line.x[k], line.x[k + 1]];
                let (distance, ..) = nearest_of_segments(ends(i), ends(j));
                if along > 0.0 && turning.keeps_apart(&(i..i + 1), &(j..j + 1), along, least) {
                    kept += 1;
                    assert!(distance >= least, "segments {i} and {j} of line {k}: {distance}");
                }
                met += usize::from(along >= 2.5 * least && distance < least);
            }
        }
        assert!(kept > 500 && met > 10, "{kept} kept apart, {met} met");
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
