//! Reference of `shared/segment.wgsl`.

use super::algebra::rotation_matrix;
use super::strain::strain;
use crate::memory::{Matrix, Memory, Rotation, Vector};

pub(crate) struct Segment {
    pub(crate) c: Vector,
    pub(crate) l: f64,
    pub(crate) inversion_stiffness: f64,
}

pub(crate) struct SegmentLaw {
    pub(crate) r: Matrix,
    pub(crate) gamma: Vector,
    pub(crate) v: Vector,
    pub(crate) n: Vector,
    /// C at v.
    pub(crate) c: Vector,
    /// Contribution of B.
    pub(crate) inverted: f64,
}

pub(crate) fn segment(m: &Memory, k: usize, variant: usize) -> Segment {
    let entry = m.offsets.segments_numbers as usize + 6 * k;
    let l = m.number(entry + 3, variant) + m.number(entry + 4, variant);
    Segment { c: m.number3(entry, variant), l, inversion_stiffness: m.number(entry + 5, variant) }
}

pub(crate) fn segment_law(s: &Segment, e: &Vector, q: &Rotation) -> SegmentLaw {
    let r = rotation_matrix(q);
    let gamma = strain(&r, e, s.l, q);
    let v = gamma + Vector::z();
    let inverted = if v.z < 0.0 { s.inversion_stiffness } else { 0.0 };
    let n = Vector::new(s.c.x * gamma.x, s.c.y * gamma.y, s.c.z * gamma.z + inverted * v.z);
    SegmentLaw { r, gamma, v, n, c: Vector::new(s.c.x, s.c.y, s.c.z + inverted), inverted }
}

pub(crate) fn segment_energy(law: &SegmentLaw, l: f64) -> f64 {
    0.5 * l * (law.n.dot(&law.gamma) + law.inverted * law.v.z)
}
