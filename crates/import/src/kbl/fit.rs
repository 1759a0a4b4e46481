//! A cubic B-spline through a computed centre line.
//!
//! Uniform knots are all that KBL has, so the spline has N spans of equal arc length, and N grows until the spline is
//! as near to the line as asked. At both ends it has the line's points and tangents exactly: the first and the last two
//! control points are `x_0`, `x_0 + L/(3N) t_0` and likewise at the other end. The others minimise the sum of squared
//! distances from points of the line at the parameters of their arc lengths (least squares; Piegl and Tiller 1997,
//! section 9.4).

use crate::curve::{Knots, Piece, Polygon, Vector, blossom, span};

/// Degree of the splines.
const DEGREE: usize = 3;

/// Points of the line for each span of the spline.
const POINTS_PER_SPAN: usize = 8;

/// Largest number of spans: a branch of 10 m then has one every 5 mm.
const MOST_SPANS: usize = 2000;

/// Control points are written to this fraction of a metre.
const ROUND: f64 = 1e9;

/// A line to be fitted.
pub(super) struct Line<'a> {
    /// Its points over the fraction of its arc length, 0 to 1, m.
    pub at: &'a dyn Fn(f64) -> Vector,
    /// Unit tangents at its start and its end.
    pub tangents: [Vector; 2],
    /// Its length, m.
    pub length: f64,
    /// Number of places at which it is known; between them it is a smooth curve.
    pub nodes: usize,
}

/// A spline and its largest distance from the line, m.
#[derive(Clone, Debug)]
pub(super) struct Fitted {
    pub polygon: Polygon,
    pub distance: f64,
}

/// The spline with the fewest spans found that is no farther from the line than `tolerance` (m); the finest one if none
/// is.
pub(super) fn fit(line: &Line, tolerance: f64, reading: Knots) -> Fitted {
    let mut spans = 1;
    loop {
        let fitted = with_spans(line, spans, reading);
        if fitted.distance <= tolerance || spans >= MOST_SPANS {
            return fitted;
        }
        spans = (spans + 1 + spans / 3).min(MOST_SPANS);
    }
}

fn with_spans(line: &Line, spans: usize, reading: Knots) -> Fitted {
    let count = POINTS_PER_SPAN * spans.max(line.nodes);
    let samples: Vec<Vector> = (0..=count).map(|j| (line.at)(j as f64 / count as f64)).collect();
    let knots = Knots::Clamped.of(DEGREE, spans + DEGREE);
    let clamped = least_squares(line, &samples, spans, &knots);
    let points = match reading {
        Knots::Clamped => clamped,
        Knots::Uniform => unclamped(&clamped, &knots),
    };
    let round = |point: Vector| point.map(|x| (x * ROUND).round() / ROUND);
    let polygon = Polygon::without_knots(DEGREE, points.into_iter().map(round).collect());
    let piece = Piece::new(&polygon, reading);
    let apart = |(j, x): (usize, &Vector)| (piece.point(j as f64 / count as f64) - x).norm();
    let distance = samples.iter().enumerate().map(apart).fold(0.0, f64::max);
    Fitted { polygon, distance }
}

/// The control points over clamped knots.
fn least_squares(line: &Line, samples: &[Vector], spans: usize, knots: &[f64]) -> Vec<Vector> {
    let n = spans + DEGREE;
    let mut points = vec![Vector::zeros(); n];
    let (last, third) = (samples.len() - 1, line.length / (3.0 * spans as f64));
    (points[0], points[n - 1]) = (samples[0], samples[last]);
    (points[1], points[n - 2]) = (samples[0] + line.tangents[0] * third, samples[last] - line.tangents[1] * third);
    // Normal equations of the inner control points: half-bandwidth p, the diagonal first.
    let inner = n - 4;
    let (mut matrix, mut right) = (vec![[0.0; DEGREE + 1]; inner], vec![Vector::zeros(); inner]);
    for (j, x) in samples.iter().enumerate() {
        let u = DEGREE as f64 + spans as f64 * j as f64 / last as f64;
        let k = span(DEGREE, n, knots, u);
        let (basis, first) = (basis(knots, k, u), k - DEGREE);
        let fixed = |i: usize| i < 2 || i >= n - 2;
        let rest = (0..=DEGREE).filter(|a| fixed(first + a)).fold(*x, |x, a| x - points[first + a] * basis[a]);
        for a in (0..=DEGREE).filter(|a| !fixed(first + a)) {
            let row = first + a - 2;
            right[row] += rest * basis[a];
            (0..=a).filter(|b| !fixed(first + b)).for_each(|b| matrix[row][a - b] += basis[a] * basis[b]);
        }
    }
    solve(&mut matrix, &mut right);
    points[2..n - 2].copy_from_slice(&right);
    points
}

/// The p + 1 basis functions that are not zero in the knot span k (Cox and de Boor; Piegl and Tiller, A2.2).
fn basis(knots: &[f64], k: usize, u: f64) -> [f64; DEGREE + 1] {
    let mut values = [0.0; DEGREE + 1];
    values[0] = 1.0;
    for r in 1..=DEGREE {
        let mut carried = 0.0;
        for i in 0..r {
            let (left, right) = (u - knots[k + 1 + i - r], knots[k + 1 + i] - u);
            let part = values[i] / (left + right);
            values[i] = carried + right * part;
            carried = left * part;
        }
        values[r] = carried;
    }
    values
}

/// Solves `A x = b` for a symmetric positive definite band matrix by Cholesky's factors; `matrix[i][d]` is
/// `A_{i, i−d}`.
fn solve(matrix: &mut [[f64; DEGREE + 1]], right: &mut [Vector]) {
    for i in 0..matrix.len() {
        for j in i.saturating_sub(DEGREE)..=i {
            let from = i.saturating_sub(DEGREE).max(j.saturating_sub(DEGREE));
            let known: f64 = (from..j).map(|k| matrix[i][i - k] * matrix[j][j - k]).sum();
            let left = matrix[i][i - j] - known;
            matrix[i][i - j] = if i == j { left.sqrt() } else { left / matrix[j][0] };
        }
        let before = (i.saturating_sub(DEGREE)..i).fold(right[i], |x, k| x - right[k] * matrix[i][i - k]);
        right[i] = before / matrix[i][0];
    }
    for i in (0..matrix.len()).rev() {
        let after = (i + 1..matrix.len().min(i + DEGREE + 1)).fold(right[i], |x, k| x - right[k] * matrix[k][k - i]);
        right[i] = after / matrix[i][0];
    }
}

/// The control points of the same curve over unclamped knots `u_i = i`: `P_i = f(i + 1, …, i + p)`, with the blossom f
/// of a span in which `P_i` acts.
fn unclamped(points: &[Vector], knots: &[f64]) -> Vec<Vector> {
    let n = points.len();
    (0..n).map(|i| blossom(DEGREE, points, knots, i.clamp(DEGREE, n - 1), |r| (i + r) as f64)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::{Curve, Fit};

    /// A quarter of a helix of radius 0.1 m.
    fn helix(f: f64) -> Vector {
        let a = f * std::f64::consts::FRAC_PI_2;
        Vector::new(0.1 * a.sin(), 0.1 * (1.0 - a.cos()), 0.05 * a)
    }

    fn tangent(f: f64) -> Vector {
        let a = f * std::f64::consts::FRAC_PI_2;
        Vector::new(0.1 * a.cos(), 0.1 * a.sin(), 0.05).normalize()
    }

    fn line() -> Line<'static> {
        let length = std::f64::consts::FRAC_PI_2 * f64::hypot(0.1, 0.05);
        Line { at: &helix, tangents: [tangent(0.0), tangent(1.0)], length, nodes: 30 }
    }

    #[test]
    fn the_importer_reads_the_line_that_was_fitted_in_both_interpretations() {
        for reading in [Knots::Uniform, Knots::Clamped] {
            for tolerance in [1e-3, 1e-4, 1e-5, 1e-6] {
                let Fitted { polygon, distance } = fit(&line(), tolerance, reading);
                assert!(distance <= tolerance, "{reading:?} {tolerance}: {distance}");
                let (curve, fit) = Curve::lay(&[polygon], helix(0.0), helix(1.0), None);
                assert!(matches!(fit, Fit::Meets { miss } if miss < 3e-9), "{fit:?}");
                assert_eq!(curve.reading(), Some(reading));
                assert!((curve.length - line().length).abs() < 0.5 * tolerance, "{}", curve.length);
                for k in 0..=100 {
                    let f = f64::from(k) / 100.0;
                    assert!((curve.point(f * curve.length) - helix(f)).norm() < 1.5 * tolerance + 1e-6, "{f}");
                }
                assert!((curve.tangent(0.0) - tangent(0.0)).norm() < 1e-6);
                assert!((curve.tangent(curve.length) - tangent(1.0)).norm() < 1e-6);
            }
        }
    }

    #[test]
    fn a_finer_tolerance_takes_more_control_points_and_a_straight_line_the_fewest() {
        let counts = [1e-4, 1e-5, 1e-6].map(|tolerance| fit(&line(), tolerance, Knots::Uniform).polygon.points.len());
        assert!(counts[0] < counts[1] && counts[1] < counts[2], "{counts:?}");
        let along = |f: f64| Vector::new(0.2 * f, 0.0, 0.0);
        let straight = Line { at: &along, tangents: [Vector::x(); 2], length: 0.2, nodes: 2 };
        assert_eq!(fit(&straight, 1e-9, Knots::Uniform).polygon.points.len(), 4);
    }

    /// Control points that are least squares are better than those next to them.
    #[test]
    fn no_inner_control_point_can_be_moved_for_the_better() {
        let spans = 3;
        let samples: Vec<Vector> = (0..=240).map(|j| helix(f64::from(j) / 240.0)).collect();
        let knots = Knots::Clamped.of(DEGREE, spans + DEGREE);
        let best = least_squares(&line(), &samples, spans, &knots);
        let sum = |points: &[Vector]| {
            let piece = Piece::new(&Polygon::without_knots(DEGREE, points.to_vec()), Knots::Clamped);
            samples.iter().enumerate().map(|(j, x)| (piece.point(j as f64 / 240.0) - x).norm_squared()).sum::<f64>()
        };
        for (point, axis, by) in [(2, 0, 1e-6), (2, 1, -1e-6), (3, 2, 1e-6), (3, 0, -1e-6)] {
            let mut moved = best.clone();
            moved[point][axis] += by;
            assert!(sum(&moved) > sum(&best), "{point} {axis}");
        }
    }
}
