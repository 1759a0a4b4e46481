//! The centre line between nodes: a cubic through positions and tangents.

use wireloom_core::Vector;

/// Fractions of the arc length that differ by less are the same.
pub const SAME: f64 = 1e-9;

/// A branch as a curve over the fraction of its arc length. Lists have one entry for each node.
pub struct Curve<'a> {
    s: &'a [f64],
    position: &'a [Vector],
    tangent: &'a [Vector],
    length: f64,
}

impl<'a> Curve<'a> {
    /// From arc lengths (m), positions (m) and unit tangents; `None` where they are no curve.
    pub fn of(s: &'a [f64], position: &'a [Vector], tangent: &'a [Vector]) -> Option<Self> {
        let length = *s.last()?;
        let whole = [position.len(), tangent.len()].iter().all(|n| *n == s.len());
        (length > 0.0 && s.len() > 1 && whole).then_some(Self { s, position, tangent, length })
    }

    /// Arc length, m.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Fractions of the arc length at nodes.
    pub fn fractions(&self) -> impl Iterator<Item = f64> + '_ {
        self.s.iter().map(|s| s / self.length)
    }

    /// Position (m) at a fraction of the arc length.
    ///
    /// With `t` from 0 to 1 between nodes `i` and `i+1`, `h = x_{i+1} − x_i` and tangents `d` as long as the
    /// arc of chord `h` that turns by the angle between them, `|h| (1 + |Δd3|²/24)`:
    /// `x = (1−t)² (1+2t) x_i + t (1−t)² d_i + t² (3−2t) x_{i+1} − t² (1−t) d_{i+1}`, the cubic of Hermite.
    pub fn at(&self, fraction: f64) -> Vector {
        let Self { s, position, tangent, .. } = self;
        let at = fraction * self.length;
        let i = s.partition_point(|s| *s <= at).clamp(1, s.len() - 1) - 1;
        let t = ((at - s[i]) / (s[i + 1] - s[i])).clamp(0.0, 1.0);
        if !(SAME..=1.0 - SAME).contains(&t) {
            return position[if t < 0.5 { i } else { i + 1 }];
        }
        let turn = (tangent[i + 1] - tangent[i]).norm_squared();
        let h = (position[i + 1] - position[i]).norm() * (1.0 + turn / 24.0);
        let u = 1.0 - t;
        position[i] * (u * u * (1.0 + 2.0 * t))
            + tangent[i] * (h * t * u * u)
            + position[i + 1] * (t * t * (3.0 - 2.0 * t))
            - tangent[i + 1] * (h * t * t * u)
    }
}
