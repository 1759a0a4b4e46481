//! Rods of given constitutive laws, such as those of plugins: a linear rod on the staggered grid, as `cosserat` is,
//! with laws of stretch and of bending in place of the stiffness of its section where they are given.
//!
//! With a law of bending the scheme is of second order in the segment length, as with sections that are not linear.

use crate::kernel::{SegmentStiffness, Stencil};
use crate::rods::nonlinear::with_given;
use crate::rods::staggered::{StaggeredRod, Stiffness};
use wireloom_core::constitutive::{ConstitutiveLaws, ConstitutiveSpec};
use wireloom_core::registry::{BuildError, ConstitutiveKind, RodKind};
use wireloom_core::rod::{RodSegment, RodSpec};
use wireloom_core::{Section, Vector};

/// The kind of rods with the laws of a kind.
pub fn kind(laws: ConstitutiveKind) -> RodKind {
    let ConstitutiveKind { name, doc, parameters, build } = laws;
    let build = Box::new(move |spec: &RodSpec, values: &_| {
        Stiffness::uncoupled(spec, "a rod of a plugin")?;
        let (name, section) = (spec.name.clone(), spec.only_section()?.clone());
        let of_laws = ConstitutiveSpec { name, section, length: spec.mesh.length(), curvature: spec.curvature };
        let laws = *build(&of_laws, values)?;
        if laws.stretch.as_ref().is_some_and(|law| law.memory() > 0) {
            let message = format!("branch \"{}\": its law of stretch has a memory", spec.name);
            return Err(BuildError::new(message, "only laws of bending and twist may remember"));
        }
        Ok(rod(spec.clone(), laws))
    });
    RodKind { name, doc, parameters, build }
}

/// A branch with these laws.
pub fn rod(spec: RodSpec, laws: ConstitutiveLaws) -> Box<dyn RodSegment> {
    let stiffness = stiffness(&spec, &laws);
    with_given(StaggeredRod::new(spec, stiffness), laws)
}

/// The stiffness of the part that is linear.
fn stiffness(spec: &RodSpec, laws: &ConstitutiveLaws) -> Stiffness {
    let linear = |given: bool, stiffness: Vector| if given { Vector::zeros() } else { stiffness };
    let of_segment = |j: usize| linear(laws.stretch.is_some(), spec.sections.of(j).stretch_diagonal());
    let of_coupling = |section: &Section| linear(laws.bend.is_some(), section.bend_diagonal());
    Stiffness {
        segments: (0..spec.mesh.segments()).map(|j| SegmentStiffness { c: of_segment(j), overturned: 0.0 }).collect(),
        couplings: spec.of_couplings().map(of_coupling).collect(),
        axes: Vec::new(),
        blends: [Stencil::END.station, Stencil::INNER.station],
        variation: if laws.bend.is_some() { 0.0 } else { 1.0 },
    }
}
