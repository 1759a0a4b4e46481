//! The mass-spring chain: the interactive cable simulation before rods, kept for comparison.
//!
//! Masses at the nodes, and between them springs: for stretch `k = EA/ℓ` along every edge, for bending and torsion
//! `k = EI/ℓ` and `k = GJ/ℓ` on the turn from edge to edge (Loock and Schömer 2001; for cloth Provot 1995). The edges
//! have no shear: frames are held to them as in [`crate::rods::kirchhoff`]. What sets it apart from a rod:
//!
//! - A bending spring knows no direction: its stiffness is the mean of EI1 and EI2.
//! - Where the chain is held, a spring as everywhere else (k = EI/ℓ) stands for the *half* segment between the last
//!   edge and the clamp, which in a rod is twice as stiff. Every clamp, connector, clip and hub is too soft by half a
//!   segment of cable, so the error falls with the first power of the segment length only.
//!
//! Against the reference equilibria (`tests/tests/reference.rs`: cables of about a metre) the largest position error
//! with 40, 80 and 160 segments a branch is 5 to 36 mm, 2.4 to 21 mm and 1.2 to 12 mm; that of `cosserat` and
//! `kirchhoff` is 0.02 to 0.5 mm with 40, a quarter of it with 80 and a sixteenth with 160.

use crate::rods::kirchhoff::aligned_segments;
use crate::rods::staggered::{StaggeredRod, Stiffness};
use wireloom_core::registry::{BuildError, RodKind};
use wireloom_core::rod::RodSpec;
use wireloom_core::{Section, Vector};

/// The kind `mass-spring`.
pub fn kind() -> RodKind {
    RodKind {
        name: "mass-spring".into(),
        doc: "masses, and springs for stretch, bending and torsion (the older practice, to compare with): one bending \
              stiffness, the mean of both; first order in the segment length wherever something holds it"
            .into(),
        parameters: vec![],
        build: Box::new(|spec, _| {
            Stiffness::uncoupled(spec, "a mass-spring chain")?;
            let linear = |section: &&Section| section.bends_linearly() && section.laws.axial.is_none();
            let Some(section) = spec.sections.iter().find(|section| !linear(section)) else {
                return Ok(Box::new(StaggeredRod::new(spec.clone(), stiffness(spec))));
            };
            let has = section.nonlinear_keys().join(", ");
            let message = format!("its section \"{}\" has {has}, a mass-spring chain is linear", section.name);
            Err(BuildError::new(message, "rod = \"cosserat\" and rod = \"kirchhoff\" have them").at("rod"))
        }),
    }
}

fn stiffness(spec: &RodSpec) -> Stiffness {
    let mesh = &spec.mesh;
    let spring = |section: &Section| {
        let [ei1, ei2] = section.bending_stiffness;
        let mean = 0.5 * (ei1 + ei2);
        Vector::new(mean, mean, section.torsion_stiffness)
    };
    // E = ½ λ (κ−κ°)ᵀ C (κ−κ°) over λ = ℓ/2 beside a station: half of C makes it a spring of C/ℓ.
    let beside_station = |c: usize| [c, c + 1].iter().any(|frame| mesh.station_frames.binary_search(frame).is_ok());
    let couplings = spec.of_couplings().map(spring).enumerate();
    let couplings = couplings.map(|(k, c)| if beside_station(k) { c * 0.5 } else { c }).collect();
    Stiffness { segments: aligned_segments(spec), couplings, axes: Vec::new(), blends: [0.0, 0.0], variation: 0.0 }
}
