//! Twin of `shared/segment.wgsl`.

use super::algebra::rotation_matrix;
use crate::memory::{Matrix, Memory, Rotation, Vector};

pub(crate) struct Segment {
    pub(crate) c: Vector,
    pub(crate) l: f64,
    pub(crate) overturned: f64,
}

pub(crate) struct SegmentLaw {
    pub(crate) r: Matrix,
    pub(crate) v: Vector,
    pub(crate) n: Vector,
    /// C at v.
    pub(crate) c: Vector,
    /// What of it B is responsible for.
    pub(crate) beyond: f64,
}

pub(crate) fn segment(m: &Memory, k: usize, variant: usize) -> Segment {
    let entry = m.places.segments_numbers as usize + 5 * k;
    Segment { c: m.number3(entry, variant), l: m.number(entry + 3, variant), overturned: m.number(entry + 4, variant) }
}

pub(crate) fn segment_law(s: &Segment, e: &Vector, q: &Rotation) -> SegmentLaw {
    let r = rotation_matrix(q);
    let v = r.tr_mul(e) * (1.0 / s.l);
    let beyond = if v.z < 0.0 { s.overturned } else { 0.0 };
    let n = Vector::new(s.c.x * v.x, s.c.y * v.y, s.c.z * (v.z - 1.0) + beyond * v.z);
    SegmentLaw { r, v, n, c: Vector::new(s.c.x, s.c.y, s.c.z + beyond), beyond }
}

pub(crate) fn segment_energy(law: &SegmentLaw, l: f64) -> f64 {
    let (n, v) = (&law.n, &law.v);
    0.5 * l * (n.x * v.x + n.y * v.y + n.z * (v.z - 1.0) + law.beyond * v.z)
}
