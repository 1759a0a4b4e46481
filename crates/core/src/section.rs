//! Cross-section of a branch.

use serde::{Deserialize, Serialize};

/// Cross-section of a branch. All values are per unstressed length, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Name in the scenario.
    pub name: String,
    /// Outer diameter, m.
    pub diameter: f64,
    /// Mass per length, kg/m.
    pub linear_density: f64,
    /// Axial stiffness EA, N.
    pub axial_stiffness: f64,
    /// Shear stiffness GA along d1 and d2, N.
    pub shear_stiffness: [f64; 2],
    /// Bending stiffness EI about d1 and d2, N m².
    pub bending_stiffness: [f64; 2],
    /// Torsion stiffness GJ, N m².
    pub torsion_stiffness: f64,
    /// Smallest bend radius allowed, m; the run reports smaller ones.
    pub min_bend_radius: Option<f64>,
    /// Smallest bend radius allowed while the branch moves, m: the dynamic one of data sheets.
    pub min_bend_radius_moving: Option<f64>,
    /// Largest tension allowed, N; of a bundle by default the tension that breaks its first conductor.
    pub max_tension: Option<f64>,
    /// Largest twist allowed beyond that at rest, either way, rad/m.
    pub max_torsion: Option<f64>,
    /// Axial strain without force per change of temperature, 1/K.
    pub thermal_expansion: f64,
    /// Curvature about d1 and d2, and twist, without moment per change of temperature, 1/(m K): layers that expand
    /// differently.
    pub thermal_curvature: crate::Vector,
    /// Friction within the section, beside its elastic stiffness.
    pub friction: SectionFriction,
    /// Part of the bending stiffness that yields, if bends beyond a limit are permanent: the section then has linear
    /// kinematic hardening, with EI up to its limit and EI less this stiffness beyond.
    pub set: Option<FrictionElement>,
}

/// Friction within a section: wires and coverings that slip on each other (Prandtl–Ishlinskii model).
///
/// Each element is a spring in series with a slider, and all of them act in parallel with the elastic stiffness of the
/// section. While nothing slips the section has the stiffness `C + Σ k`, once all slip it has C.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SectionFriction {
    /// Elements in bending. Each acts on the pair (κ1, κ2), alike in all directions, also where EI1 and EI2 differ: it
    /// slips where the length of its moment reaches its limit.
    pub bending: Vec<FrictionElement>,
    /// Elements in torsion.
    pub torsion: Vec<FrictionElement>,
}

impl SectionFriction {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.bending.is_empty() && self.torsion.is_empty()
    }
}

/// Element of friction: a spring in series with a slider.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrictionElement {
    /// k, N m²: stiffness of the spring.
    pub stiffness: f64,
    /// M, N m: moment at which the slider slips.
    pub moment: f64,
}

impl FrictionElement {
    /// Curvature at which it begins to slip, 1/m.
    pub fn limit(&self) -> f64 {
        self.moment / self.stiffness
    }
}

impl Section {
    /// Diagonal of the stretch-shear stiffness `diag(GA1, GA2, EA)`, N.
    pub fn stretch_diagonal(&self) -> crate::Vector {
        crate::Vector::new(self.shear_stiffness[0], self.shear_stiffness[1], self.axial_stiffness)
    }

    /// Diagonal of the bend-twist stiffness `diag(EI1, EI2, GJ)`, N m².
    pub fn bend_diagonal(&self) -> crate::Vector {
        crate::Vector::new(self.bending_stiffness[0], self.bending_stiffness[1], self.torsion_stiffness)
    }

    /// Diagonal of the bend-twist stiffness of what neither slips nor yields, N m²: the least that the section has.
    pub fn lasting_diagonal(&self) -> crate::Vector {
        let yields = self.set.map_or(0.0, |set| set.stiffness);
        self.bend_diagonal() - crate::Vector::new(yields, yields, 0.0)
    }

    /// All that slips or yields, beside [`Self::lasting_diagonal`].
    pub fn slipping(&self) -> SectionFriction {
        let SectionFriction { bending, torsion } = &self.friction;
        SectionFriction { bending: bending.iter().copied().chain(self.set).collect(), torsion: torsion.clone() }
    }

    /// Whether it expands or bends with the temperature.
    pub fn feels_temperature(&self) -> bool {
        self.thermal_expansion != 0.0 || self.bends_with_temperature()
    }

    /// Whether it bends with the temperature.
    pub fn bends_with_temperature(&self) -> bool {
        self.thermal_curvature != crate::Vector::zeros()
    }

    /// Whether it keeps a set: something in it slips or yields.
    pub fn remembers(&self) -> bool {
        !self.friction.is_empty() || self.set.is_some()
    }

    /// Diagonal of the bend-twist stiffness while no friction slips, N m²: the greatest that the section has.
    pub fn sticking_diagonal(&self) -> crate::Vector {
        let sum = |elements: &[FrictionElement]| elements.iter().map(|element| element.stiffness).sum::<f64>();
        let [bending, torsion] = [sum(&self.friction.bending), sum(&self.friction.torsion)];
        self.bend_diagonal() + crate::Vector::new(bending, bending, torsion)
    }
}
