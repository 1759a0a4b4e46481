//! The distance of two shapes of a branch.

use crate::ending::BranchEnd;
use wireloom_core::Vector;

/// How far two shapes of a branch are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Largest distance, m.
    pub largest: f64,
    /// Where, as a share of the arc length.
    pub share: f64,
    /// Mean distance, m.
    pub mean: f64,
}

/// Compares at the nodes of both, each at its share of the arc length; the mean is that of the trapezoidal rule.
/// A position that is not finite is infinitely far away.
pub fn gap(a: &BranchEnd, b: &BranchEnd) -> Gap {
    let (Some(a), Some(b)) = (Curve::of(a), Curve::of(b)) else {
        return Gap { largest: f64::INFINITY, share: 0.0, mean: f64::INFINITY };
    };
    let mut shares: Vec<f64> = a.shares().chain(b.shares()).collect();
    shares.sort_by(f64::total_cmp);
    shares.dedup_by(|x, y| (*x - *y).abs() < SAME);
    let distance = |u: &f64| {
        let d = (b.at(*u) - a.at(*u)).norm();
        if d.is_nan() { f64::INFINITY } else { d }
    };
    let distances: Vec<f64> = shares.iter().map(distance).collect();
    let mut gap = Gap { largest: 0.0, share: 0.0, mean: 0.0 };
    for (d, u) in distances.iter().zip(&shares) {
        if *d > gap.largest {
            (gap.largest, gap.share) = (*d, *u);
        }
    }
    gap.mean = shares.windows(2).zip(distances.windows(2)).map(|(u, d)| 0.5 * (u[1] - u[0]) * (d[0] + d[1])).sum();
    gap
}

/// Position at an arc length (m), in m; not finite where there is no curve.
pub(crate) fn position(branch: &BranchEnd, s: f64) -> Vector {
    Curve::of(branch).map_or(Vector::repeat(f64::NAN), |curve| curve.at(s / curve.length))
}

/// Shares of the arc length that differ by less are the same.
const SAME: f64 = 1e-9;

/// A branch as a curve over the share of its arc length.
struct Curve<'a> {
    branch: &'a BranchEnd,
    length: f64,
}

impl<'a> Curve<'a> {
    /// `None` where there is no curve.
    fn of(branch: &'a BranchEnd) -> Option<Self> {
        let length = *branch.s.last()?;
        let whole = [branch.position.len(), branch.tangent.len()].iter().all(|n| *n == branch.s.len());
        (length > 0.0 && branch.s.len() > 1 && whole).then_some(Self { branch, length })
    }

    fn shares(&self) -> impl Iterator<Item = f64> + '_ {
        self.branch.s.iter().map(|s| s / self.length)
    }

    /// With `t` from 0 to 1 between nodes `i` and `i+1`, `h = x_{i+1} − x_i` and tangents `d` as long as the
    /// arc of chord `h` that turns by the angle between them, `|h| (1 + |Δd3|²/24)`:
    /// `x = (1−t)² (1+2t) x_i + t (1−t)² d_i + t² (3−2t) x_{i+1} − t² (1−t) d_{i+1}`, the cubic of Hermite.
    fn at(&self, share: f64) -> Vector {
        let BranchEnd { s, position, tangent, .. } = self.branch;
        let at = share * self.length;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// An arc of radius 1 m and angle 1 rad in the plane z = `z`, of so many segments.
    fn arc(segments: usize, z: f64) -> BranchEnd {
        let angles: Vec<f64> = (0..=segments).map(|i| i as f64 / segments as f64).collect();
        BranchEnd {
            name: "arc".into(),
            position: angles.iter().map(|a| Vector::new(a.sin(), 1.0 - a.cos(), z)).collect(),
            tangent: angles.iter().map(|a| Vector::new(a.cos(), a.sin(), 0.0)).collect(),
            bend_radius: vec![1.0; angles.len()],
            s: angles,
            twist_turns: 0.0,
        }
    }

    #[test]
    fn meshes_do_not_matter() {
        let Gap { largest, mean, .. } = gap(&arc(7, 0.0), &arc(12, 0.0));
        // Corners of the coarser polygon would lie 2.5 mm inside.
        assert!(largest < 2e-6 && mean < 2e-6, "{largest} {mean}");
        let Gap { largest, mean, .. } = gap(&arc(7, 0.0), &arc(12, 0.1));
        assert!((largest - 0.1).abs() < 1e-6 && (mean - 0.1).abs() < 1e-6, "{largest} {mean}");
    }

    #[test]
    fn the_largest_distance_is_where_it_is() {
        let (a, mut b) = (arc(10, 0.0), arc(10, 0.0));
        b.position[3].z = 0.05;
        let gap = gap(&a, &b);
        assert_eq!((gap.largest, gap.share), (0.05, 0.3));
        assert!((gap.mean - 0.005).abs() < 1e-12, "{}", gap.mean);
    }

    #[test]
    fn what_is_not_there_is_infinitely_far() {
        let (a, mut b) = (arc(10, 0.0), arc(10, 0.0));
        b.position[3].z = f64::NAN;
        assert_eq!(gap(&a, &b).largest, f64::INFINITY);
        b.s.clear();
        assert_eq!(gap(&a, &b).largest, f64::INFINITY);
    }
}
