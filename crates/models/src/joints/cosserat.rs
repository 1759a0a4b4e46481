//! The pairwise joint energy, for any number of arms.
//!
//! The arms meet in one point. The segments at the joint of every pair of arms (a, b) that share wires are
//! coupled by a bend-twist element, as the wires that run from a to b are bent and twisted there:
//!
//! `E_ab = ½ λ_ab (κ−κ°)ᵀ C_ab (κ−κ°)`, `κ` the curvature between the frames `p_a h` and `p_b h̄` as within a rod
//! ([`crate::kernel::BendTwist`]), `λ_ab = ½(ℓ_a + ℓ_b)`, `h = √(r°_ab)`, κ° the mean rest curvature of the two arms.
//!
//! `p_a` is the frame of arm a turned so that its d3 runs into the joint, `p_b` that of arm b turned so that its d3
//! runs out of it; `r°_ab` is their relative rotation at rest. The strain is measured in the frame midway
//! between the two, which makes the energy the same seen from either arm; the square root exists for every
//! pair of directions, folded arms included. `C_ab = diag(EI1, EI2, GJ)` is the part of the arms' stiffness that the shared
//! wires carry, so that a joint of two arms with all wires running through is the plain rod, to the
//! last digit.
//!
//! The public text of the 2017 paper on assembly simulation of multi-branch cables stops before its joint
//! equations; this form is ours.

use super::sharing::share_out;
use crate::kernel::{BendTwist, rotation_matrix};
use nalgebra::{Quaternion, Unit};
use wireloom_core::joint::{Arm, JointModel, JointSpec, Mounting};
use wireloom_core::law::{JointLaw, PairLaw};
use wireloom_core::registry::{BuildError, JointKind};
use wireloom_core::{Matrix, Rotation, Vector};

/// The kind `cosserat`.
pub fn kind() -> JointKind {
    JointKind {
        name: "cosserat".into(),
        doc: "arms meet in a point; every pair that shares wires is coupled in bending and twist by those wires".into(),
        parameters: vec![],
        build: Box::new(|spec, _| CosseratJoint::new(spec).map(|joint| Box::new(joint) as _)),
    }
}

/// Share of an arm's stiffness that may end in a joint without a remark.
const NOTED_SHARE: f64 = 0.01;

/// One pair of arms that share wires.
struct Pair {
    a: usize,
    b: usize,
    lambda: f64,
    /// diag(EI1, EI2, GJ) of the shared wires, N m².
    stiffness: Vector,
    /// Rest curvature of the wires from one segment to the other, 1/m.
    curvature: Vector,
    /// Constant rotations with which the coupled frames are `q_a alpha` and `q_b beta`.
    alpha: Rotation,
    beta: Rotation,
}

/// A joint whose arms are coupled pair by pair.
pub struct CosseratJoint {
    pairs: Vec<Pair>,
    arms: usize,
    notes: Vec<String>,
}

/// Half a turn about d1: reverses the sense of a branch.
fn half_turn() -> Rotation {
    Unit::new_unchecked(Quaternion::new(0.0, 1.0, 0.0, 0.0))
}

/// Square root of a rotation, the shorter way.
///
/// Half a turn (folded arms) has two that are equally short, and round-off must not choose between them: the one with
/// v3 > 0, else v2 > 0, is taken. Seen from the other arm v becomes (−v1, v2, v3), so both see the same.
fn root(r: &Rotation) -> Rotation {
    /// Below this a component is round-off.
    const NONE: f64 = 1e-9;
    let decides = [r.w, r.k, r.j].into_iter().find(|x| x.abs() > NONE).unwrap_or(r.w);
    let r = if decides < 0.0 { -r.into_inner() } else { r.into_inner() };
    Unit::new_normalize(r + Quaternion::identity())
}

impl CosseratJoint {
    /// From its specification.
    ///
    /// # Errors
    /// If an arm has an offset: this joint has no size.
    pub fn new(spec: &JointSpec) -> Result<Self, BuildError> {
        if let Some(arm) = spec.arms.iter().find(|arm| arm.offset.norm() > 0.0) {
            return Err(BuildError::new(
                format!("arm `{}` of the cosserat joint `{}` has an offset", arm.branch, spec.name),
                "its arms meet in one point: leave `offset` out, or use model = \"rigid-body\"",
            )
            .at("offset"));
        }
        let (tables, notes) = stiffness_tables(spec);
        let mut pairs = Vec::new();
        for (a, arm_a) in spec.arms.iter().enumerate() {
            for (b, arm_b) in spec.arms.iter().enumerate().skip(a + 1) {
                let stiffness = Vector::from_fn(|i, _| tables[i][a][b]);
                if stiffness.max() > 0.0 {
                    pairs.push(Pair::new(a, b, arm_a, arm_b, stiffness));
                }
            }
        }
        Ok(Self { pairs, arms: spec.arms.len(), notes })
    }
}

/// For each of EI1, EI2, GJ the symmetric table of what passes between the arms, N m²; and remarks.
fn stiffness_tables(spec: &JointSpec) -> ([Vec<Vec<f64>>; 3], Vec<String>) {
    let k = spec.arms.len();
    let stiffness: Vec<Vector> = spec.arms.iter().map(|arm| arm.section.bend_diagonal()).collect();
    let mut notes = Vec::new();
    if spec.wires.is_empty() {
        let tables = [0, 1, 2].map(|i| {
            let (table, surplus) = share_out(&stiffness.iter().map(|s| s[i]).collect::<Vec<_>>());
            if i == 0
                && let Some(a) = (0..k).find(|&a| surplus[a] > NOTED_SHARE * stiffness[a][0])
            {
                notes.push(format!(
                    "arm `{}` is stiffer in bending than all other arms of joint `{}` together: {:.0} % of its stiffness ends in the joint",
                    spec.arms[a].branch, spec.name, 100.0 * surplus[a] / stiffness[a][0]
                ));
            }
            table
        });
        return (tables, notes);
    }
    let mut tables = [0, 1, 2].map(|_| vec![vec![0.0; k]; k]);
    for wire in &spec.wires {
        for (i, table) in tables.iter_mut().enumerate() {
            let x = wire.share * stiffness[wire.from][i];
            table[wire.from][wire.to] += x;
            table[wire.to][wire.from] += x;
        }
    }
    for ((arm, row), own) in spec.arms.iter().zip(&tables[0]).zip(&stiffness) {
        let ending = 1.0 - row.iter().sum::<f64>() / own[0];
        if ending > NOTED_SHARE {
            notes.push(format!(
                "{:.0} % of the bending stiffness of arm `{}` ends in joint `{}`: no other arm takes it up",
                100.0 * ending,
                arm.branch,
                spec.name
            ));
        }
    }
    (tables, notes)
}

impl Pair {
    fn new(a: usize, b: usize, arm_a: &Arm, arm_b: &Arm, stiffness: Vector) -> Self {
        // Into the joint along a, out of it along b.
        let into = if arm_a.starts_here { half_turn() } else { Rotation::identity() };
        let out = if arm_b.starts_here { Rotation::identity() } else { half_turn() };
        let rest = (arm_a.rest * into).inverse() * (arm_b.rest * out);
        let h = root(&rest);
        // Run from its other end, a branch has the curvature (−κ1, κ2, κ3) about its turned frame.
        let along = |arm: &Arm, reversed: bool| -> Vector {
            let k = arm.curvature;
            if reversed { Vector::new(-k.x, k.y, k.z) } else { k }
        };
        let curvature_a = h.inverse() * along(arm_a, arm_a.starts_here) * arm_a.segment_length;
        let curvature_b = h * along(arm_b, !arm_b.starts_here) * arm_b.segment_length;
        Self {
            a,
            b,
            lambda: 0.5 * (arm_a.segment_length + arm_b.segment_length),
            stiffness,
            curvature: (curvature_a + curvature_b) / (arm_a.segment_length + arm_b.segment_length),
            // conj(q_a α) (q_b β) = h̄ p̄_a p_b h̄.
            alpha: into * h,
            beta: out * h.inverse(),
        }
    }

    fn law(&self, frames: &[Rotation]) -> BendTwist {
        let (qa, qb) = (frames[self.a] * self.alpha, frames[self.b] * self.beta);
        BendTwist::new(&qa, &qb, self.lambda, &self.stiffness, &self.curvature)
    }
}

impl JointModel for CosseratJoint {
    fn mounting(&self) -> Mounting {
        Mounting::Point
    }

    fn energy(&self, frames: &[Rotation]) -> f64 {
        self.pairs
            .iter()
            .map(|pair| {
                let (bend, twist) = pair.law(frames).energy(pair.lambda);
                bend + twist
            })
            .sum()
    }

    fn add_gradient(&self, frames: &[Rotation], gradient: &mut [Vector]) -> f64 {
        let mut energy = 0.0;
        for pair in &self.pairs {
            let law = pair.law(frames);
            let (bend, twist) = law.energy(pair.lambda);
            energy += bend + twist;
            let (a, b) = law.gradient();
            gradient[pair.a] += pair.alpha * a;
            gradient[pair.b] += pair.beta * b;
        }
        energy
    }

    fn add_hessian(&self, frames: &[Rotation], hessian: &mut [Matrix]) {
        for pair in &self.pairs {
            let h = pair.law(frames).hessian(pair.lambda, &pair.stiffness);
            let (ra, rb) = (rotation_matrix(&pair.alpha), rotation_matrix(&pair.beta));
            hessian[pair.a * self.arms + pair.a] += ra * h.aa * ra.transpose();
            hessian[pair.b * self.arms + pair.b] += rb * h.bb * rb.transpose();
            // Only rows b ≥ columns a are asked for.
            hessian[pair.b * self.arms + pair.a] += rb * h.ab.transpose() * ra.transpose();
        }
    }

    fn law(&self) -> Option<JointLaw> {
        let pair = |pair: &Pair| PairLaw {
            a: pair.a,
            b: pair.b,
            alpha: pair.alpha,
            beta: pair.beta,
            length: pair.lambda,
            stiffness: pair.stiffness,
            curvature: pair.curvature,
        };
        Some(JointLaw { pairs: self.pairs.iter().map(pair).collect() })
    }

    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }
}
