use super::shared::algebra::{normalised, rotated, rotation_matrix};
use super::shared::assembly::{free_directions, hold_basis, hold_entry};
use super::shared::sum::{set_point, two_sum};
use crate::layout::Range;
use crate::memory::{Memory, Rotation, Vector};
use nalgebra::Quaternion;

/// The shortest rotation from direction a to b, both unit vectors; the identity if they are opposite.
fn shortest(a: &Vector, b: &Vector) -> Rotation {
    let w = 1.0 + a.dot(b);
    if w < 1e-12 {
        return Quaternion::identity();
    }
    normalised(Quaternion::from_parts(w, a.cross(b)))
}

/// The trial state: points move by α δ, frames rotate by α θ, and held variables are set to their targets.
pub(crate) fn retract(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let at = m.state_entry(k, 0, variant);
    let to = m.state_entry(k, 1, variant);
    let control = &m.control[variant];
    let step = m.vector3(m.offsets.step_vectors as usize + 3 * k, variant) * control.alpha;
    let held = hold_entry(m, k);
    let count = held.map_or(0.0, |held| m.number(held + 9, variant));
    let held = held.unwrap_or(0);
    if m.word(m.offsets.kinds_program as usize + k) == 1 {
        let mut q = rotated(&m.value4(at, variant), &step);
        if count > 2.5 {
            q = m.number4(held + 10, variant);
        } else if count > 1.5 {
            let tangent = |q: &Rotation| -> Vector { rotation_matrix(q).column(2).into() };
            q = normalised(shortest(&tangent(&q), &tangent(&m.number4(held + 10, variant))) * q);
        }
        m.set_value4(to, variant, &q);
        return;
    }
    let mut moved = two_sum(&m.value3(at, variant), &m.compensation3(at, variant), &step);
    if count > 2.5 {
        moved = two_sum(&m.number3(held + 10, variant), &m.number3(held + 14, variant), &Vector::zeros());
    } else if count > 0.5 {
        let basis = hold_basis(m, held, variant);
        let gap = (m.number3(held + 10, variant) - moved.0) + (m.number3(held + 14, variant) - moved.1);
        let gap = basis.tr_mul(&gap).component_mul(&(Vector::repeat(1.0) - free_directions(m, held, variant)));
        moved = two_sum(&moved.0, &moved.1, &(basis * gap));
    }
    set_point(m, to, variant, moved);
}
