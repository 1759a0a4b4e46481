//! The pairwise joint energy, for any number of arms.
//!
//! The arms meet in one point. Over the joint's length L, measured from that point along every arm, wires that go to
//! different arms are not bound to each other; beyond it the arm's section binds them. The wires that run from arm a to
//! arm b bend and twist more over this length than the arms they are part of, and the joint has the difference:
//!
//! ```text
//! E = Σ_ab ½ φ_abᵀ K_ab φ_ab
//! K_ab⁻¹ = L R_a (C_ab⁻¹ − C_a⁻¹) R_aᵀ + L R_b (C_ba⁻¹ − C_b⁻¹) R_bᵀ
//!
//! φ_ab  turn of the end of arm b relative to the end of arm a, beyond that at rest (rotation vector, see `BendTwist`)
//! C_a   diag(EI1, EI2, GJ) of arm a, N m²
//! C_ab  the part of C_a that belongs to the wires that run from a to b
//! R_a   rest frame of arm a in the joint's frame
//! ```
//!
//! Where a moment enters by arm a and leaves by arm b, the ends of the joint at L turn relative to each other by
//! `(L/C_a + K_ab⁻¹ + L/C_b) m = (L/C_ab + L/C_ba) m`, as the shared wires alone do over this length: the length is
//! taken from the arms, and counted once. No term depends on the mesh. Limits: if all wires of two arms run through, K
//! is infinite and the joint is the plain rod for any L; for L → 0 it is the joint `fused`. Several pairs act in
//! parallel.
//!
//! L is by default the diameter D of the thickest arm, because tape binds the wires of an arm where it can go round
//! them alone: two arms of this diameter whose axes meet at the angle α touch up to `D/(2 sin(α/2))` from that point,
//! which is D at 60°. It is at most half of the shortest arm, whose other half belongs to its other end.
//!
//! The frames that are coupled are those of stations at the ends of the arms; half a segment, between station and first
//! segment, is part of the rod like any other. Where all wires of two arms of one stiffness go straight on, the joint
//! is a plain rod without a station: the segments on its sides are coupled as any two neighbours are
//! ([`crate::kernel::BendTwist`], with `λ = ½(ℓ_a + ℓ_b)` and κ° the mean of both), so that it is the same to the last
//! digit.
//!
//! The public text of the 2017 paper on assembly simulation of multi-branch cables stops before its joint
//! equations; this form is ours.

use super::continued::ContinuedRod;
use super::pair::Pair;
use super::sharing::{Stiff, shared};
use crate::kernel::rotation_matrix;
use nalgebra::{Quaternion, Unit};
use wireloom_core::joint::{Arm, Continuation, JointModel, JointShape, JointSpec, Mounting};
use wireloom_core::law::JointLaw;
use wireloom_core::registry::{BuildError, Form, JointKind, Parameter, Quantity};
use wireloom_core::{Matrix, Rotation, Vector};

/// The kind `cosserat`.
pub fn kind() -> JointKind {
    JointKind {
        name: "cosserat".into(),
        doc:
            "arms meet in a point; over a length of each arm the wires part, and every pair of arms that shares wires \
              is coupled in \
              bending and twist by those"
                .into(),
        parameters: vec![length(
            "length of each arm, from the joint's point, over which wires that go to different arms are not bound to \
             each other; \
             default: the diameter of the thickest arm, at most half of the shortest arm",
        )],
        build: Box::new(|spec, values| {
            CosseratJoint::new(spec, values.number("length")).map(|joint| Box::new(joint) as _)
        }),
    }
}

/// The parameter `length` of a joint.
pub(super) fn length(doc: &str) -> Parameter {
    let form = Form::Number { quantity: Quantity::Length, minimum: 0.0, exclusive: true, maximum: f64::INFINITY };
    Parameter { name: "length".into(), doc: doc.into(), form, default: None, required: false }
}

/// Part of an arm that may belong to a joint: the other half belongs to its other end.
const LARGEST_PART: f64 = 0.5;

/// Least compliance of a pair, as that of so many diameters of each arm: it keeps K finite where one pair of a joint of
/// many arms has all wires of both, or where they part about some axes only.
const STIFFEST: f64 = 1e-4;

/// Least part of an arm's stiffness that the wires of a pair have about each axis: where none are said to pass about
/// one axis but some about another one, it keeps K⁻¹ finite.
const SOFTEST: f64 = 1e-6;

/// Part of an arm's stiffness below which wires that go elsewhere are round-off of the fractions.
const ROUND_OFF: f64 = 1e-9;

/// A joint whose arms are coupled pair by pair.
pub struct CosseratJoint {
    pairs: Vec<Pair>,
    /// Curvature of both arms at rest, as they run through, 1/m, if the joint is a plain rod: the segments of its two
    /// arms are coupled as neighbours, without stations.
    plain: Option<[Vector; 2]>,
    /// What the rods couple beyond the joint, if they run through it.
    continued: Option<ContinuedRod>,
    notes: Vec<String>,
}

/// Half a turn about d1: reverses the sense of a branch.
fn half_turn() -> Rotation {
    Unit::new_unchecked(Quaternion::new(0.0, 1.0, 0.0, 0.0))
}

impl CosseratJoint {
    /// From its specification and its length, m; left out, the diameter of the thickest arm, at most half of the
    /// shortest arm.
    ///
    /// # Errors
    /// If an arm has an offset: its arms meet in a point. If the length is more than half of an arm.
    pub fn new(spec: &JointSpec, length: Option<f64>) -> Result<Self, BuildError> {
        if let Some(arm) = spec.arms.iter().find(|arm| arm.offset.norm() > 0.0) {
            return Err(BuildError::new(
                format!("arm `{}` of the cosserat joint `{}` has an offset", arm.branch, spec.name),
                "its arms meet in one point: leave `offset` out, or use model = \"rigid-body\"",
            )
            .at("offset"));
        }
        let length = length_of(spec, length)?;
        let shared = shared(spec);
        let stays = |a: usize, b: usize| {
            let (own, passed) = (shared.arms[a].stiffness, shared.table[a][b]);
            (passed - own).abs() <= own * ROUND_OFF
        };
        let shares_all = spec.arms.len() == 2 && stays(0, 1) && stays(1, 0);
        let of_a_rod = if shares_all { Pair::of_a_rod([&spec.arms[0], &spec.arms[1]]) } else { None };
        if let Some((pair, curvatures)) = of_a_rod {
            return Ok(Self { pairs: vec![pair], plain: Some(curvatures), continued: None, notes: shared.notes });
        }
        let mut pairs = Vec::new();
        for a in 0..spec.arms.len() {
            for b in a + 1..spec.arms.len() {
                let wires = [shared.table[a][b], shared.table[b][a]];
                if wires[0].max() > 0.0 {
                    let arms = [a, b].map(|k| (&spec.arms[k], &shared.arms[k]));
                    pairs.push(Pair::of_wires([a, b], arms, wires, length));
                }
            }
        }
        Ok(Self { pairs, plain: None, continued: None, notes: shared.notes })
    }
}

/// L, m.
fn length_of(spec: &JointSpec, given: Option<f64>) -> Result<f64, BuildError> {
    let thickest = spec.arms.iter().map(|arm| arm.section.diameter).fold(0.0, f64::max);
    let Some(shortest) = spec.arms.iter().min_by(|a, b| a.length.total_cmp(&b.length)) else { return Ok(thickest) };
    let largest = LARGEST_PART * shortest.length;
    match given {
        None => Ok(thickest.min(largest)),
        Some(length) if length <= largest => Ok(length),
        Some(length) => Err(BuildError::new(
            format!(
                "the joint `{}` has length = {length} m, and its arm `{}` is {} m long",
                spec.name, shortest.branch, shortest.length
            ),
            format!(
                "at most half of an arm belongs to a joint: {largest} m here; left out, it is {} m (the diameter of \
                 the thickest arm, \
                 at most half of the shortest)",
                thickest.min(largest)
            ),
        )
        .at("length")),
    }
}

impl Pair {
    /// The arms' wires from a to b, which part from the others over this length (m) of each arm; `wires` is C_ab and
    /// C_ba.
    fn of_wires([a, b]: [usize; 2], arms: [(&Arm, &Stiff); 2], wires: [Vector; 2], length: f64) -> Self {
        let compliance = |(arm, Stiff { axes, stiffness: own }): (&Arm, &Stiff), wires: &Vector| -> Matrix {
            let least = STIFFEST * arm.section.diameter;
            let beyond = |i: usize| {
                let wires = wires[i].max(SOFTEST * own[i]);
                (length * (1.0 / wires - 1.0 / own[i])).max(least / own[i])
            };
            let r = rotation_matrix(&(arm.rest * axes));
            r * Matrix::from_diagonal(&Vector::new(beyond(0), beyond(1), beyond(2))) * r.transpose()
        };
        let of_both = compliance(arms[0], &wires[0]) + compliance(arms[1], &wires[1]);
        let axes = of_both.symmetric_eigen();
        let (first, second) = (axes.eigenvectors.column(0), axes.eigenvectors.column(1));
        let frame = Matrix::from_columns(&[first.into(), second.into(), first.cross(&second)]);
        let frame = Rotation::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(frame));
        Self {
            a,
            b,
            lambda: 1.0,
            stiffness: axes.eigenvalues.map(f64::recip),
            curvature: Vector::zeros(),
            alpha: arms[0].0.rest.inverse() * frame,
            beta: arms[1].0.rest.inverse() * frame,
            slips: None,
        }
    }

    /// Two arms of one stiffness that go on straight into each other, as neighbouring segments of one rod: their pair,
    /// and the rest curvature of each (1/m), all about the principal axes of the first one.
    fn of_a_rod([arm_a, arm_b]: [&Arm; 2]) -> Option<(Self, [Vector; 2])> {
        /// Turn between the arms at rest that is round-off, rad.
        const NONE: f64 = 1e-9;
        // Along the rod a branch that runs against it has frames turned by half a turn, the curvature (−κ1, κ2, κ3).
        let turned = [arm_a.starts_here, !arm_b.starts_here];
        let [into, out] = turned.map(|turned| if turned { half_turn() } else { Rotation::identity() });
        let stiffness = |arm: &Arm, sense: &Rotation| {
            let sense = rotation_matrix(sense);
            sense * arm.section.bend_stiffness() * sense.transpose()
        };
        let rest = (arm_a.rest * into).inverse() * (arm_b.rest * out);
        if rest.angle() > NONE || stiffness(arm_a, &into) != stiffness(arm_b, &out) {
            return None;
        }
        let (axes, stiffness) = arm_a.section.principal_axes();
        let axes = into.inverse() * axes;
        let curvature = |arm: &Arm, turned: bool| {
            let k = arm.curvature;
            axes.inverse() * if turned { Vector::new(-k.x, k.y, k.z) } else { k }
        };
        let curvatures = [curvature(arm_a, turned[0]), curvature(arm_b, turned[1])];
        let [length_a, length_b] = [arm_a, arm_b].map(|arm| arm.segment_length);
        let length = length_a + length_b;
        let pair = Self {
            a: 0,
            b: 1,
            lambda: 0.5 * length,
            stiffness,
            curvature: (curvatures[0] * length_a + curvatures[1] * length_b) / length,
            alpha: into * axes,
            beta: out * axes,
            slips: None,
        };
        Some((pair, curvatures))
    }
}

impl JointModel for CosseratJoint {
    fn mounting(&self) -> Mounting {
        if self.plain.is_some() { Mounting::Point } else { Mounting::Stations }
    }

    fn continue_rods(&mut self, arms: &[Option<Continuation>]) -> bool {
        if let (Some(rest), [Some(a), Some(b)]) = (self.plain, arms)
            && a.variation == b.variation
        {
            let pair = &self.pairs[0];
            self.continued = Some(ContinuedRod {
                senses: [pair.alpha, pair.beta],
                lengths: [a.length, pair.lambda, b.length],
                curvatures: [rest[0], pair.curvature, rest[1]],
                stiffness: pair.stiffness,
                variation: a.variation,
            });
        }
        self.continued.is_some()
    }

    fn energy(&self, shape: &JointShape<'_>) -> f64 {
        let of_pairs: f64 = self.pairs.iter().map(|pair| pair.energy(shape)).sum();
        of_pairs + self.continued.as_ref().map_or(0.0, |rod| rod.energy(shape.frames))
    }

    fn add_gradient(&self, shape: &JointShape<'_>, gradient: &mut [Vector]) -> f64 {
        let mut energy = 0.0;
        for pair in &self.pairs {
            energy += pair.add_gradient(shape, gradient);
        }
        energy + self.continued.as_ref().map_or(0.0, |rod| rod.add_gradient(shape.frames, gradient))
    }

    fn add_hessian(&self, shape: &JointShape<'_>, hessian: &mut [Matrix]) {
        self.pairs.iter().for_each(|pair| pair.add_hessian(shape, hessian));
        if let Some(rod) = &self.continued {
            rod.add_hessian(shape.frames, hessian);
        }
    }

    fn law(&self) -> Option<JointLaw> {
        Some(JointLaw { pairs: self.pairs.iter().map(Pair::law).collect() })
    }

    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }
}
