//! Monotone curves through the points of a table: laws of sections that are measured.
//!
//! From the origin to the last point a curve is a piecewise cubic that is monotone where its points are (Fritsch and
//! Carlson 1980, Monotone piecewise cubic interpolation, SIAM Journal on Numerical Analysis 17), with the slopes of
//! Fritsch and Butland (1984, A method for constructing local monotone piecewise cubic interpolants, SIAM Journal on
//! Scientific and Statistical Computing 5): the weighted harmonic mean of those of the chords on both sides,
//!
//! ```text
//! 3 (h₀ + h₁)/d = (2 h₁ + h₀)/Δ₀ + (h₁ + 2 h₀)/Δ₁
//! ```
//!
//! Beyond the last point it is straight, with the slope of the last chord. Where the values of the points strictly
//! increase, so does the curve: d is less than three times either chord, so its slope is nowhere zero. Slopes are
//! continuous; their derivative jumps at points.

/// A curve from the origin, for arguments from 0 on.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Pieces in the order of their starts, the last one straight.
    pieces: Vec<Piece>,
}

/// `value + c₀ d + c₁ d² + c₂ d³` with `d = x − start`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    start: f64,
    /// Value at the start.
    value: f64,
    /// Integral up to the start.
    integral: f64,
    c: [f64; 3],
}

impl Piece {
    fn integral(&self, x: f64) -> f64 {
        let (d, [c0, c1, c2]) = (x - self.start, self.c);
        self.integral + d * (self.value + d * (c0 / 2.0 + d * (c1 / 3.0 + d * c2 / 4.0)))
    }

    fn value(&self, x: f64) -> f64 {
        let (d, [c0, c1, c2]) = (x - self.start, self.c);
        self.value + d * (c0 + d * (c1 + d * c2))
    }

    fn slope(&self, x: f64) -> f64 {
        let (d, [c0, c1, c2]) = (x - self.start, self.c);
        c0 + d * (2.0 * c1 + d * 3.0 * c2)
    }
}

impl Curve {
    /// Through the origin and these points `[x, y]`, x and y positive and strictly increasing, with this slope at the
    /// origin, from 0 to three times that of the first chord; `None`: that of the first chord, which is that of the
    /// curve and its mirror image through the origin.
    ///
    /// # Panics
    /// If there are no points.
    pub fn new(points: &[[f64; 2]], slope_at_origin: Option<f64>) -> Self {
        assert!(!points.is_empty(), "a curve needs points");
        let chords = chords(points);
        let mut slopes = vec![slope_at_origin.unwrap_or(chords[0][1])];
        slopes.extend(chords.array_windows().map(|[before, after]| mean_slope(*before, *after)));
        slopes.push(chords[chords.len() - 1][1]);
        Self::with_slopes(points, &slopes)
    }

    /// Through the origin and these points with these slopes at all of them; straight beyond.
    pub(crate) fn with_slopes(points: &[[f64; 2]], slopes: &[f64]) -> Self {
        let chords = chords(points);
        let knots: Vec<[f64; 2]> = std::iter::once([0.0; 2]).chain(points.iter().copied()).collect();
        let mut pieces: Vec<Piece> = Vec::with_capacity(knots.len());
        let mut integral = 0.0;
        for (k, [h, chord]) in chords.into_iter().enumerate() {
            let ([start, value], [from, to]) = (knots[k], [slopes[k], slopes[k + 1]]);
            let c = [from, (3.0 * chord - 2.0 * from - to) / h, (from + to - 2.0 * chord) / (h * h)];
            let piece = Piece { start, value, integral, c };
            integral = piece.integral(start + h);
            pieces.push(piece);
        }
        let [start, value] = knots[knots.len() - 1];
        pieces.push(Piece { start, value, integral, c: [slopes[slopes.len() - 1], 0.0, 0.0] });
        Self { pieces }
    }

    /// The straight line of this slope.
    pub fn straight(slope: f64) -> Self {
        Self { pieces: vec![Piece { start: 0.0, value: 0.0, integral: 0.0, c: [slope, 0.0, 0.0] }] }
    }

    /// The piece at x; the first one if x is not a number.
    fn at(&self, x: f64) -> &Piece {
        &self.pieces[self.pieces.partition_point(|piece| piece.start <= x).saturating_sub(1)]
    }

    /// Its value at x.
    pub fn value(&self, x: f64) -> f64 {
        self.at(x).value(x)
    }

    /// Its slope at x; at a point of the table that of the piece behind it.
    pub fn slope(&self, x: f64) -> f64 {
        self.at(x).slope(x)
    }

    /// Its integral from 0 to x.
    pub fn integral(&self, x: f64) -> f64 {
        self.at(x).integral(x)
    }

    /// Its greatest slope.
    pub fn greatest_slope(&self) -> f64 {
        let of = |(k, piece): (usize, &Piece)| {
            let end = self.pieces.get(k + 1).map_or(piece.start, |next| next.start);
            // The slope is a parabola; where it opens downward its vertex may lie within.
            let vertex = piece.start - piece.c[1] / (3.0 * piece.c[2]);
            let inside = Some(vertex).filter(|x| piece.start < *x && *x < end);
            [piece.start, end].into_iter().chain(inside).map(|x| piece.slope(x)).fold(0.0, f64::max)
        };
        self.pieces.iter().enumerate().map(of).fold(0.0, f64::max)
    }

    /// The argument at which it has a value from 0 on: Newton's method within the piece, kept between its ends by
    /// bisection.
    pub fn inverse(&self, value: f64) -> f64 {
        let k = self.pieces.partition_point(|piece| piece.value <= value).saturating_sub(1);
        let piece = &self.pieces[k];
        let Some(next) = self.pieces.get(k + 1) else {
            return piece.start + (value - piece.value) / piece.c[0];
        };
        let (mut low, mut high) = (piece.start, next.start);
        let mut x = low + (high - low) * (value - piece.value) / (next.value - piece.value);
        // Bisection alone would need about fifty.
        for _ in 0..60 {
            let off = piece.value(x) - value;
            if off == 0.0 {
                break;
            }
            if off > 0.0 {
                high = x;
            } else {
                low = x;
            }
            let step = x - off / piece.slope(x);
            let to = if low < step && step < high { step } else { 0.5 * (low + high) };
            if (to - x).abs() <= f64::EPSILON * x {
                break;
            }
            x = to;
        }
        x
    }
}

/// `[h, Δ]` of the chords from the origin through these points.
fn chords(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut from = [0.0; 2];
    let chord = |[x, y]: &[f64; 2]| {
        let [u, v] = std::mem::replace(&mut from, [*x, *y]);
        [x - u, (y - v) / (x - u)]
    };
    points.iter().map(chord).collect()
}

/// Slope at a point between two chords `[h, Δ]`.
pub(crate) fn mean_slope([h0, before]: [f64; 2], [h1, after]: [f64; 2]) -> f64 {
    3.0 * (h0 + h1) / ((2.0 * h1 + h0) / before + (h1 + 2.0 * h0) / after)
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [[f64; 2]; 5] = [[0.5, 2.0], [1.0, 2.5], [1.1, 4.0], [3.0, 4.001], [4.0, 9.0]];

    fn grid() -> impl Iterator<Item = f64> {
        (0..=5000).map(|k| f64::from(k) * 1e-3)
    }

    #[test]
    fn it_passes_through_its_points_and_increases_in_between() {
        for slope in [None, Some(0.0), Some(1.0), Some(12.0)] {
            let curve = Curve::new(&POINTS, slope);
            assert_eq!((curve.value(0.0), curve.integral(0.0)), (0.0, 0.0));
            for [x, y] in POINTS {
                assert!((curve.value(x) - y).abs() <= 1e-14 * y, "{} at {x} instead of {y}", curve.value(x));
            }
            for x in grid() {
                assert!(curve.slope(x) >= 0.0, "slope {} at {x}", curve.slope(x));
                assert!(curve.slope(x) > 0.0 || x == 0.0, "slope 0 at {x}");
            }
        }
    }

    #[test]
    fn value_and_slope_are_derivatives() {
        let curve = Curve::new(&POINTS, None);
        let h = 1e-5;
        for x in grid().skip(1).map(|x| x + 3.3e-4) {
            let by_integral = (curve.integral(x + h) - curve.integral(x - h)) / (2.0 * h);
            assert!((by_integral - curve.value(x)).abs() < 1e-7, "value at {x}");
            let by_value = (curve.value(x + h) - curve.value(x - h)) / (2.0 * h);
            assert!((by_value - curve.slope(x)).abs() < 1e-5, "slope at {x}");
        }
    }

    #[test]
    fn it_goes_on_straight() {
        let curve = Curve::new(&POINTS, None);
        assert!((curve.value(6.0) - (9.0 + 2.0 * 4.999)).abs() < 1e-12);
        assert_eq!(curve.slope(4.0), curve.slope(100.0));
    }

    #[test]
    fn a_straight_table_is_a_straight_line() {
        let curve = Curve::new(&[[1.0, 3.0], [1.5, 4.5], [4.0, 12.0]], None);
        for x in grid() {
            assert!((curve.value(x) - 3.0 * x).abs() < 1e-13);
            assert!((curve.integral(x) - 1.5 * x * x).abs() < 1e-13);
        }
        assert!((curve.greatest_slope() - 3.0).abs() < 1e-14);
    }

    #[test]
    fn the_inverse_has_the_value() {
        for curve in [Curve::new(&POINTS, None), Curve::new(&POINTS, Some(0.0)), Curve::straight(7.0)] {
            assert_eq!(curve.inverse(0.0), 0.0);
            for value in grid().map(|x| 3.0 * x) {
                let found = curve.value(curve.inverse(value));
                assert!((found - value).abs() <= 1e-14 * (1.0 + value), "{found} instead of {value}");
            }
        }
    }

    #[test]
    fn no_slope_is_above_the_greatest() {
        let curve = Curve::new(&POINTS, None);
        let found = grid().map(|x| curve.slope(x)).fold(0.0, f64::max);
        assert!(found <= curve.greatest_slope() && found > 0.999 * curve.greatest_slope(), "{found}");
    }

    #[test]
    fn what_is_not_a_number_stays_so() {
        let curve = Curve::new(&POINTS, None);
        assert!(curve.value(f64::NAN).is_nan() && curve.integral(f64::NAN).is_nan() && curve.slope(f64::NAN).is_nan());
    }
}
