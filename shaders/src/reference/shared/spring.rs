//! Reference of `shared/spring.wgsl`.

use super::algebra::{identity, outer, rotation_matrix};
use super::coupling::{Coupling, bend_twist, bend_twist_energy, bend_twist_hessian, moment_on_second};
use crate::harness::NONE;
use crate::memory::{Matrix, Memory, Rotation, Vector};

pub(crate) struct Spring {
    pub(crate) rest: Rotation,
    pub(crate) offset: Vector,
    pub(crate) k: f64,
    tangent: f64,
    frame: f64,
    position: Vector,
    orientation: Rotation,
    force: Vector,
}

pub(crate) struct SpringLaw {
    /// R(q).
    pub(crate) r: Matrix,
    pub(crate) energy: f64,
    /// ∂E/∂X, N, world.
    pub(crate) force: Vector,
    /// ∂E/∂θ of S, N m, in the frame S.
    pub(crate) moment: Vector,
    /// ∂²E/∂θ² of S.
    pub(crate) hessian: Matrix,
}

pub(crate) fn spring(m: &Memory, k: usize, variant: usize) -> Spring {
    let entry = m.offsets.springs_numbers as usize + 20 * k;
    Spring {
        rest: m.number4(entry, variant),
        offset: m.number3(entry + 4, variant),
        k: m.number(entry + 7, variant),
        tangent: m.number(entry + 8, variant),
        frame: m.number(entry + 9, variant),
        position: m.number3(entry + 10, variant),
        orientation: m.number4(entry + 13, variant),
        force: m.number3(entry + 17, variant),
    }
}

pub(crate) fn spring_law(m: &Memory, k: usize, trial: u32, variant: usize) -> SpringLaw {
    let s = spring(m, k, variant);
    let links = m.offsets.springs_program as usize + 2 * k;
    let point = m.state_entry(m.word(links) as usize, trial, variant);
    let variable = m.word(links + 1);
    let x = m.value3(point, variant);
    let compensation = m.compensation3(point, variant);
    if variable == NONE {
        let gap = (x - s.position) + compensation;
        let energy = 0.5 * s.k * gap.dot(&gap) - s.force.dot(&x);
        let (moment, none) = (Vector::zeros(), Matrix::zeros());
        return SpringLaw { r: none, energy, force: gap * s.k - s.force, moment, hessian: none };
    }
    let q = m.value4(m.state_entry(variable as usize, trial, variant), variant);
    let r = rotation_matrix(&q);
    let lever = r * s.offset;
    let gap = ((x - s.position) + compensation) + lever;
    let at = q * s.rest;
    // ½ k_t |d3 − t|² = k_t (1 − d3·t), t in the frame S.
    let t = rotation_matrix(&at).tr_mul(&rotation_matrix(&s.orientation).column(2).into_owned());
    let c = Coupling { c: Vector::repeat(s.frame), lambda: 1.0, k0: Vector::zeros() };
    let turn = bend_twist(&s.orientation, &at, &c);
    let energy =
        0.5 * s.k * gap.dot(&gap) - s.force.dot(&(x + lever)) + s.tangent * (1.0 - t.z) + bend_twist_energy(&turn, &c);
    let e3 = Vector::z();
    let te = outer(&t, &e3);
    let hessian = (identity(t.z) - (te + te.transpose()) * 0.5) * s.tangent + bend_twist_hessian(&turn, &c).bb;
    let moment = moment_on_second(&turn) - e3.cross(&t) * s.tangent;
    SpringLaw { r, energy, force: gap * s.k - s.force, moment, hessian }
}
