//! Centre lines on the board: arcs of constant curvature, straight ones among them.

use std::f64::consts::PI;

/// A point of the plane, m.
pub type Point = nalgebra::Vector2<f64>;

/// Angle below which an arc is computed by its series, rad: the error of the series is then below round-off.
const SMALL: f64 = 1e-3;

/// Largest turn of a chord that stands for a part of an arc, rad.
const CHORD: f64 = PI / 18.0;

/// The centre line of a branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Where it begins, m.
    pub start: Point,
    /// Direction in which it begins, rad, counter-clockwise from x.
    pub direction: f64,
    /// Curvature, 1/m; above zero where it turns to the left.
    pub curvature: f64,
    /// m.
    pub length: f64,
}

impl Line {
    /// Direction at an arc length, rad.
    pub fn direction_at(&self, s: f64) -> f64 {
        self.direction + self.curvature * s
    }

    /// The point at an arc length.
    ///
    /// A chord over the angle `2a = κ s` has the length `s sin(a)/a` and the direction of the middle of its arc.
    pub fn at(&self, s: f64) -> Point {
        let half = 0.5 * self.curvature * s;
        let ratio = if half.abs() < SMALL { 1.0 - half * half / 6.0 } else { half.sin() / half };
        self.start + s * ratio * unit(self.direction + half)
    }

    /// Where it ends.
    pub fn end(&self) -> Point {
        self.at(self.length)
    }

    /// The same line from its end to its start.
    pub fn reversed(&self) -> Self {
        let direction = self.direction_at(self.length) + PI;
        Self { start: self.end(), direction, curvature: -self.curvature, length: self.length }
    }

    /// The line in parts of equal length.
    #[cfg(feature = "drawings")]
    pub(crate) fn divided(&self, parts: usize) -> impl Iterator<Item = Self> {
        let length = self.length / parts as f64;
        (0..parts).map(move |k| length * k as f64).map(move |s| Self {
            start: self.at(s),
            direction: self.direction_at(s),
            curvature: self.curvature,
            length,
        })
    }

    /// Number of chords that stand for it in distances.
    pub(crate) fn chords(&self) -> usize {
        let turn = (self.curvature * self.length).abs();
        if turn == 0.0 { 1 } else { (turn / CHORD).ceil() as usize }
    }

    /// Largest distance of the line from its chords, m.
    pub(crate) fn sagitta(&self) -> f64 {
        if self.curvature == 0.0 {
            return 0.0;
        }
        let half = 0.5 * self.curvature.abs() * self.length / self.chords() as f64;
        (1.0 - half.cos()) / self.curvature.abs()
    }

    /// The least box around it: lower left and upper right corner.
    pub(crate) fn extent(&self) -> [Point; 2] {
        let (a, b) = (self.start, self.end());
        let mut extent = [a.inf(&b), a.sup(&b)];
        if self.curvature != 0.0 {
            let n = self.chords();
            for k in 1..n {
                let p = self.at(self.length * k as f64 / n as f64);
                extent = [extent[0].inf(&p), extent[1].sup(&p)];
            }
            let more = Point::repeat(self.sagitta());
            extent = [extent[0] - more, extent[1] + more];
        }
        extent
    }
}

/// The unit vector of a direction.
pub(crate) fn unit(direction: f64) -> Point {
    let (y, x) = direction.sin_cos();
    Point::new(x, y)
}

/// An angle within half a turn to either side.
pub(crate) fn wrapped(angle: f64) -> f64 {
    PI - (PI - angle).rem_euclid(2.0 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_a_circle() {
        let line = Line { start: Point::new(1.0, 2.0), direction: 0.0, curvature: 2.0, length: PI / 4.0 };
        // Radius 0.5 m, centre at (1, 2.5).
        assert!((line.end() - Point::new(1.5, 2.5)).norm() < 1e-15, "{}", line.end());
        assert!((line.direction_at(line.length) - PI / 2.0).abs() < 1e-15);
        let back = line.reversed();
        assert!((back.end() - line.start).norm() < 1e-15 && (back.at(0.1) - line.at(line.length - 0.1)).norm() < 1e-15);
        let [low, high] = line.extent();
        assert!(low.x <= 1.0 && low.y <= 2.0 && high.x >= 1.5 && high.y >= 2.5 && (high - low).max() < 0.51);
    }

    #[test]
    fn series_and_closed_form_of_an_arc_meet() {
        let at = |curvature: f64| Line { start: Point::zeros(), direction: 0.3, curvature, length: 1.0 }.end();
        // The slope of the end by curvature is half a length across the line.
        let (below, above) = (at(2.0 * SMALL * (1.0 - 1e-9)), at(2.0 * SMALL * (1.0 + 1e-9)));
        assert!((below - above).norm() < 4e-12 && (at(0.0) - unit(0.3)).norm() < 1e-15);
    }

    #[test]
    fn angles_are_wrapped() {
        for (angle, expected) in [(0.0, 0.0), (PI, PI), (-PI, PI), (3.5 * PI, -0.5 * PI)] {
            assert!((wrapped(angle) - expected).abs() < 1e-12, "{angle}");
        }
    }
}
