//! The distance of two shapes of a branch.

use crate::curve::SAME;
use crate::ending::BranchEnd;

/// Distance between two shapes of a branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Largest distance, m.
    pub largest: f64,
    /// Its place, as a fraction of the arc length.
    pub fraction: f64,
    /// Mean distance, m.
    pub mean: f64,
}

/// Compares at the nodes of both, each at its fraction of the arc length; the mean is that of the trapezoidal rule.
/// A position that is not finite is infinitely far away.
pub fn gap(a: &BranchEnd, b: &BranchEnd) -> Gap {
    let (Some(a), Some(b)) = (a.curve(), b.curve()) else {
        return Gap { largest: f64::INFINITY, fraction: 0.0, mean: f64::INFINITY };
    };
    let mut fractions: Vec<f64> = a.fractions().chain(b.fractions()).collect();
    fractions.sort_by(f64::total_cmp);
    fractions.dedup_by(|x, y| (*x - *y).abs() < SAME);
    let distance = |u: &f64| {
        let d = (b.at(*u) - a.at(*u)).norm();
        if d.is_nan() { f64::INFINITY } else { d }
    };
    let distances: Vec<f64> = fractions.iter().map(distance).collect();
    let mut gap = Gap { largest: 0.0, fraction: 0.0, mean: 0.0 };
    for (d, u) in distances.iter().zip(&fractions) {
        if *d > gap.largest {
            (gap.largest, gap.fraction) = (*d, *u);
        }
    }
    gap.mean = fractions.windows(2).zip(distances.windows(2)).map(|(u, d)| 0.5 * (u[1] - u[0]) * (d[0] + d[1])).sum();
    gap
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom_core::Vector;

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
        assert_eq!((gap.largest, gap.fraction), (0.05, 0.3));
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
