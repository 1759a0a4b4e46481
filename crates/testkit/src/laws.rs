//! The energies of [`wireloom_core::law`], evaluated as their formulas are written there, by way of rotation matrices
//! and quaternion products: what kinds that say their law are held to.

use wireloom_core::joint::JointShape;
use wireloom_core::law::{JointLaw, RodLaw, SpringLaw, TurningLaw};
use wireloom_core::rod::{CellPair, Mesh};
use wireloom_core::section::{CreepElement, FrictionElement, SectionFriction};
use wireloom_core::{BranchShape, Matrix, Pose, Rotation, Vector};

/// w ≥ 0 and v of `q̄_a q_b`.
fn relative(a: &Rotation, b: &Rotation) -> (f64, Vector) {
    let r = (a.inverse() * b).into_inner();
    let sign = if r.w < 0.0 { -1.0 } else { 1.0 };
    (sign * r.w, r.imag() * sign)
}

/// κ, 1/m.
fn curvature(a: &Rotation, b: &Rotation, lambda: f64) -> Vector {
    let (_, v) = relative(a, b);
    v * ((2.0 / lambda) * (1.0 + v.norm_squared() / 6.0))
}

/// `½ λ (κ−κ°)ᵀ C (κ−κ°)`, J.
fn bend_twist(a: &Rotation, b: &Rotation, lambda: f64, c: &Matrix, rest: &Vector) -> f64 {
    let strain = curvature(a, b, lambda) - rest;
    0.5 * lambda * strain.dot(&(c * strain))
}

/// Energy of a branch, J.
pub fn rod_energy(law: &RodLaw, mesh: &Mesh, shape: &BranchShape<'_>) -> f64 {
    let mut energy = 0.0;
    for (j, segment) in law.segments.iter().enumerate() {
        let q = &shape.frames[mesh.segment_frames[j]];
        let l = shape.rest_lengths[j];
        let v = q.inverse() * (shape.edge(j) / l);
        let mut of_strain = Matrix::identity();
        let turn = |c: usize| *(q.inverse() * shape.frames[c]).to_rotation_matrix().matrix() - Matrix::identity();
        for beside in mesh.beside.iter().filter(|beside| beside.segment == j) {
            let is_fourth_order = law.variation > 0.0 && mesh.is_fine(j);
            let next = beside.next.filter(|_| is_fourth_order);
            for c in beside.stations.into_iter().flatten() {
                let end = c == 0 || c + 1 == shape.frames.len();
                let beta = match (is_fourth_order, next) {
                    (false, _) => law.blends[usize::from(!end)],
                    (true, None) => 1.0 / 12.0,
                    (true, Some(_)) => 1.0 / 9.0,
                };
                of_strain += turn(c) * beta;
            }
            if let Some(c) = next {
                of_strain += turn(c) / 72.0;
            }
        }
        let blended = of_strain.lu().solve(&v).unwrap_or(Vector::repeat(f64::NAN));
        let gamma = blended - Vector::z() * (1.0 + shape.free_strain);
        let overturned = blended.z.min(0.0);
        let stiff = gamma.dot(&segment.stiffness.component_mul(&gamma));
        energy += 0.5 * l * (stiff + segment.overturned * overturned * overturned);
        energy += l * law.laws.axial.as_ref().map_or(0.0, |law| law.energy(gamma.z));
    }
    for c in 0..law.couplings.len() {
        let stiffness = law.coupling_stiffness(c);
        let rest = law.curvature + shape.extra_curvature.get(c).copied().unwrap_or_default();
        energy += bend_twist(&shape.frames[c], &shape.frames[c + 1], shape.coupling_lengths[c], &stiffness, &rest);
    }
    if law.variation > 0.0 {
        energy += mesh.pairs.iter().map(|pair| variation(law, pair, shape)).sum::<f64>();
    }
    let (friction, creep) = (&law.friction, &law.laws.creep);
    let width = shape.memory.len() / law.couplings.len().max(1);
    for c in 0..law.couplings.len() {
        let (own, flows) = shape.memory[c * width..(c + 1) * width].split_at(slips(friction));
        let rest = law.curvature + shape.extra_curvature.get(c).copied().unwrap_or_default();
        let lambda = shape.coupling_lengths[c];
        let e = curvature(&shape.frames[c], &shape.frames[c + 1], lambda) - rest;
        energy += lambda * slipping(friction, &e, own);
        energy += lambda * law.laws.bending.as_ref().map_or(0.0, |curve| curve.integral(e.x.hypot(e.y)));
        let (flows, twists) = flows.split_at(if creep.bending.is_empty() { 0 } else { 2 + 2 * creep.bending.len() });
        let relaxing = |elements: &[CreepElement], e: &[f64], memory: &[f64]| -> f64 {
            let directions = e.len();
            let of = |(k, element): (usize, &CreepElement)| {
                let x = shape.duration / element.time;
                let (a, g) = if x > 0.0 { ((-x).exp(), -(-x).exp_m1() / x) } else { (1.0, 1.0) };
                let apart = |(i, e): (usize, &f64)| {
                    let (before, flow) = (memory[i], memory[(k + 1) * directions + i]);
                    (e - flow - (1.0 - a / g) * (before - flow)).powi(2)
                };
                0.5 * element.stiffness * g * e.iter().enumerate().map(apart).sum::<f64>()
            };
            elements.iter().enumerate().map(of).sum()
        };
        energy += lambda * (relaxing(&creep.bending, &[e.x, e.y], flows) + relaxing(&creep.torsion, &[e.z], twists));
    }
    energy
}

/// Energy of the variation of curvature between two couplings, J: the mean of the curvature of each cell in place of
/// its own, and `(λ³/24) κ′ᵀ C κ′`.
fn variation(law: &RodLaw, pair: &CellPair, shape: &BranchShape<'_>) -> f64 {
    let c = pair.frame;
    let stiffness = law.coupling_stiffness(c);
    let form = |e: Vector| e.dot(&(stiffness * e));
    let lambda = [shape.coupling_lengths[c - 1], shape.coupling_lengths[c]];
    let distance = (lambda[0] + lambda[1]) / 2.0;
    let (mut kappa, mut rest) = ([Vector::zeros(); 2], [Vector::zeros(); 2]);
    for k in 0..2 {
        let (_, v) = relative(&shape.frames[c - 1 + k], &shape.frames[c + k]);
        kappa[k] = v * (2.0 / lambda[k]) * (1.0 + v.norm_squared() / 6.0);
        rest[k] = law.curvature + shape.extra_curvature.get(c - 1 + k).copied().unwrap_or_default();
    }
    let rate = |of: &[Vector; 2]| (of[1] - of[0]) / distance;
    let turning = kappa[0].cross(&rate(&kappa)) - rest[0].cross(&rate(&rest));
    let mut energy = 0.0;
    for k in 0..2 {
        let strain = kappa[k] - rest[k];
        let mean = strain - turning * (lambda[k] * lambda[k] / 12.0);
        let within = law.variation * lambda[k].powi(3) / 24.0 * form(rate(&kappa) - rate(&rest));
        energy += pair.shares[k] * (0.5 * lambda[k] * (form(mean) - form(strain)) + within);
    }
    energy
}

/// Number of state variables of elements of friction.
fn slips(friction: &SectionFriction) -> usize {
    2 * friction.bending.len() + friction.torsion.len()
}

/// Energy of friction at the curvature e beyond that at rest, by length, J/m.
fn slipping(friction: &SectionFriction, e: &Vector, memory: &[f64]) -> f64 {
    let (slips, twists) = memory.split_at(2 * friction.bending.len());
    let bent = slips.chunks_exact(2).map(|p| (e.x - p[0]).hypot(e.y - p[1]));
    let twisted = twists.iter().map(|p| (e.z - p).abs());
    let of = |(element, d): (&FrictionElement, f64)| {
        let (k, m) = (element.stiffness, element.moment);
        if d <= m / k { 0.5 * k * d * d } else { m * d - 0.5 * m * m / k }
    };
    friction.bending.iter().zip(bent).chain(friction.torsion.iter().zip(twisted)).map(of).sum()
}

/// Energy of a joint, J.
pub fn joint_energy(law: &JointLaw, shape: &JointShape<'_>) -> f64 {
    let (mut energy, mut memory) = (0.0, shape.memory);
    for pair in &law.pairs {
        let (a, b) = (shape.frames[pair.a] * pair.alpha, shape.frames[pair.b] * pair.beta);
        let (own, later) = memory.split_at(slips(&pair.friction));
        let e = curvature(&a, &b, pair.length) - pair.curvature;
        energy += bend_twist(&a, &b, pair.length, &Matrix::from_diagonal(&pair.stiffness), &pair.curvature);
        energy += pair.length * slipping(&pair.friction, &e, own);
        memory = later;
    }
    energy
}

/// Energy of a spring, J.
pub fn spring_energy(law: &SpringLaw, at: &Pose, target: &Pose) -> f64 {
    let turned = match law.turning {
        TurningLaw::None => 0.0,
        TurningLaw::Tangent(k) => {
            0.5 * k * (at.orientation * Vector::z() - target.orientation * Vector::z()).norm_squared()
        }
        TurningLaw::Frame(k) => {
            bend_twist(&target.orientation, &at.orientation, 1.0, &(Matrix::identity() * k), &Vector::zeros())
        }
    };
    0.5 * law.stiffness * (at.position - target.position).norm_squared() + turned
}
