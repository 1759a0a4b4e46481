//! Reference of `shared/coupling.wgsl`.

use super::algebra::{diagonal, identity, outer, relative, skew};
use crate::memory::{Matrix, Rotation, Vector};

pub(crate) struct Coupling {
    pub(crate) c: Vector,
    pub(crate) lambda: f64,
    pub(crate) k0: Vector,
}

pub(crate) struct BendTwist {
    w: f64,
    v: Vector,
    moment: Vector,
    strain: Vector,
    /// ½ ∂E/∂v = G m, G = (1 + |v|²/6) I + v vᵀ/3.
    half_mu: Vector,
}

pub(crate) fn bend_twist(qa: &Rotation, qb: &Rotation, c: &Coupling) -> BendTwist {
    let (w, v) = relative(qa, qb);
    let g = 1.0 + v.dot(&v) / 6.0;
    let strain = v * (2.0 * g / c.lambda) - c.k0;
    let moment = c.c.component_mul(&strain);
    let half_mu = moment * g + v * (v.dot(&moment) / 3.0);
    BendTwist { w, v, moment, strain, half_mu }
}

pub(crate) fn bend_twist_energy(law: &BendTwist, c: &Coupling) -> f64 {
    0.5 * c.lambda * law.moment.dot(&law.strain)
}

/// −½(w μ + v × μ)
pub(crate) fn moment_on_first(law: &BendTwist) -> Vector {
    -(law.half_mu * law.w + law.v.cross(&law.half_mu))
}

/// ½(w μ − v × μ)
pub(crate) fn moment_on_second(law: &BendTwist) -> Vector {
    law.half_mu * law.w - law.v.cross(&law.half_mu)
}

pub(crate) struct CouplingHessian {
    pub(crate) aa: Matrix,
    pub(crate) ab: Matrix,
    pub(crate) bb: Matrix,
}

/// With J_b = ½(w I + \[v\]ₓ), J_a = −J_bᵀ, K = ∂²E/∂v² = (4/λ) G C G + ⅔ ((m·v) I + m vᵀ + v mᵀ):
/// J_aᵀ K J_a − ¼(μ·v) I, J_aᵀ K J_b + ¼(v μᵀ + μ vᵀ + w \[μ\]ₓ − (μ·v) I), J_bᵀ K J_b − ¼(μ·v) I.
pub(crate) fn bend_twist_hessian(law: &BendTwist, c: &Coupling) -> CouplingHessian {
    let (w, v, m) = (law.w, &law.v, &law.moment);
    let g = 1.0 + v.dot(v) / 6.0;
    let cv = c.c.component_mul(v);
    let y = (cv * (g / 3.0) + v * (cv.dot(v) / 18.0)) * (4.0 / c.lambda) + m * (2.0 / 3.0);
    let vy = outer(v, &y);
    let k = diagonal(&(c.c * (4.0 * g * g / c.lambda))) + identity(m.dot(v) * (2.0 / 3.0)) + vy + vy.transpose();
    // A = [v]ₓ K, B = [v]ₓ K [v]ₓ: 4 J K Jᵀ = w² K − B + w (A + Aᵀ), 4 Jᵀ K J = w² K − B − w (A +
    // Aᵀ),
    // 4 J K J = w² K + B + w (A − Aᵀ).
    let a = skew(v) * k;
    let b = (a * skew(v)) * 0.25;
    let at = a.transpose();
    let kw = k * (0.25 * w * w);
    let sum = (a + at) * (0.25 * w);
    let difference = (a - at) * (0.25 * w);
    let mu = &law.half_mu;
    let own = identity(-0.5 * mu.dot(v));
    let vm = outer(v, mu) * 0.5;
    let mixed = vm + vm.transpose() + skew(mu) * (0.5 * w) + own;
    let both = kw - b + own;
    CouplingHessian { aa: both + sum, ab: mixed - kw - b - difference, bb: both - sum }
}
