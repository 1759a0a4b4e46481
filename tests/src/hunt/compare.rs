//! Distance of two results of the same harness.

use super::outcome::{BranchOutcome, StepOutcome};
use super::scene::Scene;
use super::variants::Variant;
use wireloom::geometry::Vector;

/// The largest distance of two shapes: of nodes, per length of the longest branch, or a tenth of their distance seen
/// from the start of their branch, per its length, so that small branches count.
pub fn apart(scene: &Scene, one: &StepOutcome, variant: &Variant, other: &StepOutcome) -> f64 {
    let length = scene.length();
    let mut most = 0.0_f64;
    for branch in &scene.branches {
        let name = format!("b{}", branch.name);
        let (a, b) = (&one.branches[&name], &other.branches[&name]);
        let reversed = variant.reversed.contains(&branch.name);
        let at = |k: usize| -> Vector {
            let s = if reversed { branch.length - a.s[k] } else { a.s[k] };
            variant.back(&position(b, s * variant.scale))
        };
        let gaps: Vec<Vector> = (0..a.s.len()).map(|k| at(k) - a.position[k]).collect();
        for gap in &gaps {
            let own = 0.1 * (gap - gaps[0]).norm() / branch.length;
            most = most.max(gap.norm() / length).max(own);
        }
        if gaps.iter().any(|g| !g.norm().is_finite()) {
            return f64::INFINITY;
        }
    }
    most
}

/// The same for two results of one scene.
pub fn moved(scene: &Scene, one: &StepOutcome, other: &StepOutcome) -> f64 {
    apart(scene, one, &super::variants::moved(scene, wireloom::geometry::Rotation::identity(), Vector::zeros()), other)
}

/// Position of a branch at arc length `s`: of a node, or on the cubic between two nodes with their tangents.
fn position(b: &BranchOutcome, s: f64) -> Vector {
    let n = b.s.len() - 1;
    let k = b.s.partition_point(|t| *t <= s).clamp(1, n) - 1;
    let (length, t) = (b.s[k + 1] - b.s[k], (s - b.s[k]) / (b.s[k + 1] - b.s[k]));
    let (x, y) = (b.position[k], b.position[k + 1]);
    let (u, v) = (b.d3[k] * length, b.d3[k + 1] * length);
    if t < 1e-9 {
        return x;
    }
    if t > 1.0 - 1e-9 {
        return y;
    }
    let (t2, t3) = (t * t, t * t * t);
    x * (2.0 * t3 - 3.0 * t2 + 1.0) + u * (t3 - 2.0 * t2 + t) + y * (3.0 * t2 - 2.0 * t3) + v * (t3 - t2)
}
