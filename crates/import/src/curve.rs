//! Drawn centre lines: chains of B-splines, interpreted such that they meet the nodes.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

pub(super) type Vector = Vector3<f64>;

/// Largest distance, m, of the end of a drawn curve from its node. Good curves of the known files miss by 10⁻⁹ m,
/// stale ones by 0.05 m and more; assembly tolerances of harnesses are some mm.
pub(super) const NODE_TOLERANCE: f64 = 1e-3;

/// Distance, m, between the points of a curve that are tried first for the one nearest to a fixing; bundles bend less
/// tightly.
const PROJECTION_STEP: f64 = 2e-3;

/// Steps per knot span of the table of arc lengths. Chords of a smooth span of 0.3 m then fall short of the
/// arc by some 10⁻⁶ of it.
const STEPS_PER_SPAN: usize = 200;

/// Number of steps of a whole curve above which its spans, which are then short, have fewer steps.
const MANY_STEPS: usize = 20_000;

/// Least number of steps of a span.
const LEAST_STEPS: usize = 8;

/// Degree and control points (m) of one B-spline, as in the file.
#[derive(Clone, Debug)]
pub(super) struct Polygon {
    pub degree: usize,
    pub points: Vec<Vector>,
    /// Where the file gives knots: one more than degree and points together, none less than the one before, and those
    /// of the curve itself, from number `degree` to number `points`, not all equal.
    pub knots: Option<Vec<f64>>,
    /// Where the curve is rational: one for each point, above zero.
    pub weights: Option<Vec<f64>>,
}

impl Polygon {
    /// A curve as KBL gives it.
    pub fn without_knots(degree: usize, points: Vec<Vector>) -> Self {
        Self { degree, points, knots: None, weights: None }
    }
}

/// The two interpretations of a curve without knots, as in KBL. The schema says "uniform", with knots of multiplicity
/// 1; its implementation guideline allows both, as both are in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Knots {
    /// u_i = i: the curve does not touch its first and last control point.
    Uniform,
    /// First and last knot repeated: the curve starts and ends on control points.
    Clamped,
}

impl Knots {
    /// The knots of a spline of degree `p` with `n` control points.
    pub fn of(self, p: usize, n: usize) -> Vec<f64> {
        match self {
            Knots::Uniform => (0..n + p + 1).map(|i| i as f64).collect(),
            Knots::Clamped => (0..n + p + 1).map(|i| i.clamp(p, n) as f64).collect(),
        }
    }
}

/// One B-spline with its knots, traversed forwards or backwards.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    degree: usize,
    /// Of a rational curve times their weights.
    points: Vec<Vector>,
    /// Of a rational curve, as first components.
    weights: Option<Vec<Vector>>,
    knots: Vec<f64>,
    reversed: bool,
}

impl Piece {
    pub fn new(polygon: &Polygon, reading: Knots) -> Self {
        let Polygon { degree, points, knots, weights } = polygon;
        let knots = knots.clone().unwrap_or_else(|| reading.of(*degree, points.len()));
        let mut points = points.clone();
        let weights = weights.as_ref().map(|weights| {
            points.iter_mut().zip(weights).for_each(|(point, weight)| *point *= *weight);
            weights.iter().map(|weight| Vector::x() * *weight).collect()
        });
        Self { degree: *degree, points, weights, knots, reversed: false }
    }

    fn steps(&self) -> usize {
        let spans = self.points.len() - self.degree;
        // Degree 1 is a polyline: its spans are straight.
        let per_span = if self.degree == 1 { 1 } else { (MANY_STEPS / spans).clamp(LEAST_STEPS, STEPS_PER_SPAN) };
        spans * per_span
    }

    /// Knot parameter of t ∈ [0, 1] along the traversed piece.
    fn parameter(&self, t: f64) -> f64 {
        let (first, last) = (self.knots[self.degree], self.knots[self.points.len()]);
        first + (last - first) * if self.reversed { 1.0 - t } else { t }
    }

    /// c = A / w, where A and w are the splines of the weighted points and of the weights (Piegl and Tiller 1997,
    /// eq. 4.1).
    pub fn point(&self, t: f64) -> Vector {
        let of = |points: &[Vector]| de_boor(self.degree, points, &self.knots, self.parameter(t));
        self.weights.as_ref().map_or_else(|| of(&self.points), |weights| of(&self.points) / of(weights).x)
    }

    /// Direction of travel, not normalised: c' = (A' − w' c) / w (eq. 4.8).
    fn derivative(&self, t: f64) -> Vector {
        let d = self.derivative_of(&self.points, t);
        let d = match &self.weights {
            Some(weights) => {
                let weight = de_boor(self.degree, weights, &self.knots, self.parameter(t)).x;
                (d - self.point(t) * self.derivative_of(weights, t).x) / weight
            }
            None => d,
        };
        if self.reversed { -d } else { d }
    }

    /// Derivative of a spline on the knots of the piece with these control points, by the knot parameter.
    ///
    /// c'(u) is the spline of degree p − 1 on the inner knots with the control points
    /// `p (P_{i+1} − P_i) / (u_{i+p+1} − u_{i+1})` (de Boor 1978; Piegl and Tiller 1997, eq. 3.8).
    fn derivative_of(&self, points: &[Vector], t: f64) -> Vector {
        let parameter = self.parameter(t);
        // The knot span alone: p + 1 control points and the knots around them.
        let (p, k) = (self.degree, span(self.degree, points.len(), &self.knots, parameter));
        let u = &self.knots[k - p..=k + p + 1];
        let points: Vec<Vector> = points[k - p..=k]
            .windows(2)
            .enumerate()
            .map(|(i, w)| (w[1] - w[0]) * (p as f64 / (u[i + p + 1] - u[i + 1])))
            .collect();
        de_boor(p - 1, &points, &u[1..u.len() - 1], parameter)
    }
}

/// De Boor's algorithm: the blossom at p equal arguments.
fn de_boor(p: usize, points: &[Vector], knots: &[f64], u: f64) -> Vector {
    blossom(p, points, knots, span(p, points.len(), knots, u), |_| u)
}

/// The blossom of the polynomial of the knot span k at p arguments `u_r`:
/// `d_j ← (1 − α) d_{j−1} + α d_j`, `α = (u_r − u_{j+k−p}) / (u_{j+1+k−r} − u_{j+k−p})`, for r = 1..p.
pub(super) fn blossom(p: usize, points: &[Vector], knots: &[f64], k: usize, u: impl Fn(usize) -> f64) -> Vector {
    let mut d: Vec<Vector> = points[k - p..=k].to_vec();
    for r in 1..=p {
        for j in (r..=p).rev() {
            let low = knots[j + k - p];
            let alpha = (u(r) - low) / (knots[j + 1 + k - r] - low);
            d[j] = d[j - 1] * (1.0 - alpha) + d[j] * alpha;
        }
    }
    d[p]
}

/// The knot span k of a parameter: `u_k ≤ u < u_{k+1}`, among those of a spline of degree `p` with `points` control
/// points; at its end the last one that is not empty.
pub(super) fn span(p: usize, points: usize, knots: &[f64], u: f64) -> usize {
    let mut k = p + knots[p + 1..points].partition_point(|knot| *knot <= u);
    while k > p && knots[k] >= knots[k + 1] {
        k -= 1;
    }
    k
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    /// Arc length from the start of the chain, m.
    s: f64,
    piece: usize,
    t: f64,
    x: Vector,
}

/// Pieces in order, with a table of arc lengths.
#[derive(Clone, Debug)]
struct Chain {
    /// How its pieces are interpreted.
    reading: Knots,
    pieces: Vec<Piece>,
    samples: Vec<Sample>,
    /// Largest gap between one piece and the next, m.
    gap: f64,
}

impl Chain {
    /// The curves in the order of the file; each is reversed if that joins it better to the one before.
    fn new(polygons: &[Polygon], reading: Knots, first_reversed: bool) -> Self {
        let mut pieces: Vec<Piece> = polygons.iter().map(|polygon| Piece::new(polygon, reading)).collect();
        let mut gap = 0.0_f64;
        for i in 0..pieces.len() {
            if i == 0 {
                pieces[0].reversed = first_reversed;
                continue;
            }
            let end = pieces[i - 1].point(1.0);
            let (as_is, turned) = ((pieces[i].point(0.0) - end).norm(), (pieces[i].point(1.0) - end).norm());
            pieces[i].reversed = turned < as_is;
            gap = gap.max(as_is.min(turned));
        }
        Self::tabulated(reading, pieces, gap)
    }

    fn tabulated(reading: Knots, pieces: Vec<Piece>, gap: f64) -> Self {
        let mut samples: Vec<Sample> = Vec::new();
        for (index, piece) in pieces.iter().enumerate() {
            let steps = piece.steps();
            for step in 0..=steps {
                let t = step as f64 / steps as f64;
                let x = piece.point(t);
                let s = samples.last().map_or(0.0, |last| last.s + (x - last.x).norm());
                samples.push(Sample { s, piece: index, t, x });
            }
        }
        Self { reading, pieces, samples, gap }
    }

    fn backwards(&self) -> Self {
        let pieces = self.pieces.iter().rev().map(|p| Piece { reversed: !p.reversed, ..p.clone() }).collect();
        Self::tabulated(self.reading, pieces, self.gap)
    }

    fn start(&self) -> Vector {
        self.samples[0].x
    }

    fn end(&self) -> Vector {
        self.samples[self.samples.len() - 1].x
    }

    fn length(&self) -> f64 {
        self.samples[self.samples.len() - 1].s
    }

    /// The samples about s, and how far s is from the first to the second (0 to 1).
    fn bracket(&self, s: f64) -> (&Sample, &Sample, f64) {
        let i = self.samples.partition_point(|sample| sample.s <= s).clamp(1, self.samples.len() - 1);
        let (a, b) = (&self.samples[i - 1], &self.samples[i]);
        let span = b.s - a.s;
        (a, b, if span > 0.0 { ((s - a.s) / span).clamp(0.0, 1.0) } else { 0.0 })
    }

    fn point(&self, s: f64) -> Vector {
        let (a, b, f) = self.bracket(s);
        if a.piece == b.piece { self.pieces[a.piece].point(a.t + f * (b.t - a.t)) } else { a.x.lerp(&b.x, f) }
    }

    /// Unit tangent; the direction of the chord if the derivative vanishes.
    fn tangent(&self, s: f64) -> Vector {
        let (a, b, f) = self.bracket(s);
        let t = if a.piece == b.piece { a.t + f * (b.t - a.t) } else { a.t };
        let chord = self.end() - self.start();
        let tangent = self.pieces[a.piece].derivative(t);
        [tangent, b.x - a.x, chord].iter().find_map(|v| v.try_normalize(1e-12)).unwrap_or_else(Vector::x)
    }

    /// Arc length of the point of the curve nearest to `x`, and its distance, m.
    fn nearest(&self, x: &Vector) -> (f64, f64) {
        let distance = |s: f64| (self.point(s) - x).norm();
        let i = (0..self.samples.len())
            .min_by(|&a, &b| (self.samples[a].x - x).norm_squared().total_cmp(&(self.samples[b].x - x).norm_squared()))
            .unwrap_or(0);
        let (low, high) = (i.saturating_sub(1), (i + 1).min(self.samples.len() - 1));
        let s = minimum(self.samples[low].s, self.samples[high].s, distance);
        (s, distance(s))
    }
}

/// Minimum of a function with one minimum between `low` and `high`: ternary search.
pub(super) fn minimum(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..80 {
        let third = (high - low) / 3.0;
        if f(low + third) <= f(high - third) { high -= third } else { low += third }
    }
    0.5 * (low + high)
}

/// Agreement of a drawn curve with its nodes.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Fit {
    /// As drawn; largest miss, m.
    Meets { miss: f64 },
    /// The curve is that of a longer run: it passes both nodes, and the piece between them has the stated length.
    Cut { before: f64, after: f64 },
    /// Straight from node to node, because the file has no curve.
    Absent,
    /// Straight from node to node, because the curve misses the nodes by this much, m.
    Stale { miss: f64 },
}

/// The centre line of a branch, from node to node.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    chain: Chain,
    /// Arc length on the chain where the branch starts, m.
    first: f64,
    /// Arc length of the branch, m.
    pub length: f64,
    /// Displacements of the ends of the chain onto the nodes, m (interpolated linearly in between).
    shift: [Vector; 2],
}

impl Curve {
    /// Tries both interpretations of the knots and both directions, and keeps the curve that meets the nodes `from` and
    /// `to`. `length`: length of the segment, m, by which a piece of a longer curve is recognised.
    pub fn lay(polygons: &[Polygon], from: Vector, to: Vector, length: Option<f64>) -> (Self, Fit) {
        if polygons.is_empty() {
            return (Self::straight(from, to), Fit::Absent);
        }
        let mut chains = Vec::new();
        // Curves with knots of their own are the same with both.
        let open = polygons.iter().any(|polygon| polygon.knots.is_none());
        for &reading in if open { &[Knots::Uniform, Knots::Clamped][..] } else { &[Knots::Clamped] } {
            for first_reversed in [false, true] {
                let chain = Chain::new(polygons, reading, first_reversed);
                chains.push(chain.backwards());
                chains.push(chain);
            }
        }
        let misses: Vec<f64> = chains
            .iter()
            .map(|chain| chain.gap.max((chain.start() - from).norm()).max((chain.end() - to).norm()))
            .collect();
        let best = (0..chains.len()).min_by(|&a, &b| misses[a].total_cmp(&misses[b])).unwrap_or(0);
        let miss = misses[best];
        if miss <= NODE_TOLERANCE {
            let chain = chains.swap_remove(best);
            let span = chain.length();
            return (Self::between(chain, 0.0, span, from, to), Fit::Meets { miss });
        }
        let cut = chains
            .into_iter()
            .filter_map(|chain| Self::cut(chain, from, to, length?))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match cut {
            Some((_, curve)) => {
                let fit = Fit::Cut { before: curve.first, after: curve.chain.length() - curve.first - curve.length };
                (curve, fit)
            }
            None => (Self::straight(from, to), Fit::Stale { miss }),
        }
    }

    /// The piece of a longer curve between two nodes: design tools that split a run may leave the curve of
    /// the whole run on every piece. Accepted where the curve passes both nodes and the arc between them
    /// agrees with the length of the segment to 1 % or the tolerance.
    fn cut(chain: Chain, from: Vector, to: Vector, length: f64) -> Option<(f64, Self)> {
        let ((first, miss_first), (last, miss_last)) = (chain.nearest(&from), chain.nearest(&to));
        let off = (last - first - length).abs();
        let passes = chain.gap.max(miss_first).max(miss_last) <= NODE_TOLERANCE;
        (passes && last > first && off <= NODE_TOLERANCE.max(0.01 * length))
            .then(|| (off, Self::between(chain, first, last, from, to)))
    }

    fn between(chain: Chain, first: f64, last: f64, from: Vector, to: Vector) -> Self {
        let shift = [from - chain.point(first), to - chain.point(last)];
        Self { chain, first, length: last - first, shift }
    }

    fn straight(from: Vector, to: Vector) -> Self {
        let piece = Piece::new(&Polygon::without_knots(1, vec![from, to]), Knots::Clamped);
        let chain = Chain::tabulated(Knots::Clamped, vec![piece], 0.0);
        let length = chain.length();
        Self { chain, first: 0.0, length, shift: [Vector::zeros(); 2] }
    }

    /// How the knots of the file are interpreted; `None` for polylines, which are the same with both.
    pub fn reading(&self) -> Option<Knots> {
        self.chain.pieces.iter().any(|piece| piece.degree > 1).then_some(self.chain.reading)
    }

    /// Point at arc length s ∈ [0, length], m.
    pub fn point(&self, s: f64) -> Vector {
        let f = if self.length > 0.0 { s / self.length } else { 0.0 };
        self.chain.point(self.first + s) + self.shift[0].lerp(&self.shift[1], f)
    }

    /// Unit tangent at arc length s.
    pub fn tangent(&self, s: f64) -> Vector {
        let tangent = self.chain.tangent(self.first + s);
        let slope = (self.shift[1] - self.shift[0]) / self.length.max(NODE_TOLERANCE);
        (tangent + slope).try_normalize(1e-12).unwrap_or(tangent)
    }

    /// Arc length, m, in [0, length], of the point of the branch nearest to `x`.
    pub fn project(&self, x: &Vector) -> f64 {
        let distance = |s: f64| (self.point(s) - x).norm_squared();
        let steps = (self.length / PROJECTION_STEP).ceil().clamp(1.0, 10_000.0);
        let nearest = (0..=steps as usize)
            .map(|i| self.length * i as f64 / steps)
            .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
            .unwrap_or(0.0);
        let step = self.length / steps;
        minimum((nearest - step).max(0.0), (nearest + step).min(self.length), distance)
    }

    /// Points from node to node, evenly spaced along the curve (to 1 %) at `spacing` (m) or less; at most 1001.
    pub fn path(&self, spacing: f64) -> Vec<Vector> {
        let n = (self.length / spacing).ceil().clamp(1.0, 1000.0) as usize;
        (0..=n).map(|i| self.point(self.length * i as f64 / n as f64)).collect()
    }

    /// The frame at arc length s (columns d1, d2, d3) of the untwisted field that starts with d1 as near to
    /// world z as can be (to world x where the curve starts within 18° of the vertical).
    ///
    /// Double reflection (Wang, Jüttler, Zheng, Liu 2008, "Computation of rotation minimizing frames"): with
    /// `v1 = x_{i+1} − x_i`, `rᴸ = r − 2/c1 (v1·r) v1`, `tᴸ = t − 2/c1 (v1·t) v1`, `c1 = v1·v1`,
    /// `v2 = t_{i+1} − tᴸ`, `r_{i+1} = rᴸ − 2/c2 (v2·rᴸ) v2`, `c2 = v2·v2`.
    pub fn frame(&self, s: f64) -> UnitQuaternion<f64> {
        let steps = ((400.0 * s / self.length.max(1e-9)).ceil() as usize).clamp(1, 400);
        let (mut x, mut t) = (self.point(0.0), self.tangent(0.0));
        let up = if t.z.abs() > 0.95 { Vector::x() } else { Vector::z() };
        let mut r = (up - t * t.dot(&up)).normalize();
        for i in 1..=steps {
            let at = s * i as f64 / steps as f64;
            let (next_x, next_t) = (self.point(at), self.tangent(at));
            let reflect = |a: Vector, v: &Vector| {
                let c = v.norm_squared();
                if c > 1e-30 { a - v * (2.0 * v.dot(&a) / c) } else { a }
            };
            let v1 = next_x - x;
            let v2 = next_t - reflect(t, &v1);
            r = reflect(reflect(r, &v1), &v2);
            (x, t) = (next_x, next_t);
        }
        let d1 = (r - t * t.dot(&r)).try_normalize(1e-6).unwrap_or(r);
        let columns = Matrix3::from_columns(&[d1, t.cross(&d1), t]);
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(columns))
    }

    /// [`Curve::frame`], turned by the shortest turn so that its d3 is the unit vector `along`.
    pub fn frame_along(&self, s: f64, along: &Vector) -> UnitQuaternion<f64> {
        let frame = self.frame(s);
        UnitQuaternion::rotation_between(&(frame * Vector::z()), along).unwrap_or_default() * frame
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Control points of the polynomial curve c(t), t ∈ [0, 1], of degree 6 on the uniform knots 0, 1, …, 13: by
    /// the blossom, P_i = f(u_{i+1}, …, u_{i+6}) with u = 6 at t = 0. Here c is quadratic, c(t) = a + b t + c t².
    fn uniform_polygon(a: Vector, b: Vector, c: Vector) -> Polygon {
        let points = (0..7)
            .map(|i| {
                let u: Vec<f64> = (1..=6).map(|k| (i + k) as f64 - 6.0).collect();
                let e1: f64 = u.iter().sum::<f64>() / 6.0;
                let mut e2 = 0.0;
                for p in 0..6 {
                    for q in 0..p {
                        e2 += u[p] * u[q] / 15.0;
                    }
                }
                a + b * e1 + c * e2
            })
            .collect();
        Polygon::without_knots(6, points)
    }

    fn parabola() -> (Polygon, Vector, Vector) {
        let (a, b, c) = (Vector::new(0.1, 0.2, 0.3), Vector::new(0.3, 0.0, 0.1), Vector::new(0.0, 0.2, 0.0));
        (uniform_polygon(a, b, c), a, a + b + c)
    }

    /// ∫ √(|b|² + 4 b·c t + 4 |c|² t²) dt by Simpson's rule: independent of the table of chords.
    fn parabola_length() -> f64 {
        let speed = |t: f64| (Vector::new(0.3, 0.0, 0.1) + Vector::new(0.0, 0.4, 0.0) * t).norm();
        let n = 200;
        let weight = |i: usize| if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
        (0..=n).map(|i| weight(i) * speed(i as f64 / n as f64)).sum::<f64>() / (3.0 * n as f64)
    }

    #[test]
    fn the_uniform_reading_meets_the_nodes() {
        let (polygon, from, to) = parabola();
        let (curve, fit) = Curve::lay(&[polygon], from, to, None);
        assert!(matches!(fit, Fit::Meets { miss } if miss < 1e-12), "{fit:?}");
        assert!((curve.length - parabola_length()).abs() < 2e-6, "{} {}", curve.length, parabola_length());
        let expected = Vector::new(0.3, 0.0, 0.1).normalize();
        assert!((curve.tangent(0.0) - expected).norm() < 1e-10);
        let expected = Vector::new(0.3, 0.4, 0.1).normalize();
        assert!((curve.tangent(curve.length) - expected).norm() < 1e-10);
    }

    #[test]
    fn a_reversed_curve_is_turned_round() {
        let (polygon, from, to) = parabola();
        let (curve, fit) = Curve::lay(&[polygon], to, from, None);
        assert!(matches!(fit, Fit::Meets { .. }));
        assert!((curve.point(0.0) - to).norm() < 1e-12);
        assert!((curve.tangent(0.0) + Vector::new(0.3, 0.4, 0.1).normalize()).norm() < 1e-10);
    }

    #[test]
    fn the_clamped_reading_is_kept_where_it_meets() {
        let points: Vec<Vector> = (0..7).map(|i| Vector::new(i as f64 / 6.0, 0.1 * (i % 2) as f64, 0.0)).collect();
        let (from, to) = (points[0], points[6]);
        let (curve, fit) = Curve::lay(&[Polygon::without_knots(6, points)], from, to, None);
        assert!(matches!(fit, Fit::Meets { miss } if miss < 1e-12));
        // Bernstein: c(½) = Σ binom(6, i) P_i / 64; the odd points carry 0.1 · 32/64.
        let middle = curve.chain.pieces[0].point(0.5);
        assert!((middle - Vector::new(0.5, 0.05, 0.0)).norm() < 1e-12);
    }

    #[test]
    fn a_piece_of_a_longer_curve_is_cut_out() {
        let (polygon, from, to) = parabola();
        let whole = Curve::lay(std::slice::from_ref(&polygon), from, to, None).0;
        let (a, b) = (whole.point(0.1), whole.point(0.35));
        let (curve, fit) = Curve::lay(std::slice::from_ref(&polygon), a, b, Some(0.25));
        let Fit::Cut { before, .. } = fit else { panic!("{fit:?}") };
        assert!((before - 0.1).abs() < 1e-6 && (curve.length - 0.25).abs() < 1e-6);
        assert!((curve.point(0.0) - a).norm() < 1e-12 && (curve.point(curve.length) - b).norm() < 1e-12);
        // With another length it is not a piece of this run.
        assert!(matches!(Curve::lay(&[polygon], a, b, Some(0.3)).1, Fit::Stale { .. }));
    }

    #[test]
    fn two_pieces_join_whichever_way_the_second_runs() {
        let (first, from, middle) = parabola();
        let b = Vector::new(0.3, 0.4, 0.1);
        let second = uniform_polygon(middle + b, -b, Vector::zeros());
        let (curve, fit) = Curve::lay(&[first, second], from, middle + b, None);
        assert!(matches!(fit, Fit::Meets { .. }), "{fit:?}");
        assert!((curve.length - parabola_length() - b.norm()).abs() < 2e-6);
    }

    #[test]
    fn the_frame_field_is_untwisted_on_a_plane_curve() {
        // On a plane curve the normal of the plane is a constant vector of the field.
        let (a, b, c) = (Vector::zeros(), Vector::new(0.3, 0.0, 0.0), Vector::new(0.0, 0.3, 0.0));
        let (curve, _) = Curve::lay(&[uniform_polygon(a, b, c)], a, a + b + c, None);
        for s in [0.0, 0.2, curve.length] {
            let frame = curve.frame(s);
            assert!((frame * Vector::x() - Vector::z()).norm() < 1e-9);
            assert!((frame * Vector::z() - curve.tangent(s)).norm() < 1e-9);
        }
    }

    #[test]
    fn no_curve_is_a_straight_line() {
        let (from, to) = (Vector::zeros(), Vector::new(0.0, 0.0, 0.1));
        let (curve, fit) = Curve::lay(&[], from, to, None);
        assert_eq!(fit, Fit::Absent);
        assert_eq!(curve.path(0.03).len(), 5);
        assert_eq!(curve.tangent(0.05), Vector::z());
        // Nodes that coincide still have a frame.
        let (curve, _) = Curve::lay(&[], from, from, None);
        assert!(curve.frame(0.0).coords.iter().all(|c| c.is_finite()));
    }
}
