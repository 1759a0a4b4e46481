//! Joints that are rigid hubs: `rigid-body` and `fused`. Arms leave them at fixed poses; neither has an energy.

use wireloom_core::joint::{JointModel, JointShape, Mounting};
use wireloom_core::law::JointLaw;
use wireloom_core::registry::{BuildError, JointKind, Parameter};
use wireloom_core::{Matrix, Vector};

/// The parameter `length` of hubs.
pub(super) fn unused_length() -> Parameter {
    super::cosserat::length("of a joint `cosserat`; a hub does not look at it, so that one file serves all models")
}

/// A rigid hub.
pub struct Hub;

impl JointModel for Hub {
    fn mounting(&self) -> Mounting {
        Mounting::Pose
    }

    fn energy(&self, _: &JointShape<'_>) -> f64 {
        0.0
    }

    fn add_gradient(&self, _: &JointShape<'_>, _: &mut [Vector]) -> f64 {
        0.0
    }

    fn add_hessian(&self, _: &JointShape<'_>, _: &mut [Matrix]) {}

    fn law(&self) -> Option<JointLaw> {
        Some(JointLaw { pairs: vec![] })
    }
}

/// The kind `rigid-body`: a body with pose and mass; arms leave it at fixed poses, with offsets.
pub fn rigid_body() -> JointKind {
    JointKind {
        name: "rigid-body".into(),
        doc: "a rigid body with pose and mass; arms leave it at fixed places and in fixed directions".into(),
        parameters: vec![unused_length()],
        build: Box::new(|_, _| Ok(Box::new(Hub))),
    }
}

/// The kind `fused`: all arms share one point and one frame, their rest angles are kept.
pub fn fused() -> JointKind {
    JointKind {
        name: "fused".into(),
        doc: "all arms share one point and one frame; the angles between them never change; no size".into(),
        parameters: vec![unused_length()],
        build: Box::new(|spec, _| match spec.arms.iter().find(|arm| arm.offset.norm() > 0.0) {
            None => Ok(Box::new(Hub)),
            Some(arm) => Err(BuildError::new(
                format!("arm `{}` of the fused joint `{}` has an offset", arm.branch, spec.name),
                "a fused joint has no size: leave `offset` out, or use model = \"rigid-body\"",
            )
            .at("offset")),
        }),
    }
}
