//! Views, and the extents of the scene.

use wireloom_core::equilibrium::BranchResult;
use wireloom_core::{StepResult, Vector};

/// A view.
#[derive(Clone, Copy, PartialEq)]
pub enum View {
    /// Along +y: x to the right, z up.
    Front,
    /// Along −x: y to the right, z up.
    Side,
    /// Along −z: x to the right, y up.
    Above,
}

impl View {
    pub fn name(self) -> &'static str {
        match self {
            View::Front => "front",
            View::Side => "side",
            View::Above => "above",
        }
    }

    /// Index of the world axis to the right, and of the one up.
    pub fn axes(self) -> [usize; 2] {
        match self {
            View::Front => [0, 2],
            View::Side => [1, 2],
            View::Above => [0, 1],
        }
    }

    /// Towards the eye: larger is nearer.
    pub fn nearness(self, x: &Vector) -> f64 {
        match self {
            View::Front => -x.y,
            View::Side => x.x,
            View::Above => x.z,
        }
    }

    /// Its caption.
    pub fn caption(self) -> &'static str {
        match self {
            View::Front => "front: x–z, seen along +y",
            View::Side => "side: y–z, seen along −x",
            View::Above => "above: x–y, seen along −z",
        }
    }
}

/// Points farther than this from the origin (m) are not drawn: only a failed run has any, and a single one would
/// shrink the harness to a dot.
const FAR: f64 = 1e6;

/// Bounding box of everything that can be drawn, and the number of parts that cannot.
pub struct Scene {
    /// Lowest coordinates, m.
    pub low: [f64; 3],
    /// Highest coordinates, m.
    pub high: [f64; 3],
    /// Nodes, joints and constraints without a finite position.
    pub hidden: usize,
}

impl Scene {
    pub fn of(step: &StepResult) -> Self {
        let of_branch = |branch: &BranchResult| -> Vec<(Vector, f64)> {
            let r = radius(branch.diameter);
            branch.position.iter().map(|x| (*x, r)).collect()
        };
        let branches = step.branches.iter().flat_map(of_branch);
        let joints = step.joints.iter().map(|joint| (joint.position, 0.0));
        Self::around(branches.chain(joints).chain(step.constraints.iter().map(|constraint| (constraint.position, 0.0))))
    }

    /// Around points, each with a radius (m).
    pub fn around(points: impl Iterator<Item = (Vector, f64)>) -> Self {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        let mut hidden = 0;
        for (x, r) in points {
            if !visible(&x) {
                hidden += 1;
                continue;
            }
            for i in 0..3 {
                low[i] = low[i].min(x[i] - r);
                high[i] = high[i].max(x[i] + r);
            }
        }
        if low[0] > high[0] {
            (low, high) = ([0.0; 3], [0.0; 3]);
        }
        // A single point still needs a scale: 0.1 m around it. So does a scene that is tiny compared with its
        // distance.
        let size = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
        let reach = (0..3).map(|i| high[i].abs().max(low[i].abs())).fold(0.0, f64::max);
        if size < 1e-6_f64.max(1e-9 * reach) {
            for i in 0..3 {
                low[i] -= 0.05;
                high[i] += 0.05;
            }
        }
        Self { low, high, hidden }
    }

    /// Extents, m.
    pub fn size(&self) -> [f64; 3] {
        [0, 1, 2].map(|i| self.high[i] - self.low[i])
    }

    /// Middle of the box, m.
    pub fn centre(&self) -> [f64; 3] {
        [0, 1, 2].map(|i| 0.5 * (self.high[i] + self.low[i]))
    }
}

/// Whether a point can be drawn.
pub fn visible(x: &Vector) -> bool {
    x.iter().all(|c| c.abs() < FAR)
}

/// Half a diameter (m), or 0 where it is not a positive number.
pub fn radius(diameter: f64) -> f64 {
    if diameter > 0.0 && diameter < FAR { 0.5 * diameter } else { 0.0 }
}
