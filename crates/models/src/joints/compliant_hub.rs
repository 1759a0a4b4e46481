//! A hub to which springs hold the arms: `compliant-hub`.
//!
//! The hub has a pose, and a mass if given. The end point of arm a is fixed to it at the arm's offset. The frame of the
//! station there is coupled to that of the hub:
//!
//! ```text
//! E = Σ_a ½ φ_aᵀ K_a φ_a + Σ_a Σ h(φ_a − p)
//!
//! φ_a  turn from the end of arm a to its rest frame on the hub, in the axes of the arm (rotation vector, to the fourth
//!      power of the angle: see `BendTwist`), rad
//! K_a  diag(k1, k2, k3): stiffness about d1 and d2 (bending) and about d3 (torsion) of the arm, N m/rad
//! h    energy of an element of friction between arm and hub, in bending or in torsion, with the slip p: see
//!      [`crate::friction`], N m/rad and rad in place of N m² and 1/m
//! ```
//!
//! The energy is that of a coupling with λ = 1 m, so minimisers, monitors and devices know it. Where a moment M enters
//! by one arm and leaves by another one, they turn relative to each other by `M/k_a + M/k_b`: springs in series, with
//! the hub between them. That is for small turns: a spring that has turned by 0.5 rad has 0.2 % less moment, by 1 rad
//! 3 % less, and none bears more than 1.4 rad times k. For K → ∞ the joint is `rigid-body`, and `fused` where no arm
//! has an offset.
//!
//! Where a scenario gives `friction`, what holds the arm slips beyond a moment, and the arm keeps a set: tape that is
//! wound about a break-out, a boot that is not glued. The slips are what the joint remembers.
//!
//! It is the model of a body that is soft where its arms leave it: moulded break-outs of rubber, heat-shrink boots,
//! backshells with a rubber grommet. `rigid-body` is for housings that do not give way, `cosserat` for break-outs
//! without a body, whose wires part.

use super::pair::{Pair, Slipping};
use wireloom_core::joint::{JointModel, JointShape, JointSpec, Mounting};
use wireloom_core::law::JointLaw;
use wireloom_core::registry::{BuildError, JointKind};
use wireloom_core::{Matrix, Rotation, Vector};

/// The kind `compliant-hub`.
pub fn kind() -> JointKind {
    JointKind {
        name: "compliant-hub".into(),
        doc: "a body with pose and mass; arms leave it at fixed places, and springs in bending and twist hold their \
              directions (`bending_stiffness` and `torsion_stiffness` of the joint or of an arm), beside them what \
              slips and keeps a set (`friction`): for moulded break-outs, shrink boots, backshells of rubber, tape"
            .into(),
        parameters: vec![super::hub::unused_length()],
        build: Box::new(|spec, _| CompliantHub::new(spec).map(|joint| Box::new(joint) as _)),
    }
}

/// A hub with one spring for each arm.
pub struct CompliantHub {
    springs: Vec<Pair>,
}

impl CompliantHub {
    /// From its specification.
    ///
    /// # Errors
    /// If the spring of an arm has no stiffness in bending or in torsion.
    pub fn new(spec: &JointSpec) -> Result<Self, BuildError> {
        let hub = spec.arms.len();
        let mut springs: Vec<Pair> = Vec::with_capacity(hub);
        let mut memory = 0;
        for (a, arm) in spec.arms.iter().enumerate() {
            let missing = |key: &str| {
                BuildError::new(
                    format!("arm `{}` of the compliant hub `{}` has no `{key}`", arm.branch, spec.name),
                    format!("give `{key}` in N m/rad, of this arm, or of the joint for all arms"),
                )
                .at(&format!("arms.{}", arm.branch))
            };
            let [k1, k2] = arm.spring.bending.ok_or_else(|| missing("bending_stiffness"))?;
            let k3 = arm.spring.torsion.ok_or_else(|| missing("torsion_stiffness"))?;
            let spring = Pair {
                a,
                b: hub,
                lambda: 1.0,
                stiffness: Vector::new(k1, k2, k3),
                curvature: Vector::zeros(),
                alpha: Rotation::identity(),
                beta: arm.rest,
                slips: Slipping::new(&arm.spring.friction, memory),
            };
            memory += spring.width();
            springs.push(spring);
        }
        Ok(Self { springs })
    }
}

impl JointModel for CompliantHub {
    fn mounting(&self) -> Mounting {
        Mounting::CompliantHub
    }

    fn energy(&self, shape: &JointShape<'_>) -> f64 {
        self.springs.iter().map(|spring| spring.energy(shape)).sum()
    }

    fn add_gradient(&self, shape: &JointShape<'_>, gradient: &mut [Vector]) -> f64 {
        let mut energy = 0.0;
        for spring in &self.springs {
            energy += spring.add_gradient(shape, gradient);
        }
        energy
    }

    fn add_hessian(&self, shape: &JointShape<'_>, hessian: &mut [Matrix]) {
        self.springs.iter().for_each(|spring| spring.add_hessian(shape, hessian));
    }

    fn memory(&self) -> Vec<f64> {
        vec![0.0; self.springs.iter().map(Pair::width).sum()]
    }

    fn commit(&self, shape: &JointShape<'_>, memory: &mut [f64], dissipated: &mut [f64]) {
        for (spring, dissipated) in self.springs.iter().zip(dissipated) {
            *dissipated += spring.commit(shape, memory);
        }
    }

    fn set(&self, arm: usize, memory: &[f64]) -> Option<Vector> {
        // The pair turns from the arm to its rest frame, the set is the other way round; written so that 0 has no sign.
        self.springs.get(arm)?.set(memory).map(|turn| Vector::zeros() - turn.scaled_axis())
    }

    fn law(&self) -> Option<JointLaw> {
        Some(JointLaw { pairs: self.springs.iter().map(Pair::law).collect() })
    }
}
