//! The Cosserat rod: stretch, shear, bending and twist with the stiffnesses of the section.

use crate::kernel::{END_BLEND, INNER_BLEND, SegmentStiffness};
use crate::rods::friction::with_friction;
use crate::rods::staggered::{StaggeredRod, Stiffness};
use wireloom_core::registry::RodKind;
use wireloom_core::rod::RodSpec;

/// The kind `cosserat`.
pub fn kind() -> RodKind {
    RodKind {
        name: "cosserat".into(),
        doc: "geometrically exact rod: stretch, shear, bending and twist; second order in the segment length".into(),
        parameters: vec![],
        build: Box::new(|spec, _| Ok(with_friction(spec, rod(spec.clone())))),
    }
}

/// A branch as a Cosserat rod.
pub fn rod(spec: RodSpec) -> StaggeredRod {
    let segment = SegmentStiffness { c: spec.section.stretch_diagonal(), overturned: 0.0 };
    let stiffness = Stiffness {
        segments: vec![segment; spec.mesh.segments()],
        couplings: vec![spec.section.lasting_diagonal(); spec.mesh.coupling_lengths.len()],
        blends: [END_BLEND, INNER_BLEND],
    };
    StaggeredRod::new(spec, stiffness)
}
