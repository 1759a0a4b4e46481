//! Centre lines between nodes.

use crate::{Pose, Vector};

/// Largest number of steps to the place nearest to a point.
const STEPS: usize = 60;
/// Change of half the squared distance with the fraction, in units of the squared length, at which that search ends.
const LEVEL: f64 = 1e-13;

/// A segment as the arc that the centre line is between its nodes, `x(t) = a + t e − ½ ℓ² t (1 − t) x″(t)`, with x″
/// between those of the nodes: a cubic whose tangents are continuous (Catmull and Rom 1974, A class of local
/// interpolating splines).
#[derive(Clone, Copy, Debug)]
pub struct Arc {
    start: Vector,
    /// e, m.
    edge: Vector,
    /// `−½ ℓ² x″` at both nodes, m.
    bulge: [Vector; 2],
}

impl Arc {
    /// From one node to the next (m) on a segment of this length (m), with x″ (1/m) at both.
    pub fn new(start: Vector, end: Vector, length: f64, bends: [Vector; 2]) -> Self {
        Self { start, edge: end - start, bulge: bends.map(|bend| bend * (-0.5 * length * length)) }
    }

    /// The same in the axes of a body.
    #[must_use]
    pub fn seen_from(&self, pose: &Pose) -> Self {
        let turned = |v: &Vector| pose.orientation.inverse_transform_vector(v);
        Self { start: pose.local(&self.start), edge: turned(&self.edge), bulge: self.bulge.each_ref().map(turned) }
    }

    /// Its chord.
    #[must_use]
    pub fn chord(&self) -> Self {
        Self { bulge: [Vector::zeros(); 2], ..*self }
    }

    /// From its first node to its second, m.
    pub fn edge(&self) -> Vector {
        self.edge
    }

    /// x(t), m.
    pub fn at(&self, t: f64) -> Vector {
        self.start + self.edge * t + self.beside(t)
    }

    /// Way from the chord to the arc, m.
    pub fn beside(&self, t: f64) -> Vector {
        let [a, b] = &self.bulge;
        (a * (1.0 - t) + b * t) * (t * (1.0 - t))
    }

    /// ∂x/∂t, m.
    pub fn tangent(&self, t: f64) -> Vector {
        let [a, b] = &self.bulge;
        self.edge + (a * (1.0 - t) + b * t) * (1.0 - 2.0 * t) + (b - a) * (t * (1.0 - t))
    }

    /// ∂²x/∂t², m.
    pub fn bend(&self, t: f64) -> Vector {
        let [a, b] = &self.bulge;
        (b - a) * (2.0 - 4.0 * t) - (a * (1.0 - t) + b * t) * 2.0
    }

    /// Fraction at which it is nearest to a point, as far as it is less bent than a circle around that point. Newton's
    /// method, with bisections where it leaves the bracket.
    pub fn nearest(&self, x: &Vector) -> f64 {
        let square = self.edge.norm_squared();
        let on_chord = ((x - self.start).dot(&self.edge) / square).clamp(0.0, 1.0);
        if self.bulge.iter().all(|bulge| *bulge == Vector::zeros()) {
            return on_chord;
        }
        let slope = |t: f64| (self.at(t) - x).dot(&self.tangent(t));
        let rises = [0.0, 1.0].map(|t| slope(t) > 0.0);
        let (mut low, mut high) = match rises {
            [false, true] => (0.0, 1.0),
            [true, true] => return 0.0,
            [false, false] => return 1.0,
            [true, false] => return if (self.at(0.0) - x).norm() < (self.at(1.0) - x).norm() { 0.0 } else { 1.0 },
        };
        let mut t = on_chord;
        for _ in 0..STEPS {
            let own = slope(t);
            if own.abs() <= LEVEL * square {
                break;
            }
            if own > 0.0 {
                high = t
            } else {
                low = t
            }
            let newton = t - own / (self.tangent(t).norm_squared() + (self.at(t) - x).dot(&self.bend(t)));
            t = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        t
    }
}

/// x″ of a centre line at its nodes (m), 1/m, by the segments on both sides; at the ends that of the next node.
pub fn bends(nodes: &[Vector], lengths: &[f64]) -> Vec<Vector> {
    let tangents: Vec<Vector> =
        nodes.windows(2).zip(lengths).map(|(ends, length)| (ends[1] - ends[0]) / *length).collect();
    let inner = tangents.windows(2).zip(lengths.windows(2));
    let mut bends = vec![Vector::zeros(); nodes.len()];
    for (node, (tangents, lengths)) in inner.enumerate() {
        bends[node + 1] = (tangents[1] - tangents[0]) * (2.0 / (lengths[0] + lengths[1]));
    }
    if let [first, second, ..] = &mut bends[..] {
        *first = *second;
    }
    if let [.., before, last] = &mut bends[..] {
        *last = *before;
    }
    bends
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In the middle the arc is `9 ℓ⁴ κ³/384` inside the circle, to leading order; its tangent is that of the next arc.
    #[test]
    fn the_arc_between_nodes_of_a_circle_is_on_it() {
        let (radius, angle) = (0.1, 0.1);
        let node = |k: usize| {
            let (sin, cos) = (angle * k as f64).sin_cos();
            Vector::new(radius * cos, radius * sin, 0.0)
        };
        let nodes: Vec<Vector> = (0..6).map(node).collect();
        let lengths = [2.0 * radius * (0.5 * angle).sin(); 5];
        let bends = bends(&nodes, &lengths);
        let arc = |k: usize| Arc::new(nodes[k], nodes[k + 1], lengths[k], [bends[k], bends[k + 1]]);
        let off = (arc(2).at(0.5).norm() - radius).abs();
        let expected = radius * angle.powi(4) * 9.0 / 384.0;
        assert!((off - expected).abs() < 0.01 * expected, "{off}, {expected} expected");
        let kink = (arc(2).tangent(1.0) - arc(3).tangent(0.0)).norm();
        assert!(kink < 1e-15, "{kink}");
        let h = 1e-4;
        let second = (arc(2).tangent(0.3 + h) - arc(2).tangent(0.3 - h)) / (2.0 * h);
        assert!((second - arc(2).bend(0.3)).norm() < 1e-9 * second.norm());
    }
}
