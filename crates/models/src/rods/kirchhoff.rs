//! The Kirchhoff rod: stretch, bending and twist; no shear, the tangent is that of the edge.
//!
//! The theory is that of discrete elastic rods (Bergou, Wardetzky, Robinson, Audoly and Grinspun 2008; with stretch
//! Bergou, Audoly, Vouga, Wardetzky and Grinspun 2010): positions and the angle of the material frame about each edge
//! are the freedoms, and from one state to the next a frame is carried by the smallest rotation that takes it to the
//! new edge (the time-parallel frame).
//!
//! Here a frame keeps its two tilts, which on this grid are freedoms like any others, and an alignment holds it to its
//! edge:
//!
//! ```text
//! Γ = Rᵀ e/ℓ − e3,   E = ½ ℓ (A1 Γ1² + A2 Γ2² + EA Γ3²),   A1 = α EI2/ℓ²,   A2 = α EI1/ℓ²
//! ```
//!
//! A tilts a frame about the axis about which EI bends it. A belongs to the mesh, not to the material (the section's GA
//! is not used), and grows as the mesh gets finer: as a compliance, ℓ²/(α EI), it is of the order of what the grid
//! itself neglects. The shear force of a bent rod is `Q = EI κ′`, so the alignment changes the energy to leading
//! order by `−½ ∫ Q²/A ds = −(ℓ²/2α) ∫ κ′ᵀ C κ′ ds`: with α = 240 by a twentieth of the `−(ℓ²/24) ∫ κ′ᵀ C κ′ ds` that
//! the grid makes anyway (see `crates/README.md`). [`crate::variation`] takes out both, with the factor 1.05. What is
//! left is of second order in space, where Q is not EI κ′ alone (there is `m × κ`), with a constant a hundredth of the
//! one before. So the rod goes to the unshearable one; and every joint and constraint finds the frames it needs.
//! (MacNeal 1978 chose the shear compliance of beam elements in this way.) The energy of the alignment is what results
//! call shear; on a mesh that is fine enough it is negligible.
//!
//! An edge that points against its frame (a far start may bring that about) meets A along the frame, too: the energy
//! then falls all the way as the frame turns to its edge, where the quadratic law alone would have a minimum with the
//! segment overturned.
//!
//! The frames turn by a smallest rotation where a tilt follows an edge, and about the edge only where twist asks for
//! it: the minimisers' steps carry them in time as Bergou's are.

use crate::kernel::{SegmentStiffness, Stencil};
use crate::rods::nonlinear::with_laws;
use crate::rods::staggered::{StaggeredRod, Stiffness};
use wireloom_core::registry::RodKind;
use wireloom_core::rod::RodSpec;
use wireloom_core::{Section, Vector};

/// α. Below 100 the alignment shows beside the error of the grid; far above 1000 round-off of fine meshes does.
const ALIGNMENT: f64 = 240.0;

/// The kind `kirchhoff`.
pub fn kind() -> RodKind {
    RodKind {
        name: "kirchhoff".into(),
        doc: "unshearable rod (theory of discrete elastic rods): stretch, bending and twist, shear_stiffness is not \
              looked at; second order in the segment length, with a small constant"
            .into(),
        parameters: vec![],
        build: Box::new(|spec, _| {
            Stiffness::uncoupled(spec, "a Kirchhoff rod")?;
            with_laws(spec, StaggeredRod::new(spec.clone(), stiffness(spec)))
        }),
    }
}

fn stiffness(spec: &RodSpec) -> Stiffness {
    Stiffness {
        segments: aligned_segments(spec),
        couplings: spec.of_couplings().map(Section::lasting_diagonal).collect(),
        axes: Vec::new(),
        blends: [Stencil::END.station, Stencil::INNER.station],
        variation: if spec.sections.iter().all(Section::bends_linearly) { 1.0 + 12.0 / ALIGNMENT } else { 0.0 },
    }
}

/// The stiffness of every segment.
pub(super) fn aligned_segments(spec: &RodSpec) -> Vec<SegmentStiffness> {
    let lengths = spec.mesh.rest_lengths.iter().enumerate();
    lengths.map(|(j, length)| aligned(spec.sections.of(j), *length)).collect()
}

/// diag(A1, A2, EA) and what keeps edges from being overturned, of a segment of this length (m).
fn aligned(section: &Section, length: f64) -> SegmentStiffness {
    let [a2, a1] = section.bending_stiffness.map(|ei| ALIGNMENT * ei / (length * length));
    SegmentStiffness { c: Vector::new(a1, a2, section.linear_stretch_diagonal().z), overturned: a1.max(a2) }
}
