//! Reference of `shared/station_segment.wgsl`.

use super::algebra::{identity, inverse33, relative, rotation_matrix, skew};
use super::strain::strain;
use crate::harness::NONE;
use crate::memory::{Matrix, Memory, Rotation, Vector};

pub(crate) struct StationSegment {
    pub(crate) c: Vector,
    pub(crate) l: f64,
    pub(crate) inversion_stiffness: f64,
}

/// A station of the segment: the independent frame that carries it, its matrix R, rest and offset in that frame, β,
/// and β (I − R′).
#[derive(Default)]
pub(crate) struct Station {
    pub(crate) present: bool,
    pub(crate) r: Matrix,
    pub(crate) rest: Rotation,
    pub(crate) offset: Vector,
    pub(crate) blend: f64,
    pub(crate) lack: Matrix,
}

pub(crate) struct StationLaw {
    pub(crate) r: Matrix,
    pub(crate) v: Vector,
    pub(crate) n: Vector,
    pub(crate) c: Vector,
    pub(crate) inverted: f64,
    pub(crate) gamma: Vector,
    pub(crate) u: Vector,
    pub(crate) inverse: Matrix,
}

pub(crate) fn station_segment(m: &Memory, k: usize, variant: usize) -> StationSegment {
    let entry = m.offsets.station_segments_numbers as usize + 22 * k;
    StationSegment {
        c: m.number3(entry, variant),
        l: m.number(entry + 3, variant) + m.number(entry + 4, variant),
        inversion_stiffness: m.number(entry + 5, variant),
    }
}

pub(crate) fn station(m: &Memory, k: usize, end: usize, q: &Rotation, trial: u32, variant: usize) -> Station {
    let variable = m.word(m.offsets.station_segments_program as usize + 5 * k + 3 + end);
    if variable == NONE {
        return Station::default();
    }
    let entry = m.offsets.station_segments_numbers as usize + 22 * k + 6 + 8 * end;
    let carrier = m.value4(m.state_entry(variable as usize, trial, variant), variant);
    let rest = m.number4(entry, variant);
    let (w, v) = relative(q, &(carrier * rest));
    let blend = m.number(entry + 7, variant);
    // R′ = I + 2 w [v]ₓ + 2 [v]ₓ²
    let across = skew(&v);
    let lack = (across * w + across * across) * (-2.0 * blend);
    Station { present: true, r: rotation_matrix(&carrier), rest, offset: m.number3(entry + 4, variant), blend, lack }
}

pub(crate) fn station_law(
    s: &StationSegment,
    e: &Vector,
    q: &Rotation,
    first: &Station,
    second: &Station,
) -> StationLaw {
    let r = rotation_matrix(q);
    let straight = strain(&r, e, s.l, q);
    let v = straight + Vector::z();
    let lack = first.lack + second.lack;
    let inverse = inverse33(&(identity(1.0) - lack));
    // Γ = B⁻¹ (v − B e3), without the difference of u and e3.
    let gamma = inverse * (straight + lack.column(2));
    let u = gamma + Vector::z();
    let inverted = if gamma.z < -1.0 { s.inversion_stiffness } else { 0.0 };
    let n = Vector::new(s.c.x * gamma.x, s.c.y * gamma.y, s.c.z * gamma.z + inverted * (gamma.z + 1.0));
    StationLaw { r, v, n, c: Vector::new(s.c.x, s.c.y, s.c.z + inverted), inverted, gamma, u, inverse }
}

pub(crate) fn station_energy(law: &StationLaw, l: f64) -> f64 {
    0.5 * l * (law.n.dot(&law.gamma) + law.inverted * (law.gamma.z + 1.0))
}

/// p = B⁻ᵀ n, the force conjugate to v.
pub(crate) fn conjugate_force(law: &StationLaw) -> Vector {
    law.inverse.tr_mul(&law.n)
}

/// β R′.
pub(crate) fn station_turn(s: &Station) -> Matrix {
    identity(s.blend) - s.lack
}

/// Moment on a station, in the body frame of its carrier: the lever of the force on the end (world), and ℓ z × u with
/// z = β R′ᵀ p.
pub(crate) fn station_moment(s: &Station, force: &Vector, p: &Vector, u: &Vector, l: f64) -> Vector {
    let own = station_turn(s).tr_mul(p).cross(u) * l;
    s.offset.cross(&s.r.tr_mul(force)) + rotation_matrix(&s.rest) * own
}
