//! The stiffness rule: what KBL does not say, from what it does.
//!
//! KBL (like VEC) describes wires and coverings, not mechanics: no EI, GJ or EA stands anywhere in it. Until a section
//! has been measured, this rule stands in. It is a first rule, good to a factor of about two for bending; every
//! constant has its story below, and the scenario repeats the rule where it was used. Replace the sections by measured
//! values where you have them.
//!
//! **One wire**, copper area A, strands of diameter d, insulation between the conductor's diameter D_c and the
//! outside diameter D. Strands slip on each other:
//!
//! ```text
//! number of strands n = A / (π d²/4), each with I = π d⁴/64, so Σ I = A d²/16
//! EI = E_cu A d²/16 + E_ins π (D⁴ − D_c⁴)/64,      D_c = √(4 A / (π φ))
//! GJ = E_cu/(1 + ν_cu) A d²/16 + E_ins/(1 + ν_ins) π (D⁴ − D_c⁴)/64      (G J = E/(2(1+ν)) · 2 I)
//! EA = k E_cu A + E_ins π (D² − D_c²)/4
//! ```
//!
//! **A bundle.** Wires slip on each other, so their EI, GJ and EA add up. Friction between strands and wires makes
//! the bundle stiffer than that: EI and GJ are multiplied by a bundle factor K, [`LOOSE`] where nothing binds the wires and
//! [`TAPED`] under tape. A covering over a fraction f of a branch puts the two parts in series: 1/K = f/TAPED +
//! (1 − f)/LOOSE. Tubes (no tape) let the wires slip; their own stiffness is not known and left out.
//!
//! **Joints.** The stiffness that passes between two arms is that of the wires that run from one to the other, with the
//! smaller of the two arms' bundle factors, so that it never exceeds what either arm has.

use std::f64::consts::PI;

/// E_cu, Pa: Young's modulus of annealed copper. Handbooks give 110 to 130 GPa.
pub const COPPER_YOUNG: f64 = 120e9;
/// ν_cu: Poisson's ratio of copper.
pub const COPPER_POISSON: f64 = 0.34;
/// kg/m³: density of copper.
pub const COPPER_DENSITY: f64 = 8960.0;
/// E_ins, Pa: small-strain modulus of the insulation. Wire PVC at 23 °C lies between some 20 MPa (soft, thick walls) and
/// 150 MPa (thin walls, cold); it counts for 5 % of a 0.35 mm² wire and a third of a 25 mm² one.
pub const INSULATION_YOUNG: f64 = 50e6;
/// ν_ins: plasticised PVC is nearly incompressible.
pub const INSULATION_POISSON: f64 = 0.45;
/// kg/m³: density of wire PVC; used only where the file gives no mass.
pub const INSULATION_DENSITY: f64 = 1350.0;
/// φ: share of the conductor's circle that is copper; 7 equal strands fill 0.78, bunched ones somewhat less.
pub const STRAND_FILL: f64 = 0.75;
/// k: axial stiffness of a stranded conductor relative to a solid one of the same area. A lay angle β of 10° to 15°
/// gives cos³ β = 0.90 to 0.96.
pub const STRANDING: f64 = 0.9;
/// K of wires that nothing binds. Full slip would be 1; strands rub on each other and on their insulation.
pub const LOOSE: f64 = 1.5;
/// K under tape. Wires wholly glued together would be one solid bar (K in the hundreds for a large bundle); taped bundles stay
/// near the slipping limit, two to three times above it for bends that exceed their friction.
pub const TAPED: f64 = 2.5;
/// Share of a bundle's circle that its wires fill: 7 equal wires fill 0.78, random bundles some 0.7 to 0.8.
pub const WIRE_FILL: f64 = 0.75;
/// Minimum bend radius over outside diameter, for bundles, and for wires whose file gives none (usual for fixed laying).
pub const BEND_RADIUS: f64 = 4.0;

/// d, m: strand diameter by copper area (m²), as in the flexible (type B) rows of ISO 6722-1 wire tables: 0.21 mm to
/// 1 mm², 0.26 mm to 2.5 mm², 0.31 mm to 6 mm², 0.41 mm above.
pub fn strand_diameter(copper_area: f64) -> f64 {
    match copper_area * 1e6 {
        a if a < 1.25 => 0.21e-3,
        a if a < 3.0 => 0.26e-3,
        a if a < 8.0 => 0.31e-3,
        _ => 0.41e-3,
    }
}

/// One insulated wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wire {
    /// A, m².
    pub copper_area: f64,
    /// D, m.
    pub outside_diameter: f64,
    /// Mass per length, kg/m.
    pub linear_density: f64,
    /// Smallest bend radius its maker allows, m.
    pub min_bend_radius: f64,
}

impl Wire {
    /// From what a file says; what it does not say is estimated: D = 2 mm · √(A/mm²) and back (within 15 % of the wire
    /// tables from 0.35 to 25 mm²), 0.5 mm² where neither is known; the mass from copper and insulation; the bend
    /// radius as [`BEND_RADIUS`] · D. Areas in m², diameter and radius in m, density in kg/m.
    pub fn new(area: Option<f64>, outside: Option<f64>, density: Option<f64>, bend_radius: Option<f64>) -> Self {
        // D = 2e-3 √(A / 1e-6) m is D = 2 √A m.
        let copper_area = area.unwrap_or_else(|| outside.map_or(0.5e-6, |d| 0.25 * d * d));
        let outside_diameter = outside.unwrap_or(2.0 * copper_area.sqrt());
        let mut wire = Self { copper_area, outside_diameter, linear_density: 0.0, min_bend_radius: 0.0 };
        wire.linear_density =
            density.unwrap_or(COPPER_DENSITY * copper_area + INSULATION_DENSITY * wire.insulation_area());
        wire.min_bend_radius = bend_radius.unwrap_or(BEND_RADIUS * outside_diameter);
        wire
    }

    /// `D_c = √(4 A / (π φ))`, at most D.
    fn conductor_diameter(&self) -> f64 {
        (4.0 * self.copper_area / (PI * STRAND_FILL)).sqrt().min(self.outside_diameter)
    }

    /// `π (D² − D_c²)/4`.
    fn insulation_area(&self) -> f64 {
        0.25 * PI * (self.outside_diameter.powi(2) - self.conductor_diameter().powi(2))
    }

    /// `Σ I = A d²/16` of the strands and `π (D⁴ − D_c⁴)/64` of the insulation, m⁴.
    fn second_moments(&self) -> (f64, f64) {
        let d = strand_diameter(self.copper_area);
        let insulation = PI / 64.0 * (self.outside_diameter.powi(4) - self.conductor_diameter().powi(4));
        (self.copper_area * d * d / 16.0, insulation)
    }

    /// EI of the wire with slipping strands, N m².
    pub fn bending_stiffness(&self) -> f64 {
        let (strands, insulation) = self.second_moments();
        COPPER_YOUNG * strands + INSULATION_YOUNG * insulation
    }

    /// GJ of the wire with slipping strands, N m².
    pub fn torsion_stiffness(&self) -> f64 {
        let (strands, insulation) = self.second_moments();
        COPPER_YOUNG / (1.0 + COPPER_POISSON) * strands + INSULATION_YOUNG / (1.0 + INSULATION_POISSON) * insulation
    }

    /// EA of the wire, N.
    pub fn axial_stiffness(&self) -> f64 {
        STRANDING * COPPER_YOUNG * self.copper_area + INSULATION_YOUNG * self.insulation_area()
    }
}

/// What covers a branch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Covering {
    /// Fraction of the branch under tape, 0 to 1.
    pub taped: f64,
    /// Mass of all coverings spread over the branch, kg/m.
    pub linear_density: f64,
    /// Largest stated outside diameter of a tube, m; 0 without one.
    pub outside_diameter: f64,
}

/// A section by the rule of this module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bundle {
    /// Outside diameter, m.
    pub diameter: f64,
    /// Mass per length, kg/m.
    pub linear_density: f64,
    /// EA, N.
    pub axial_stiffness: f64,
    /// EI, N m².
    pub bending_stiffness: f64,
    /// GJ, N m².
    pub torsion_stiffness: f64,
    /// m.
    pub min_bend_radius: f64,
    /// K, the bundle factor in EI and GJ.
    pub factor: f64,
}

impl Bundle {
    /// Wires (at least one) under coverings. The diameter is that of the wire if it is alone, else
    /// `√(Σ D² / WIRE_FILL)`, or that of a tube.
    pub fn new(wires: &[Wire], covering: &Covering) -> Self {
        let sum = |of: fn(&Wire) -> f64| wires.iter().map(of).sum::<f64>();
        let factor = 1.0 / (covering.taped / TAPED + (1.0 - covering.taped) / LOOSE);
        let allowed = wires.iter().map(|wire| wire.min_bend_radius).fold(0.0, f64::max);
        let (wires_diameter, min_bend_radius) = match wires {
            [only] => (only.outside_diameter, allowed),
            _ => {
                let diameter = (sum(|wire| wire.outside_diameter.powi(2)) / WIRE_FILL).sqrt();
                (diameter, allowed.max(BEND_RADIUS * diameter))
            }
        };
        Self {
            diameter: wires_diameter.max(covering.outside_diameter),
            linear_density: sum(|wire| wire.linear_density) + covering.linear_density,
            axial_stiffness: sum(Wire::axial_stiffness),
            bending_stiffness: factor * sum(Wire::bending_stiffness),
            torsion_stiffness: factor * sum(Wire::torsion_stiffness),
            min_bend_radius,
            factor,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn thin() -> Wire {
        Wire::new(Some(0.35e-6), Some(1.3e-3), None, None)
    }

    #[test]
    fn a_thin_wire_is_the_sum_of_its_strands() {
        // 0.35 mm² of 0.21 mm strands: n = 10.1; π d⁴/64 each; insulation from 0.771 mm to 1.3 mm.
        let n = 0.35e-6 / (PI * 0.21e-3_f64.powi(2) / 4.0);
        let strands = n * PI * 0.21e-3_f64.powi(4) / 64.0 * 120e9;
        let insulation = PI / 64.0 * (1.3e-3_f64.powi(4) - (4.0 * 0.35e-6 / (PI * 0.75)).powi(2)) * 50e6;
        assert!((thin().bending_stiffness() - strands - insulation).abs() < 1e-12);
        assert!((1.0e-4..1.5e-4).contains(&thin().bending_stiffness()), "{}", thin().bending_stiffness());
    }

    #[test]
    fn twenty_taped_wires_bend_like_a_harness() {
        let bundle = Bundle::new(&[thin(); 20], &Covering { taped: 1.0, ..Covering::default() });
        assert!((5e-3..1e-2).contains(&bundle.bending_stiffness), "{}", bundle.bending_stiffness);
        assert!((bundle.diameter - 1.3e-3 * (20.0_f64 / 0.75).sqrt()).abs() < 1e-12);
        assert!((0.6..0.8).contains(&(bundle.torsion_stiffness / bundle.bending_stiffness)));
        assert!((bundle.min_bend_radius - 4.0 * bundle.diameter).abs() < 1e-12);
    }

    #[test]
    fn half_a_tape_is_in_series() {
        let bundle = Bundle::new(&[thin(); 2], &Covering { taped: 0.5, ..Covering::default() });
        // Curvature under a moment M: half the length M/(2.5 EI), half M/(1.5 EI), EI that of both wires.
        let both = 2.0 * thin().bending_stiffness();
        let mean_curvature = 0.5 / (2.5 * both) + 0.5 / (1.5 * both);
        assert!((bundle.bending_stiffness * mean_curvature - 1.0).abs() < 1e-12);
        assert!((bundle.factor - 1.875).abs() < 1e-12);
    }

    #[test]
    fn what_a_file_leaves_out_is_near_the_wire_tables() {
        // Area mm², outside diameter mm, g/m: usual values of type B wires.
        for (area, diameter, mass) in [(0.5, 1.6, 6.0), (1.0, 2.1, 11.0), (2.5, 3.0, 26.0), (4.0, 3.7, 40.0)] {
            let wire = Wire::new(Some(area * 1e-6), None, None, None);
            assert!((wire.outside_diameter * 1e3 / diameter - 1.0).abs() < 0.15);
            let wire = Wire::new(Some(area * 1e-6), Some(diameter * 1e-3), None, None);
            assert!((wire.linear_density * 1e3 / mass - 1.0).abs() < 0.15, "{area}: {}", wire.linear_density);
        }
        assert_eq!(Wire::new(None, None, None, None).copper_area, 0.5e-6);
    }
}
