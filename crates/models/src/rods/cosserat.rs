//! The Cosserat rod: stretch, shear, bending and twist with the stiffnesses of the section.

use crate::kernel::{SegmentStiffness, Stencil};
use crate::rods::nonlinear::with_laws;
use crate::rods::staggered::{StaggeredRod, Stiffness};
use wireloom_core::Section;
use wireloom_core::registry::RodKind;
use wireloom_core::rod::RodSpec;

/// The kind `cosserat`.
pub fn kind() -> RodKind {
    RodKind {
        name: "cosserat".into(),
        doc: "geometrically exact rod: stretch, shear, bending and twist; fourth order in the segment length".into(),
        parameters: vec![],
        build: Box::new(|spec, _| with_laws(spec, rod(spec.clone()))),
    }
}

/// A branch as a Cosserat rod.
pub fn rod(spec: RodSpec) -> StaggeredRod {
    let stiffness = stiffness(&spec);
    StaggeredRod::new(spec, stiffness)
}

/// The stiffness of every part of a branch that is linear. Where bending or torsion is not, the scheme is of second
/// order.
pub fn stiffness(spec: &RodSpec) -> Stiffness {
    let segment = |section: &Section| SegmentStiffness { c: section.linear_stretch_diagonal(), overturned: 0.0 };
    let (axes, couplings) = if spec.sections.iter().any(Section::couples) {
        spec.of_couplings().map(Section::principal_axes).unzip()
    } else {
        (Vec::new(), spec.of_couplings().map(Section::lasting_diagonal).collect())
    };
    Stiffness {
        segments: (0..spec.mesh.segments()).map(|j| segment(spec.sections.of(j))).collect(),
        couplings,
        axes,
        blends: [Stencil::END.station, Stencil::INNER.station],
        variation: if spec.sections.iter().all(Section::bends_linearly) { 1.0 } else { 0.0 },
    }
}
